"""What is kept of a long record."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.view.envelope import BINS, LONG, envelope


def test_a_short_record_is_drawn_whole():
    x, y = np.arange(LONG, dtype=float), np.ones(LONG)
    assert envelope(x, y)[1] is y


@settings(deadline=None, max_examples=20)
@given(st.integers(LONG + 1, 4 * LONG), st.integers(0, 2**32 - 1))
def test_extremes_ends_and_points_stay(count, seed):
    y = np.random.default_rng(seed).standard_normal(count)
    x = np.linspace(0, 1, count)
    kept_x, kept_y = envelope(x, y)
    assert len(kept_y) <= 2 * BINS + 2
    assert (kept_y.min(), kept_y.max()) == (y.min(), y.max())
    assert (kept_y[0], kept_y[-1]) == (y[0], y[-1])
    assert np.all(np.diff(kept_x) > 0)
    assert np.array_equal(kept_y, y[np.searchsorted(x, kept_x)])


def test_a_single_spike_survives():
    y = np.zeros(10 * LONG)
    y[123_457] = 1.0
    assert envelope(np.arange(len(y), dtype=float), y)[1].max() == 1.0


def test_missing_samples_leave_a_gap_and_hide_nothing():
    y = np.sin(np.linspace(0, 20, 5 * LONG))
    y[30_000:40_000] = np.nan
    y[50_000] = np.nan
    x, kept = envelope(np.arange(len(y), dtype=float), y)
    inside = (x > 30_100) & (x < 39_900)
    assert inside.any()
    assert np.isnan(kept[inside]).all()
    assert np.nanmax(kept) == pytest.approx(np.nanmax(y), abs=0)


def test_nothing_but_missing_samples():
    assert np.isnan(envelope(np.arange(3.0 * LONG), np.full(3 * LONG, np.nan))[1]).all()
