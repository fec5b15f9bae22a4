"""For generated drives, formats and limits: what exceeds a limit is never written, and what is written is never clipped."""

import math
from pathlib import Path

import numpy as np
import pytest
from waveform_files import read_back

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.exports.waveform_formats import WAVEFORM_FORMATS
from electrovib.physics.drive.sampled import Held
from electrovib.studies.check import sampled
from electrovib.studies.check.function import checked_values

pytestmark = pytest.mark.filterwarnings(r"ignore:export_waveform\(largest_error=")

EDGE = 5e-6
JOINED = {suffix: {} if suffix == ".pwl" else {"edge": "line"} for suffix in WAVEFORM_FORMATS}
FORMS = list(JOINED.items())
FORMS.append((".csv", {"instrument": "hp_33120a", "scaling": ev.Scaling(gain=100.0), "edge": EDGE}))
SCALES = (0.5, 0.999, math.nan, 1.001, 2.0)
"""Limit over the value that the drive reaches; NaN stands for the next number below it."""
BASE = ev.load("vezzoli_2014/fig6").replace({"limits": {}, "stack.insulator.breakdown_field": "10 GV/m"})


def drive_of(draw):
    """A random drive that begins and ends at 0 V."""
    kind = draw.integers(4)
    high = float(draw.uniform(-800, 800))
    if kind == 0:
        rise, hold, fall = draw.uniform(0.5e-3, 5e-3, 3).tolist()
        return {"model": "Trapezium", "high": high, "low": 0.0, "rise": rise, "hold": hold, "fall": fall}
    if kind == 1:
        return {"model": "Sine", "amplitude": abs(high), "frequency": float(draw.integers(50, 3000))}
    if kind == 2:
        times = np.append(0.0, np.cumsum(draw.uniform(0.2e-3, 2e-3, 6)))
        inner = draw.uniform(-500, 500, 5).tolist()
        return {"model": "Sampled", "time_samples": times.tolist(), "voltage_samples": [0.0, *inner, 0.0]}
    frequency = float(draw.integers(100, 2000))
    return {"model": "Burst", "amplitude": abs(high), "frequency": frequency, "cycles": 3}


def exported(scenario, path, limits, options):
    """The waveform, or the words with which it is refused."""
    try:
        return ev.export_waveform(scenario, path, limits=limits, largest_error=0.05, **options), ""
    except InputError as error:
        return None, str(error)


@pytest.mark.parametrize("seed", range(36))
def test_what_is_written_is_within_every_limit_and_the_rest_is_not_written(seed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    draw = np.random.default_rng(seed)
    scenario = BASE.replace({"drive": drive_of(draw)})
    if draw.integers(2):
        stray = {"stray_capacitance": float(draw.uniform(0, 500e-12))}
        scenario = scenario.replace({"circuit.amplifier": stray})
    reached = checked_values(scenario).largest
    limits = {"voltage": 2e3, "current": 1.0}
    for name in draw.permutation(list(reached))[: draw.integers(1, 4)].tolist():
        scale = float(draw.choice(SCALES))
        limits[name] = float(np.nextafter(reached[name], 0)) if math.isnan(scale) else scale * reached[name]
    suffix, options = FORMS[seed % len(FORMS)]
    exceeded = [name for name, limit in limits.items() if reached[name] > limit]
    found, refused = exported(scenario, f"drive{suffix}", limits, options)
    if found is None:
        assert not list(Path().iterdir()), "nothing is written, and nothing is left half written"
        if "puts out at least 0.1 V" in refused:
            assert scenario.drive.largest() < 0.05 * options["scaling"].gain
            return
        assert "above" in refused
        near = [name for name, limit in limits.items() if reached[name] > 0.9 * limit]
        assert near, "a drive far within its limits is written"
        return
    assert not exceeded
    times, voltages = read_back(found.path, found.full_scale)
    drive = sampled(times, voltages)
    if "instrument" in options:
        drive = Held(samples=drive, edge=min(EDGE, times[1]))
    again = checked_values(scenario.model_copy(update={"drive": drive}))
    for name, limit in limits.items():
        assert again.largest[name] <= limit * (1 + 1e-12)
    assert np.max(np.abs(voltages)) <= limits["voltage"]
    played = times <= scenario.drive.duration
    off = np.max(np.abs(voltages - scenario.drive.voltage(times))[played])
    assert off <= found.waveform.error + 1e-9, "not clipped"
    assert (voltages[0], voltages[-1]) == (0, 0)


RAMP = {"model": "Trapezium", "high": 100, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3}


@pytest.mark.parametrize("suffix", WAVEFORM_FORMATS)
@pytest.mark.parametrize("limit", [100.0, np.nextafter(100.0, 0)])
def test_a_voltage_at_exactly_its_limit_is_written_and_above_it_refused(suffix, limit, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scenario = BASE.replace({"drive": RAMP, "limits": {"voltage": limit, "current": 1.0}})
    if limit < 100:
        with pytest.raises(InputError, match="above 100 V"):
            ev.export_waveform(scenario, f"drive{suffix}", **JOINED[suffix])
        assert not list(tmp_path.iterdir())
    else:
        found = ev.export_waveform(scenario, f"drive{suffix}", largest_error=0.05, **JOINED[suffix])
        assert np.max(read_back(found.path, found.full_scale)[1]) == pytest.approx(100, rel=1e-6)


def test_the_strictest_of_scenario_and_file_counts(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for own, other in ((90, 500), (500, 90)):
        scenario = BASE.replace({"drive": RAMP, "limits": {"voltage": own, "current": 1.0}})
        with pytest.raises(InputError, match="above 90 V"):
            ev.export_waveform(scenario, "drive.csv", limits={"voltage": other, "current": 2.0}, edge="line")
    assert not list(tmp_path.iterdir())
