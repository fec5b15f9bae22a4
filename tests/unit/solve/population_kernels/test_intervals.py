"""Statistics of responses that are not stored: those of the stored ones, to the last bit."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels import Histogram, first_order_hold_many, quantiles, square_quantiles

SHARES = [0.0, 0.05, 0.5, 0.95]


def some_fingers(fingers, modes, seed=1):
    """Rates over nine decades, residues of both signs, states that are not at rest, and factors."""
    random = np.random.default_rng(seed)
    rates = 10 ** random.uniform(-2, 7, (fingers, modes))
    return {
        "rates": rates,
        "residues": random.normal(size=(fingers, modes)) * rates,
        "direct": random.normal(size=fingers),
        "state": random.normal(size=(fingers, modes)),
        "factor": random.uniform(0.5, 2.0, fingers),
    }


def some_drive(times=1300):
    """Many equal steps, corners between them and a discontinuity."""
    even = np.linspace(0.0, 13e-3, times)
    time = np.sort(np.concatenate([even, [np.pi * 1e-3, 5.0000123e-3], even[[times // 2]]]))
    return time, np.random.default_rng(2).normal(size=time.size)


@pytest.mark.parametrize(("fingers", "modes"), [(1, 2), (77, 3), (4100, 1)])
@pytest.mark.parametrize("threads", [1, 2])
def test_quantiles_are_those_of_stored_responses(fingers, modes, threads):
    given, (time, voltage) = some_fingers(fingers, modes), some_drive()
    outputs = np.flatnonzero(np.random.default_rng(3).random(time.size) < 0.7)
    outputs = outputs[(outputs < 256) | (outputs >= 512)]  # without any in some intervals
    stored = first_order_hold_many(**given, voltage=voltage, time=time, dtype=np.float32)[:, outputs]
    asked = {"voltage": voltage, "time": time, "outputs": outputs, "probabilities": SHARES}
    found = square_quantiles(**given, **asked, threads=threads)
    assert found.tobytes() == quantiles(stored, SHARES).tobytes()
    known = {fingers // 2: np.full((1, len(outputs)), 0.5, np.float32)}
    stored[fingers // 2] = 0.5
    found = square_quantiles(**given, **asked, known=known, threads=threads)
    assert found.tobytes() == quantiles(stored, SHARES).tobytes()


def test_a_value_that_is_no_number_has_no_quantiles_at_its_times():
    given, (time, voltage) = some_fingers(30, 2), some_drive(300)
    known = {3: np.zeros((1, time.size), np.float32)}
    known[3][0, 200] = np.nan
    found = square_quantiles(
        **given, voltage=voltage, time=time, outputs=np.arange(time.size), probabilities=SHARES, known=known
    )
    assert np.flatnonzero(np.isnan(found).any(axis=0)).tolist() == [200]
    with pytest.raises(InputError, match="from 0 to 1"):
        square_quantiles(**given, voltage=voltage, time=time, outputs=[0], probabilities=[2])


@pytest.mark.slow
@pytest.mark.parametrize("fingers", [1, 2500])
@pytest.mark.parametrize("threads", [1, 2])
def test_counts_are_those_of_stored_responses(fingers, threads):
    given, (time, voltage) = some_fingers(fingers, 2), some_drive()
    given["factor"][::3] *= -1.0
    outputs = np.flatnonzero(np.random.default_rng(3).random(time.size) < 0.7)
    stored = first_order_hold_many(**given, voltage=voltage, time=time, dtype=np.float32)[:, outputs]
    known = {fingers // 2: np.full((1, len(outputs)), -0.0, np.float32)}
    stored[fingers // 2] = known[fingers // 2]
    found, expected = Histogram(len(outputs)), Histogram(len(outputs))
    for change in (1.0, 1.0, 4096.0):  # into octaves without memory, with, and both
        given["factor"][1:] *= change
        stored[1:] *= np.float32(change)  # a power of two: no rounding
        found.add_squares(**given, voltage=voltage, time=time, outputs=outputs, known=known, threads=threads)
        expected.add(stored)
        assert_same_counts(found, expected)
    with pytest.raises(InputError, match="expected 3"):
        Histogram(3).add_squares(**given, voltage=voltage, time=time, outputs=[0, 1])


def assert_same_counts(found, expected):
    filled = expected.pages >= 0
    assert np.array_equal(found.pages >= 0, filled)
    assert np.array_equal(found.counts[found.pages[filled]], expected.counts[expected.pages[filled]])
    assert found.count == expected.count


def test_merging_adds_the_counts():
    random = np.random.default_rng(1)
    one, other, both = Histogram(5), Histogram(5), Histogram(5)
    values = random.normal(size=(300, 5)) * 10.0 ** random.integers(-4, 4, (300, 5))
    one.add(values[:100])
    other.add(values[100:])
    both.add(values)
    one.merge(other)
    assert_same_counts(one, both)
    with pytest.raises(InputError, match="cannot be added"):
        one.merge(Histogram(4))
