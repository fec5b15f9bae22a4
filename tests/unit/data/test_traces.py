"""Round trips of a Trace, and files that are none."""

import json
from pathlib import Path

import numpy as np
import pint
import pytest
import scipy.io
import xarray
from every_kind import only, same, small, with_sweep
from hypothesis import example, given, settings
from hypothesis import strategies as st

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.signals import FORMAT, SIGNALS, make_trace, stamp
from electrovib.data import trace_csv as comma_separated
from electrovib.data.registry import read_columns
from electrovib.data.trace_csv import load_csv, save_csv
from electrovib.data.traces import load_nc, open_trace, save_mat, save_nc


@pytest.mark.parametrize(
    "trace", [small(), with_sweep(), small().isel(time=2), small().isel(time=slice(0, 0))]
)
def test_netcdf_round_trip(tmp_path, trace):
    path = tmp_path / "out.nc"
    assert save_nc(trace, path) == [path]
    same(trace, load_nc(path))
    save_nc(load_nc(path).isel(layer=slice(0, 2)), path)  # what was loaded can be cut and saved again
    xarray.testing.assert_identical(trace.isel(layer=slice(0, 2)), load_nc(path))


@pytest.mark.parametrize(
    "trace",
    [small(), small().isel(frequency=2), small().isel(time=slice(0, 0)), only("time"), only("frequency")],
)
def test_csv_round_trip(tmp_path, trace):
    path = tmp_path / "my.out.csv"
    files = save_csv(trace, path)
    both = {"time", "frequency"} <= set(trace.sizes)
    assert files == [path, tmp_path / "my.out.frequency.csv"][: 1 + both]
    same(trace, load_csv(path))


BOTH = ((save_nc, load_nc, "a.nc"), (save_csv, load_csv, "a.csv"))


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
    save_csv(make_trace({"drive_voltage": (("time",), [1, 2])}, {"time": [0, 1]}, {}), tmp_path / "a.csv")
    assert load_csv(tmp_path / "a.csv").drive_voltage.dtype == np.float64


@pytest.mark.parametrize("save", [save_nc, save_csv, save_mat])
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
    save_csv(small(bad="zero\0byte"), tmp_path / "a.csv")
    assert load_csv(tmp_path / "a.csv").bad == "zero\0byte"


def test_csv_is_made_for_reading(tmp_path):
    save_csv(small(), tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert lines[0] == f"# {FORMAT}"
    assert json.loads(lines[2].removeprefix("# attributes: "))["tau"] == 0.1
    rows = [line for line in lines if line[0] != "#"]
    assert rows[0].startswith(
        "time [s],field[insulator] [V/m],field[gap] [V/m],field[stratum_corneum] [V/m],"
    )
    assert rows[0].endswith(",drive_voltage [V]")
    assert len(rows) == 6
    assert rows[4].startswith("0.30000000000000004,")
    frequency = (tmp_path / "a.frequency.csv").read_text().splitlines()
    assert ",impedance.real [ohm],impedance.imag [ohm]" in frequency[3]
    found = read_columns(tmp_path / "a.csv", {"t": ("time", "ms"), "e": ("field[gap]", "V/m")})
    np.testing.assert_array_equal(found["e"], small().field.values[1])


def test_csv_refuses_more_than_one_dimension(tmp_path):
    both = make_trace({"impedance": (("time", "frequency"), [[1.0]])}, {"time": [0], "frequency": [1]}, {})
    dates = make_trace({"current": (("time",), [1.0])}, {"time": np.array(["2024-01-01"], "M8[ns]")}, {})
    for trace, words in (
        (with_sweep(), r"one dimension, .* runs over drive\.rise, stack.*; save as \.nc or \.mat"),
        (both, "'impedance' has two"),
        (small().isel(time=0, frequency=0), "neither time nor frequency"),
        (dates, "'time' holds 'datetime64"),
    ):
        with pytest.raises(InputError, match=words):
            save_csv(trace, tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())


FLOATS, WHOLE = st.floats(width=64), st.complex_numbers(allow_nan=True, allow_infinity=True)
SPOILT = [
    (-0.0, complex(-0.0, -0.0)),
    (5e-324, complex(np.nan, -np.inf)),
    (1.7976931348623157e308, 0.1 + 0.2j),
]


@given(st.lists(st.tuples(FLOATS, WHOLE), min_size=1, max_size=8))
@example(SPOILT)
@settings(deadline=None, max_examples=60)
def test_csv_loses_no_bit(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("x") / "a.csv"
    real, whole = np.array([r for r, _ in rows]), np.array([c for _, c in rows])
    time = np.arange(len(rows), dtype=float)
    trace = make_trace({"current": (("time",), real), "impedance": (("time",), whole)}, {"time": time}, {})
    save_csv(trace, path)
    same(trace, load_csv(path))


@pytest.mark.parametrize("stop", [KeyboardInterrupt, RuntimeError])
def test_interrupted_save_leaves_the_older_files(tmp_path, monkeypatch, stop):
    every = (*BOTH, (save_mat, None, "a.mat"))
    for save, _, name in every:
        save(small(steps=1), tmp_path / name)
        with pytest.raises(InputError, match="does not exist; make it first"):
            save(small(), tmp_path / "no" / name)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    write_table = comma_separated._write_table

    def stopped(*args, **kwargs):
        raise stop

    def half(out, trace, structure, over):
        return (stopped if over == "frequency" else write_table)(out, trace, structure, over)

    monkeypatch.setattr(xarray.Dataset, "dump_to_store", stopped)
    monkeypatch.setattr(scipy.io, "savemat", stopped)
    monkeypatch.setattr(comma_separated, "_write_table", half)
    for save, _, name in every:
        with pytest.raises(stop):
            save(small(steps=2), tmp_path / name)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before
    assert len(before) == 4


# --------------------------------------------------------------------------------- files that are none


def saved(folder: Path) -> Path:
    save_csv(small(), folder / "a.csv")
    return folder / "a.csv"


def test_other_files_are_no_trace(tmp_path):
    xarray.Dataset({"x": ("t", [1.0])}).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    (tmp_path / "a.csv").write_text("time,voltage\n0,1\n1,2\n")
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
    with pytest.raises(DataFileError, match=r"a\.nc: is damaged or not a netCDF file") as caught:
        load_nc(tmp_path / "a.nc")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("0.1,", "0.1x,", r"a\.csv: .*'0.1x' .* at row 1, column 1"),
        (",-inf\n", "\n", "number of columns changed from 8 to 7 at row 3"),
        ("time [s],", "t [s],", "its columns are not those that were saved"),
        ("# attributes: {", "# attributes: {{", "damaged or not a Trace"),
        ('"sizes": ', '"size": ', "damaged or not a Trace"),
        ('"time": 5', '"time": 6', "holds 5 rows over time with 8 numbers each, but 6 with 8 were saved"),
        ('"layer": 3', '"layer": 2', "damaged or not a Trace"),
        ('"kind": "real"', '"kind": "complex"', "its columns are not"),
        ('"time": 5', '"drive.rise": 5', "damaged or not a Trace"),
        ("# structure: {", "# structure: [", "damaged or not a Trace"),
        ("# table: ", "# tables: ", "damaged or not a Trace"),
        ("# structure: ", "# structures: ", "is one part of a Trace"),
        ('"key": "', '"key": "0', "another save"),
    ],
)
def test_changed_csv(tmp_path, old, new, words):
    path = saved(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(DataFileError, match=words) as caught:
        load_csv(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("kept", "words"),
    [
        (-1, "holds 4 rows over time .*, but 5 .* were saved"),
        (6, "holds 0 rows over time"),
        (5, "its columns are not those that were saved"),
        (1, "damaged or not a Trace"),
    ],
)
def test_csv_cut_short(tmp_path, kept, words):
    path = saved(tmp_path)
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:kept]))
    with pytest.raises(DataFileError, match=words):
        load_csv(path)


def test_parts_of_a_csv_belong_together(tmp_path):
    path, other = saved(tmp_path), tmp_path / "a.frequency.csv"
    with pytest.raises(DataFileError, match=r"a\.frequency\.csv: is one part of a Trace"):
        load_csv(other)
    older, changed = other.read_bytes(), small()
    changed.impedance[3] = 7.0
    save_csv(changed, path)
    assert load_csv(path).impedance[3] == 7.0
    other.write_bytes(older)
    with pytest.raises(DataFileError, match=r"a\.frequency\.csv: is of another save"):
        load_csv(path)
    other.unlink()
    said = r"a\.frequency\.csv: there is no such file, but a\.csv was saved together"
    with pytest.raises(DataFileError, match=said):
        load_csv(path)
    save_csv(small(), path)
    save_csv(only("time"), path)  # the part of an older save is not picked up
    same(only("time"), load_csv(path))


def test_a_csv_keeps_words_beside_its_numbers(tmp_path):
    trace = small().assign_coords(phase=("time", ["rest", "touch", "slide", "slide", "rest"]))
    save_csv(trace, tmp_path / "a.csv")
    same(trace, load_csv(tmp_path / "a.csv"))


@pytest.mark.parametrize("kept", [{}, {"drive.rise": 1}, {"drive.rise": 0, "stack.gap": 2}])
def test_a_sweep_is_a_row_for_each_case(tmp_path, kept):
    random = np.random.default_rng(2)
    swept = xarray.Dataset(
        {
            "electrostatic_force": (("stack.gap", "drive.rise"), random.normal(size=(3, 2))),
            "gap": (("stack.gap",), random.normal(size=3)),
            "impedance": (("drive.rise",), random.normal(size=2) + 1j),
            "friction": (("drive.rise",), np.array(["low", "high"])),
        },
        {"drive.rise": [0.1, 0.2], "stack.gap": [1e-6, 2e-6, 3e-6]},
        {"format": FORMAT},
    ).isel(kept)
    save_csv(stamp(swept), tmp_path / "a.csv")
    same(stamp(swept), load_csv(tmp_path / "a.csv"))
    rows = [line for line in (tmp_path / "a.csv").read_text().splitlines() if line[0] != "#"]
    assert rows[0].split(",")[0].startswith(("drive.rise", "stack.gap"))
    assert len(rows) == 1 + int(np.prod(list(swept.sizes.values())))


SAVED = {".nc": save_nc, ".csv": save_csv, ".mat": save_mat}


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
    elif suffix == ".csv":
        with path.open() as file:
            heads = next(line for line in file if not line.startswith("#")).strip().split(",")
        written = {head.split(" ")[0]: head.partition(" [")[2].rstrip("]") for head in heads}
    else:
        found = scipy.io.loadmat(path, simplify_cells=True)["units"]
        written = {name: str(unit) if len(unit) else "1" for name, unit in found.items()}
    assert "C/m^2" in written.values()
    registry = pint.UnitRegistry()
    for name, unit in written.items():
        inside = SIGNALS[name.split("[")[0]].unit if name.split("[")[0] in SIGNALS else "1"
        assert registry.Quantity(1, unit) == registry.Quantity(1, inside.replace("m2", "m**2")), name
    monkeypatch.setattr("electrovib.data.trace_csv.unit_in_files", str)  # as they were written before
    SAVED[suffix](trace, tmp_path / f"old{suffix}")
    xarray.testing.assert_identical(open_trace(tmp_path / f"old{suffix}"), trace)
