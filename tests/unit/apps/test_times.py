"""``electrovib times``: its table, its folder, and what it refuses."""

import csv

import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError

TAU = 6e-3


@pytest.fixture(scope="module")
def trace(tmp_path_factory):
    """Write a record with one rising and one falling edge of an exponential, and return its path."""
    folder = tmp_path_factory.mktemp("record")
    time = np.arange(0, 1.0, 4e-4)
    random = np.random.default_rng(0)
    force = np.where(
        time < 0.6, 1 - np.exp(-np.maximum(time - 0.2, 0) / TAU), np.exp(-np.maximum(time - 0.6, 0) / TAU)
    )
    volts = np.where((time > 0.2) & (time < 0.6), 100.0, 0.0)
    rows = np.column_stack([time, force + 0.01 * random.standard_normal(time.size), volts])
    np.savetxt(folder / "force.csv", rows, delimiter=",", header="time [s],force [N],drive [V]", comments="")
    found = ev.import_file(
        folder / "force.csv", {"lateral_force_measured": "force [N]", "drive_voltage": "drive [V]"}
    )
    ev.save(found, folder / "force.nc")
    return folder / "force.nc"


def run(*arguments):
    return CliRunner().invoke(app, ["times", *map(str, arguments)], catch_exceptions=True)


def test_the_table_states_times_with_intervals(trace, tmp_path):
    out = tmp_path / "found"
    answer = run(trace, "--quantity", "lateral_force_measured", "--exponentials", "1", "-o", out)
    assert answer.exit_code == 0, answer.output
    assert "rising, 10-90 % time as recorded: 13" in answer.output
    assert "falling, time constant (exponential): 6" in answer.output
    assert "95 % interval" in answer.output
    assert sorted(path.name for path in out.iterdir()) == ["report.html", "times.csv"]
    with (out / "times.csv").open() as file:
        assert file.readline().startswith("# electrovib table as CSV")
        rows = list(csv.DictReader(file))
    time = next(row for row in rows if row["group"] == "falling" and "of the fitted form" in row["name"])
    assert float(time["value"]) == pytest.approx(TAU * np.log(9), rel=0.02)
    assert float(time["lower"]) < TAU * np.log(9) < float(time["upper"])
    assert {row["unit"] for row in rows} == {"s"}
    page = (out / "report.html").read_text()
    assert "Falling edges" in page
    assert "Forms of relaxation of the rising edges" in page
    # written again over its own files, but not over those of others
    (out / "times.csv").write_text("mine")
    refused = run(trace, "--quantity", "lateral_force_measured", "--exponentials", "1", "-o", out)
    assert isinstance(refused.exception, InputError)
    assert (out / "times.csv").read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--levels", "90"], "--levels 90"),
        (["--levels", "90:10"], "levels = "),
        (["--sensor", "fast"], "sensor = fast"),
        (["--window", "soon"], "--window"),
        (["--antiphase"], "readback"),
    ],
)
def test_a_mistake_is_one_sentence_and_nothing_is_written(trace, tmp_path, arguments, words):
    answer = run(trace, "--quantity", "lateral_force_measured", *arguments, "-o", tmp_path / "found")
    assert isinstance(answer.exception, InputError)
    assert any(words in problem for problem in answer.exception.problems)
    assert not (tmp_path / "found").exists()


def test_the_drive_marks_the_edges_and_a_sensor_is_taken_out(trace):
    answer = run(
        trace, "--quantity", "lateral_force_measured", "--by", "drive_voltage", "--sensor", "380Hz:3", "--levels", "20:80",
        "--exponentials", "1", "--edges", "falling",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.output
    assert "falling, delay" in answer.output
    assert "20-80 % time of an instantaneous change through the sensor" in answer.output
    assert "rising" not in answer.output


def test_the_python_names_are_public(trace):
    found = ev.measure_times(xarray.load_dataset(trace), signal="lateral_force_measured", exponentials=1)
    assert found.falling.form == "exponential"
    assert ev.Sensor(frequency=380.0, quality=3.0).shortest_time() == pytest.approx(0.489e-3, rel=1e-3)
