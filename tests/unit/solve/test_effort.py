"""Before a run: one place says which solver answers, and what it takes is counted, then measured, and refused beyond."""

import functools
import itertools

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.budget import BudgetError, budget
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.solve import choice, effort, expanded
from electrovib.solve.diagnostics import judge
from electrovib.solve.diagnostics.peaks import count_evaluation_times, evaluation_times
from electrovib.solve.electrics.solution import RENEWAL, Question, linear_quantities
from electrovib.solve.electrics.without_modes import follow_all
from electrovib.solve.expanded import Expanded

PLATE = "vezzoli_2014/fig6"
SINE = {"model": "Sine", "amplitude": 100, "frequency": 1e3}
SQUARE = {"model": "Square", "high": 100, "low": -100}
BURST = {"model": "Burst", "amplitude": 100, "frequency": 1e6, "cycles": 10**9}
AMPLIFIED = {"circuit.amplifier": {"bandwidth": 1e5, "source_current": 0.01}}
LEAK = {"stack.insulator.leak": {"model": "FieldConduction", "conductivity": 1e-9, "onset_field": 1e5}}
LONG = {"drive": SQUARE | {"frequency": 1e5}, "time.duration": 10} | LEAK


def simulate(changes, **how):
    return ev.simulate(ev.load(PLATE, changes=changes), **how)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"time.samples": 1e8}, "1e.08 output times.*Ask for fewer time.samples"),
        (
            {"drive": SQUARE | {"frequency": 1e6}, "time.duration": 1000},
            "2e.09 corners of the drive up to 1000 s.*time.duration = 1e-06 .*PeriodicState",
        ),
        (
            {"drive": BURST} | AMPLIFIED,
            "steps of the solver 'amplifier' in 1e.09 corners and cycles.*shorter time.duration",
        ),
        (LONG, "steps of the solver 'nonlinear branch' in 2e.06 corners .*shorter time.duration"),
    ],
)
def test_what_would_fill_the_memory_or_the_day_is_refused_at_once(changes, said):
    with pytest.raises(BudgetError, match=said):
        simulate(changes)
    assert issubclass(BudgetError, InputError)


def test_a_sweep_of_too_many_cases_is_refused_before_the_first():
    paths = ("drive.high", "drive.rise", "drive.fall")
    with pytest.raises(BudgetError, match=r"1e.15 cases, 100000 values of drive.high x .*Sweep fewer values"):
        ev.sweep(ev.load(PLATE), {path: np.linspace(1e-3, 2e-3, 100_000) for path in paths})


def test_times_that_are_given_count_instead_of_the_scenario_s_and_a_budget_lets_more_through():
    many, few = {"time.samples": 1e8}, np.linspace(0, 1e-3, 11)
    assert simulate(many, time=few).sizes["time"] == 11
    with budget(memory=1e3), pytest.raises(BudgetError, match="11 output times"):
        simulate(many, time=few)
    with budget(memory=1e6), pytest.raises(BudgetError):
        simulate({"time.samples": 20_000})
    with budget(memory=1e8):
        assert simulate({"time.samples": 20_000}).sizes["time"] == 20_000


@pytest.mark.parametrize("changes", [{}, {"time.duration": 0.3}, {"time.samples": 7}])
def test_as_many_times_as_there_are_are_counted(changes):
    scenario = ev.load(PLATE, changes=changes)
    assert scenario.time.count(scenario.drive) == len(scenario.time.times(scenario.drive))


SHORT = LONG | {"drive": SQUARE | {"frequency": 1e3}, "time.duration": 0.01}
LIMITED = {"drive": SINE, "time.duration": 2000, "circuit.amplifier": {"source_current": 2e-6}}
REPEATS = "would take about .*, for {} s, of which .*shorter time.duration"


@pytest.mark.parametrize(
    ("changes", "tick", "allowed", "said"),
    [
        (SHORT, 1, {"time": 4.5}, r"the leaking layer would take.* 0\.01 s, of which"),
        (SHORT | AMPLIFIED, 1, {"time": 20}, r"Radau's method on . equations would take .* of which"),
        # the first periods tell what the whole would take
        (LONG | AMPLIFIED | {"time.duration": 0.1}, 1 / 16, {}, f"Radau.* {REPEATS.format(0.1)}"),
        (LIMITED, 1 / 16, {}, f"the amplifier with limits {REPEATS.format(2000)}"),
    ],
)
def test_a_march_ends_when_its_budget_is_spent_or_would_be(monkeypatch, changes, tick, allowed, said):
    ticks = itertools.count()
    monkeypatch.setattr("electrovib.solve.meter.clock", lambda: tick * next(ticks))
    with budget(**allowed), pytest.raises(BudgetError, match=said):
        simulate(changes)
    assert tick * next(ticks) < 320


BRISTLES = {"model": "Dahl", "steady": {"model": "Coulomb", "coefficient": 0.5}, "stiffness": 500.0}
SETTLED = {"time.initial_state": {"model": "PeriodicState"}, "drive": SQUARE | {"frequency": 60}}
CURRENT = {"drive": SINE | {"model": "CurrentSine", "amplitude": 1e-3}}
TREMOR = {"model": "TremblingDistance", "mean": 1e-4, "amplitude": 1e-5, "frequency": 8}
SENSORS = {
    "normal": {"natural_frequency": 2000.0, "damping_ratio": 0.02, "time_constant": 10.0},
    "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.05},
}
DIGITISER = {"sampling_rate": 1e9, "bits": 12, "normal_range": 10, "lateral_range": 10, "seed": 1}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"friction": BRISTLES}, "friction = Dahl needs motion.speed"),
        ({"friction": {"model": "AdhesiveShear", "shear_strength": 1e6}}, "contact.surface is not given"),
        ({"time.initial_state": {"model": "PeriodicState"}}, "Trapezium does not repeat"),
        (SETTLED | LEAK, "layer 'insulator' leaks by FieldConduction"),
        (SETTLED | AMPLIFIED, "behind an amplifier with limits the periodic state is not known"),
        (CURRENT | AMPLIFIED, "CurrentSine prescribes the current itself"),
        (CURRENT | LEAK | {"circuit.amplifier": {"gain": 2.0}}, "CurrentSine prescribes the current itself"),
        ({"motion.distance": TREMOR}, "gap"),
        ({"rig": {"model": "Tribometer", "digitiser": DIGITISER} | SENSORS}, "readings are more than half"),
        ({"force": {"model": "Vezzoli2014PerFrequency"}}, "not causal"),
    ],
)
def test_what_does_not_go_together_is_told_before_the_materials_are_reduced(monkeypatch, changes, said):
    monkeypatch.setattr(expanded, "modes", lambda *_: pytest.fail("the materials were reduced first"))
    with pytest.raises(ElectrovibError, match=said):
        simulate(changes)


DRIVES = [
    {"model": "Sine", "amplitude": 1, "frequency": 125},
    SQUARE | {"frequency": 1e3},
    {"model": "Trapezium", "high": 1, "rise": 0.01, "hold": 0.1, "fall": 0.01},
    {"model": "Chirp", "amplitude": 1, "first": 1, "last": 1e4, "length": 1},
    {"model": "Step", "level": 1},
    {"model": "Burst", "amplitude": 1, "frequency": 100, "cycles": 50},
    {"model": "AmplitudeModulation", "amplitude": 1, "carrier": 3e3, "modulation": 100, "depth": 0.5},
]


@pytest.mark.parametrize("table", DRIVES, ids=lambda table: table["model"])
@pytest.mark.parametrize("end", [1e-3, 0.03, 1, 60])
def test_looks_and_corners_are_counted_without_being_chosen(table, end):
    """Never fewer looks than there are, and less than ten times as many."""
    drive = read_model(Drive, table)
    for settled in (False, True)[: 1 + (drive.period is not None)]:
        chosen = len(evaluation_times(drive, end=end, settled=settled))
        assert chosen <= count_evaluation_times(drive, end=end, settled=settled) <= 10 * chosen
    assert abs(drive.count_corners(end) - len(drive.corners(end)[0])) <= 4


def test_a_limit_that_is_never_met_is_not_taken_for_one_that_is():
    """A million periods, a chirp of as many: both are quick where nothing changes, and neither is held in memory."""
    chirp = {"model": "Chirp", "amplitude": 100, "first": 1, "last": 1e4, "length": 100}
    for changes in (LIMITED | {"time.duration": 1000}, {"drive": chirp}):
        effort.refuse_large(ev.load(PLATE, changes=changes | {"circuit.amplifier": {"source_current": 1.0}}))


REST, FEW = {"time.initial_state": {"model": "AtRest"}}, {"time.samples": 50}
SLEWS = {
    "drive": SQUARE | {"frequency": 500},
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
    "nonlinear branch": ("kaczmarek_2006/gap_positive", FEW),
    "moving gap": ("vezzoli_2014/fig2_tremor", FEW),
    "amplifier": ("bau_2010/sine", REST | SLEWS),
    "nonlinear": ("kaczmarek_2006/gap_positive", SATURATED | FEW),
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
def test_a_march_and_a_closed_form_are_asked_once(monkeypatch, method):
    asked = []
    for module, name in ((expanded, "solve"), (expanded, "along"), (judge, "solve_fields")):
        whole = getattr(module, name)

        def counted(*arguments, name=name, whole=whole, **options):
            asked.append(name)
            return whole(*arguments, **options)

        monkeypatch.setattr(module, name, counted)
    scenario = scenario_for(method)
    Expanded(scenario).at(scenario.time.times(scenario.drive), closely=True)
    assert asked.count("solve" if method == "amplifier" else "along") == 1
    assert "solve_fields" not in asked  # where it is largest the response of the same course is looked up


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


def test_the_times_between_of_a_moving_gap_are_counted():
    scenario = ev.load("vezzoli_2014/fig2_tremor")
    times = scenario.time.times(scenario.drive)
    further = len(expanded._further(scenario, times))
    numbers = effort.SIGNALS + effort.SIGNALS_OF_LAYER * len(scenario.stack.layers)
    assert effort.counted(scenario)[0].memory >= 8 * (len(times) + further) * numbers
