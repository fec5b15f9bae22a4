"""Many fingers: quantiles and histograms, and parts on threads."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.solve.population.percentiles import Histogram, in_threads, quantiles, ranges, thread_count

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


@pytest.mark.parametrize("fingers", [1, 2, 17, 5003])
@pytest.mark.parametrize("threads", [1, 2])
def test_quantiles_are_exact_and_those_of_a_histogram_within_its_stated_error(fingers, threads):
    values = columns(fingers)
    found = quantiles(values, PROBABILITIES, threads=threads)
    expected = np.quantile(values.astype(float), PROBABILITIES, axis=0)
    assert np.allclose(found, expected, rtol=1e-15, atol=0)

    counted = Histogram(values.shape[1])
    counted.add(values, threads=threads)
    places = np.rint(np.array(PROBABILITIES) * (fingers - 1)).astype(int)
    expected = np.sort(values, axis=0)[places].astype(float)
    off = np.abs(counted.quantiles(PROBABILITIES) - expected) > 0.002 * np.abs(expected)
    assert not (off & (np.abs(expected) > 1.2e-38)).any()  # a subnormal number counts as 0
    assert counted.count == fingers


def test_infinities_have_an_order_and_nan_has_none():
    values = columns(99)
    values[3, 0], values[4, 1], values[5, 11] = np.inf, np.nan, -np.inf
    found = quantiles(values, [0.0, 1.0])
    assert found[1, 0] == np.inf
    assert found[0, 11] == -np.inf
    assert np.isnan(found[:, 1]).all()
    assert np.isfinite(np.delete(found, [0, 1, 11], axis=1)).all()
    counted = Histogram(2)
    counted.add([[np.inf, -np.inf]])
    assert counted.quantiles([0.5]).tolist() == [[np.inf, -np.inf]]


def test_histograms_add_up_whatever_the_division():
    values = columns(3000)
    whole, total, grown = (Histogram(values.shape[1]) for _ in range(3))
    whole.add(values)
    for part in (slice(2000, 3000), slice(0, 7), slice(7, 2000)):
        some = Histogram(values.shape[1])
        some.add(values[part])
        total.merge(some)
        grown.add(values[part])  # octaves that are new in one part: its other numbers are counted once
    assert grown.counts[: grown.used].sum() == values.size
    assert np.array_equal(grown.quantiles(PROBABILITIES), whole.quantiles(PROBABILITIES))
    assert total.count == 3000
    assert np.array_equal(total.pages >= 0, whole.pages >= 0)
    filled = whole.pages >= 0
    assert np.array_equal(total.counts[total.pages[filled]], whole.counts[whole.pages[filled]])
    assert total.counts[: total.used].sum() == values.size
    assert np.array_equal(total.quantiles(PROBABILITIES), whole.quantiles(PROBABILITIES))


def test_what_is_no_number_is_not_counted():
    with pytest.raises(InputError, match="not a number"):
        Histogram(2).add([[1.0, np.nan]])


def test_each_place_in_the_order_is_found():
    """Consecutive numbers of float32: every limit of every bucket is one of them."""
    ordered = (np.int32(0x3F7FF000) + np.arange(9001, dtype=np.int32)).view(np.float32)
    values = np.random.default_rng(3).permutation(ordered)[:, np.newaxis]
    places = np.concatenate([np.arange(0, 200), np.arange(4000, 4300), np.arange(8801, 9001)])
    found = quantiles(values, places / 9000.0)[:, 0]
    assert np.allclose(found, ordered[places], rtol=1e-12, atol=0)


def test_threads_share_the_parts_and_pass_on_errors():
    done: list[int] = []
    for threads in (1, 3, None):
        in_threads(done.append, [1, 2, 3], threads)
    assert sorted(done) == [1, 1, 1, 2, 2, 2, 3, 3, 3]
    assert ranges(5, 2) == [(0, 2), (2, 4), (4, 5)]
    assert thread_count(0) == 1
    assert thread_count(None) >= 1

    def fails(part):
        raise ValueError(part)

    with pytest.raises(ValueError, match="7"):
        in_threads(fails, [7, 8], 2)
