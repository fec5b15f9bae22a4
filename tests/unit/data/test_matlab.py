"""MATLAB files: against scipy's reader, and every fault that they may have, without a crash."""

import contextlib
import struct
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from damaged_records import mat73
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import DataFileError
from electrovib.data.guarded import read_guarded
from electrovib.data.readers import matlab
from electrovib.data.registry import read_columns

pytestmark = pytest.mark.usefixtures("forked")
TABLE = np.arange(12.0).reshape(4, 3) / 7


def read_matlab(path, variable=""):
    """Return an array as MATLAB shows it; without a name the only one that is no single number."""
    found = {name: values for name, _, values in matlab._arrays(path)}
    read = {name: values for name, values in found.items() if not isinstance(values, str)}
    if not variable:
        (variable,) = [name for name, each in read.items() if each.size > 1 and "." not in name]
    if variable not in read:
        read_columns(path, {"x": (variable, "V")})
    return np.asarray(read[variable], float)


SWIPE = Path(__file__).parents[4] / "shared" / "data" / "tribometer" / "finger_swipe.mat"
HEADER = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
NONSENSE = zlib.compress(b"\0" * 64)
BOTH = pytest.mark.parametrize("packed", [True, False])


def saved(folder, content, name="record.mat", **options):
    path = folder / name
    scipy.io.savemat(path, content, **options)
    return path


def big_endian(name, values):
    """Write a file as a machine of the other byte order does, from the description of the format."""
    flags = struct.pack(">IIII", 6, 8, 6, 0)
    sizes = struct.pack(">IIii", 5, 8, *values.shape)
    small_name = struct.pack(">HH4s", len(name), 1, name.encode())
    numbers = values.astype(">i2").tobytes(order="F")
    data = struct.pack(">II", 3, len(numbers)) + numbers + b"\0" * (-len(numbers) % 8)
    body = flags + sizes + small_name + data
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\x01\x00MI" + struct.pack(">II", 14, len(body)) + body


def element(kind, content, *, small=False):
    """An element of version 5: tag, content, and what fills it up to eight bytes."""
    if small:
        return struct.pack("<HH4s", kind, len(content), content)
    return struct.pack("<II", kind, len(content)) + content + b"\0" * (-len(content) % 8)


def flags(number):
    return element(6, struct.pack("<II", number, 0))


def opaque(name="tbl", of="table"):
    """An object as MATLAB saves it: flags of class 17, name, system and class, then its place in the subsystem.

    No sizes. After the open readers of the format, since the published description ends before class 17.
    """
    place = flags(13) + element(5, struct.pack("<ii", 6, 1)) + element(1, b"")
    place += element(6, struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1))
    texts = element(1, name.encode(), small=len(name) <= 4) + element(1, b"MCOS") + element(1, of.encode())
    return flags(17) + texts + element(14, place)


def handle(name="fun"):
    """A function handle: flags of class 16, sizes, name, then a struct that is not looked at."""
    inner = flags(2) + element(5, struct.pack("<ii", 1, 1)) + element(1, b"")
    inner += element(5, struct.pack("<i", 1)) + element(1, b"")
    return flags(16) + element(5, struct.pack("<ii", 1, 1)) + element(1, name.encode()) + element(14, inner)


def nameless():
    """The subsystem in which objects keep their content: bytes without a name."""
    return flags(9) + element(5, struct.pack("<ii", 1, 8)) + element(1, b"") + element(2, bytes(range(8)))


def with_objects(folder, content, *, packed, extra=None):
    """Put an object, a function handle and the subsystem around ordinary variables."""
    path = saved(folder, content, do_compression=packed)
    raw = path.read_bytes()

    def wrapped(body):
        whole = element(14, body)
        squeezed = zlib.compress(whole)
        return struct.pack("<II", 15, len(squeezed)) + squeezed if packed else whole

    before, after = wrapped(opaque()), wrapped(handle()) + wrapped(extra or opaque("when", "datetime"))
    path.write_bytes(raw[:128] + before + raw[128:] + after + wrapped(nameless()))
    return path


@BOTH
def test_objects_and_function_handles_are_listed_and_skipped(tmp_path, packed):
    path = with_objects(tmp_path, {"record": TABLE}, packed=packed)
    np.testing.assert_array_equal(read_matlab(path), TABLE)
    np.testing.assert_array_equal(read_columns(path, {"v": ("record[1]", "V")})["v"], TABLE[:, 1])
    for wanted, words in {
        "recrod": r"no column 'recrod'. Did you mean 'record\[\d\]'. It has: tbl, record\[0\], .*, fun, when",
        "tbl": "column 'tbl' is no array of real numbers, but object of class table",
        "fun": "column 'fun' is no array of real numbers, but 1 x 1 function handle",
        "when": "object of class datetime",
    }.items():
        with pytest.raises(DataFileError, match=words):
            read_columns(path, {"x": (wanted, "V")})


def damaged(path, whole, number):
    """Write a file with one to three other bytes, many times."""
    random = np.random.default_rng(4)
    for _ in range(number):
        raw = bytearray(whole)
        for place in random.integers(124, len(raw), random.integers(1, 4)):
            raw[place] = random.integers(256)
        path.write_bytes(raw)
        yield


@pytest.mark.parametrize("number", [40, pytest.param(500, marks=pytest.mark.slow)])
@BOTH
def test_no_damage_is_more_than_an_input_error(tmp_path, packed, number):
    path = saved(tmp_path, {"record": TABLE, "rate": 1e4}, do_compression=packed)
    refused = 0
    for _ in damaged(path, path.read_bytes(), number):
        try:
            assert read_matlab(path, "record").shape
        except DataFileError:
            refused += 1
    # an unpacked file has no checksum: what hits a number goes unnoticed; a third of its bytes are numbers
    assert refused > number * (0.86 if packed else 0.3)
    path = with_objects(tmp_path, {"record": TABLE}, packed=packed)
    whole = path.read_bytes()
    for _ in damaged(path, whole, number // 2):
        with contextlib.suppress(DataFileError):
            assert read_matlab(path, "record").shape
    for length in range(129, len(whole), 1500 // number):
        path.write_bytes(whole[:length])
        with contextlib.suppress(DataFileError):
            assert read_matlab(path, "record").shape == TABLE.shape


@BOTH
def test_fields_of_structs_are_reached_by_their_path(tmp_path, packed):
    rig = {"name": "left", "drive": {"voltage": [1.0, 2.0, 3.0]}, "none": []}
    trial = {"force": TABLE, "rate": 1e4, "rig": rig}
    path = saved(tmp_path, {"trial": trial, "other": TABLE}, do_compression=packed)
    np.testing.assert_array_equal(read_matlab(path, "trial.force"), TABLE)
    assert read_matlab(path, "trial.rate").tolist() == [[1e4]]
    found = read_columns(path, {"a": ("trial.rig.drive.voltage [kV]", "V")})["a"]
    assert found.tolist() == [1e3, 2e3, 3e3]
    np.testing.assert_array_equal(read_matlab(path), TABLE)  # fields are no arrays of the file
    for wanted, words in {
        "trial": r"no column 'trial'. Did you mean 'trial.rate'. It has: trial.force\[0\], .*, trial.rate, trial.rig.name",
        "trial.fource": r"no column 'trial.fource'. Did you mean 'trial.force\[\d\]'",
        "trial.rig.name": "column 'trial.rig.name' is no array of real numbers, but 1 x 4 char",
        "trial.rig.none": "column 'trial.rig.none' is empty",
        "trial.rate": "column 'trial.rate' is the single value 10000",
    }.items():
        with pytest.raises(DataFileError, match=words):
            read_columns(path, {"x": (wanted, "V")})


def test_elements_of_an_array_of_structs_are_reached_by_their_number(tmp_path):
    trials = np.zeros(3, dtype=[("force", "O")])
    for place in range(3):
        trials[place]["force"] = TABLE * place
    path = saved(tmp_path, {"trials": trials})
    with pytest.raises(DataFileError, match=r"'trials.force'. Did you mean 'trials\[\d\].force\[\d\]'"):
        read_columns(path, {"x": ("trials.force", "V")})
    np.testing.assert_array_equal(read_matlab(path, "trials[1].force"), TABLE)
    assert read_columns(path, {"x": ("trials[2].force[1]", "V")})["x"].tolist() == (2 * TABLE[:, 1]).tolist()


def struct_of(name_length, *values):
    body = flags(2) + element(5, struct.pack("<ii", 1, 1)) + element(1, b"s", small=True)
    body += struct.pack("<HH4s", 5, 4, struct.pack("<i", name_length)) + element(1, b"x" * 8)
    return body + b"".join(values)


FORGED = [*(struct_of(length) for length in (0, -1, 2**31 - 1, 8)), struct_of(8, element(9, b"\0" * 8))]


@pytest.mark.parametrize("body", [*FORGED, struct_of(8, struct.pack("<II", 14, 2**31))])
def test_a_forged_struct_is_one_sentence(tmp_path, body):
    path = tmp_path / "forged.mat"
    path.write_bytes(HEADER + element(14, body))
    words = r"(is damaged or not a MATLAB file|there is no column 's\.x')"
    with pytest.raises(DataFileError, match=rf"forged\.mat: {words}"):
        read_matlab(path, "s.x")


def test_fields_and_objects_of_version_73(tmp_path):
    path, column = tmp_path / "new.mat", [[1.0], [2.0]]
    content = {
        "record": TABLE,
        "about/force": TABLE,
        "about/rig/v": column,
        "few/data": column,
        "trials/x": column,
    }
    path.write_bytes(mat73(content, compression="gzip"))
    with h5py.File(path, "r+") as file:
        file.create_group("#refs#")
        file["tbl"] = np.array([[0xDD000000, 2, 1, 1, 1, 1]], "u4")
        file["tbl"].attrs["MATLAB_object_decode"] = 3
        file["#subsystem#/MCOS"] = [1]
        file["few"].attrs["MATLAB_sparse"] = 5
        references = file.create_dataset("trials/force", (3, 1), dtype=h5py.ref_dtype)
        references[:] = file["record"].ref
        file.create_group("fun")
        file["elsewhere"] = h5py.ExternalLink("other.mat", "record")
        for name, kind in {"tbl": "table", "fun": "function_handle", "few": "double"}.items():
            file[name].attrs["MATLAB_class"] = np.bytes_(kind)
    np.testing.assert_array_equal(read_matlab(path), TABLE)
    np.testing.assert_array_equal(read_matlab(path, "about.force"), TABLE)
    assert read_matlab(path, "about.rig.v").tolist() == [[1], [2]]
    for wanted, words in {
        "about": r"no column 'about'.* It has: .*about.rig.v",
        "tbl": r"is no array of real numbers, but 6 x 1 object of class table",
        "few": "is no array of real numbers, but double",
        "elsewhere": "no column 'elsewhere'",
    }.items():
        with pytest.raises(DataFileError, match=words):
            read_columns(path, {"x": (wanted, "V")})
    whole = path.read_bytes()
    for part in (600, len(whole) // 2, len(whole) - 10):
        path.write_bytes(whole[:part])
        with pytest.raises(DataFileError, match=r"new.mat: is damaged or not a MATLAB file"):
            read_matlab(path)


@BOTH
@pytest.mark.parametrize("kind", ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"])
def test_arrays_are_read_as_scipy_reads_them(tmp_path, packed, kind):
    values = (100 * TABLE).astype(kind)
    path = saved(tmp_path, {"record": values, "rate": 1e4, "note": "a text"}, do_compression=packed)
    found = read_matlab(path)
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, values)
    np.testing.assert_array_equal(found, scipy.io.loadmat(path)["record"])
    assert read_matlab(path, "rate").tolist() == [[1e4]]


@given(
    st.integers(1, 5),
    st.integers(1, 40),
    st.sampled_from(["f8", "f4", "i2", "u1"]),
    st.booleans(),
    st.integers(0),
)
@settings(deadline=None, max_examples=30)
def test_any_size_and_several_variables(tmp_path_factory, width, rows, kind, packed, seed):
    made, names = np.random.default_rng(seed), ("a", "long_name_of_a_signal", "b2")
    content = {name: made.integers(0, 100, (rows, width)).astype(kind) for name in names}
    path = saved(tmp_path_factory.mktemp("mat"), content, do_compression=packed)
    for name, values in content.items():
        np.testing.assert_array_equal(read_matlab(path, name), values)


def test_three_dimensions_and_the_other_byte_order(tmp_path):
    cube = np.arange(24.0).reshape(2, 3, 4)
    np.testing.assert_array_equal(read_matlab(saved(tmp_path, {"cube": cube})), cube)
    path = tmp_path / "big.mat"
    path.write_bytes(big_endian("abc", 7 * TABLE))
    np.testing.assert_array_equal(read_matlab(path), np.rint(7 * TABLE))


def test_columns_through_the_guarded_process(tmp_path, monkeypatch):
    monkeypatch.setattr(matlab, "read_guarded", read_guarded)
    path = saved(tmp_path, {"record": TABLE})
    found = read_columns(path, {"t": (0, "us"), "v": ("record[2]", "mV"), "w": ("record[1] [kV]", "V")})
    np.testing.assert_allclose(found["t"], TABLE[:, 0] * 1e-6, rtol=1e-15)
    np.testing.assert_allclose(found["v"], TABLE[:, 2] * 1e-3, rtol=1e-15)
    np.testing.assert_allclose(found["w"], TABLE[:, 1] * 1e3, rtol=1e-15)
    rows = saved(tmp_path, {"t": [1.0, 2.0], "v": [[3.0], [4.0]], "x": [1.0, 2.0, 3.0]}, "rows.mat")
    assert read_columns(rows, {"a": ("t", "s"), "b": ("v", "V")})["b"].tolist() == [3, 4]
    with pytest.raises(DataFileError, match="differ in length: column 't' 2, column 'x' 3"):
        read_columns(rows, {"a": ("t", "s"), "b": ("x", "V")})


@pytest.mark.parametrize(
    ("content", "column", "words"),
    [
        ({"record": TABLE}, 3, r"no column 3; they are numbered 0 to 2. It has: record\[0\]"),
        (
            {"record": TABLE},
            "recrod[0]",
            r"no column 'recrod\[0\]'. Did you mean 'record\[\d\]'. It has: record",
        ),
        ({"record": TABLE}, "record", r"no column 'record'. Did you mean 'record\[\d\]'"),
        ({"record": TABLE}, "record(:,1)", r"no column 'record\(:,1\)'. Did you mean 'record\["),
        ({"a": TABLE, "b": TABLE}, 0, r"no column 0; ask by name. It has: a\[0\]"),
        ({"text": "words", "rate": 1e4}, 0, "no column 0; ask by name. It has: text, rate"),
        ({"z": TABLE * 1j}, "z", r"'z' is no array of real numbers, but 4 x 3 complex double"),
        ({"cube": np.ones((2, 3, 4))}, "cube", r"'cube' has 3 dimensions \(2 x 3 x 4\)"),
        (
            {"n": np.array([[1.0, np.nan], [2.0, 3.0]])},
            1,
            r"row 0 \(first is 0\), column 'n\[1\]': nan is not a fin",
        ),
    ],
)
def test_wrong_columns(tmp_path, content, column, words):
    with pytest.raises(DataFileError, match=words):
        read_columns(saved(tmp_path, content), {"x": (column, "V")})


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        (b"", "the file is empty"),
        (
            b"time,voltage\n0,1\n1,2\n",
            "is not a MATLAB file of version 4, 5 or 7.3; in MATLAB save it with -v7",
        ),
        (HEADER[:19], "is not a MATLAB file"),
        (HEADER, "It has: nothing"),
        (HEADER + b"\1" * 7, "could not read bytes"),
        (HEADER + struct.pack("<II", 99, 0), "Did not read any bytes"),
        (HEADER + struct.pack("<II", 15, len(NONSENSE)) + NONSENSE, "is damaged or not a MATLAB file"),
        (b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + HEADER, "is damaged or not a MATLAB file"),
        (b"MATLAB 7.3 MAT-file".ljust(512), "is damaged or not a MATLAB file"),
        (b"\x89HDF\r\n\x1a\n" + b"\0" * 100, "is damaged or not a MATLAB file"),
    ],
)
def test_what_is_no_matlab_file(tmp_path, raw, words):
    path = tmp_path / "record.mat"
    path.write_bytes(raw)
    with pytest.raises(DataFileError, match=words):
        matlab.read_columns(path, ["record[0]"], False)


@BOTH
def test_a_file_cut_short_anywhere_is_refused(tmp_path, packed):
    path = saved(tmp_path, {"record": TABLE}, do_compression=packed)
    whole = path.read_bytes()
    for length in range(1, len(whole)):
        path.write_bytes(whole[:length])
        with pytest.raises(DataFileError, match=r"record\.mat"):
            read_columns(path, {"x": ("record[0]", "V")})


@pytest.mark.parametrize("seed", range(3))
def test_a_forged_size_asks_for_no_memory(tmp_path, seed):
    """A variable that says it is 2^31 by 2^31, packed with a right checksum."""
    sizes = (2**31 - 1, 2 ** (29 + seed % 3) - 1)
    inner = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, *sizes)
    inner += struct.pack("<HH4s", 1, 1, b"a") + struct.pack("<II", 9, 8) + b"\0" * 8
    packed = zlib.compress(struct.pack("<II", 14, len(inner)) + inner)
    path = tmp_path / "forged.mat"
    path.write_bytes(HEADER + struct.pack("<II", 15, len(packed)) + packed)
    with pytest.raises(DataFileError, match=r"damaged or not a MATLAB file \(cannot reshape array of size 1"):
        read_matlab(path)


def test_the_recorded_swipe_is_read_as_scipy_reads_it():
    if not SWIPE.exists():
        pytest.skip("needs shared/data/tribometer/finger_swipe.mat beside the repository")
    np.testing.assert_array_equal(read_matlab(SWIPE), scipy.io.loadmat(SWIPE)["dataQ"])
