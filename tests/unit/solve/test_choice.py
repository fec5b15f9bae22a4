"""One place says which solver answers; the method of each says what follows from it."""

from __future__ import annotations

import functools
import json

import numpy as np
import pytest

import electrovib as ev
from electrovib.solve import choice
from electrovib.solve.diagnostics import judge
from electrovib.solve.electrics.solution import RENEWAL, Question, linear_quantities
from electrovib.solve.electrics.without_modes import follow_all
from electrovib.solve.expanded import Expanded

REST = {"model": "AtRest"}
LIMITED = {"gain": 1.0, "source_current": "20 uA"}
SQUARE = {"model": "Square", "high": 100, "low": -100, "frequency": 500}
SCENARIOS = {
    "transient": ("vezzoli_2014/fig6", {}),
    "periodic": ("bau_2010/sine", {}),
    "current drive": ("kim_2015/current", {}),
    "one sine": ("vezzoli_2014/fig7", {}),
    "nonlinear branch": ("kaczmarek_2006/gap_positive", {"time.samples": 50}),
    "moving gap": ("vezzoli_2014/fig2_tremor", {"time.samples": 50}),
    "amplifier": (
        "bau_2010/sine",
        {"time.initial_state": REST, "time.duration": "4 ms", "drive": SQUARE, "circuit.amplifier": LIMITED},
    ),
    "nonlinear": (
        "kaczmarek_2006/gap_positive",
        {"circuit.amplifier": {"bandwidth": "20 kHz", "saturation": "100 kV"}, "time.samples": 50},
    ),
    "renewal": (
        "bau_2010/sine",
        {
            "time.initial_state": REST,
            "time.duration": "8 ms",
            "time.samples": 20,
            "motion": {"speed": "0.1 m/s", "renews_film": True},
        },
    ),
}
"""Method to a scenario that it is for."""


def scenario_for(method):
    name, changes = SCENARIOS[method]
    return ev.load(name, changes=changes)


def test_every_solver_has_a_scenario_here():
    assert {solver.method.name for solver in choice.SOLVERS} == set(SCENARIOS)


@pytest.mark.parametrize("method", SCENARIOS)
def test_the_trace_tells_the_solver_that_was_chosen(method):
    scenario = scenario_for(method)
    assert choice.chosen(scenario).method.name == method
    if method not in {"nonlinear", "moving gap", "nonlinear branch"}:  # told by tests of their own
        assert ev.simulate(scenario).attrs["solver"] == method


def test_the_last_solver_takes_everything_and_the_others_not():
    for method in SCENARIOS:
        scenario = scenario_for(method)
        takers = [solver.method.name for solver in choice.SOLVERS if solver.takes(scenario)]
        assert takers[0] == method
        assert takers[-1] == "transient"


@pytest.mark.parametrize("method", ["amplifier", "periodic"])
def test_a_march_is_asked_once_and_a_closed_form_again_where_it_is_largest(monkeypatch, method):
    asked = {"solve": 0, "solve_fields": 0}
    for name in asked:
        whole = getattr(judge, name)

        def counted(*arguments, name=name, whole=whole, **options):
            asked[name] += 1
            return whole(*arguments, **options)

        monkeypatch.setattr(judge, name, counted)
    scenario = scenario_for(method)
    Expanded(scenario).at(scenario.time.times(scenario.drive), closely=True)
    assert asked["solve"] == 1
    assert (asked["solve_fields"] == 0) == (method == "amplifier")


@pytest.mark.parametrize(("method", "state"), [("current drive", "ok"), ("renewal", "unknown")])
def test_the_error_of_materials_holds_where_the_answer_is_linear_in_the_drive(method, state):
    skin = {"stack.stratum_corneum.material": "gabriel_1996/dry"}
    trace = ev.simulate(scenario_for(method).replace(skin))
    (diagnostic,) = [diagnostic for diagnostic in diagnostics_of(trace) if diagnostic["name"] == "memory"]
    assert diagnostic["state"] == state


def diagnostics_of(trace):
    return json.loads(trace.attrs["validity"])


def test_only_marches_have_steps_that_cost():
    marched = {solver.method.name for solver in choice.SOLVERS if solver.method.is_marched}
    assert marched == {"nonlinear branch", "moving gap", "amplifier", "nonlinear"}
    assert not RENEWAL.by_modes


def test_the_general_reference_begins_at_time_0_whatever_times_are_asked_for():
    scenario = scenario_for("amplifier")
    expanded = Expanded(scenario)
    times = np.linspace(0, 4e-3, 41)

    def asked(some):
        wanted = functools.partial(linear_quantities, scenario)
        return follow_all(
            Question(scenario=scenario, section=expanded.section, times=some, wanted=wanted)
        ).found["stack_voltage"]

    np.testing.assert_allclose(asked(times[7:]), asked(times)[7:], rtol=0, atol=1e-6)
