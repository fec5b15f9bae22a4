"""Round trips of a Trace, and files that are none."""

import json

import numpy as np
import pint
import pytest
import scipy.io
import xarray
from every_kind import same, small, with_sweep

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.signals import FORMAT, SIGNALS, make_trace
from electrovib.data.traces import load_mat, load_nc, open_trace, save_mat, save_nc

pytestmark = pytest.mark.usefixtures("forked")


@pytest.mark.parametrize(
    "trace", [small(), with_sweep(), small().isel(time=2), small().isel(time=slice(0, 0))]
)
def test_netcdf_round_trip(tmp_path, trace):
    path = tmp_path / "out.nc"
    assert save_nc(trace, path) == [path]
    same(trace, load_nc(path))
    save_nc(load_nc(path).isel(layer=slice(0, 2)), path)  # what was loaded can be cut and saved again
    xarray.testing.assert_identical(trace.isel(layer=slice(0, 2)), load_nc(path))


BOTH = ((save_nc, load_nc, "a.nc"), (save_mat, load_mat, "a.mat"))


def test_round_trips_notice_a_difference():
    changed = small()
    changed.impedance.values[3] = 0
    xarray.testing.assert_identical(changed, small())  # blind to the sign of zero, so `same` has to see it
    with pytest.raises(AssertionError):
        same(changed, small())
    with pytest.raises(AssertionError):
        same(small(steps=3.0), small(steps=3))


@pytest.mark.parametrize("size", [8000, 8001, 70_000, 1_000_000])
def test_long_attributes(tmp_path, size):
    trace = small(scenario=json.dumps({"note": "µ\n" * (size // 2)}, ensure_ascii=False), other="x" * size)
    for save, load, name in BOTH:
        save(trace, tmp_path / name)
        same(trace, load(tmp_path / name))


def test_kinds_of_numbers_and_units_are_stamped_on_save(tmp_path):
    trace = small(flag=True, count=np.int64(3), size=np.float64(2.5), array=np.array(1)) ** 2
    trace.time.attrs["units"] = "fortnight"
    for save, load, name in BOTH:
        save(trace, tmp_path / name)
        found = load(tmp_path / name)
        assert [type(found.attrs[k]) for k in ("count", "size", "array")] == [int, float, int]
        assert found.attrs["flag"] == 1
        assert (found.time.units, found.field.units, found.attrs["format"]) == ("s", "V/m", FORMAT)
    assert trace.time.units == "fortnight"  # the Trace in hand is not touched


@pytest.mark.parametrize("save", [save_nc, save_mat])
@pytest.mark.parametrize("value", [None, [1, 2], {"a": 1}, 1j, np.arange(2)])
def test_attributes_that_are_neither_text_nor_number_are_refused(tmp_path, save, value):
    with pytest.raises(InputError, match=r"attribute 'bad' is of type .*, not a text or a number"):
        save(small(bad=value), tmp_path / "a")
    trace = small()
    trace.time.attrs["bad"] = value
    with pytest.raises(InputError, match=r"attribute 'time\.bad' is of type"):
        save(trace, tmp_path / "a")
    assert not list(tmp_path.iterdir())


def test_what_netcdf_cannot_hold(tmp_path):
    with pytest.raises(InputError, match="cannot be written as netCDF"):
        save_nc(small(bad="zero\0byte"), tmp_path / "a.nc")
    assert not list(tmp_path.iterdir())
    save_mat(small(bad="zero\0byte"), tmp_path / "a.mat")
    assert load_mat(tmp_path / "a.mat").bad == "zero\0byte"


@pytest.mark.parametrize("stop", [KeyboardInterrupt, RuntimeError])
def test_interrupted_save_leaves_the_older_files(tmp_path, monkeypatch, stop):
    for save, _, name in BOTH:
        save(small(steps=1), tmp_path / name)
        with pytest.raises(InputError, match="does not exist; make it first"):
            save(small(), tmp_path / "no" / name)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    def stopped(*args, **kwargs):
        raise stop

    monkeypatch.setattr(xarray.Dataset, "dump_to_store", stopped)
    monkeypatch.setattr(scipy.io, "savemat", stopped)
    for save, _, name in BOTH:
        with pytest.raises(stop):
            save(small(steps=2), tmp_path / name)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before
    assert len(before) == 2


# --------------------------------------------------------------------------------- files that are none


def test_other_files_are_no_trace(tmp_path):
    xarray.Dataset({"x": ("t", [1.0])}).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    scipy.io.savemat(tmp_path / "a.mat", {"x": 1.0})
    for _, load, name in BOTH:
        with pytest.raises(DataFileError, match=f"{name}: is not a Trace"):
            load(tmp_path / name)
        (tmp_path / name).write_text("")
        with pytest.raises(DataFileError, match="the file is empty"):
            load(tmp_path / name)
        with pytest.raises(DataFileError, match="no such file"):
            load(tmp_path / f"no{name}")


@pytest.mark.parametrize("part", [8, 60, 500, 3000, -2000, -1])
def test_netcdf_cut_short(tmp_path, part):
    save_nc(small(), tmp_path / "a.nc")
    (tmp_path / "a.nc").write_bytes((tmp_path / "a.nc").read_bytes()[:part])
    with pytest.raises(
        DataFileError, match=r"a\.nc: is damaged(, or was edited| or not a netCDF file)"
    ) as caught:
        load_nc(tmp_path / "a.nc")
    assert "\n" not in str(caught.value)


SAVED = {".nc": save_nc, ".mat": save_mat}


@pytest.mark.parametrize("suffix", SAVED)
def test_units_in_files_are_read_by_pint_and_older_files_are_opened(tmp_path, suffix, monkeypatch):
    names = [name for name, each in SIGNALS.items() if each.dims == ("time",)]
    values = {name: (("time",), [1.0, 2.0]) for name in names}
    values["displacement"] = (("layer", "time"), [[1.0, 2.0]])
    trace = make_trace(values, {"time": [0.0, 1.0], "layer": ["gap"]}, {})
    path = tmp_path / f"a{suffix}"
    SAVED[suffix](trace, path)
    xarray.testing.assert_identical(open_trace(path), trace)
    if suffix == ".nc":
        written = {
            name: each.attrs.get("units", "1") for name, each in xarray.open_dataset(path).variables.items()
        }
    else:
        found = scipy.io.loadmat(path, simplify_cells=True)["units"]
        written = {name: str(unit) if len(unit) else "1" for name, unit in found.items()}
    assert "C/m^2" in written.values()
    registry = pint.UnitRegistry()
    for name, unit in written.items():
        inside = SIGNALS[name.split("[")[0]].unit if name.split("[")[0] in SIGNALS else "1"
        assert registry.Quantity(1, unit) == registry.Quantity(1, inside.replace("m2", "m**2")), name
    monkeypatch.setattr("electrovib.data.traces.unit_in_files", str)  # as they were written before
    SAVED[suffix](trace, tmp_path / f"old{suffix}")
    xarray.testing.assert_identical(open_trace(tmp_path / f"old{suffix}"), trace)
