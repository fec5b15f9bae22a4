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
SKIN = palmar_1995.skins()["dry_men"].material.to_dict()
OVER = {"stack.insulator.thickness": [1e-6, 30e-6], "drive.frequency": [3e-1, 10.0, 1e3, 3e5]}


def dispersive(preset: str):
    return load(preset).replace({"stack.stratum_corneum.material": SKIN} | SETTLED)


def points_of(over):
    return [
        dict(zip(over, values, strict=True))
        for values in np.array(np.meshgrid(*over.values(), indexing="ij")).reshape(len(over), -1).T.tolist()
    ]


def assert_same_diagnostics(found, alone):
    assert [(each.name, each.state) for each in found] == [(each.name, each.state) for each in alone]
    for each, other in zip(found, alone, strict=True):
        assert (each.text, each.unit) == (other.text, other.unit)
        np.testing.assert_allclose(
            np.array([each.value, each.limit], float), np.array([other.value, other.limit], float), rtol=1e-9
        )


INEXACT = ("transfer_error", "attraction_error")
"""Least squares, of which the last digits depend on how many cases share one matrix."""


@pytest.mark.parametrize("preset", ["vezzoli_2014/fig6", "vezzoli_2014/fig6_gap", "bau_2010/sine"])
def test_cases_of_one_stack_answer_as_each_alone(preset, monkeypatch):
    plain = preset == "bau_2010/sine"
    scenario = load(preset).replace(SETTLED) if plain else dispersive(preset)
    over = OVER | {"drive.amplitude": [20.0, 500.0]}
    names = [read_name(text, tuple(scenario.stack.layers)) for text in NAMES]
    points = points_of(over)
    together = Together(_scenarios(scenario, points), names)
    asked_alone = []
    monkeypatch.setattr(
        "electrovib.solve.quantities.together.answer",
        lambda expanded, names: asked_alone.append(expanded) or answer(expanded, names),
    )
    for place, point in enumerate(points):
        found, alone = together.answer(place), answer(solved(scenario.replace(point)), names)
        assert list(found.values) == list(alone.values)
        np.testing.assert_allclose(list(found.values.values()), list(alone.values.values()), rtol=1e-12)
        np.testing.assert_allclose(list(found.errors.values()), list(alone.errors.values()), atol=1e-15)
        exact = {**found.how} | dict.fromkeys(INEXACT, 0)
        assert exact == {**alone.how} | dict.fromkeys(INEXACT, 0)
        for name in INEXACT:
            assert found.how.get(name, 0) == pytest.approx(alone.how.get(name, 0), rel=1e-8)
        assert_same_diagnostics(found.diagnostics, alone.diagnostics)
    assert len(asked_alone) <= 4  # those whose materials need another band


MODULATED = {"model": "AmplitudeModulation", "amplitude": 50, "carrier": 1e3, "modulation": 100, "depth": 0.5}


@pytest.mark.parametrize(
    ("preset", "changes", "over", "alone"),
    [
        (
            "bau_2010/sine",
            {"drive": MODULATED},
            {"drive.amplitude": [3.0, 40.0], "drive.depth": [0.2, 1.0]},
            0,
        ),
        ("vezzoli_2014/fig6", {"drive": MODULATED}, {"drive.amplitude": [3.0, 40.0]}, 0),
        ("bau_2010/sine", {"drive": MODULATED}, {"drive.modulation": [100.0, 200.0, 250.0]}, 3),
        ("bau_2010/sine", {"drive": MODULATED}, {"drive.modulation": [50.0, 100.0, 50.0]}, 1),
        (
            "bau_2010/sine",
            {"contact": {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}},
            {"drive.amplitude": [20.0, 300.0], "drive.phase": [0.0, 1.0]},
            2,  # the area under the larger attraction is not resolved by the first pieces
        ),
        ("bau_2010/sine", {"limits.rms_current": 1e-6}, {"drive.amplitude": [20.0, 60.0]}, 0),
        ("bau_2010/sine", {}, {"drive.amplitude": [0.0, 20.0, 40.0], "drive.offset": [0.0, 5.0]}, 4),
        ("bau_2010/sine", {"friction.coefficient": 0.3}, {"drive.frequency": [30.0, 300.0]}, 0),
    ],
)
def test_tones_contacts_and_limits_in_arrays_are_those_of_each_alone(
    preset, changes, over, alone, monkeypatch
):
    scenario = load(preset).replace(SETTLED | changes)
    names = [read_name(text, tuple(scenario.stack.layers)) for text in NAMES]
    points = points_of(over)
    together = Together(_scenarios(scenario, points), names)
    asked_alone = []
    monkeypatch.setattr(
        "electrovib.solve.quantities.together.answer",
        lambda expanded, names: asked_alone.append(expanded) or answer(expanded, names),
    )
    for place, point in enumerate(points):
        found, one = together.answer(place), answer(solved(scenario.replace(point)), names)
        np.testing.assert_allclose(
            [*found.values.values()],
            [*one.values.values()],
            rtol=1e-12,
            atol=1e-12 * max(one.values.values()),
        )
        assert_same_diagnostics(found.diagnostics, one.diagnostics)
        assert found.how["solver_reason"] == one.how["solver_reason"]
    assert len(asked_alone) == alone


def test_a_sweep_is_the_same_in_any_order_of_its_parameters():
    scenario = dispersive("vezzoli_2014/fig6")
    one = sweep(scenario, OVER, quantities=NAMES)
    other = sweep(scenario, dict(reversed(OVER.items())), quantities=NAMES)
    for name in NAMES:
        np.testing.assert_allclose(other[name].transpose(*one[name].dims), one[name], rtol=1e-12)
    named = [
        {each["name"]: each["value"] for each in json.loads(trace.attrs["validity"]) if "value" in each}
        for trace in (one, other)
    ]
    assert named[0] == pytest.approx(named[1], rel=1e-9)


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
    scenario = load("bau_2010/sine").replace(SETTLED)
    assert together.is_of_tones(scenario)
    assert not together.is_of_tones(scenario.replace(change))


def test_a_drive_of_nothing_among_others_is_answered_too():
    scenario = load("vezzoli_2014/fig6").replace(SETTLED)
    trace = sweep(scenario, {"drive.amplitude": [0.0, 1.0, 2.0]}, quantities=["mean electrostatic_force"])
    values = trace["mean electrostatic_force"].values
    assert values[0] == 0
    np.testing.assert_allclose(values[2], 4 * values[1], rtol=1e-12)


def test_more_cases_than_are_held_at_once(monkeypatch):
    monkeypatch.setattr("electrovib.solve.quantities.together.MOST", 260)  # three of 86 times
    scenario = load("vezzoli_2014/fig6").replace(SETTLED)
    over = {"drive.frequency": [100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0]}
    found = sweep(scenario, over, quantities=["peak current"])["peak current"].values
    alone = [
        float(
            sweep(scenario.replace({"drive.frequency": each}), {}, quantities=["peak current"])[
                "peak current"
            ]
        )
        for each in over["drive.frequency"]
    ]
    np.testing.assert_allclose(found, alone, rtol=1e-12)


def test_a_load_that_changes_bends_the_signals_of_a_sine():
    """The pieces end where the load begins to rise, so that the mean of the friction is exact."""
    changes = {"load.time_profile": {"model": "Press", "begin": 0.13e-3, "rise": 0.31e-3}}
    scenario = load("vezzoli_2014/fig6").replace(SETTLED | {"drive.amplitude": 1e-3} | changes)
    trace = sweep(scenario, {}, quantities=["mean normal_force", "minimum normal_force"])
    share = (0.5 * 0.31e-3 + 1e-3 - 0.44e-3) / 1e-3
    assert float(trace["mean normal_force"]) == pytest.approx(scenario.load.normal_force * share, rel=1e-12)
    assert float(trace["minimum normal_force"]) == pytest.approx(0.0, abs=1e-15)


def test_cases_beside_a_measured_table_say_so_as_each_alone():
    table = {"model": "Tabulated"} | Tabulated.example
    scenario = load("vezzoli_2014/fig6").replace({"stack.stratum_corneum.material": table} | SETTLED)
    names = [read_name(text, tuple(scenario.stack.layers)) for text in NAMES]
    points = points_of({"drive.frequency": [3.0, 5.0, 100.0, 1e3, 3e5, 4e5]})
    together = Together(_scenarios(scenario, points), names)
    judged = []
    for place, point in enumerate(points):
        found = together.answer(place).diagnostics
        assert_same_diagnostics(found, answer(solved(scenario.replace(point)), names).diagnostics)
        judged.append("memory" in [each.name for each in found])
    assert judged == [
        point["drive.frequency"] >= Tabulated.example["frequency_samples"][0] for point in points
    ]
