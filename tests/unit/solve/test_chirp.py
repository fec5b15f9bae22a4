"""Modes under a chirp in closed form, against the march of its polynomials and against long arithmetic."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import Chirped, Smooth
from electrovib.solve.electrics.formulas import GONE, chirp_response, smooth_states
from electrovib.solve.electrics.transient import transient
from electrovib.solve.expanded import Expanded
from electrovib.solve.stack.transfer import Transfer

MARCHED = 5e-11
"""Of the amplitude, against the march; measured 9e-12 over 120 chirps drawn at random, which is the march's own."""
EXACT = 2e-13
"""Of the amplitude, against long arithmetic; measured 3e-14."""


def each(part, rates, time, *, lag=False):
    return chirp_response(part, rates, np.eye(len(rates)), time, lag=lag)


@settings(max_examples=15)
@given(
    first=st.one_of(st.just(0.0), st.floats(-1, 2.5).map(lambda power: 10.0**power)),
    last=st.floats(-1, 2.5).map(lambda power: 10.0**power),
    length=st.floats(0.01, 1.0),
    even=st.booleans(),
)
def test_the_march(first, last, length, even):
    """Rising, falling and of one frequency, beneath modes slower and faster than all of it, and after its end."""
    part = Chirped.between(1.0, last if even else first, last, length)
    crossed = np.sqrt(2 * GONE * np.pi * max(abs(part.sweep), 1e-3))
    rates = np.concatenate([[1e-30], np.geomspace(1e-2, 1e7, 10), crossed * np.array([0.3, 0.99, 1.01, 3.0])])
    time = np.unique(np.append(np.linspace(0, 1.3 * length, 300), length))
    marched, states = smooth_states(part, rates, time), each(part, rates, time)
    assert np.max(np.abs(states - marched)) < MARCHED
    np.testing.assert_allclose(states[0], marched[0], rtol=0, atol=1e-9 * np.max(np.abs(marched[0])))
    assert np.max(np.abs(each(part, rates, time, lag=True) - (marched - part.value(time)))) < MARCHED


@pytest.mark.slow
@pytest.mark.parametrize(("first", "last"), [(1.0, 60.0), (60.0, 0.5), (0.0, 40.0)])
def test_long_arithmetic(first, last):
    part = Chirped.between(1.0, first, last, 0.5)
    rates, time = np.array([2.0, 40.0, 180.0, 900.0, 2e5]), np.array([0.02, 0.21, 0.4999])
    found, lags = each(part, rates, time), each(part, rates, time, lag=True)
    with mpmath.workdps(30):
        a, b = mpmath.pi * mpmath.mpf(part.sweep), 2 * mpmath.pi * mpmath.mpf(first)
        for (row, column), value in np.ndenumerate(found):
            rate, end = float(rates[row]), mpmath.mpf(float(time[column]))

            def fading(u, rate=rate, end=end):
                return mpmath.exp(-rate * (end - u)) * mpmath.sin(b * u + a * u * u)

            expected = rate * mpmath.quad(fading, mpmath.linspace(max(0.0, end - 80 / rate), end, 40))
            assert abs(value - expected) < EXACT
            assert abs(lags[row, column] - (expected - mpmath.sin(b * end + a * end**2))) < EXACT
    assert np.max(np.abs(lags[-1])) > 1e4 * EXACT  # a fast mode lags by w over its rate


@pytest.mark.parametrize("lag", [False, True])
def test_many_times_read_what_few_do(lag):
    """Polynomials through the envelope: the same at a million times as at some of them, without and with lag."""
    part, rates, time = (
        Chirped.between(1.0, 1.0, 1e4, 100.0),
        np.geomspace(1e-3, 1e9, 60),
        np.linspace(0, 101, 200_001),
    )
    gains = np.array([np.ones(60), np.where(np.arange(60) % 2, 1.0, -1.0)])
    some = np.unique(np.concatenate([np.arange(40), np.arange(0, 200_001, 4999), [198_018, 198_020]]))
    many = chirp_response(part, rates, gains, time, lag=lag)[:, some]
    few = np.hstack([chirp_response(part, rates, gains, time[[place]], lag=lag) for place in some])
    assert np.max(np.abs(many - few)) < 1e-12
    assert np.max(np.abs(few)) > 1


def test_off_and_at_its_end():
    part = Chirped.between(2.0, 5.0, 80.0, 0.1)
    rates, time = np.array([3.0, 40.0]), np.array([0.0, 0.1, 0.15])
    states, lags = each(part, rates, time), each(part, rates, time, lag=True)
    assert np.all(states[:, 0] == 0)
    np.testing.assert_allclose(states[:, 2], states[:, 1] * np.exp(-rates * 0.05), rtol=1e-12)
    np.testing.assert_allclose(lags[:, 1:], states[:, 1:], rtol=1e-14)  # the drive is 0 V from its end on
    just_before = each(part, rates, np.array([np.nextafter(0.1, 0)]))
    np.testing.assert_allclose(states[:, 1:2], just_before, rtol=1e-12)


def test_a_chirp_as_a_current_and_an_unknown_formula():
    """A divided chirp stays one; the same as a formula that says nothing of itself gives the same."""
    table = {"model": "Chirp", "amplitude": 3.0, "first": 200.0, "last": 10.0, "length": 0.05}
    drive = read_model(Drive, {"model": "CurrentAmplifier", "command": table, "sense_resistance": 1e3})
    (part,), (plain,) = drive.parts(), read_model(Drive, table).parts()
    assert isinstance(part, Chirped)
    assert part.bound() == pytest.approx(3e-3)
    rates, gains, time = np.array([5.0, 700.0]), np.array([1.0, -0.3]), np.linspace(0, 0.06, 41)
    wanted = Transfer(rates=rates, gains=gains, direct=0.2, slope=1e-4)
    unknown = Smooth(plain.formula, plain.derivative, plain.start, plain.stop, plain.highest_frequency)
    marched = gains @ smooth_states(unknown, rates, time) + 0.2 * plain.value(time) + 1e-4 * plain.slope(time)
    np.testing.assert_allclose(transient({"x": wanted}, drive, time)["x"], marched / 1e3, atol=1e-12)


def test_a_long_chirp_is_answered_without_its_cycles(monkeypatch):
    """5e5 cycles on a skin with a memory: nothing marches, and no array is as long as the chirp has cycles."""
    drive = {"model": "Chirp", "amplitude": 100, "first": 1, "last": 1e4, "length": 100}
    causal = {"force": {"model": "Vezzoli2014Causal"}, "time.initial_state": {"model": "AtRest"}}
    scenario = ev.load("vezzoli_2014/fig7", changes={"drive": drive} | causal)
    longest = []

    def counted(part, rates, gains, time, *, lag=False):
        longest.append(len(time))
        return chirp_response(part, rates, gains, time, lag=lag)

    monkeypatch.setattr("electrovib.solve.electrics.transient.smooth_states", None)
    monkeypatch.setattr("electrovib.solve.electrics.transient.chirp_response", counted)
    trace = ev.simulate(scenario)
    assert max(longest) < 50_000
    sure = ev.simulate(scenario, time=np.array([0.0, *trace.time.values[[700, 1999]]])).electrostatic_force
    force = trace.electrostatic_force.values
    np.testing.assert_allclose(sure[1:], force[[700, 1999]], rtol=1e-3, atol=1e-4 * force.max())
    expanded, time = Expanded(scenario), np.linspace(0, 100, 20_001)
    few = expanded.at(time[::1000]).solution.force
    many = expanded.at(time).solution.force[::1000]
    np.testing.assert_allclose(many, few, rtol=1e-9, atol=1e-10 * few.max())
