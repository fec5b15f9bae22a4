"""Repeated straight pieces are answered in closed form, period by period; written out they say the same."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.physics.drive.pieces import Linear
from electrovib.solve.electrics.straight import SharedModes, periodic_state


def straight(part, rates, gains, times, state, *, lag=False):
    """The modes x, or their lags x - v."""
    modes = SharedModes(rates, gains, np.zeros(len(gains)), np.full(len(gains), lag))
    return np.array(modes.straight(part, times, state))


def straight_lag(*given):
    """The lag x - v of the modes."""
    return straight(*given, lag=True)


@pytest.mark.parametrize("respond", [straight, straight_lag])
@pytest.mark.parametrize("seed", range(20))
def test_a_period_at_a_time_is_what_all_pieces_say(respond, seed):
    """To rounding: a phase of 40 periods is known to 40 eps, which a mode of 1e4/period turns into 1e-10."""
    rng = np.random.default_rng(seed)
    period, inside = 10 ** rng.uniform(-6, 0), rng.integers(1, 5)
    breaks = np.concatenate([[0], np.sort(rng.uniform(0, period, inside)), [period]])
    before, after = rng.normal(size=(2, len(breaks)))
    if seed % 3 == 0:
        before = after.copy()
    before[0], after[-1] = 0.0, after[0]
    part = Linear(breaks, before, after, period)
    end = period * rng.uniform(0.2, 40)
    starts = np.arange(0, end / period) * period
    times = np.concatenate([rng.uniform(0, end, 50), (starts[:, None] + breaks[:-1]).ravel(), [0.0, end]])
    times = np.unique(times[times <= end])
    rates, gains = 10 ** rng.uniform(-3, 4, 6) / period, rng.normal(size=(2, 6))
    state = rng.normal(size=6) * (seed % 2)
    written_out = respond(part.until(end), rates, gains, times, state)
    assert respond(part, rates, gains, times, state) == pytest.approx(written_out, abs=2e-10)
    assert part.count_breaks(end) == len(part.until(end).times)


def test_a_late_period_of_a_fast_square_wave_is_its_periodic_state():
    """100 kHz for 2000 s, 4e8 corners: the beginning is forgotten to 2e-9; the time is rounded to 2e-13 s, 2e-7 of 1/rate."""
    changes = {"drive": {"model": "Square", "high": 100, "low": -60, "frequency": 1e5}}
    scenario = ev.load("vezzoli_2014/fig6", changes=changes)
    part = scenario.drive.parts()[0]
    rates, gains = np.array([1e-2, 1e2, 1e6]), np.eye(3)
    phases = np.linspace(0, 0.95e-5, 20)
    late = straight(part, rates, gains, 2000.0 + phases, np.zeros(3))
    settled = straight(part, rates, gains, phases, periodic_state(part, rates))
    assert late == pytest.approx(settled, abs=1e-4)
