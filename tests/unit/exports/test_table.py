"""A Trace as a table of plain values: what a spreadsheet, pandas and an import find in it."""

import math

import numpy as np
import pandas as pd
import pytest
import xarray
from hypothesis import example, given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import DataFileError, InputError
from electrovib.core.signals import FORMAT, make_trace
from electrovib.data.registry import read_columns
from electrovib.exports.save import save_csv

TIME, LAYERS = np.arange(5) * 0.1, ["insulator", "gap"]


def small(**attributes) -> xarray.Dataset:
    random = np.random.default_rng(1)
    signals = {
        "field": (("layer", "time"), random.standard_normal((2, 5))),
        "displacement": (("time", "layer"), random.standard_normal((5, 2))),
        "drive_voltage": (("time",), [np.nan, np.inf, -np.inf, -0.0, 5e-324]),
        "normal_force": ((), 0.5),
        "field_gain": (("frequency", "layer"), random.standard_normal((3, 2)) + 1j),
        "impedance": (("frequency",), [1 + 2j, complex(np.nan, 1), -(0.0 + 0.0j)]),
    }
    return make_trace(signals, {"time": TIME, "frequency": [1.0, 2.0, 3.0], "layer": LAYERS}, attributes)


def read(path) -> pd.DataFrame:
    return pd.read_csv(path, comment="#")


def test_a_row_for_each_time_with_the_unit_in_the_head(tmp_path):
    validity = '[{"name": "a", "state": "warning", "text": "not sure"}]'
    trace = small(title="A run", validity=validity)
    assert save_csv(trace, tmp_path / "a.csv") == [tmp_path / "a.csv"]
    head = [line for line in (tmp_path / "a.csv").read_text().splitlines() if line.startswith("#")]
    assert head[1:] == [
        "# A run",
        "# not in this table, but in .nc and .mat: field_gain, impedance, frequency",
        "# warning: not sure",
    ]
    table = read(tmp_path / "a.csv")
    assert list(table) == [
        "time [s]", "field[insulator] [V/m]", "field[gap] [V/m]", "displacement[insulator] [C/m^2]",
        "displacement[gap] [C/m^2]", "drive_voltage [V]", "normal_force [N]",
    ]  # fmt: skip
    np.testing.assert_array_equal(table["field[gap] [V/m]"], trace.field.to_numpy()[1])
    np.testing.assert_array_equal(table["displacement[gap] [C/m^2]"], trace.displacement.to_numpy()[:, 1])
    np.testing.assert_array_equal(table["drive_voltage [V]"], trace.drive_voltage)
    assert set(table["normal_force [N]"]) == {0.5}


def test_without_time_the_rows_are_frequencies_and_a_complex_number_has_two_columns(tmp_path):
    trace = small().drop_dims("time")
    save_csv(trace, tmp_path / "a.csv")
    table = read(tmp_path / "a.csv")
    np.testing.assert_array_equal(table["frequency [Hz]"], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(table["impedance.real [ohm]"], trace.impedance.to_numpy().real)
    np.testing.assert_array_equal(table["field_gain[gap].imag [1]"], trace.field_gain.to_numpy()[:, 1].imag)


def test_it_is_read_as_a_measured_table_and_not_opened_as_a_trace(tmp_path):
    save_csv(small(), tmp_path / "a.csv")
    found = read_columns(tmp_path / "a.csv", {"t": ("time", "ms"), "e": ("field[gap]", "V/m")})
    np.testing.assert_array_equal(found["t"], TIME)
    np.testing.assert_array_equal(found["e"], small().field.to_numpy()[1])
    trace = ev.import_file(tmp_path / "a.csv", {"normal_force": "normal_force"})
    np.testing.assert_array_equal(trace.time, TIME)
    with pytest.raises(DataFileError, match=r"a table of numbers.* 'electrovib import .*a\.csv'"):
        ev.open_trace(tmp_path / "a.csv")


FLOATS, WHOLE = st.floats(width=64, allow_nan=False), st.complex_numbers(allow_nan=False)


@given(st.lists(st.tuples(FLOATS, WHOLE), min_size=1, max_size=8))
@example([(-0.0, complex(-0.0, -0.0)), (5e-324, complex(1, -np.inf)), (1.7976931348623157e308, 0.1 + 0.2j)])
@settings(deadline=None, max_examples=60)
def test_a_number_has_all_its_digits(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("x") / "a.csv"
    real, whole = np.array([r for r, _ in rows]), np.array([c for _, c in rows])
    signals = {"current": (("time",), real), "impedance": (("time",), whole)}
    save_csv(make_trace(signals, {"time": np.arange(len(rows), dtype=float)}, {}), path)
    table = read(path)
    for column, values in {"current [A]": real, "impedance.imag [ohm]": whole.imag}.items():
        assert table[column].to_numpy(float).tobytes() == values.tobytes()


def test_more_than_one_dimension_is_refused(tmp_path):
    swept = small().drop_dims("frequency").expand_dims({"drive.rise": [1.0, 2.0]})
    for trace, words in (
        (swept, r"one dimension, .* runs over drive\.rise; save as \.nc or \.mat"),
        (small().isel(time=0, frequency=0), "neither time nor frequency"),
    ):
        with pytest.raises(InputError, match=words):
            save_csv(trace, tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kept", [{}, {"drive.rise": 1}, {"drive.rise": 0, "stack.gap": 2}])
def test_a_sweep_is_a_row_for_each_case(tmp_path, kept):
    random = np.random.default_rng(2)
    swept = xarray.Dataset(
        {
            "electrostatic_force": (("stack.gap", "drive.rise"), random.normal(size=(3, 2))),
            "gap": (("stack.gap",), random.normal(size=3)),
            "friction": (("drive.rise",), np.array(["low", "high"])),
        },
        {"drive.rise": [0.1, 0.2], "stack.gap": [1e-6, 2e-6, 3e-6]},
        {"format": FORMAT},
    ).isel(kept)
    save_csv(swept, tmp_path / "a.csv")
    table = read(tmp_path / "a.csv")
    assert len(table) == math.prod(swept.sizes.values())
    for _, row in table.iterrows():
        place = {name: row[name] for name in swept.sizes}
        case = swept.sel(place)
        assert (row["electrostatic_force [N]"], row["friction"]) == (case.electrostatic_force, case.friction)


def test_a_table_of_ours_is_replaced_and_an_edited_one_is_not(tmp_path):
    path = tmp_path / "a.csv"
    for _ in range(2):
        save_csv(small(), path)
    path.write_text(path.read_text().replace("0.5", "0.6"))
    with pytest.raises(InputError, match="exists already and is no table as CSV that electrovib wrote"):
        save_csv(small(), path)
