"""A run is counted before it begins and measured while it runs; it is refused with the figure and what would help."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.budget import BudgetError, budget
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.solve import effort, expanded
from electrovib.solve.diagnostics.peaks import count_evaluation_times, evaluation_times

PLATE = "vezzoli_2014/fig6"
SQUARE = {"model": "Square", "high": 100, "low": -100}
AMPLIFIER = {"bandwidth": 1e5, "source_current": 0.01}
LEAK = {"model": "FieldConduction", "conductivity": 1e-9, "onset_field": 1e5}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"time.samples": 1e8}, "1e.08 output times.*Ask for fewer time.samples"),
        (
            {"drive": SQUARE | {"frequency": 1e6}, "time.duration": 1000},
            "2e.09 corners of the drive up to 1000 s.*time.duration = 1e-06 .*PeriodicState",
        ),
        (
            {
                "drive": {"model": "Burst", "amplitude": 100, "frequency": 1e6, "cycles": 10**9},
                "circuit.amplifier": AMPLIFIER,
            },
            "steps of the solver 'amplifier' in 1e.09 corners and cycles.*shorter time.duration",
        ),
        (
            {"drive": SQUARE | {"frequency": 1e5}, "time.duration": 10, "stack.insulator.leak": LEAK},
            "steps of the solver 'nonlinear branch' in 2e.06 corners .*shorter time.duration",
        ),
    ],
)
def test_what_would_fill_the_memory_or_the_day_is_refused_at_once(changes, said):
    with pytest.raises(BudgetError, match=said):
        ev.simulate(ev.load(PLATE, changes=changes))


def test_a_sweep_of_too_many_cases_is_refused_before_the_first():
    paths = ("drive.high", "drive.rise", "drive.fall")
    with pytest.raises(BudgetError, match=r"1e.15 cases, 100000 values of drive.high x .*Sweep fewer values"):
        ev.sweep(ev.load(PLATE), {path: np.linspace(1e-3, 2e-3, 100_000) for path in paths})


def test_times_that_are_given_count_instead_of_the_scenario_s():
    scenario = ev.load(PLATE, changes={"time.samples": 1e8})
    trace = ev.simulate(scenario, time=np.linspace(0, 1e-3, 11))
    assert trace.sizes["time"] == 11
    with budget(memory=1e3), pytest.raises(BudgetError, match="11 output times"):
        ev.simulate(scenario, time=np.linspace(0, 1e-3, 11))


def test_a_budget_lets_more_through():
    scenario = ev.load(PLATE, changes={"time.samples": 20_000})
    with budget(memory=1e6), pytest.raises(BudgetError):
        ev.simulate(scenario)
    with budget(memory=1e8):
        assert ev.simulate(scenario).sizes["time"] == 20_000


@pytest.mark.parametrize("changes", [{}, {"time.duration": 0.3}, {"time.samples": 7}])
def test_as_many_times_as_there_are_are_counted(changes):
    scenario = ev.load(PLATE, changes=changes)
    assert scenario.time.count(scenario.drive) == len(scenario.time.times(scenario.drive))


@pytest.fixture
def clock(monkeypatch):
    """A clock on which a second passes whenever it is read."""
    ticks = itertools.count()
    monkeypatch.setattr("electrovib.solve.meter.clock", lambda: float(next(ticks)))


def test_a_march_ends_when_its_budget_is_spent(clock):
    leaks = {"stack.insulator.leak": LEAK, "drive": SQUARE | {"frequency": 1e3}, "time.duration": 0.01}
    with (
        budget(time=4.5),
        pytest.raises(BudgetError, match=r"the leaking layer would take.* 0\.01 s, of which"),
    ):
        ev.simulate(ev.load(PLATE, changes=leaks))
    with (
        budget(time=20),
        pytest.raises(BudgetError, match=r"Radau's method on . equations would take .* of which"),
    ):
        ev.simulate(ev.load(PLATE, changes=leaks | {"circuit.amplifier": AMPLIFIER}))


SINE = {"model": "Sine", "amplitude": 100, "frequency": 1e3}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {
                "drive": SQUARE | {"frequency": 1e5},
                "time.duration": 10,
                "stack.insulator.leak": LEAK,
                "circuit.amplifier": AMPLIFIER,
            },
            "Radau's method on . equations would take about .*, for 10 s, of which .*shorter time.duration",
        ),
        (
            {"drive": SINE, "time.duration": 2000, "circuit.amplifier": {"source_current": 2e-6}},
            "the amplifier with limits would take about .*, for 2000 s, of which .*shorter time.duration",
        ),
    ],
)
def test_what_repeats_is_ended_soon_with_what_the_whole_would_take(monkeypatch, changes, said):
    """Its first periods tell."""
    ticks = itertools.count()
    monkeypatch.setattr("electrovib.solve.meter.clock", lambda: next(ticks) / 16)
    with pytest.raises(BudgetError, match=said):
        ev.simulate(ev.load(PLATE, changes=changes))
    assert next(ticks) < 5000


def test_a_refusal_is_a_mistake_in_the_input():
    assert issubclass(BudgetError, InputError)


BRISTLES = {"model": "Dahl", "steady": {"model": "Coulomb", "coefficient": 0.5}, "stiffness": 500.0}
SETTLED = {"model": "PeriodicState"}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"friction": BRISTLES}, "friction = Dahl needs motion.speed"),
        ({"friction": {"model": "AdhesiveShear", "shear_strength": 1e6}}, "contact.surface is not given"),
        ({"time.initial_state": SETTLED}, "Trapezium does not repeat"),
        (
            {
                "drive": SQUARE | {"frequency": 60},
                "time.initial_state": SETTLED,
                "stack.insulator.leak": LEAK,
            },
            "layer 'insulator' leaks by FieldConduction",
        ),
        (
            {
                "drive": SQUARE | {"frequency": 60},
                "time.initial_state": SETTLED,
                "circuit.amplifier": AMPLIFIER,
            },
            "behind an amplifier with limits the periodic state is not known",
        ),
        (
            {
                "drive": {"model": "CurrentSine", "amplitude": 1e-3, "frequency": 100},
                "circuit.amplifier": AMPLIFIER,
            },
            "CurrentSine prescribes the current itself",
        ),
        (
            {
                "motion.distance": {
                    "model": "TremblingDistance",
                    "mean": 1e-4,
                    "amplitude": 1e-5,
                    "frequency": 8,
                }
            },
            "gap",
        ),
        (
            {
                "rig": {
                    "model": "Tribometer",
                    "normal": {"natural_frequency": 2000.0, "damping_ratio": 0.02, "time_constant": 10.0},
                    "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.05},
                    "digitiser": {
                        "sampling_rate": 1e9,
                        "bits": 12,
                        "normal_range": 10,
                        "lateral_range": 10,
                        "seed": 1,
                    },
                }
            },
            "readings are more than half of",
        ),
        ({"force": {"model": "Vezzoli2014PerFrequency"}}, "not causal"),
    ],
)
def test_what_does_not_go_together_is_told_before_the_materials_are_reduced(monkeypatch, changes, said):
    def reduced(*_):
        pytest.fail("the materials were reduced first")

    monkeypatch.setattr(expanded, "modes", reduced)
    with pytest.raises(ElectrovibError, match=said):
        ev.simulate(ev.load(PLATE, changes=changes))


DRIVES = [
    {"model": "Sine", "amplitude": 1, "frequency": 125},
    SQUARE | {"frequency": 1e3},
    {"model": "Trapezium", "high": 1, "rise": 0.01, "hold": 0.1, "fall": 0.01},
    {"model": "Chirp", "amplitude": 1, "first": 1, "last": 1e4, "length": 1},
    {"model": "Step", "level": 1},
    {"model": "Burst", "amplitude": 1, "frequency": 100, "cycles": 50},
    {"model": "AmplitudeModulation", "amplitude": 1, "carrier": 3e3, "modulation": 100, "depth": 0.5},
]


@pytest.mark.parametrize("table", DRIVES)
@pytest.mark.parametrize("end", [1e-3, 0.03, 1, 60])
def test_looks_are_counted_without_being_chosen(table, end):
    """Never fewer than there are, and less than ten times as many."""
    drive = read_model(Drive, table)
    for settled in (False, True)[: 1 + (drive.period is not None)]:
        chosen = len(evaluation_times(drive, end=end, settled=settled))
        assert chosen <= count_evaluation_times(drive, end=end, settled=settled) <= 10 * chosen


@pytest.mark.parametrize("table", DRIVES)
@pytest.mark.parametrize("end", [1e-3, 0.03, 1])
def test_corners_are_counted_without_being_written_out(table, end):
    drive = read_model(Drive, table)
    assert abs(drive.count_corners(end) - len(drive.corners(end)[0])) <= 4


def test_a_limit_that_is_never_met_is_not_taken_for_one_that_is():
    """A million periods, a chirp of as many: both are quick where nothing changes, and neither is held in memory."""
    amplifier = {"circuit.amplifier": {"source_current": 1.0}}
    sine = {"drive": {"model": "Sine", "amplitude": 100, "frequency": 1e3}, "time.duration": 1000}
    chirp = {"drive": {"model": "Chirp", "amplitude": 100, "first": 1, "last": 1e4, "length": 100}}
    for drive in (sine, chirp):
        effort.refuse_large(ev.load(PLATE, changes=drive | amplifier))
