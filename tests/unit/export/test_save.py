"""The suffix chooses the format."""

from pathlib import Path

import numpy as np
import pytest
import xarray

from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.data.traces import load_csv, load_mat, load_nc, open_trace
from electrovib.export.save import check_output, save
from electrovib.scenario import load


def small() -> xarray.Dataset:
    return make_trace(
        {"drive_voltage": (("time",), [1.0, np.nan]), "impedance": (("frequency",), [1j, 2.0])},
        {"time": [0.0, 0.1], "frequency": [1.0, 2.0]},
        {"steps": 3},
    )


@pytest.mark.parametrize(
    ("name", "load"), [("a.nc", load_nc), ("a.csv", load_csv), ("a.mat", load_mat), ("a.b.NC", load_nc)]
)
def test_suffix_chooses(tmp_path, name, load):
    files = save(small(), tmp_path / name)
    assert files[0] == tmp_path / name
    assert sorted(files) == sorted(tmp_path.iterdir())
    xarray.testing.assert_identical(load(tmp_path / name), small())
    xarray.testing.assert_identical(open_trace(tmp_path / name), small())


@pytest.mark.parametrize("name", ["a.nc", "a.csv", "a.mat"])
def test_a_name_is_as_good_as_a_path(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    check_output(name, {"time": 2, "frequency": 2})
    assert save(small(), name)[0] == Path(name)
    assert (tmp_path / name).is_file()
    with pytest.raises(InputError, match="saved as"):
        save(small(), "a.xlsx")
    with pytest.raises(InputError, match="does not exist"):
        check_output(f"no/{name}", {"time": 2})


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("a.xlsx", r"saved as \.nc, \.csv, \.mat, not as '\.xlsx'\.$"),
        ("a", r"not as ''\.$"),
        ("a.cvs", r"not as '\.cvs'\. Did you mean '\.csv'"),
    ],
)
def test_unknown_suffix(tmp_path, name, words):
    with pytest.raises(InputError, match=words):
        save(small(), tmp_path / name)
    with pytest.raises(InputError, match=words):
        check_output(tmp_path / name, {"time": 2})
    assert not list(tmp_path.iterdir())


def test_check_before_a_long_computation(tmp_path):
    sizes = {"time": 2, "frequency": 2, "layer": 1}
    for name in ("a.nc", "a.csv", "a.mat"):
        check_output(tmp_path / name, sizes)
        with pytest.raises(InputError, match="does not exist"):
            check_output(tmp_path / "no" / name, sizes)
    (tmp_path / "a.frequency.csv").mkdir()
    with pytest.raises(InputError, match=r"a\.frequency\.csv: is a folder"):
        check_output(tmp_path / "a.csv", sizes)
    with pytest.raises(InputError, match=r"runs over drive\.rise"):
        check_output(tmp_path / "a.csv", {"time": 2, "drive.rise": 2})
    check_output(tmp_path / "a.nc", {"time": 2, "drive.rise": 2})
    assert [p.name for p in tmp_path.iterdir()] == ["a.frequency.csv"]


def test_a_scenario_is_no_trace(tmp_path):
    with pytest.raises(InputError, match="only a Trace is saved, not a Scenario"):
        save(load("vezzoli_2014/fig6"), tmp_path / "a.nc")
    assert not list(tmp_path.iterdir())
