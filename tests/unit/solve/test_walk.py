"""A record in many stretches has the signals, largest values and errors of the same record in one."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.diagnostics import diagnostics_of
from electrovib.papers import palmar_1995
from electrovib.solve.diagnostics import peaks
from electrovib.solve.electrics import transient

COUNT = 25_000
STAMPS = np.arange(COUNT) * 1e-6
JITTERED = STAMPS + 2e-7 * np.random.default_rng(2).uniform(-1, 1, COUNT) * (STAMPS > 0)
VOLTS = 20 + np.round(100 * np.sin(2 * np.pi * 500 * STAMPS), 2)
SINE = {"model": "Sine", "amplitude": 100.0, "frequency": 300.0}
CHIRP = {"model": "Chirp", "amplitude": 50.0, "first": 100.0, "last": 400.0, "length": 0.1}
GRID = {"time.duration": 0.1, "time.samples": COUNT}
PERIODIC = {"time.initial_state": {"model": "PeriodicState"}}
SKIN = palmar_1995.skins()["dry_men"].material.to_dict()


def record(stamps):
    return {"drive": {"model": "Sampled", "time_samples": stamps, "voltage_samples": VOLTS}}


@pytest.mark.parametrize("law", ["fig6_gap", "fig6"])
@pytest.mark.parametrize(
    "changes",
    [
        pytest.param(record(STAMPS), id="even stamps"),
        pytest.param(record(JITTERED), id="jittered stamps"),
        pytest.param({"drive": SINE} | GRID, id="sine from rest"),
        pytest.param({"drive": SINE} | GRID | PERIODIC, id="periodic state"),
        pytest.param({"drive": {"model": "Square", "high": 100.0, "frequency": 300.0}} | GRID, id="square"),
        pytest.param({"drive": CHIRP} | GRID, id="formula"),
    ],
)
def test_stretches_are_the_whole(law, changes, monkeypatch):
    scenario = ev.load(f"vezzoli_2014/{law}").replace({"stack.stratum_corneum.material": SKIN} | changes)
    monkeypatch.setattr(peaks, "_MANY", 10_000)
    whole = ev.simulate(scenario)
    monkeypatch.setattr(transient, "STRETCH", 10_240)
    found = ev.simulate(scenario)
    assert list(found) == list(whole)
    for name in whole:
        size = float(np.abs(whole[name]).max())
        np.testing.assert_allclose(found[name], whole[name], rtol=0, atol=2e-12 * size, err_msg=name)
    for name in ("transfer_error", "attraction_error"):
        assert found.attrs[name] == pytest.approx(whole.attrs[name], rel=1e-6)
    said = [[each.text for each in diagnostics_of(trace)] for trace in (found, whole)]
    assert said[0] == said[1]
