"""The suffix chooses the format."""

from pathlib import Path

import numpy as np
import pytest
import xarray

from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.data.traces import load_mat, load_nc, open_trace
from electrovib.exports.save import check_output, save
from electrovib.scenario import load

SIZES = {"time": 2, "frequency": 2, "layer": 1}


def small() -> xarray.Dataset:
    signals = {"drive_voltage": (("time",), [1.0, np.nan]), "impedance": (("frequency",), [1j, 2.0])}
    return make_trace(signals, {"time": [0.0, 0.1], "frequency": [1.0, 2.0]}, {"steps": 3})


@pytest.mark.parametrize(("name", "load"), [("a.nc", load_nc), ("a.mat", load_mat), ("a.b.NC", load_nc)])
def test_suffix_chooses_and_a_name_is_as_good_as_a_path(tmp_path, monkeypatch, name, load):
    check_output(tmp_path / name, SIZES)
    files = save(small(), tmp_path / name)
    assert files[0] == tmp_path / name
    assert sorted(files) == sorted(tmp_path.iterdir())
    for reader in (load, open_trace):
        xarray.testing.assert_identical(reader(tmp_path / name), small())
    monkeypatch.chdir(tmp_path)
    check_output(name, SIZES)
    assert save(small(), name)[0] == Path(name)
    for missing in (f"no/{name}", tmp_path / "no" / name):
        with pytest.raises(InputError, match="does not exist"):
            check_output(missing, SIZES)


UNKNOWN = {
    "a.xlsx": r"saved as \.nc, \.csv, \.mat, \.html, .*\.pdf, .*, not as '\.xlsx'\.$",
    "a.cvs": r"not as '\.cvs'\. Did you mean '\.csv'",
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_unknown_suffix(tmp_path, name):
    for path in (tmp_path / name, name):
        with pytest.raises(InputError, match=UNKNOWN[name]):
            save(small(), path)
    with pytest.raises(InputError, match=UNKNOWN[name]):
        check_output(tmp_path / name, {"time": 2})
    assert not list(tmp_path.iterdir())


def test_check_before_a_long_computation(tmp_path):
    (tmp_path / "a.csv").write_text("mine")
    with pytest.raises(InputError, match=r"a\.csv: exists already and is no table as CSV"):
        check_output(tmp_path / "a.csv", SIZES)
    swept = {"time": 2, "drive.rise": 2}
    with pytest.raises(InputError, match=r"runs over drive\.rise"):
        check_output(tmp_path / "a.csv", swept)
    check_output(tmp_path / "a.nc", swept)
    with pytest.raises(InputError, match="only a Trace or a result with a document is saved, not a Scenario"):
        save(load("vezzoli_2014/fig6"), tmp_path / "a.nc")
    assert [p.name for p in tmp_path.iterdir()] == ["a.csv"]
