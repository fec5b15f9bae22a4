"""Mean squares of many fingers over frequency, from their complex formulas."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels import mean_square_over_frequency


def given(fingers=37, modes=5, seed=1):
    random = np.random.default_rng(seed)
    rates = 10 ** random.uniform(-2, 7, (fingers, modes))
    return rates, rates * random.normal(size=(fingers, modes)), random.normal(size=fingers)


FREQUENCIES = np.geomspace(0.1, 1e6, 61)


def expected_of(rates, residues, direct, frequencies):
    """Transfer functions, and the sum of the absolute values of their terms."""
    s = 2j * np.pi * np.asarray(frequencies)
    terms = residues[:, :, np.newaxis] / (s + rates[:, :, np.newaxis])
    return direct[:, np.newaxis] + terms.sum(axis=1), np.abs(direct)[:, np.newaxis] + np.abs(terms).sum(
        axis=1
    )


@pytest.mark.parametrize("modes", [0, 1, 4, 5, 12])
def test_mean_square_is_that_of_the_sum_of_poles(modes):
    rates, residues, direct = given(modes=modes)
    expected, size = expected_of(rates, residues, direct, FREQUENCIES)
    factor = np.linspace(1, 2, len(direct))
    square = mean_square_over_frequency(rates, residues, direct, FREQUENCIES, factor=factor)
    assert np.max(np.abs(square - factor[:, np.newaxis] * np.abs(expected) ** 2 / 2) / size**2) < 1e-13


def test_frequency_zero_is_the_static_response():
    rates, residues, direct = given()
    found = mean_square_over_frequency(rates, residues, direct, [0.0], factor=2.0)[:, 0]
    assert np.allclose(found, (direct + (residues / rates).sum(axis=1)) ** 2, rtol=1e-12)


def test_a_finger_does_not_depend_on_the_company():
    rates, residues, direct = given(fingers=1131, modes=12)
    whole = mean_square_over_frequency(rates, residues, direct, FREQUENCIES)
    for part in (slice(0, 1), slice(5, 18), slice(1129, 1131)):
        some = rates[part], residues[part], direct[part]
        assert np.array_equal(mean_square_over_frequency(*some, FREQUENCIES), whole[part])


@pytest.mark.parametrize("scale", [1e-60, 1e-40, 1e37, 1e60])
def test_rates_and_frequencies_far_from_one_do_not_overflow(scale):
    rates, residues, direct = given(modes=12)
    whole = mean_square_over_frequency(rates, residues, direct, FREQUENCIES)
    scaled = mean_square_over_frequency(rates * scale, residues * scale, direct, FREQUENCIES * scale)
    assert np.allclose(scaled, whole, rtol=1e-12, atol=1e-12 * whole.max())
    rates[3, 2], residues[3, 2] = scale, 0.0
    some = mean_square_over_frequency(rates, residues, direct, FREQUENCIES)
    others = np.arange(len(direct)) != 3
    assert np.array_equal(some[others], whole[others])
    assert np.isfinite(some).all()


def test_what_disagrees_is_refused():
    with pytest.raises(InputError, match="shapes"):
        mean_square_over_frequency([[1.0]], [[1.0, 2.0]], [0.0], [1.0])
