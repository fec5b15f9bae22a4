"""The integrator with events: closed forms, landings, breaks, output times, order of convergence."""

import functools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from electrovib.core.errors import ElectrovibError
from electrovib.solve.nonlinear import integrate as integrator
from electrovib.solve.nonlinear.integrate import System, integrate, land

ORDER = 5
"""Of Radau's method with three stages, where the rate is smooth."""
LOOSE = 1e-2
"""A tolerance with which the largest step alone sets the steps."""


class Plain(System):
    """One state of a given rate; no breaks, and switches where they are given."""

    scale = np.ones(1)

    def __init__(self, rate=np.ones_like, switch=None):
        self.given, self.switch = rate, switch

    def breaks(self, _end):
        return ()

    def jump(self, state, **_):
        return state

    def rate(self, state, _mode, **_):
        return self.given(state)

    def switches(self, state, mode, **_):
        return np.empty(0) if self.switch is None else self.switch(state, mode)

    def following(self, _index, _state, mode, **_):
        return (mode[0] + 1,)


class Rubbed(Plain):
    """x'' = -x - friction sign(v), let go at x = -1 with v = 0: the rate jumps where the mass turns."""

    scale = np.ones(2)

    def __init__(self, friction=0.15, *, located=True):
        self.friction, self.located = friction, located

    def rate(self, state, mode, **_):
        direction = mode[0] if self.located else np.sign(state[1])
        return np.array([state[1], -state[0] - self.friction * direction])

    def switches(self, state, mode, **_):
        return np.array([mode[0] * state[1]] if self.located else [])

    def following(self, _index, _state, mode, **_):
        return (-mode[0],)

    def exact(self, time):
        """Half cosines about -friction and +friction in turn, each 2 friction shorter than the one before."""
        half = np.floor(time / np.pi)
        sign = -((-1.0) ** half)
        return sign * ((1 - (2 * half + 1) * self.friction) * np.cos(time - half * np.pi) + self.friction)


def let_go(system, times, **more):
    return integrate(system, np.array([-1.0, 0.0]), (1,), times, **more)


def test_harmonic_motion_between_located_reversals():
    times = np.linspace(0, 9, 91)
    solved = let_go(Rubbed(), times)
    np.testing.assert_allclose(solved.states[0], Rubbed().exact(times), rtol=0, atol=1e-9)
    found = [when for when, _ in solved.events]
    np.testing.assert_allclose(found, np.pi * np.arange(1, 3), rtol=0, atol=1e-9)
    assert np.max(np.abs(solved.states[0] - let_go(Rubbed(0.0), times).states[0])) > 0.1


def error_at(step, *, located=True):
    times = np.array([0.0, 7.0])
    solved = let_go(Rubbed(located=located), times, step=step, tolerance=LOOSE)
    return abs(solved.states[0, -1] - Rubbed().exact(times)[-1])


def order(errors, steps):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


def measured_order():
    steps = [0.5, 0.25, 0.125, 0.0625]
    return order([error_at(step) for step in steps], steps)


def test_order_across_jumps_of_the_rate(monkeypatch):
    """The order of the method, unless events are not located or a state is read from the polynomial of a step."""
    assert measured_order() == pytest.approx(ORDER, abs=0.1)
    # of 562 steps the error is a million times that of 114 which end at the reversals
    assert error_at(0.0125 * 0.9973, located=False) > 1e6 * error_at(0.0625)

    def read(march, _system, _mode, *, when, after, **_):
        piece, _ = next(march(stop=after, whole=True))
        state, piece.t = piece(when), when
        return [piece], state

    monkeypatch.setattr(integrator, "land", read)
    assert measured_order() < ORDER - 0.3


class Kicked(Plain):
    """y' = -y, from 1 s on y' = 3 - y, and at 2 s y jumps by 1."""

    def breaks(self, _end):
        return (1.0, 2.0)

    def jump(self, state, *, time):
        return state + 1 if time == 2.0 else state

    def rate(self, state, _mode, *, time):
        return np.where(np.asarray(time) >= 1, 3.0, 0.0) - state

    def exact(self, time):
        to_one = np.exp(-np.minimum(time, 1))
        to_two = 3 + (to_one - 3) * np.exp(-np.clip(time - 1, 0, 1))
        return np.where(time < 2, to_two, 3 + (to_two - 2) * np.exp(-np.maximum(time - 2, 0)))

    def followed(self, times, **more):
        return integrate(self, np.array([1.0]), (), np.array(times), **more).states[0] - self.exact(times)


@pytest.mark.parametrize("step", [None, 0.02])
def test_breaks_end_steps_and_jumps_are_seen_after_them(step):
    times = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.0 + 1e-12, 2.5, 3.0])
    for asked in (times, np.array([2.0])):
        np.testing.assert_allclose(Kicked().followed(asked, step=step), 0, rtol=0, atol=1e-9)


def test_order_across_a_jump_of_the_rate_at_a_break():
    times, steps = np.array([1.5]), [0.5, 0.25, 0.125]
    errors = [abs(Kicked().followed(times, step=step, tolerance=LOOSE)[0]) for step in steps]
    assert order(errors, steps) == pytest.approx(ORDER, abs=0.1)


def from_(start, system, times, **more):
    return integrate(system, np.array([start]), (0,), np.array(times), **more)


def test_events_between_and_at_output_times():
    """y' = 1: below 0.4, inside, above 0.45; a single step jumps over all of it."""
    window = Plain(switch=lambda state, mode: np.array([{0: 0.4, 1: 0.45, 2: np.inf}[mode[0]] - state[0]]))
    times = [0.0, 0.4, 0.45, 1.0]
    solved = from_(0.0, window, times)
    np.testing.assert_allclose(solved.states[0], times, rtol=0, atol=1e-14)
    np.testing.assert_allclose([when for when, _ in solved.events], [0.4, 0.45], rtol=0, atol=1e-14)
    assert solved.modes[0] == (0,)
    assert solved.modes[-1] == (2,)
    solved = from_(0.42, window, [0.0, 1.0])  # a mode that does not hold ends at once
    assert solved.events[0] == (0.0, 0)
    assert solved.modes[0] == (1,)


def test_a_switch_that_has_risen_again_is_found():
    """It dips below 0 between 0.3 and 0.7 and has risen again long before the step ends."""
    dip = Plain(switch=lambda y, mode: (y - 0.5) ** 2 - 0.2**2 if mode == (0,) else np.ones_like(y))
    solved = from_(0.0, dip, [0.0, 1.0], step=1.0)
    assert solved.events[0][0] == pytest.approx(0.3, abs=1e-14)


@pytest.mark.parametrize(
    ("system", "start", "words", "step"),
    [
        (Plain(switch=lambda y, _: -np.ones_like(y)), 0.0, "chatters", None),
        (Plain(lambda y: y**2), 1.0, "could not be solved", None),
        (Plain(lambda y: y**2), 1.0, "could not be solved", 0.3),
        (Plain(lambda y: np.where(y < 2, 1.0, np.nan)), 1.0, "could not be solved beyond", None),
    ],
    ids=["chatter", "no solution", "no solution in long steps", "not a number"],
)
def test_what_cannot_be_followed_is_refused(system, start, words, step, monkeypatch):
    monkeypatch.setattr(integrator, "MOST_EVENTS", 50)
    with np.errstate(over="ignore", invalid="ignore"), pytest.raises(ElectrovibError, match=words):
        from_(start, system, [0.0, 2.0], step=step)


def linear(matrix, scale=1.0):
    system = Plain(lambda state: matrix @ state)
    system.scale = np.full(len(matrix), scale)
    return system


@given(
    fast=st.floats(0, 8).map(lambda power: -(10.0**power)),
    slow=st.floats(-2, 1).map(lambda power: -(10.0**power)),
    turn=st.floats(0, 3.1),
)
def test_stiff_linear_systems(fast, slow, turn):
    axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    system = linear(axes @ np.diag([fast, slow]) @ axes.T)
    solved = integrate(system, np.array([1.0, 0.5]), (), np.array([0.0, 0.7]), tolerance=1e-8)
    exact = axes @ (np.exp(np.array([fast, slow]) * 0.7) * (axes.T @ [1.0, 0.5]))
    np.testing.assert_allclose(solved.states[:, -1], exact, rtol=0, atol=1e-7)  # ten local errors


@pytest.mark.parametrize("unit", [1e-9, 1e6])
def test_nothing_depends_on_the_unit(unit):
    matrix, times, start = np.array([[0.0, 1.0], [-40.0, -0.3]]), np.linspace(0, 3, 31), np.array([1.0, 0.0])
    one, other = (integrate(linear(matrix, scale), scale * start, (), times) for scale in (1.0, unit))
    assert abs(one.steps - other.steps) <= 1
    np.testing.assert_allclose(other.states / unit, one.states, rtol=0, atol=1e-8)
    exact = np.transpose([expm(matrix * time) @ start for time in times.tolist()])
    np.testing.assert_allclose(one.states, exact, rtol=0, atol=1e-7)


def test_a_landing_within_the_rounding_of_a_time_is_a_landing():
    """From 1 s to the next number: there is no earlier time to take the slope from."""
    falling = Plain(switch=lambda state, mode: np.array([state[0] if not mode else 0.0]))
    given_ = {"start": 1.0, "scale": np.ones(1), "tolerance": 1e-9, "step": None}
    march = functools.partial(
        integrator._steps, lambda _, states: -np.ones_like(states), np.zeros(1), **given_
    )
    landed, _ = land(march, falling, (), when=np.nextafter(1.0, 2.0), after=1.1, index=0)
    assert landed[-1].t == pytest.approx(1.0)
