"""Many fingers: responses, quantiles and histograms, and parts on threads."""

import numpy as np
import pytest
from plain_recursion import march_loop

from electrovib.core.errors import InputError
from electrovib.solve.population.drive import first_order_hold_many, time_steps
from electrovib.solve.population.percentiles import Histogram, in_threads, quantiles, ranges, thread_count

SAME = 1e-12


END = 7e-3
SPREAD = np.random.default_rng(1).exponential(1e-5, 700)
TIMES = {
    "even": np.linspace(0.0, END, 700),
    "corners": np.unique([*np.linspace(0, END, 500), 1e-5 * np.pi, 2e-3, 2.0000123e-3, 6.9e-3]),
    "discontinuous": np.insert(
        np.linspace(0.0, END, 300), [5, 100, 100], [END * 4 / 299, END * 99 / 299, END * 99 / 299]
    ),
    "uneven": np.cumsum(SPREAD),  # more kinds of steps than weights are kept for
}


def some_fingers(seed, fingers, modes):
    """Rates over nine decades, residues of both signs, states that are not at rest."""
    random = np.random.default_rng(seed)
    rates = 10 ** random.uniform(-2, 7, (fingers, modes))
    given = {"rates": rates, "residues": random.normal(size=(fingers, modes)) * rates}
    return given | {"direct": random.normal(size=fingers), "state": random.normal(size=(fingers, modes))}


def drive(times):
    return np.random.default_rng(2).normal(size=times.size)


@pytest.mark.parametrize(("fingers", "modes"), [(11, 1), (11, 12), (70, 7)])
@pytest.mark.parametrize("kind", TIMES)
def test_responses_are_those_of_the_plain_loop(kind, fingers, modes):
    """70 in more than one tile, with modes that fill up the row and modes that charge alone excites."""
    given, times = some_fingers(3, fingers, modes), TIMES[kind]
    if fingers == 70:
        given["residues"][::3, 2] = 0.0
    voltage = drive(times)
    found = first_order_hold_many(**given, voltage=voltage, time=times)
    assert found.shape == (fingers, times.size)
    for finger in range(0, fingers, 1 + fingers // 7):
        rates, state = given["rates"][finger], given["state"][finger]
        gains = given["residues"][finger] / rates
        idle = gains == 0
        start = np.where(idle, 0.0, state / np.where(idle, 1.0, gains))
        pieces = voltage[:-1], voltage[1:], np.diff(times)
        expected = march_loop(-rates, [gains], [given["direct"][finger]], *pieces, start)[0][0]
        expected += (state * np.exp(-np.multiply.outer(times - times[0], rates)))[:, idle].sum(axis=1)
        assert np.max(np.abs(found[finger] - expected)) <= SAME * np.max(np.abs(expected))


@pytest.mark.parametrize("kind", TIMES)
def test_the_lag_of_a_mode_behind_the_drive(kind):
    """direct v + sum residue s is (direct + sum gain) v + sum gain (rate s - v), whatever the steps and jumps."""
    given, times = some_fingers(8, 70, 3), TIMES[kind]
    given["state"][:] = 0.0
    voltage, gains = drive(times), given["residues"] / given["rates"]
    expected = first_order_hold_many(**given, voltage=voltage, time=times)
    given |= {"residues": gains, "direct": given["direct"] + gains.sum(axis=1), "state": -gains * voltage[0]}
    rises = np.append(np.diff(voltage), 0.0)
    found = first_order_hold_many(**given, voltage=voltage, time=times, rises=rises)
    assert np.max(np.abs(found - expected)) <= SAME * np.max(np.abs(expected))


def test_a_rate_of_zero_integrates_trapped_charge_stays_and_one_time_is_the_state():
    times = np.linspace(0, 1, 101)
    given = {"rates": [[0.0, 0.0]], "residues": [[2.0, 0.0]], "direct": [0.0], "state": [[0.0, 5.0]]}
    found = first_order_hold_many(**given, voltage=times, time=times)[0]
    assert np.allclose(found, times**2 + 5, rtol=1e-14, atol=0)
    found = first_order_hold_many([[1.0, 2.0]], [[1.0, 1.0]], [2.0], [[3.0, 4.0]], [10.0], [0.0])
    assert found.tolist() == [[27.0]]


@pytest.mark.parametrize("kind", ["even", "corners"])
def test_a_finger_does_not_depend_on_the_company(kind):
    given, times = some_fingers(5, 1100, 5), TIMES[kind]
    shared = {"voltage": drive(times), "time": times}
    found = first_order_hold_many(**given, **shared)
    for part in (slice(0, 1), slice(3, 4), slice(5, 42), slice(1023, 1030), slice(1097, 1100)):
        some = {name: values[part] for name, values in given.items()}
        assert np.array_equal(first_order_hold_many(**some, **shared), found[part])


def test_digits_are_kept():
    """Of a lag where the mode follows; of slow modes over long records, and over short ones.

    Behind a ramp of 1 V/s a mode lags by 1/rate, 1e-9 of the drive. The response of a slow mode to 1 V from rest is one
    exponential. Rounding is compensated once it has accumulated, not before.
    """
    times, rises = np.linspace(0.0, 1.0, 1001), np.append(np.full(1000, 1e-3), 0.0)
    found = first_order_hold_many([[1e9]], [[1.0]], [0.0], [[0.0]], times, times, rises=rises)
    assert np.allclose(found[0, 1:], -1e-9, rtol=1e-13, atol=0)

    times, rates = np.arange(60_001) * 1e-6, np.array([[1.0, 7.0], [30.0, 0.1]])
    found = first_order_hold_many(rates, rates, [0.0, 0.0], np.zeros((2, 2)), np.ones(times.size), times)
    expected = -np.expm1(-rates[:, :, np.newaxis] * times).sum(axis=1)
    assert np.max(np.abs(found - expected) / np.max(expected, axis=1, keepdims=True)) < 2e-13

    times, rates = np.arange(20) * 1e-6, np.linspace(10.0, 900.0, 40)[:, np.newaxis]
    nothing = np.zeros(rates.shape)
    found = first_order_hold_many(rates, nothing, np.zeros(40), nothing + 1.0, np.zeros(20), times)
    assert np.max(np.abs(found / np.exp(-rates * times) - 1)) < 4e-15


def test_equal_steps_count_once():
    assert time_steps(0.3 + np.linspace(0, 1e-2, 1001)).duration.size == 1
    steps = time_steps([0.0, 0.0, 1.0, 2.0, 2.5, 3.0])
    assert steps.duration.tolist() == [0.0, 0.5, 1.0]
    assert steps.kind.tolist() == [0, 2, 2, 1, 1]
    assert time_steps([1.0]).kind.size == 0


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
