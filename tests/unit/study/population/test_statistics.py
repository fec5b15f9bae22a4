"""Counts of fingers, and histograms of signals that are not known everywhere."""

from __future__ import annotations

import numpy as np

from electrovib.solve.population.kernels import Histogram, block_moments
from electrovib.study.population.counts import FingerCounts
from electrovib.study.population.reduced import ReducedSignal, count_in
from electrovib.study.population.words import percentile_words


def counted(values, *thresholds):
    return FingerCounts.of(values, thresholds, block_moments(values))


def test_values_that_are_not_known_are_counted_apart():
    values = np.array([[1.0, np.nan], [2.0, np.nan], [3.0, 5.0]])
    counts = counted(values, 1.5, 4.0)
    np.testing.assert_array_equal(counts.above, [[2, 1], [0, 1]])
    np.testing.assert_array_equal(counts.anywhere, [2, 1])
    np.testing.assert_array_equal(counts.unknown, [0, 2])
    histogram = Histogram(2)
    count_in(histogram, ReducedSignal([], counts, values.astype(np.float32), None), None)
    assert histogram.count == 3
    np.testing.assert_allclose(histogram.quantiles([0.5])[0, 0], 2.0, rtol=2e-3)


def test_a_value_equal_to_the_threshold_does_not_exceed_it():
    assert counted(np.array([[5e-3]]), 5e-3).above.sum() == 0


def test_counts_of_all_fingers_are_the_sum_of_those_of_the_parts():
    values = np.random.default_rng(1).normal(size=(20, 3))
    whole = counted(values, 0.0, 1.0)
    merged = FingerCounts.empty(2, 3)
    merged.merge(counted(values[:7], 0.0, 1.0))
    before = merged.copy()
    merged.merge(counted(values[7:], 0.0, 1.0))
    for name in ("above", "anywhere", "unknown"):
        np.testing.assert_array_equal(getattr(merged, name), getattr(whole, name))
    np.testing.assert_array_equal(before.above, counted(values[:7], 0.0, 1.0).above)


def test_percentiles_in_words():
    found = [percentile_words(share) for share in (50.0, 5.0, 1.0, 2.0, 3.0, 11.0, 21.0, 2.5, 99.0)]
    assert found == [
        "median", "5th percentile", "1st percentile", "2nd percentile", "3rd percentile", "11th percentile",
        "21st percentile", "2.5th percentile", "99th percentile",
    ]  # fmt: skip
