"""One place says which solver answers; the method of each says what follows from it."""

from __future__ import annotations

import functools
import importlib
import threading

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.diagnostics import diagnostics_of
from electrovib.solve import choice
from electrovib.solve.diagnostics import judge
from electrovib.solve.electrics.solution import RENEWAL, Question, linear_quantities
from electrovib.solve.electrics.without_modes import follow_all
from electrovib.solve.expanded import Expanded

REST, SHORT = {"time.initial_state": {"model": "AtRest"}}, {"time.samples": 50}
SQUARE = {"model": "Square", "high": 100, "low": -100, "frequency": 500}
LIMITED = {
    "drive": SQUARE,
    "circuit.amplifier": {"gain": 1.0, "source_current": "20 uA"},
    "time.duration": "4 ms",
}
RENEWED = {"motion": {"speed": "0.1 m/s", "renews_film": True}, "time.duration": "8 ms", "time.samples": 20}
SATURATED = {"circuit.amplifier": {"bandwidth": "20 kHz", "saturation": "100 kV"}}
SCENARIOS = {
    "transient": ("vezzoli_2014/fig6", {}),
    "periodic": ("bau_2010/sine", {}),
    "current drive": ("kim_2015/current", {}),
    "one sine": ("vezzoli_2014/fig7", {}),
    "nonlinear branch": ("kaczmarek_2006/gap_positive", SHORT),
    "moving gap": ("vezzoli_2014/fig2_tremor", SHORT),
    "amplifier": ("bau_2010/sine", REST | LIMITED),
    "nonlinear": ("kaczmarek_2006/gap_positive", SATURATED | SHORT),
    "renewal": ("bau_2010/sine", REST | RENEWED),
}
"""Method to a scenario that it is for."""


def scenario_for(method):
    name, changes = SCENARIOS[method]
    return ev.load(name, changes=changes)


def test_every_solver_has_a_scenario_here_and_only_marches_have_steps_that_cost():
    methods = [solver.method for solver in choice.SOLVERS]
    assert {method.name for method in methods} == set(SCENARIOS)
    marched = {method.name for method in methods if method.is_marched}
    assert marched == {"nonlinear branch", "moving gap", "amplifier", "nonlinear"}
    assert not RENEWAL.by_modes


@pytest.mark.parametrize("method", SCENARIOS)
def test_the_trace_tells_the_solver_that_was_chosen(method):
    """The last solver takes everything, and the others not."""
    scenario = scenario_for(method)
    assert choice.chosen(scenario).method.name == method
    takers = [solver.method.name for solver in choice.SOLVERS if solver.takes(scenario)]
    assert (takers[0], takers[-1]) == (method, "transient")
    if method not in {"nonlinear", "moving gap", "nonlinear branch"}:  # told by tests of their own
        assert ev.simulate(scenario).attrs["solver"] == method


@pytest.mark.parametrize("method", ["amplifier", "periodic"])
def test_a_march_is_asked_once_and_a_closed_form_again_where_it_is_largest(monkeypatch, method):
    asked = []
    for name in ("solve", "solve_fields"):
        whole = getattr(judge, name)

        def counted(*arguments, name=name, whole=whole, **options):
            asked.append(name)
            return whole(*arguments, **options)

        monkeypatch.setattr(judge, name, counted)
    scenario = scenario_for(method)
    Expanded(scenario).at(scenario.time.times(scenario.drive), closely=True)
    assert asked.count("solve") == 1
    assert ("solve_fields" not in asked) == (method == "amplifier")


@pytest.mark.parametrize(("method", "state"), [("current drive", "ok"), ("renewal", "unknown")])
def test_the_error_of_materials_holds_where_the_answer_is_linear_in_the_drive(method, state):
    skin = {"stack.stratum_corneum.material": "gabriel_1996/dry"}
    found = diagnostics_of(ev.simulate(scenario_for(method).replace(skin)))
    assert [diagnostic.state for diagnostic in found if diagnostic.name == "memory"] == [state]


def test_the_general_reference_begins_at_time_0_whatever_times_are_asked_for():
    scenario, times = scenario_for("amplifier"), np.linspace(0, 4e-3, 41)
    wanted, section = functools.partial(linear_quantities, scenario), Expanded(scenario).section
    late, whole = (
        follow_all(Question(scenario=scenario, section=section, times=some, wanted=wanted)).found[
            "stack_voltage"
        ]
        for some in (times[7:], times)
    )
    np.testing.assert_allclose(late, whole[7:], rtol=0, atol=1e-6)


def test_a_long_run_has_its_record_written_in_another_thread():
    provenance = importlib.import_module("electrovib.solve.simulate")
    for count, elsewhere in ((provenance._MANY, True), (provenance._MANY - 1, False)):
        with provenance.beside(count, lambda: {"by": threading.get_ident()}) as stated:
            assert (stated()["by"] != threading.get_ident()) == elsewhere

    def fail():
        raise KeyError("scenario")

    with pytest.raises(KeyError, match="scenario"), provenance.beside(provenance._MANY, fail) as stated:
        stated()
