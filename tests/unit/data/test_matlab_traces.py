"""Round trips through MATLAB files, and files that are none."""

import json
import re

import h5py
import numpy as np
import pytest
import scipy.io
import xarray
from damaged_records import mat73
from every_kind import LAYERS, same, small, with_sweep

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.signals import make_trace
from electrovib.data.guarded import read_guarded
from electrovib.data.traces import load_mat, matlab_names, save_mat

pytestmark = pytest.mark.usefixtures("forked")


@pytest.mark.parametrize(
    "trace",
    [
        small(flag=True),
        with_sweep(),
        small().isel(time=2),
        small().isel(time=slice(0, 0)),
        small().isel(time=[1]),
        small(scenario="µ" * 10**6),
    ],
)
def test_round_trip(tmp_path, trace):
    assert save_mat(trace, tmp_path / "out.mat") == [tmp_path / "out.mat"]
    same(trace, load_mat(tmp_path / "out.mat"))


def test_matlab_sees_plain_variables(tmp_path):
    save_mat(with_sweep().merge(small()[["impedance"]]), tmp_path / "a.mat")
    found = scipy.io.loadmat(tmp_path / "a.mat", squeeze_me=True, struct_as_record=False)
    np.testing.assert_array_equal(found["drive_rise"], [1e-6, 1e-3])
    assert found["field"].shape == (2, 2, 3, 5)
    assert list(found["layer"]) == LAYERS
    assert found["units"].field == "V/m"
    assert found["dimensions"].field == "drive.rise, stack.gap.material, layer, time"
    assert found["impedance"][0] == 1 + 2j


def test_names_are_valid_and_distinct():
    odd = ["drive.rise", "drive_rise", "drive rise", "end", "units", "", "1st", "é"]
    odd += ["a" * 80, "a" * 81, "_x", "for"]
    found = matlab_names(odd)
    assert found["drive.rise"] == "drive_rise"
    assert len(set(found.values())) == len(odd)
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name) for name in found.values())
    assert not {"end", "for", "units", "dimensions", "trace_json"} & set(found.values())


def test_what_does_not_fit_into_the_format_is_refused(tmp_path, monkeypatch):
    def refuse(*args, **kwargs):
        raise scipy.io.matlab.MatWriteError("Matrix too large to save with this format")

    monkeypatch.setattr(scipy.io, "savemat", refuse)
    with pytest.raises(InputError, match=r"does not fit into a \.mat file \(Matrix too .*\); save as \.nc"):
        save_mat(small(), tmp_path / "a.mat")
    assert not list(tmp_path.iterdir())


def test_damaged_files(tmp_path):
    path = tmp_path / "a.mat"
    save_mat(small(), path)
    raw = path.read_bytes()
    flipped = bytearray(raw)
    flipped[len(raw) // 2] ^= 0xFF
    for damage in (raw[:128], raw[: len(raw) // 2], bytes(flipped)):
        path.write_bytes(damage)
        with pytest.raises(DataFileError, match="is damaged, or was edited") as caught:
            load_mat(path)
        assert "\n" not in str(caught.value)


@pytest.fixture
def version_73(tmp_path):
    """A Trace that MATLAB has read and saved again with ``-v7.3``."""
    path = tmp_path / "a.mat"
    save_mat(small(scenario="µ ☃"), path)
    content = {name: values for name, values in scipy.io.loadmat(path).items() if not name.startswith("__")}
    texts = {name: str(values[0]) for name, values in content.items() if values.dtype.kind == "U"}
    numbers = {name: values for name, values in content.items() if values.dtype.kind in "fciu"}
    path.write_bytes(mat73(numbers | texts | {"units/none": np.zeros((1, 1))}))
    return path


def test_a_trace_saved_again_as_version_73_is_the_same(version_73):
    found, trace = load_mat(version_73), small(scenario="µ ☃")
    assert "not verified" in found.attrs.pop("validity")  # MATLAB keeps no header of ours
    xarray.testing.assert_identical(found, trace)
    assert found.impedance.values.tobytes() == trace.impedance.values.tobytes()


def elsewhere(file):
    file["impedance"] = h5py.ExternalLink("other.mat", "impedance")


def forged(file):
    """A variable that would fill the memory."""
    parts = np.dtype([("real", "<f8"), ("imag", "<f8")])
    made = file.create_dataset("impedance", (1, 10_000_000), parts, chunks=True, compression="gzip")
    made.attrs["MATLAB_class"] = np.bytes_("double")


@pytest.mark.parametrize(
    ("gone", "put", "words"),
    [
        ("impedance", elsewhere, r"damaged or not a MATLAB file \('impedance'\)"),
        ("impedance", forged, r"too small for the 10000000 numbers of 'impedance'"),
        ("trace_json", lambda _: None, "is not a Trace"),
    ],
)
def test_a_changed_variable_of_version_73_is_refused(version_73, gone, put, words):
    with h5py.File(version_73, "r+") as file:
        del file[gone]
        put(file)
    with pytest.raises(DataFileError, match=words):
        load_mat(version_73)


OTHERS = [
    {"x": [1.0], "trace_json": text} for text in ("{", "[]", "{}", '{"format": "electrovib trace 1"}', "é")
]


@pytest.mark.parametrize("content", [*OTHERS, {"x": [1.0]}, {"trace_json": [1.0, 2.0]}])
def test_other_contents_are_no_trace(tmp_path, content):
    scipy.io.savemat(tmp_path / "a.mat", content, do_compression=True)
    text = isinstance(content.get("trace_json"), str)
    words = "is not a Trace|damaged or not a MATLAB file" if text else "is not a Trace"
    with pytest.raises(DataFileError, match=words):
        load_mat(tmp_path / "a.mat")


def test_numbers_that_are_all_alike_can_be_read_again(tmp_path):
    steps = 2_100_000  # two signals of 17 MB that compression makes a thousand times smaller
    zeros = {name: (("time",), np.zeros(steps)) for name in ("current", "drive_voltage")}
    trace = make_trace(zeros, {"time": np.zeros(steps)}, {})
    save_mat(trace, tmp_path / "a.mat")
    xarray.testing.assert_identical(load_mat(tmp_path / "a.mat"), trace)


@pytest.mark.parametrize("count", [1, 3])
def test_a_packed_file_that_unfolds_too_far(tmp_path, count, monkeypatch):
    """One large variable, or several of which each alone would pass."""
    monkeypatch.setattr("electrovib.data.readers.matlab.read_guarded", read_guarded)
    save_mat(small(), tmp_path / "a.mat")
    content = {n: v for n, v in scipy.io.loadmat(tmp_path / "a.mat").items() if not n.startswith("__")}
    about = json.loads(content["trace_json"].item())
    names = {}
    for number in range(count):
        entry = {"name": f"x{number}", "dims": [], "kind": "real", "coordinate": False, "attributes": {}}
        about["structure"]["variables"].append(entry)
        about["names"][f"x{number}"] = f"x{number}"
        names[f"x{number}"] = np.zeros(6_000_000 // count)
    scipy.io.savemat(
        tmp_path / "a.mat", content | names | {"trace_json": json.dumps(about)}, do_compression=True
    )
    with pytest.raises(DataFileError, match="packed too tightly: 0"):
        load_mat(tmp_path / "a.mat")
