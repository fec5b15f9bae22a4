"""A record in many stretches has the signals, largest values and errors of the same record in one."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.diagnostics import diagnostics_of
from electrovib.papers import palmar_1995
from electrovib.solve.diagnostics import peaks
from electrovib.solve.electrics import transient
from electrovib.solve.expanded import Expanded
from electrovib.solve.stack.expand import Surroundings, shortest_time
from electrovib.solve.stack.keys import DisplacementOf, FieldOf

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


@pytest.mark.parametrize("law", ["fig6_gap", pytest.param("fig6", marks=pytest.mark.slow)])
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


@pytest.mark.parametrize(
    ("row", "place"),
    [
        ([1.0, -3.0, 2.0], 1),
        ([1.0, 3.0, -2.0], 1),
        ([0.0, -2.0, 2.0, -2.0], 1),
        ([0.0, 2.0, -2.0, 2.0], 1),
        ([np.nan, 1.0, -np.inf, -2.0], 3),
        ([np.nan, 5.0, -1.0, 3.0], 1),
    ],
)
def test_the_farthest_value_from_0_is_the_first_finite_one(row, place):
    assert peaks._farthest(np.array(row)) == place == peaks._largest(np.array(row))


@pytest.mark.parametrize(
    "circuit",
    [
        {},
        {"circuit.amplifier": {"stray_capacitance": 1e-9}},
        {"circuit.return_path": {"model": "SecondElectrode", "area": 2e-4}},
    ],
)
def test_energy_is_stored_in_all_layers_in_both_contacts_and_in_stray_capacitance(circuit):
    scenario = ev.load("vezzoli_2014/fig6_gap").replace(circuit)
    found = Expanded(scenario).at(scenario.time.times(scenario.drive)).solution.found
    record = peaks.PeakRecord.of(scenario, scenario.time.times(scenario.drive), found)
    around, layers = Surroundings.of(scenario), scenario.stack.layers
    each = [layers[name].thickness * found[FieldOf(name)] * found[DisplacementOf(name)] for name in layers]
    stray = 1e-9 if "circuit.amplifier" in circuit else 0.0
    expected = (1 + around.second) * around.area * sum(each) / 2 + stray * record.rows["voltage"] ** 2 / 2
    np.testing.assert_allclose(record.rows["stored_energy"], expected, rtol=1e-12, atol=0)


def test_the_shortest_time_after_a_corner_is_found_among_all_output_times():
    times = np.sort(np.append(np.linspace(0, 3e-3, 50), [1e-3, 1e-3 + 3e-7, 2e-3 + 1e-7, 2e-3 * (1 + 1e-13)]))
    drive = {"model": "Trapezium", "high": 100, "rise": 1e-3, "hold": 1e-3, "fall": 1e-4}
    scenario = ev.load("vezzoli_2014/fig6").replace({"drive": drive})
    assert shortest_time(scenario, times) == pytest.approx(1e-7, rel=1e-6)
    assert shortest_time(scenario, times[:-1][times[:-1] < 2e-3]) == pytest.approx(3e-7, rel=1e-6)


def test_a_record_of_very_many_samples_is_looked_at_between_the_first_and_between_the_last_of_them():
    drive = ev.load("vezzoli_2014/fig6_gap").replace(record(STAMPS)).drive
    found = peaks.evaluation_times(drive, end=STAMPS[-1], settled=False, seen=STAMPS)
    spans = np.unique(np.searchsorted(STAMPS, found, side="right") - 1)
    half = peaks.FEW_CORNERS // 2
    assert set(spans) >= {*range(half), *range(COUNT - 1 - half, COUNT - 1)}
