"""Charge carried away by sliding, against the convection equation solved apart and its closed forms."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.physics.drive.edges import Step, Trapezium
from electrovib.physics.drive.sines import Sine
from electrovib.physics.motion import Motion
from electrovib.scenario import load
from electrovib.solve.electrics.renewal import Renewal, entered, renewed
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.transfer import Transfer

TAU, LENGTH = 7.7e-3, 1e-2
FOUNDING = Transfer(rates=np.array([1 / TAU]), gains=np.array([-1.0]), direct=1.0)
"""tau s/(1 + tau s)."""


def mean_square(drive, time, speed, **motion):
    renewal = Renewal.over(LENGTH)
    moving = Motion(speed=speed, renews_film=True, **motion)
    answer = renewed({"e": FOUNDING}, drive, time, motion=moving, renewal=renewal)["e"]
    return renewal.weights @ answer**2


@pytest.mark.parametrize("speed", [0.01, 0.03, 0.05, 0.1, 1.0])
def test_the_plateau_of_a_held_voltage(speed):
    """Mean of e^2 over the contact, e = V exp(-x/(v tau)); the panels integrate exponentials to 1e-7."""
    held = mean_square(Step(level=1.0), np.array([0.0, 40 * TAU + LENGTH / speed]), speed)[-1]
    ratio = speed * TAU / LENGTH
    assert held == pytest.approx(ratio / 2 * -np.expm1(-2 / ratio), rel=1e-7)


@pytest.mark.parametrize(("speed", "ratio"), [(0.01, 0.95), (0.03, 0.85), (0.05, 0.76), (0.1, 0.58)])
def test_the_falling_edge_over_the_rising_one(speed, ratio):
    """Two digits, computed apart from this code: ramps of 25 ms, hold of 200 ms."""
    drive = Trapezium(high=1000, rise=25e-3, hold=200e-3, fall=25e-3)
    time = np.linspace(0, 0.3, 3001)
    force = mean_square(drive, time, speed)
    assert np.max(force[time > 0.225]) / np.max(force[time < 0.026]) == pytest.approx(ratio, abs=0.006)


def upwind(drive, end, speed, cells):
    """March de/dt + u de/dx = dV/dt - e/tau along its characteristics: one cell a step, no diffusion."""
    step = LENGTH / cells / speed
    count = round(end / step)
    voltage = drive.voltage(np.arange(count + 1) * step)
    field = np.full(cells + 1, voltage[0])
    decay = np.exp(-step / TAU)
    rise = -np.expm1(-step / TAU) * TAU / step
    squares = []
    for before, after in itertools.pairwise(voltage):
        moved = np.concatenate([[0.0], field[:-1]]) * decay + rise * (after - before)
        moved[0] = after
        field = moved
        squares.append((field[0] ** 2 / 2 + np.sum(field[1:-1] ** 2) + field[-1] ** 2 / 2) / cells)
    return np.arange(1, count + 1) * step, np.array(squares)


@pytest.mark.parametrize(
    "drive", [Trapezium(high=1.0, rise=10e-3, hold=50e-3, fall=20e-3), Sine(amplitude=1.0, frequency=30.0)]
)
def test_it_is_the_convection_equation(drive):
    """Against a march along characteristics with 8000 cells, of second order: 1e-6 for the sine."""
    time, expected = upwind(drive, 0.12, 0.1, 8000)
    chosen = slice(0, None, 200)
    found = mean_square(drive, time[chosen], 0.1)
    assert np.max(np.abs(found - expected[chosen])) < 3e-6
    wrong = mean_square(drive, time[chosen], 0.11)
    assert np.max(np.abs(wrong - expected[chosen])) > 1e-3


def test_a_slow_finger_is_one_at_rest_and_a_speed_without_renewal_changes_nothing():
    scenario = load("vezzoli_2014/fig6")
    rest = simulate(scenario).electrostatic_force.values
    slow = simulate(scenario.replace({"motion.speed": 1e-9, "motion.renews_film": True}))
    # the film that entered in 0.2 s is 2e-10 m of 10 mm
    np.testing.assert_allclose(slow.electrostatic_force.values, rest, atol=1e-7 * rest.max())
    assert slow.attrs["solver"] == "renewal"
    moving = simulate(scenario.replace({"motion.speed": "30 mm/s"}))
    np.testing.assert_array_equal(moving.electrostatic_force.values, rest)


@settings(max_examples=60, deadline=None)
@given(
    corners=st.lists(st.tuples(st.floats(1e-3, 0.2), st.floats(0, 1)), min_size=1, max_size=6),
    place=st.floats(0, LENGTH),
    when=st.floats(0, 1.5),
)
def test_the_way_since_entry_is_the_place(corners, place, when):
    """The finger has gone as far since a place came under it as the place is from the leading edge."""
    times = np.cumsum([gap for gap, _ in corners]).tolist()
    points = [{"time": t, "share": s} for t, (_, s) in zip(times, corners, strict=True)]
    moving = Motion.model_validate({"speed": 0.1, "time_profile": {"model": "Corners", "points": points}})
    began = entered(moving, np.array([when]), np.array([place]))[0, 0]
    assert 0 <= began <= when
    fine = np.unique(np.concatenate([np.linspace(began, when, 2001), [t for t in times if began < t < when]]))
    way = np.trapezoid(moving.speeds(fine), fine)
    if began > 0:
        assert way == pytest.approx(place, rel=1e-6, abs=1e-12)
    else:
        assert way <= place * (1 + 1e-6) + 1e-12


def test_renewal_needs_a_speed():
    with pytest.raises(InputError, match="speed"):
        load("vezzoli_2014/fig6").replace({"motion.renews_film": True})
