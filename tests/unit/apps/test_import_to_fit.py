"""From the file of an instrument to a parameter with both of its uncertainties, through the commands."""

import csv
import json

import numpy as np
import pytest
from tests.unit.apps.written import uncommented
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.recordings.calibration_error import CalibrationError
from electrovib.scenario.toml import to_toml

GAP, FORCE = "stack.gap.thickness", "electrostatic_force"
PLATE = {
    "drive": {"model": "Trapezium", "high": "100 V", "rise": "10 us", "hold": "20 ms", "fall": "10 us"},
    "time": {"model": "TimeGrid", "duration": "30 ms"},
    "stack.gap.material.conductivity": "2e-9 S/m",
}
SENSITIVITY = 0.05
"""N/V of the sensor; its readings below are in mV."""


def run(*words):
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 0, (result.output, result.exception)
    return result.output


def gap_row(folder):
    lines = uncommented(folder / "parameters.csv")
    return next(row for row in csv.DictReader(lines) if row["name"] == GAP)


@pytest.fixture
def recorded(tmp_path, monkeypatch):
    """A recorded step, and the readings of its sensor under five weights with a scatter of 1 %."""
    monkeypatch.chdir(tmp_path)
    plate, rng = ev.load("bau_2010/sine").replace(PLATE), np.random.default_rng(5)
    (tmp_path / "plate.toml").write_text(to_toml(plate))
    trace = ev.simulate(plate)
    time = np.linspace(1e-3, 29e-3, 60)
    force = np.interp(time, trace["time"].values, trace[FORCE].values)
    force += 0.003 * force.max() * rng.normal(size=time.size)
    rows = "\n".join(
        f"{t!r},{1e3 * f / SENSITIVITY!r}" for t, f in zip(time.tolist(), force.tolist(), strict=True)
    )
    (tmp_path / "a.csv").write_text(f"t [s],u [mV]\n{rows}")
    weights = np.linspace(0, 1.2 * force.max(), 5)
    scatter = 0.01 * force.max() * np.array([1.0, -1.5, 0.5, 1.0, -1.0])
    known = [
        f"{1e3 * (w + e) / SENSITIVITY!r},{w!r}"
        for w, e in zip(weights.tolist(), scatter.tolist(), strict=True)
    ]
    (tmp_path / "cal.csv").write_text("\n".join(["u [mV],F [N]", *known]))
    return tmp_path


def test_a_calibration_at_import_is_the_systematic_error_of_the_fit(recorded):
    calibrated = ["--column", f"{FORCE}=u", "--set", f"calibration.{FORCE}=cal.csv"]
    run("import", "a.csv", *calibrated, "-o", "a.nc")
    stated = ev.open_trace("a.nc")[FORCE].attrs
    said = run("fit", "plate.toml", "a.nc", "--free", GAP, "-o", "fit")
    row = gap_row(recorded / "fit")
    assert float(row["systematic"]) > 0
    assert "by calibration" in said
    assert "y calibration" in (recorded / "fit" / "report.html").read_text()
    line = ev.calibrate(*(np.loadtxt("cal.csv", delimiter=",", skiprows=1).T * [[1e-3], [1.0]]))
    assert stated["gain_uncertainty"] == pytest.approx(np.sqrt(line.covariance[1, 1]) / line.sensitivity)
    assert stated["zero_uncertainty"] == pytest.approx(
        line.standard_uncertainty(-line.intercept / line.sensitivity)
    )
    error = CalibrationError.from_attributes(stated)
    assert -1 < error.covariance / (error.gain * error.zero) < -0.5
    bare = ev.open_trace("a.nc")
    bare[FORCE].attrs = {"units": "N"}
    by_hand = ev.fit("plate.toml", bare, free=[GAP], calibration={FORCE: error})
    assert by_hand.rows[0].systematic == float(row["systematic"])


def test_a_baseline_removes_the_zero_error_and_no_calibration_states_none(recorded):
    calibrated = ["--column", f"{FORCE}=u", "--set", f"calibration.{FORCE}=cal.csv"]
    run("import", "a.csv", *calibrated, "--set", f"baseline.{FORCE}=25 ms..29 ms", "-o", "a.nc")
    stated = ev.open_trace("a.nc")[FORCE].attrs
    assert stated["zero_uncertainty"] == stated["gain_zero_covariance"] == 0 < stated["gain_uncertainty"]
    run("import", "a.csv", "--column", f"{FORCE}=u", "--set", f"scale.{FORCE}=0.05 N/V", "-o", "b.nc")
    run("fit", "plate.toml", "b.nc", "--free", GAP, "-o", "fit")
    assert gap_row(recorded / "fit")["systematic"] in ("", "nan")
    assert json.loads(ev.open_trace("b.nc").attrs["options"])["scale"] == {FORCE: "0.05 N/V"}
