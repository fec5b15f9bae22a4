"""Statistics of fingers, also of signals that are not known everywhere."""

from __future__ import annotations

import numpy as np

from electrovib.study.population.fingers import Statistics
from electrovib.study.population.words import percentile_words


def counted(values, *thresholds, binned=False):
    found = Statistics(thresholds, values.shape[1], binned=binned)
    found.add(values.copy())
    return found


def test_values_that_are_not_known_are_counted_apart():
    values = np.array([[1.0, np.nan], [2.0, np.nan], [3.0, 5.0]])
    found = counted(values, 1.5, 4.0, binned=True)
    np.testing.assert_array_equal(found.above, [[2, 1], [0, 1]])
    np.testing.assert_array_equal(found.anywhere, [2, 1])
    np.testing.assert_array_equal(found.unknown, [0, 2])
    found.count(values.astype(np.float32), None)
    histogram = found.histogram
    assert histogram.count == 3
    np.testing.assert_allclose(histogram.quantiles([0.5])[0, 0], 2.0, rtol=2e-3)


def test_a_value_equal_to_the_threshold_does_not_exceed_it():
    assert counted(np.array([[5e-3]]), 5e-3).above.sum() == 0


def test_thresholds_are_compared_with_numbers_in_float64():
    value = 1.0
    threshold = float(np.nextafter(value, 0.0))  # both have the same float32
    assert counted(np.array([[value]]), threshold).above[0, 0] == 1


def test_statistics_of_all_fingers_are_those_of_the_parts():
    values = np.random.default_rng(1).normal(size=(20, 3))
    whole = counted(values, 0.0, 1.0)
    merged = Statistics((0.0, 1.0), 3)
    merged.merge(counted(values[:7], 0.0, 1.0))
    merged.merge(counted(values[7:], 0.0, 1.0))
    for name in ("above", "anywhere", "unknown"):
        np.testing.assert_array_equal(getattr(merged, name), getattr(whole, name))
    assert merged.fingers == 20
    np.testing.assert_allclose(merged.mean, values.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(merged.variance(), values.var(axis=0, ddof=1), rtol=1e-12)


def test_statistics_are_restored_from_their_arrays():
    values = np.random.default_rng(1).normal(size=(20, 3))
    whole, first = counted(values, 0.0, binned=True), counted(values[:7], 0.0, binned=True)
    whole.count(values.astype(np.float32), None)
    first.count(values[:7].astype(np.float32), None)
    later = Statistics((0.0,), 3, binned=True)
    later.restore(first.arrays())
    later.merge(counted(values[7:], 0.0))
    later.count(values[7:].astype(np.float32), None)
    for name, each in whole.arrays().items():
        if name not in {"pages", "bins"}:
            np.testing.assert_allclose(later.arrays()[name], each, rtol=1e-12)
    shares = np.linspace(0.0, 1.0, 9)
    np.testing.assert_array_equal(later.histogram.quantiles(shares), whole.histogram.quantiles(shares))


def test_percentiles_in_words():
    found = [percentile_words(share) for share in (50.0, 5.0, 1.0, 2.0, 3.0, 11.0, 21.0, 2.5, 99.0)]
    assert found == [
        "median", "5th percentile", "1st percentile", "2nd percentile", "3rd percentile", "11th percentile",
        "21st percentile", "2.5th percentile", "99th percentile",
    ]  # fmt: skip
