"""Where two features of a scenario meet: what the product of all of them has found wrong, each by its closed form."""

from __future__ import annotations

import functools
import itertools

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.solve.electrics import renewal
from electrovib.solve.electrics.solution import LEAK, Question, linear_quantities
from electrovib.solve.electrics.without_modes import follow_all
from electrovib.solve.expanded import Expanded
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.keys import FieldOf

CLOSES = {
    "contact.surface": {"model": "LinearSpring", "stiffness": 1e9, "free_gap": "10 um"},
    "motion.distance": None,
    "contact.closing": {"damping": 1e6},
    "stack.stratum_corneum.material.conductivity": 0.0,
    "load.normal_force": 0.5,
}
BARE = {"circuit.return_path.resistance": 0.0}


@pytest.fixture(scope="module")
def suspended():
    return load("vezzoli_2014/fig2")


@pytest.fixture(scope="module")
def founding():
    return load("vezzoli_2014/fig6_gap")


def assert_same(found, expected, names, share):
    for name in names:
        size = float(np.abs(expected[name]).max())
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=share * size, err_msg=str(name))


def test_bridges_take_their_share_of_the_pull_that_closes_a_gap(suspended):
    """At rest the surface topography carries load and attraction, the attraction that the Trace reports."""
    bridged = {"stack.gap.material": {"model": "BridgedAir", "bridged_share": 0.4, "spot_conductivity": 0.0}}
    held = {"drive": {"model": "Step", "level": 400.0}}
    trace = simulate(suspended.replace(CLOSES | bridged | held), time=np.linspace(0, 0.05, 11))
    carried = 1e9 * (10e-6 - trace.gap.values[-1]) * 1e-4
    pull = float(trace.electrostatic_force[-1])
    assert pull > 0.01
    assert carried == pytest.approx(0.5 + pull, rel=1e-9)
    second = {"circuit.return_path": {"model": "SecondElectrode", "area": "0.5 cm2"}}
    with pytest.raises(InputError, match=r"contact\.closing: .*use Grounded or Floating"):
        simulate(suspended.replace(CLOSES | second))  # two contacts do not close as one


def test_a_closing_gap_draws_its_current_on_every_stretch_of_the_drive(suspended):
    """Without resistance the current is the rate of change of the charge, before the last break of the drive too."""
    steps = {"drive": {"model": "Trapezium", "high": 600.0, "rise": 4e-3, "hold": 3e-3, "fall": 1e-3}}
    time = np.linspace(0, 12e-3, 1201)
    trace = simulate(suspended.replace(CLOSES | BARE | steps), time=time)
    charge = trace.displacement.sel(layer="insulator").values * 1e-4
    mean = (charge[2:] - charge[:-2]) / (time[2:] - time[:-2])
    found = trace.current.values[1:-1]
    smooth = np.min(np.abs(time[1:-1, None] - np.array([4e-3, 7e-3, 8e-3])), axis=1) > 2e-5
    assert np.max(np.abs(found - mean)[smooth]) < 1e-4 * np.max(np.abs(found))


DEBYE = {
    "model": "Debye",
    "permittivity_high": 100.0,
    "strength": 900.0,
    "relaxation_time": 0.5e-3,
    "conductivity": 1e-5,
}


def test_an_amplifier_that_just_cannot_follow_does_not_chatter(founding, monkeypatch):
    """A chirp that needs the largest current at one moment, within rounding: it used to change without end."""
    monkeypatch.setattr("electrovib.solve.electrics.amplifier.MOST_CHANGES", 1000)
    changes = {
        "drive": {"model": "Chirp", "amplitude": 60.0, "first": 50.0, "last": 500.0, "length": 7e-3},
        "stack.insulator.thickness": 2e-6,
        "stack.gap": {"thickness": 2e-6, "material": {"model": "Constant", "permittivity": 1.0}},
        "stack.stratum_corneum.material": DEBYE,
        "circuit.amplifier": {"gain": 1.5, "source_current": 15e-6, "stray_capacitance": 5e-11},
        "circuit.return_path.resistance": 2e4,
    }
    trace = simulate(founding.replace(changes), time=np.linspace(0, 8e-3, 81))
    assert "9 changes" in trace.attrs["solver_reason"]
    assert float(np.abs(trace.amplifier_current).max()) <= 15e-6 * (1 + 1e-9)


@pytest.mark.parametrize("end", [2e-3, 2.3e-3])
def test_the_last_time_of_a_record_is_like_any_other(founding, end):
    """Behind a limit, the current at the end of a record is that of a longer one."""
    amplifier = {"circuit.amplifier": {"saturation": 50.0, "stray_capacitance": 5e-11}}
    sine = {"drive": {"model": "Sine", "amplitude": 60.0, "frequency": 200.0}}
    scenario, time = founding.replace(BARE | sine | amplifier), np.array([0.0, 1e-3, end])
    ends, goes_on = simulate(scenario, time=time), simulate(scenario, time=np.append(time, 2 * end))
    assert_same(ends, goes_on.isel(time=slice(3)), ("current", "amplifier_current", "plate_voltage"), 5e-3)
    assert abs(float(ends.current[-1])) > 0.01 * float(np.abs(goes_on.current).max())


RECTIFYING = {"model": "PolarityConduction", "conductivity_positive": 4e-9, "conductivity_negative": 1e-9}


@pytest.mark.parametrize("limit", [{}, {"saturation": 1e5}], ids=["gain", "limit"])
def test_an_amplifier_before_a_single_leak_counts(founding, limit):
    """A gain of 2 before a leak, and twice the drive without an amplifier."""
    leaking = {
        "stack.gap.leak": RECTIFYING,
        "drive": {"model": "Sine", "amplitude": 50.0, "frequency": 100.0},
    }
    scenario, time = founding.replace(leaking), np.linspace(0, 10e-3, 21)
    amplified = simulate(scenario.replace({"circuit.amplifier": {"gain": 2.0} | limit}), time=time)
    doubled = simulate(scenario.replace({"drive.amplitude": 100.0}), time=time)
    assert ("an amplifier with limits before a leak" in amplified.attrs["solver_reason"]) == bool(limit)
    assert_same(amplified, doubled, ("stack_voltage", "current", "electrostatic_force"), 5e-5)


LEAKS = {
    "rectifying": RECTIFYING,
    "growing": {"model": "FieldConduction", "conductivity": 1e-9, "onset_field": 2e6},
}
DRIVES = {
    "sine": {"model": "Sine", "amplitude": 50.0, "frequency": 100.0},
    "square": {"model": "Square", "high": 60.0, "low": -20.0, "frequency": 100.0},
    "pulse": {"model": "Trapezium", "high": 80.0, "rise": 2e-3, "hold": 5e-3, "fall": 1e-3},
}
BEFORE_LEAKS = [
    case if place % 7 == 1 else pytest.param(*case, marks=pytest.mark.slow)
    for place, case in enumerate(itertools.product(["gap", "insulator"], LEAKS, DRIVES, [0.0, 1e6]))
]


@pytest.mark.parametrize(("layer", "leak", "drive", "resistance"), BEFORE_LEAKS)
def test_gain_and_pole_before_a_leak_are_those_of_the_general_solver(
    founding, layer, leak, drive, resistance
):
    changes = {
        f"stack.{layer}.leak": LEAKS[leak],
        "drive": DRIVES[drive],
        "circuit.amplifier": {"gain": -1.5, "bandwidth": 1e3, "stray_capacitance": 1e-10},
        "circuit.return_path.resistance": resistance,
    }
    scenario, time = founding.replace(changes), np.linspace(0, 12e-3, 41)
    prepared = Expanded(scenario, time)
    solution = prepared.at(time).solution
    wanted = functools.partial(linear_quantities, scenario)
    question = Question(scenario=scenario, section=prepared.section, times=time, wanted=wanted)
    assert solution.method is LEAK
    names = [
        "plate_voltage",
        "current",
        "amplifier_current",
        "stack_voltage",
        FieldOf("gap"),
        FieldOf("insulator"),
    ]
    assert_same(solution.found, follow_all(question).found, names, 5e-5)


def test_a_current_drive_before_an_amplifier_and_a_leak_is_refused(founding):
    current = {"drive": {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 100.0}}
    changes = current | {"stack.gap.leak": LEAKS["growing"], "circuit.amplifier": {"gain": 2.0}}
    with pytest.raises(InputError, match="prescribes the current itself"):
        simulate(founding.replace(changes))


def test_charge_on_fresh_film_counts_once(founding):
    """Where nothing conducts, film with the same charge comes and goes unseen: the answer is that of a finger at rest."""
    charged = BARE | {
        "stack.insulator.initial_charge": 1e-4,
        "stack.gap.material.conductivity": 0.0,
        "stack.stratum_corneum.material": {"model": "Constant", "permittivity": 300.0},
        "motion.speed": 0.1,
    }
    rest, fresh, without = (
        simulate(founding.replace(charged | more), time=np.linspace(0, 0.3, 31))
        for more in ({}, {"motion.renews_film": True}, {"stack.insulator.initial_charge": 0.0})
    )
    assert (rest.attrs["solver"], fresh.attrs["solver"]) == ("transient", "renewal")
    assert_same(fresh, rest, ("field", "displacement", "electrostatic_force"), 1e-12)
    assert abs(float(rest.electrostatic_force[0] - without.electrostatic_force[0])) > 1e-3


@pytest.mark.parametrize(
    "drive",
    [
        {"model": "Square", "high": 300.0, "low": -100.0, "frequency": 30.0},
        {"model": "Trapezium", "high": 300.0, "rise": 10e-3, "hold": 50e-3, "fall": 10e-3},
    ],
    ids=["jumps", "ramps"],
)
def test_the_mean_over_the_contact_states_its_error(founding, drive, monkeypatch):
    """Twenty times as many places: no signal moves by more than what was stated."""
    scenario = founding.replace({"drive": drive, "motion.speed": 0.3, "motion.renews_film": True})
    trace = simulate(scenario, time=np.linspace(0, 0.08, 41))
    monkeypatch.setattr(renewal, "PANELS", 320)
    fine = simulate(scenario, time=np.linspace(0, 0.08, 41))
    stated = trace.attrs["quadrature_error"]
    assert_same(trace, fine, ("electrostatic_force", "current", "stack_voltage"), stated + 1e-12)
    assert 1e-12 < stated < 1e-3
    assert fine.attrs["quadrature_error"] < stated
    assert f"{stated:.1e} of the largest value" in trace.attrs["solver_reason"]
