"""Sums, counts, histograms and quantiles over fingers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from electrovib.study.population.histogram import BandHistogram
from electrovib.study.population.quantiles import exact_quantiles
from electrovib.study.population.sums import Counts, Sums, sums_of


def draws(fingers, samples=5, seed=0):
    generator = np.random.default_rng(seed)
    return np.exp(generator.normal(0, 2, (fingers, samples))) * np.logspace(-6, 3, samples)


def test_merged_sums_are_those_of_all_fingers():
    values = 1e6 + np.random.default_rng(1).normal(0, 1e-3, (2500, 3))  # naive squares would lose all digits
    merged = Sums.empty(3)
    for begin in range(0, 2500, 1024):
        merged.merge(sums_of(values[begin : begin + 1024]))
    exact = [math.fsum((x - math.fsum(column) / 2500) ** 2 for x in column) for column in values.T.tolist()]
    np.testing.assert_allclose(
        merged.mean, [math.fsum(each) / 2500 for each in values.T.tolist()], rtol=5e-15
    )
    np.testing.assert_allclose(merged.squares, exact, rtol=1e-6)
    np.testing.assert_allclose(merged.variance, np.asarray(exact) / 2499, rtol=1e-6)


def test_the_variance_of_one_finger_is_not_known():
    one = sums_of(np.ones((1, 2)))
    assert np.isnan(one.variance).all()


def test_a_copy_keeps_its_sums():
    first = sums_of(draws(10))
    copy = first.copy()
    first.merge(sums_of(draws(10, seed=2)))
    np.testing.assert_array_equal(copy.mean, sums_of(draws(10)).mean)


@pytest.mark.parametrize("fingers", [1, 2, 101, 1000])
def test_exact_quantiles_are_those_of_numpy(fingers):
    values = draws(fingers).astype(np.float32)
    shares = (0.05, 0.5, 0.731, 0.95)
    np.testing.assert_allclose(
        exact_quantiles(values, shares), np.quantile(values.astype(float), shares, axis=0), rtol=1e-14
    )


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_quantiles_of_a_histogram_are_within_its_error(sign):
    values = (sign * draws(20000)).astype(np.float32)
    values[:3000, 0] = 0.0
    whole = BandHistogram(5)
    whole.add(values)
    shares = (0.001, 0.05, 0.5, 0.95, 0.999)
    np.testing.assert_allclose(whole.quantiles(shares), exact_quantiles(values, shares), rtol=2.5e-3)
    assert (
        np.abs(whole.quantiles(shares) / np.where(v := exact_quantiles(values, shares), v, 1) - 1)[
            :, 1:
        ].max()
        > 1e-5
    )


def test_histograms_merge_to_the_same_bits_in_any_order():
    values = draws(900).astype(np.float32)
    whole, parts = BandHistogram(5), [BandHistogram(5) for _ in range(3)]
    whole.add(values)
    for part, begin in zip(parts, (0, 300, 600), strict=True):
        part.add(values[begin : begin + 300] if begin else values[:300])
    merged = BandHistogram(5)
    for part in (parts[2], BandHistogram(5), parts[0], parts[1]):
        merged.merge(part)
    assert merged.first == whole.first
    np.testing.assert_array_equal(merged.counts, whole.counts)


def test_values_that_are_not_known_are_counted_apart():
    values = np.array([[1.0, np.nan], [2.0, np.nan], [3.0, 5.0]])
    counts = Counts.of(values, (1.5, 4.0))
    np.testing.assert_array_equal(counts.above, [[2, 1], [0, 1]])
    np.testing.assert_array_equal(counts.anywhere, [2, 1])
    np.testing.assert_array_equal(counts.unknown, [0, 2])
    histogram = BandHistogram(2)
    histogram.add(values.astype(np.float32))
    assert histogram.counts.sum() == 4


def test_a_value_equal_to_the_threshold_does_not_exceed_it():
    assert Counts.of(np.array([[5e-3]]), (5e-3,)).above.sum() == 0
