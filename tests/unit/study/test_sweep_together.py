"""Cases that share a stack are solved at once, with the numbers, errors and diagnostics of each on its own."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.papers import palmar_1995
from electrovib.physics.tabulated import Tabulated
from electrovib.scenario import load
from electrovib.solve.quantities import Together, answer, read_name, solved, together
from electrovib.study.sweep import sweep
from electrovib.study.sweep.run import _scenarios

FIG6, BAU = "vezzoli_2014/fig6", "bau_2010/sine"
SETTLED = {
    "drive": {"model": "Sine", "amplitude": 100.0, "frequency": 1e3},
    "time.initial_state": {"model": "PeriodicState"},
}
NAMES = [
    "mean electrostatic_force",
    "swing lateral_force",
    "peak current",
    "rms field in insulator",
    "minimum drive_voltage",
]
SKIN = {"stack.stratum_corneum.material": palmar_1995.skins()["dry_men"].material.to_dict()}
OVER = {"stack.insulator.thickness": [1e-6, 30e-6], "drive.frequency": [3e-1, 10.0, 1e3, 3e5]}
LOUD = OVER | {"drive.amplitude": [20.0, 500.0]}
MODULATED = {"model": "AmplitudeModulation", "amplitude": 50, "carrier": 1e3, "modulation": 100, "depth": 0.5}
GROWING = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}
TABLE = {"stack.stratum_corneum.material": {"model": "Tabulated"} | Tabulated.example}
INEXACT = ("transfer_error", "attraction_error")
"""Least squares, of which the last digits depend on how many cases share one matrix."""


def settled(preset, changes):
    return load(preset).replace(SETTLED | changes)


def assert_same(found, alone):
    """Compare the answer of a case with that of the case alone."""
    assert list(found.values) == list(alone.values)
    ours, theirs = ([*each.values.values()] for each in (found, alone))
    np.testing.assert_allclose(ours, theirs, rtol=1e-12)
    np.testing.assert_allclose([*found.errors.values()], [*alone.errors.values()], atol=1e-15)
    exact = [each.how | dict.fromkeys(INEXACT, 0) for each in (found, alone)]
    assert exact[0] == exact[1]
    for name in INEXACT:
        assert found.how.get(name, 0) == pytest.approx(alone.how.get(name, 0), rel=1e-8)
    for each, other in zip(found.diagnostics, alone.diagnostics, strict=True):
        words = [(one.name, one.state, one.text, one.unit) for one in (each, other)]
        assert words[0] == words[1]
        numbers = [np.array([one.value, one.limit], float) for one in (each, other)]
        np.testing.assert_allclose(*numbers, rtol=1e-9)


@pytest.mark.parametrize(
    ("preset", "changes", "over", "alone"),
    [
        (FIG6, SKIN, LOUD, 4),  # alone are those whose materials need another band
        ("vezzoli_2014/fig6_gap", SKIN, LOUD, 4),
        (BAU, {}, LOUD, 4),
        (FIG6, TABLE, {"drive.frequency": [3.0, 5.0, 100.0, 1e3, 3e5, 4e5]}, 6),
        (BAU, {"drive": MODULATED}, {"drive.amplitude": [3.0, 40.0], "drive.depth": [0.2, 1.0]}, 0),
        (FIG6, {"drive": MODULATED}, {"drive.amplitude": [3.0, 40.0]}, 0),
        (BAU, {"drive": MODULATED}, {"drive.modulation": [100.0, 200.0, 250.0]}, 3),
        (BAU, {"drive": MODULATED}, {"drive.modulation": [50.0, 100.0, 50.0]}, 1),
        # the area under the larger attraction is not resolved by the first pieces
        (BAU, {"contact": GROWING}, {"drive.amplitude": [20.0, 300.0], "drive.phase": [0.0, 1.0]}, 2),
        (BAU, {"limits.rms_current": 1e-6}, {"drive.amplitude": [20.0, 60.0]}, 0),
        (BAU, {}, {"drive.amplitude": [0.0, 20.0, 40.0], "drive.offset": [0.0, 5.0]}, 4),
        (BAU, {"friction.coefficient": 0.3}, {"drive.frequency": [30.0, 300.0]}, 0),
    ],
)
def test_cases_of_one_stack_answer_as_each_alone(preset, changes, over, alone, monkeypatch):
    scenario = settled(preset, changes)
    names = [read_name(text, tuple(scenario.stack.layers)) for text in NAMES]
    grid = np.array(np.meshgrid(*over.values(), indexing="ij")).reshape(len(over), -1)
    points = [dict(zip(over, values, strict=True)) for values in grid.T.tolist()]
    found = Together(_scenarios(scenario, points), names)
    asked_alone = []
    monkeypatch.setattr(
        "electrovib.solve.quantities.together.answer",
        lambda expanded, names: asked_alone.append(expanded) or answer(expanded, names),
    )
    for place, point in enumerate(points):
        own = answer(solved(scenario.replace(point)), names)
        assert_same(found.answer(place), own)
        if changes is TABLE:  # below its first frequency
            remembered = point["drive.frequency"] >= Tabulated.example["frequency_samples"][0]
            assert ("memory" in [each.name for each in own.diagnostics]) == remembered
    assert len(asked_alone) <= alone if over is LOUD or changes is TABLE else len(asked_alone) == alone


def test_a_sweep_is_the_same_in_any_order_of_its_parameters():
    scenario = settled(FIG6, SKIN)
    one, other = (sweep(scenario, dict(each), quantities=NAMES) for each in (OVER, reversed(OVER.items())))
    for name in NAMES:
        np.testing.assert_allclose(other[name].transpose(*one[name].dims), one[name], rtol=1e-12)
    judged = [json.loads(trace.attrs["validity"]) for trace in (one, other)]
    ours, theirs = ({each["name"]: each["value"] for each in found if "value" in each} for found in judged)
    assert ours == pytest.approx(theirs, rel=1e-9)


@pytest.mark.parametrize(
    "change",
    [
        {"time.initial_state": {"model": "AtRest"}},
        {"drive.offset": 20.0},
        {"load.time_profile": {"model": "Press", "begin": 0.0, "rise": 0.1}},
        {"drive.amplitude": 0.0},
        {"drive": {"model": "Square", "high": 50, "frequency": 100}},
        {"circuit.amplifier": {"model": "Amplifier", "bandwidth": 1e4}},
    ],
)
def test_other_drives_states_and_circuits_are_left_to_their_own_solvers(change):
    scenario = settled(BAU, {})
    assert together.is_of_tones(scenario)
    assert not together.is_of_tones(scenario.replace(change))


def test_a_drive_of_nothing_among_others_and_more_cases_than_are_held_at_once(monkeypatch):
    trace = sweep(settled(FIG6, {}), {"drive.amplitude": [0.0, 1.0, 2.0]}, quantities=NAMES[:1])
    values = trace["mean electrostatic_force"].values
    assert values[0] == 0
    np.testing.assert_allclose(values[2], 4 * values[1], rtol=1e-12)
    monkeypatch.setattr("electrovib.solve.quantities.together.MOST", 260)  # three of 86 times
    frequencies = [100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0]
    scenario, asked = settled(FIG6, {}), ["peak current"]
    found = sweep(scenario, {"drive.frequency": frequencies}, quantities=asked)["peak current"].values
    each = (sweep(scenario.replace({"drive.frequency": at}), {}, quantities=asked) for at in frequencies)
    np.testing.assert_allclose(found, [float(alone["peak current"]) for alone in each], rtol=1e-12)


def test_a_load_that_changes_bends_the_signals_of_a_sine():
    """The pieces end where the load begins to rise, so that the mean of the friction is exact."""
    pressed = {"load.time_profile": {"model": "Press", "begin": 0.13e-3, "rise": 0.31e-3}}
    scenario = settled(FIG6, {"drive.amplitude": 1e-3} | pressed)
    trace = sweep(scenario, {}, quantities=["mean normal_force", "minimum normal_force"])
    share = (0.5 * 0.31e-3 + 1e-3 - 0.44e-3) / 1e-3
    assert float(trace["mean normal_force"]) == pytest.approx(scenario.load.normal_force * share, rel=1e-12)
    assert float(trace["minimum normal_force"]) == pytest.approx(0.0, abs=1e-15)
