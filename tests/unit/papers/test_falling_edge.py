"""The candidates for the falling edge: numbers computed apart, and what each can and cannot explain."""

from dataclasses import replace

import numpy as np
import pytest

from electrovib.papers.vezzoli_2014 import falling_edge
from electrovib.papers.vezzoli_2014.falling_edge import candidates, outcome, outcomes, table
from electrovib.solve.simulate import simulate

TAU = 7.7e-3


def named(name):
    return next(candidate for candidate in candidates() if candidate.name == name)


@pytest.mark.parametrize(("ramp", "hold"), [(25e-3, 20e-3), (25e-3, 200e-3), (18e-3, 20e-3)])
def test_one_relaxation_time_against_its_closed_form(ramp, hold):
    """(1 - exp(-(hold + ramp)/tau))^2, with (C_i + C_s) R_s in the place of tau: 0.5 % longer."""
    found = outcome(named("the paper's model"), ramp=ramp, hold=hold)
    tau = TAU * (1 + 32.957e-12 / 6.9063e-9)
    assert found.ratio == pytest.approx((1 - np.exp(-(hold + ramp) / tau)) ** 2, rel=1e-5)
    assert found.decay == pytest.approx(tau / 2, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "hold", "ratio"),
    [
        ("dispersive skin, palmar men 2 uS", 20e-3, 0.66),
        ("dispersive skin, palmar men 2 uS", 200e-3, 0.89),
        ("dispersive skin, 1963 impedance", 20e-3, 0.77),
        ("dispersive skin, 1963 impedance", 50e-3, 0.83),
    ],
)
def test_dispersive_memory(name, hold, ratio):
    """Two digits, computed apart from this code for ramps of 25 ms."""
    assert outcome(named(name), hold=hold).ratio == pytest.approx(ratio, abs=0.006)


@pytest.mark.slow
def test_sliding():
    for speed, ratio in ((10, 0.95), (30, 0.85), (100, 0.58)):
        assert outcomes()[f"sliding at {speed} mm/s"].ratio == pytest.approx(ratio, abs=0.006)


def test_polarity_goes_either_way_and_a_slow_sink_makes_a_smaller_falling_pulse():
    """Time constants of 7.7 and 2.5 ms: the one sign makes the falling pulse 12 % of the rising one, the other 8 times."""
    assert outcome(named("positive pulses stronger")).ratio == pytest.approx(0.12, abs=0.01)
    assert 8 < outcome(named("positive pulses weaker")).ratio < 9.5
    slow, usual = (
        outcome(named(name)) for name in ("amplifier sinks less than it sources", "the paper's model")
    )
    assert slow.ratio < 0.5
    assert slow.decay == pytest.approx(usual.decay)


KNOWS_THE_SIGN = {
    "positive pulses weaker": "positive pulses stronger",
    "positive pulses stronger": "positive pulses weaker",
    "sliding over positive film": "sliding over negative film",
    "sliding over negative film": "sliding over positive film",
}


@pytest.mark.slow
@pytest.mark.parametrize("candidate", candidates(), ids=lambda candidate: candidate.name)
def test_inverting_the_drive_turns_over_what_knows_its_sign(candidate):
    """Polarity, charged film and the amplifier; the page says so, and that nothing else does."""
    inverted = replace(candidate, changes=dict(candidate.changes) | {"drive.high": -1000.0})
    ratio = outcome(inverted).ratio
    if "amplifier" in candidate.name:
        assert ratio == pytest.approx(1 / outcomes()[candidate.name].ratio, rel=1e-3)
    elif "left on the film" in candidate.name:
        assert ratio == pytest.approx(2 - outcomes()[candidate.name].ratio, abs=1e-3)
    else:
        turned = KNOWS_THE_SIGN.get(candidate.name, candidate.name)
        assert ratio == pytest.approx(outcomes()[turned].ratio, rel=1e-4)


@pytest.mark.parametrize("name", ["viscoelastic skin", "sensor relaxes"])
def test_what_relaxes_linearly_leaves_equal_pulses_equal(name):
    """Numbers to 1e-6 of a force of which the load makes 99 %: so 1e-4 of the swing."""
    drive = {"model": "Trapezium", "high": 1000.0, "rise": 10e-3, "hold": 40e-3, "fall": 10e-3, "repeat": 0.1}
    settled = {"drive": drive, "time.initial_state": {"model": "PeriodicState"}}
    candidate = named(name)
    force = simulate(candidate.scenario().replace(settled), time=np.linspace(0, 0.1, 1001))[candidate.signal]
    first, second = force.values[:500], force.values[500:1000]
    assert np.max(np.abs(first - second)) < 1e-4 * np.ptp(first)


def test_a_periodic_trapezium_of_equal_halves_is_equal_under_any_linear_law():
    """One of unequal halves is not, so that this equality says something."""
    assert falling_edge.periodic_asymmetry() < 1e-12
    assert sum(candidate.linear for candidate in candidates()) >= 5
    drive = {"model": "Trapezium", "high": 1000.0, "rise": 10e-3, "hold": 20e-3, "fall": 10e-3, "repeat": 0.1}
    skin = named("dispersive skin, palmar men 2 uS").scenario()
    scenario = skin.replace({"drive": drive, "time.initial_state": {"model": "PeriodicState"}})
    force = simulate(scenario, time=np.array([10e-3, 40e-3])).electrostatic_force.values
    assert abs(force[1] / force[0] - 1) > 0.05


@pytest.mark.slow
def test_every_candidate_is_in_the_table_with_its_experiment():
    found = table()
    assert [row[0] for row in found.rows] == [candidate.name for candidate in candidates()]
    assert all(len(row[5]) > 10 or row[0] == "the paper's model" for row in found.rows)
    said = {row[0]: row[3] for row in found.rows}
    assert said["the paper's model"] == ""
    assert said["positive pulses stronger"] == "ramp"
    assert said["leak that grows with the field"] == "hold"
    assert said["sliding at 30 mm/s"] == "ramp, hold"
    note = next(row for row in falling_edge.rows() if row.id == "periodic_trapezium").note
    assert "sensor" not in note.split("neither")[0]
