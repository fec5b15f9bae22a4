"""The verdict of ``electrovib fit``: five lines, an exit code of its own, and what was taken from a recording."""

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.scenario.toml import to_toml

GAP, LEAK = "stack.gap.thickness", "stack.gap.material.conductivity"
PULSE = {"model": "Trapezium", "high": "100 V", "rise": "10 us", "hold": "20 ms", "fall": "10 us"}
GRID = {"model": "TimeGrid", "duration": "30 ms"}
TIMES = np.linspace(0, 30e-3, 60)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A force of 100 V with 1 % of noise and the recorded voltage, its model, one without leak and one of 300 V."""
    place, rng = tmp_path_factory.mktemp("verdict"), np.random.default_rng(6)
    plate = ev.load("bau_2010/sine").replace({"drive": PULSE, "time": GRID, LEAK: "2e-9 S/m"})
    force = ev.prepare(plate, free=[GAP]).signals([3e-6], names=["electrostatic_force"], time=TIMES)
    values = force["electrostatic_force"]
    values = values + 0.01 * values.max() * rng.normal(size=TIMES.size)
    voltage = plate.drive.voltage(TIMES) + 0.2 * rng.normal(size=TIMES.size)
    signals = {"electrostatic_force": (("time",), values), "drive_voltage": (("time",), voltage)}
    ev.save(make_trace(signals, {"time": TIMES}, {}), place / "a.nc")
    (place / "right.toml").write_text(to_toml(plate))
    (place / "wrong.toml").write_text(to_toml(plate.replace({LEAK: 0.0})))
    (place / "high.toml").write_text(to_toml(plate.replace({"drive.high": "300 V"})))
    return place


def fitted(folder, scenario, *options):
    words = ["fit", str(folder / scenario), str(folder / "a.nc"), "--free", GAP, *options]
    return CliRunner().invoke(app, words)


def test_a_model_that_does_not_describe_its_recording_ends_with_3_and_says_so_in_every_file(folder, tmp_path):
    found = fitted(folder, "wrong.toml", "-o", str(tmp_path / "out"))
    assert found.exit_code == 3
    assert found.output.startswith(
        "warning: the model does not describe this recording: electrostatic_force of a.nc"
    )
    for name in ("report.html", "parameters.csv", "parameters.toml", "space.toml"):
        text = (tmp_path / "out" / name).read_text().lower()
        assert "the model does not describe this recording" in text, name
    assert ",misfit," in (tmp_path / "out" / "parameters.csv").read_text()


def test_the_right_model_ends_with_0(folder):
    found = fitted(folder, "right.toml")
    assert found.exit_code == 0, found.output
    assert "does not describe" not in found.output


def test_a_voltage_that_differs_is_stated_with_both_numbers_and_refused_where_it_was_set(folder):
    found = fitted(folder, "high.toml")
    assert found.exit_code == 0, found.output
    assert "a.nc: the drive has up to 100." in found.output
    assert "300 V in the scenario" in found.output
    refused = fitted(folder, "right.toml", "--set", "drive.high=300 V")
    assert isinstance(refused.exception, InputError)
    assert "--keep drive" in str(refused.exception)
    kept = fitted(folder, "right.toml", "--set", "drive.high=300 V", "--keep", "drive")
    assert kept.exit_code in {0, 3}
    assert f"{GAP}: 1" in kept.output  # um, three times as wide and more


@pytest.mark.parametrize(
    "options", [[], ["--free", LEAK, "--free", "stack.insulator.thickness", "--free", "contact.area"]]
)
def test_the_verdict_has_five_lines_at_most_and_help_begins_with_an_example(folder, options):
    told = fitted(folder, "wrong.toml", *options).output.splitlines()
    of_scenario = ("warning: the voltage across", "not judged:")  # which every command prints
    assert len([line for line in told if not line.startswith(of_scenario)]) <= 5
    told = CliRunner().invoke(app, ["fit", "-h"]).output.splitlines()
    assert told[2].strip().startswith("Example: electrovib fit my.toml")
