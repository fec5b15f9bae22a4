"""Measured files as SI columns, and every fault that they may have."""

import os
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import DataFileError
from electrovib.data.registry import read_columns, read_recorded

pytestmark = pytest.mark.usefixtures("forked")

WANTED = {"time": ("time", "s"), "volts": ("voltage", "V")}
BY_NUMBER = {"time": (0, "us"), "volts": (1, "V")}
TIME, VOLTAGE = [0.0, 77e-6, 156e-6], [1.0, -2.5, 3e2]


def written(folder: Path, content: str | bytes, name: str = "rec.csv") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def check(columns) -> None:
    # both are decimal numbers divided by a power of ten, so the floats are the nearest ones
    np.testing.assert_array_equal(columns["time"], TIME)
    np.testing.assert_array_equal(columns["volts"], VOLTAGE)


ROWS = "0,1\n77,-2.5\n156,3e2\n"


@pytest.mark.parametrize(
    "content",
    [
        "time [us],voltage [V]\n" + ROWS,
        "time [us],voltage [V]\r\n" + ROWS.replace("\n", "\r\n"),
        "# made by hand, 3 rows\n\ntime [us],voltage\n0,1\n\n# a pause\n77,-2.5\n156,3e2",
        "time [us];voltage [V]\n" + ROWS.replace(",", ";"),
        "time [us]\tvoltage, raw [V]\tvoltage [V]\n0\t9\t1\n77\t9\t-2.5\n156\t9\t3e2\n",
        "time [us] voltage(V)\n" + ROWS.replace(",", "  "),
        '"time [us]","voltage [V]"\n"0","1"\n"77","-2.5"\n"156","3e2"\n',
        "\ufefftime [us],voltage [V]\n" + ROWS,
        "time [us], voltage [mV], note\n0, 1e3, 'start'\n77, -2500, x\n156, 3e5, end\n",
        "time,voltage\n[us],[kV]\n0,1e-3\n77,-2.5e-3\n156,0.3\n",
        "time (us),voltage (V),\n" + ROWS,
        "time [us],voltage [V],\n" + ROWS.replace("\n", ",\n"),
        "time [µs],voltage [V]\n".encode("latin-1") + ROWS.encode(),
        ("time [us],voltage [V]\n" + ROWS).encode("utf-16"),
    ],
)
def test_text_files_are_read(tmp_path, content):
    check(read_columns(written(tmp_path, content), WANTED))


def test_columns_by_number_and_a_first_row_in_quotes_that_is_no_heading(tmp_path):
    """Without a delimiter quotes were taken for headings, and their numbers were lost."""
    for name in ("a.csv", "a.txt", "a.TSV"):
        check(read_columns(written(tmp_path, ROWS, name), BY_NUMBER))
    check(read_columns(written(tmp_path, ROWS.replace(",", " ").replace("0 1", '"0" "1"')), BY_NUMBER))
    found = read_columns(written(tmp_path, '"1"\n"-2.5"\n"3e2"\n'), {"v": (0, "V")})
    np.testing.assert_array_equal(found["v"], VOLTAGE)


@pytest.mark.parametrize(
    "rows",
    ["0 us,1 V\n77 us,-2.5 V\n156 us,300 V\n", "0.0D+00,1\n77,-2.5\n1.56D+02,3D+02\n", "+ 0,1\n77,- 2.5\n156,+ 300\n",
     "0,1\n77,\u22122.5\n156,3e2\n"],
)  # fmt: skip
def test_numbers_that_instruments_write_otherwise_are_read_with_and_without_headings(tmp_path, rows):
    """They were refused here and read on import; the first row must not be taken for headings."""
    check(read_columns(written(tmp_path, rows), BY_NUMBER))
    check(read_columns(written(tmp_path, "time [us],voltage [V]\n" + rows), WANTED))


def test_a_row_that_begins_with_a_missing_reading_is_no_comment(tmp_path):
    """It was left out without a word, because #N/A begins like a comment."""
    path = written(tmp_path, "F [N],t [s]\n1,0\n#N/A,1\n# a comment\n3,2\n")
    found = read_columns(path, {"F": ("F", "N"), "t": ("t", "s")}, missing=True)
    np.testing.assert_array_equal(found["F"], [1, np.nan, 3])
    np.testing.assert_array_equal(found["t"], [0, 1, 2])
    with pytest.raises(DataFileError, match=r"line 3, column 'F \[N\]': '#N/A' is not a number"):
        read_columns(path, {"F": ("F", "N")})


TABS = 't [V]\tf [V]\tu [V]\n1\t5\t"6"\n2\t3\t"1"\n3\t1\t"9"\n4\t1\t"0"\n5\t7\t"7";2\n'


@pytest.mark.parametrize(
    ("content", "column", "expected"),
    [
        ("a b [V]\n" + "1\n" * 15 + "-2.5\t\n", "a b", [1.0] * 15 + [-2.5]),
        ("a; b [V]; c\n; 1; 64\n; ; 8\n; ; 98\n; -6; 67\n-1; ; 32\n", "b", [1, np.nan, np.nan, -6, np.nan]),
        ('t [V], c, a b [V]\n5, abc, "-1"\n, start, "9"\n0.1, x, "-2"\n', "t", [5, np.nan, 0.1]),
        (TABS, "f", [5, 3, 1, 1, 7]),
        # two blanks divide the columns; pandas warned, which reached the user
        ("Probe position [V]  Drive out [V]\n1  5\n2  3\n3  1\n", "Drive out", [5, 3, 1]),
        (",x [V],when\n0,1,2024-01-01\n1,2,2024-01-02\n", "x", [1, 2]),
        ("time,1,2\n0,5,6\n1,7,8\n", "2", [6, 8]),
        ("field[gap],field[gap]2 [V]\n1,2\n3,4\n", "field[gap]", [1, 3]),
        ("field[gap],field[gap]2 [V]\n1,2\n3,4\n", "field[gap]2", [2, 4]),
        ("impedance(real),impedance(real)2 [V]\n1,2\n3,4\n", "impedance(real)", [1, 3]),
    ],
)
def test_delimiters_labels_and_headings_are_told_apart(tmp_path, content, column, expected):
    found = read_columns(written(tmp_path, content), {"x": (column, "V")}, missing=True)["x"]
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(
    ("heading", "asked", "factor"),
    [
        ("x", "us", 1e-6), ("x", "kV", 1e3), ("x", "um", 1e-6), ("x", "Hz", 1.0), ("x", "S/m", 1.0), ("x", "1", 1.0),
        ("x [-]", "1", 1.0), ("x [%]", "1", 0.01), ("x [ms]", "us", 1e-3), ("x [MHz]", "Hz", 1e6), ("x[kohm]", "ohm", 1e3),
        ("x (mm/s)", "m/s", 1e-3), ("x [uS/m]", "S/m", 1e-6), ("x [cm2]", "m2", 1e-4), ("x [min]", "s", 60.0),
        ("x", "deg", np.pi / 180),
    ],
)  # fmt: skip
def test_units(tmp_path, heading, asked, factor):
    found = read_columns(written(tmp_path, f"{heading}\n1\n2\n"), {"x": ("x", asked)})
    np.testing.assert_allclose(found["x"], [factor, 2 * factor], rtol=1e-15)  # one rounding


def test_text_takes_less_than_ten_times_its_size(tmp_path):
    path = written(tmp_path, "# Ω\n" + "1,2\n" * 250_000)
    tracemalloc.start()
    try:
        found = read_columns(path, BY_NUMBER, missing=True)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 10 * path.stat().st_size
    assert found["volts"].sum() == 500_000


MANY = ",".join(f"heading {i}" + "x" * 500 for i in range(50)) + "\n"


@pytest.mark.parametrize(
    ("content", "column", "words"),
    [
        ("a," * 1024 + "b\n1\n2\n", "b", "has more than 1024 columns; a table has a row per sample"),
        (
            "a b\n1 2\n3 4" + " 5" * 500_000,
            "b",
            "line 3 has 1000003 characters; a table has a row per sample",
        ),
        ("9" * 2_000_000, "b", "line 1 has 2000000 characters"),
        (MANY, "zork", r"It has: heading 0x{51}, heading 1x{51}, "),
        # the time of brackets grew with the square of their length: minutes for these
        *(
            (f"{heading}\n1\n2\n", "x", r"there is no column 'x'|line 2 has 1 fields|1024 columns")
            for heading in ("(" * 300_000, "[" * 300_000 + "]", "a" + " " * 300_000 + "[V", "a [ " * 40_000)
        ),
    ],
    ids=["columns", "characters", "digits", "headings", "round", "square", "blanks", "open"],
)
def test_tables_that_are_none_take_no_time(tmp_path, content, column, words):
    with pytest.raises(DataFileError, match=words):
        read_columns(written(tmp_path, content), {"x": (column, "V")})


def test_brackets_that_are_never_closed_take_no_time_in_a_whole_file(tmp_path):
    """The time of a setting's name grew with the square of its length: half a minute for a third of this one."""
    begun = time.process_time()
    assert read_recorded(written(tmp_path, "(" * 100_000 + "\n1\n2\n")).size == 2
    assert time.process_time() - begun < 5


@given(st.lists(st.integers(-(10**9), 10**9), min_size=2, max_size=5))
@settings(deadline=None, max_examples=30)
def test_scaled_numbers_are_the_nearest_floats(tmp_path_factory, numbers):
    path = written(tmp_path_factory.mktemp("x"), "\n".join(map(str, numbers)))
    found = read_columns(path, {"x": (0, "us")})["x"]
    assert list(found) == [float(f"{number}e-6") for number in numbers]


HEADED = "time [s],voltage [V]\n0,1\n"


@pytest.mark.parametrize(
    ("content", "wanted", "words"),
    [
        ("", WANTED, "the file is empty"),
        ("# only\n\n  \n", WANTED, "holds no rows"),
        ("time,voltage\n", WANTED, "column 'time' has no rows"),
        (HEADED, WANTED, "column 'time .s.' has only one row; at least two"),
        (HEADED + "1,zwei\n", WANTED, "line 3, column 'voltage .V.': 'zwei' is not a number"),
        ("# c\n\n" + HEADED + "\n1,\n", WANTED, "line 6, column 'voltage .V.': the number is missing"),
        (HEADED + "1,0x10\n", WANTED, "'0x10' is not a number"),
        (HEADED + "1,1_000\n", WANTED, "'1_000' is not a number"),
        (HEADED + "1,１\n", WANTED, "'１' is not a number"),
        (HEADED.replace(",", ";") + "1;2,5\n", WANTED, "'2,5' is not a number; write decimals with a point"),
        (HEADED + "1,2,3\n2,3\n", WANTED, "line 3 has 3 fields, but the headings have 2"),
        (HEADED + "1\n", WANTED, "line 3 has 1 fields, but the headings have 2"),
        ("time\n0,1\n1,2\n", {"t": ("time", "s")}, "line 2 has 2 fields, but the headings have 1"),
        ("0,1\n1,2\n2\n", BY_NUMBER, "line 3 has 1 fields, but the first row has 2"),
        ('time,voltage\n"0","1"\n"1"\n2,3,"4,5"\n', WANTED, "line 3 has 1 fields"),
        (HEADED + "1,nan\n", WANTED, "line 3, column 'voltage .V.': nan is not a finite number[.]"),
        (HEADED + "# c\ninf,2\n2,2\n-inf,1\n", WANTED, "line 4, column 'time .s.': inf .*, nor are 1 more"),
        ("0,1\n1,2\n", {"x": (2, "V")}, "there is no column 2; they are numbered 0 to 1"),
        ("0,1\n1,2\n", {"x": (-1, "V")}, "there is no column -1"),
        ("time,1,2\n0,5,6\n1,7,8\n", {"x": (2, "V")}, "first row has 'time' above a number"),
        ("0,1\n1,2\n", WANTED, "has no headings; ask for column 'time' by its number"),
        (HEADED, {"x": ("tme", "s")}, "no column 'tme'. Did you mean 'time'. It has: time, voltage"),
        (HEADED + "1,2\n", {"x": ("voltage [mV]", "V")}, r"column 'voltage \[V\]' is in 'V', not in 'mV'"),
        (HEADED, {"x": ("current", "A")}, "no column 'current'. It has: time, voltage"),
        ("a,a\n1,2\n3,4\n", {"x": ("a", "V")}, "more than one column is called 'a'"),
        ("a [V],a [mV]\n1,2\n3,4\n", {"x": ("a", "V")}, "more than one column is called 'a'"),
        ("0,1\nx,2\n", BY_NUMBER, "line 2, column 0: 'x' is not a number"),
        ("x,1\n0,2\n", BY_NUMBER, "first row has 'x' above a number"),
        ("x,1\ny,2\n", BY_NUMBER, "line 1, column 0: 'x' is not a number"),
        ("t [V],v\n0,1\n1,2\n", {"x": ("t", "s")}, "column 't .V.' is in 'V', but a time is needed"),
        ("t [counts],v\n0,1\n1,2\n", {"x": ("t", "s")}, "'counts' is not a known unit"),
        ("t [rad/s],v\n0,1\n1,2\n", {"x": ("t", "Hz")}, "'rad/s' is not a known unit"),
        ("t [rpm],v\n0,1\n1,2\n", {"x": ("t", "Hz")}, "'rpm' is not a known unit"),
        ("v [kV]\n1\n1e307\n", {"x": ("v", "V")}, "line 3, column 'v .kV.': 1e.307 kV is too large a number"),
        (HEADED + "1,2\n", {"x": ("time", "sekunde")}, "'sekunde' is not a known unit"),
        (b"PK\x03\x04\0\0\0\0", WANTED, "is an archive; unpack it"),
    ],
)
def test_wrong_text_files_are_refused_in_one_sentence(tmp_path, content, wanted, words):
    with pytest.raises(DataFileError, match=words) as caught:
        read_columns(written(tmp_path, content), wanted)
    assert "rec.csv: " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_are_none(tmp_path):
    written(tmp_path, ROWS, "record.csv")
    (tmp_path / "folder.csv").mkdir()
    os.mkfifo(tmp_path / "pipe.csv")
    cases = {
        "recrod.csv": r"there is no such file\. Did you mean 'record\.csv'",
        "no/record.csv": "there is no such file",
        "folder.csv": "is a folder",
        "pipe.csv": "not an ordinary file",
        "record.csv/x.csv": "cannot be read|there is no such file",
        "n" * 300 + ".csv": "cannot be read",
    }
    for name, words in cases.items():
        with pytest.raises(DataFileError, match=words):
            read_columns(tmp_path / name, BY_NUMBER)
    with pytest.raises(DataFileError, match="is damaged or not a spreadsheet"):
        read_columns(written(tmp_path, "x", "a.xlsx"), BY_NUMBER)
    with pytest.raises(DataFileError, match=r"is in no format that is known\. Known are netCDF"):
        read_columns(written(tmp_path, b"\0\1\2" * 9, "a.raw"), BY_NUMBER)


def test_unreadable_file(tmp_path, monkeypatch):
    path = written(tmp_path, ROWS)

    def refuse(self, *args, **kwargs):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(DataFileError, match=r"cannot be read: .*Permission denied"):
        read_columns(path, BY_NUMBER)


def test_npy_by_number_and_by_field(tmp_path):
    plain = np.array([[0, 77, 156], VOLTAGE]).T
    np.save(tmp_path / "a.npy", plain)
    check(read_columns(tmp_path / "a.npy", BY_NUMBER))
    check(read_columns(tmp_path / "a.npy", {"time": ("column 0", "us"), "volts": ("column 1", "V")}))
    np.save(tmp_path / "b.npy", np.asfortranarray(plain).astype(">f8"))
    check(read_columns(tmp_path / "b.npy", BY_NUMBER))
    fields = np.zeros(3, [("time [us]", "i4"), ("voltage", "f4")])
    fields["time [us]"], fields["voltage"] = [0, 77, 156], VOLTAGE
    np.save(tmp_path / "c.npy", fields)
    check(read_columns(tmp_path / "c.npy", WANTED))
    check(read_columns(tmp_path / "c.npy", BY_NUMBER))


SIGNALLING = np.array([1, 0x7FA00000, 3], "u4").view("f4")
"""With a NaN that complains when it is converted."""
NOT_PLAIN = "holds Python objects, which are not unpickled"


@pytest.mark.parametrize(
    ("array", "wanted", "words"),
    [
        (np.zeros((3, 2)), {"x": (2, "V")}, "there is no column 2"),
        (np.zeros((3, 2)), WANTED, "has no headings; ask for column 'time' by its number, 0 first"),
        (np.zeros((1, 2)), BY_NUMBER, "there is no column 1; they are numbered 0 to 0"),
        (np.zeros((0, 2)), BY_NUMBER, "there is no column 0"),
        (np.zeros(7), BY_NUMBER, "there is no column 1; they are numbered 0 to 0"),
        (np.zeros((2, 3, 4)), BY_NUMBER, r"shape \(2, 3, 4\)"),
        (
            np.array([[0, 1], [1, np.nan]]),
            BY_NUMBER,
            "row 1 .first is 0., column 1: nan is not a finite number",
        ),
        (np.array([SIGNALLING, SIGNALLING]).T, BY_NUMBER, "nan is not a finite number"),
        (np.zeros((3, 2), complex), BY_NUMBER, "column 0 holds complex numbers"),
        (np.array([["a", "b"]] * 2), BY_NUMBER, "column 0 holds text"),
        (np.array([[{}, 1], [2, 3]], dtype=object), BY_NUMBER, NOT_PLAIN),
        (
            np.zeros(3, [("time", "f8", (2,)), ("voltage", "f8")]),
            WANTED,
            "no column 'time'. Did you mean 'time.1.'",
        ),
        (np.zeros(3, [("time", "f8"), ("volt", "f8")]), WANTED, "no column 'voltage'. Did you mean 'volt'"),
    ],
)
def test_wrong_npy_files_are_refused(tmp_path, array, wanted, words):
    np.save(tmp_path / "rec.npy", array)
    with pytest.raises(DataFileError, match=words):
        read_columns(tmp_path / "rec.npy", wanted)


def test_a_size_that_is_a_lie_is_refused(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((30, 2)))
    lie = (tmp_path / "a.npy").read_bytes().replace(b"(30, 2), }         ", b"(30000000000, 2), }")
    with pytest.raises(DataFileError, match="damaged"):
        read_columns(written(tmp_path, lie, "b.npy"), BY_NUMBER)


def dataset() -> xarray.Dataset:
    return xarray.Dataset(
        {
            "voltage": ("time", VOLTAGE, {"units": "V"}),
            "current": ("time", [1.0, 2.0, 3.0]),
            "packed": ("time", [0.5, 1.0, 1.5], {"units": "mm"}),
            "field": (("layer", "time"), np.zeros((2, 3))),
            "gain": ("frequency", [1j, 2.0]),
            "single": ((), 1.0),
            "odd": ("time", [1.0, 2.0, 3.0], {"units": "counts"}),
            "other": ("frequency", [1.0, 2.0]),
        },
        {"time": ("time", [0.0, 77, 156], {"units": "us"}), "layer": ["a", "b"]},
    )


@pytest.mark.parametrize("engine", ["h5netcdf", "scipy"])
def test_netcdf_by_name(tmp_path, engine):
    packing = {"packed": {"dtype": "i2", "scale_factor": 0.5, "_FillValue": -1}}
    data = dataset().drop_vars("gain")
    data.to_netcdf(tmp_path / "a.nc", engine=engine, encoding=packing)
    check(read_columns(tmp_path / "a.nc", WANTED))
    found = read_columns(tmp_path / "a.nc", {"i": ("current", "mA"), "p": ("packed", "m")})
    np.testing.assert_array_equal(found["i"], [1e-3, 2e-3, 3e-3])
    np.testing.assert_array_equal(found["p"], [0.5e-3, 1e-3, 1.5e-3])


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ({"x": (0, "V")}, "no column 0; ask by name. It has: voltage, "),
        ({"x": ("volt", "V")}, "no column 'volt'"),
        ({"x": ("voltage", "A")}, "column 'voltage' is in 'V', but a current is needed"),
        ({"x": ("field", "V/m")}, r"no column 'field'. Did you mean 'field\[2\]'"),
        ({"x": ("single", "V")}, "column 'single' is the single value 1.0"),
        ({"x": ("gain", "1")}, "column 'gain' holds complex numbers"),
        ({"x": ("layer", "1")}, "column 'layer' holds"),
        ({"x": ("odd", "m")}, "'counts' is not a known unit"),
        ({"t": ("time", "s"), "x": ("other", "V")}, "differ in length: column 'time' 3, column 'other' 2"),
    ],
)
def test_wrong_netcdf_variables_are_refused(tmp_path, wanted, words):
    dataset().to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    with pytest.raises(DataFileError, match=words):
        read_columns(tmp_path / "a.nc", wanted)


@pytest.mark.parametrize("suffix", [".npy", ".nc"])
@pytest.mark.parametrize("engine", ["h5netcdf", "scipy"])
def test_damaged_binary_files_are_refused(tmp_path, suffix, engine):
    path = tmp_path / f"a{suffix}"
    if suffix == ".npy":
        np.save(path, np.zeros((3, 2)))
    else:
        dataset().drop_vars("gain").to_netcdf(path, engine=engine)
    raw = path.read_bytes()
    for damage in (b"\0", b"time,voltage\n0,1\n", raw[:7], raw[:60], raw[: len(raw) // 2], b"\xff" * 200):
        path.write_bytes(damage)
        with pytest.raises(DataFileError, match=f"a{suffix}: (is damaged or not|the file is)") as caught:
            read_columns(path, BY_NUMBER if suffix == ".npy" else WANTED)
        assert "\n" not in str(caught.value)


def test_a_number_that_stands_for_no_reading_is_missing_in_columns_too(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,u\n" + "".join(f"{at},{9.9e37 if at == 3 else at % 5}\n" for at in range(20)))
    found = read_columns(path, {"voltage": ("u", "V")}, missing=True)["voltage"]
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(found)), [3])
    with pytest.raises(DataFileError, match=r"line 5, column 'u': 9.9e\+37 stands for no reading"):
        read_columns(path, {"voltage": ("u", "V")})
