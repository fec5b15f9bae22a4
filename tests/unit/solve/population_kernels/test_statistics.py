"""Quantiles and histograms over fingers."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels import Histogram, quantiles

PROBABILITIES = [0.0, 0.05, 0.5, 0.5001, 0.95, 1.0]


def columns(fingers, seed=1):
    """Kinds of distributions side by side, float32."""
    random = np.random.default_rng(seed)
    made = [
        random.normal(size=fingers),
        random.lognormal(sigma=4, size=fingers),
        np.full(fingers, 0.25),
        random.integers(0, 3, fingers),
        np.zeros(fingers),
        np.where(random.random(fingers) < 0.5, -0.0, 0.0),
        random.uniform(1, 1 + 1e-6, fingers),
        -random.exponential(size=fingers) * 1e-38,
        np.where(np.arange(fingers) == 0, 3e38, random.normal(size=fingers)),
        np.arange(fingers) - fingers / 2,
    ]
    repeated = np.stack([*made, *made], axis=1)  # more columns than a tile has
    return repeated.astype(np.float32)


@pytest.mark.parametrize("fingers", [1, 2, 3, 17, 1000, 5003])
@pytest.mark.parametrize("threads", [1, 2])
def test_quantiles_are_exact(fingers, threads):
    values = columns(fingers)
    found = quantiles(values, PROBABILITIES, threads=threads)
    expected = np.quantile(values.astype(float), PROBABILITIES, axis=0)
    assert np.allclose(found, expected, rtol=1e-15, atol=0)


def test_infinities_have_an_order_and_nan_has_none():
    values = columns(99)
    values[3, 0], values[4, 1], values[5, 11] = np.inf, np.nan, -np.inf
    found = quantiles(values, [0.0, 1.0])
    assert found[1, 0] == np.inf
    assert found[0, 11] == -np.inf
    assert np.isnan(found[:, 1]).all()
    assert np.isfinite(np.delete(found, [0, 1, 11], axis=1)).all()


def test_quantiles_of_nothing_are_refused():
    with pytest.raises(InputError, match="one finger or more"):
        quantiles(np.zeros((0, 3)), [0.5])
    with pytest.raises(InputError, match="from 0 to 1"):
        quantiles(np.zeros((1, 3)), [1.5])


@pytest.mark.parametrize("threads", [1, 2])
def test_a_histogram_is_within_its_stated_error(threads):
    values = columns(5003)
    counted = Histogram(values.shape[1])
    counted.add(values, threads=threads)
    found = counted.quantiles(PROBABILITIES)
    places = np.rint(np.array(PROBABILITIES) * 5002).astype(int)
    expected = np.sort(values, axis=0)[places].astype(float)
    off = np.abs(found - expected) > 0.002 * np.abs(expected)
    assert not (off & (np.abs(expected) > 1.2e-38)).any()  # a subnormal number counts as 0
    assert counted.count == 5003


def test_histograms_add_up_whatever_the_division():
    values = columns(3000)
    whole = Histogram(values.shape[1])
    whole.add(values)
    parts = []
    for part in (slice(2000, 3000), slice(0, 7), slice(7, 2000)):
        parts.append(Histogram(values.shape[1]))
        parts[-1].add(values[part])
    total = Histogram(values.shape[1])
    for part in parts:
        total.merge(part)
    assert total.count == 3000
    assert np.array_equal(total.pages >= 0, whole.pages >= 0)
    filled = whole.pages >= 0
    assert np.array_equal(total.counts[total.pages[filled]], whole.counts[whole.pages[filled]])
    assert total.counts[: total.used].sum() == values.size
    assert np.array_equal(total.quantiles(PROBABILITIES), whole.quantiles(PROBABILITIES))
    with pytest.raises(InputError, match="cannot be added"):
        total.merge(Histogram(4))


def test_a_histogram_counts_numbers_only():
    counted = Histogram(2)
    with pytest.raises(InputError, match="not a number"):
        counted.add([[1.0, np.nan]])
    with pytest.raises(InputError, match=r"expected \(fingers, 2\)"):
        counted.add([[1.0]])
    with pytest.raises(InputError, match="one value or more"):
        counted.quantiles([0.5])
    counted.add([[np.inf, -np.inf]])
    assert counted.quantiles([0.5]).tolist() == [[np.inf, -np.inf]]


def test_each_place_in_the_order_is_found():
    """Consecutive numbers of float32: every limit of every bucket is one of them."""
    ordered = (np.int32(0x3F7FF000) + np.arange(9001, dtype=np.int32)).view(np.float32)
    values = np.random.default_rng(3).permutation(ordered)[:, np.newaxis]
    places = np.concatenate([np.arange(0, 200), np.arange(4000, 4300), np.arange(8801, 9001)])
    found = quantiles(values, places / 9000.0)[:, 0]
    assert np.allclose(found, ordered[places], rtol=1e-12, atol=0)
