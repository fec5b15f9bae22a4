"""Transfer functions of many fingers over frequency, from their complex formulas."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels import (
    cole_cole_over_frequency,
    mean_square_over_frequency,
    transfer_over_frequency,
)


def given(fingers=37, modes=5, seed=1):
    random = np.random.default_rng(seed)
    rates = 10 ** random.uniform(-2, 7, (fingers, modes))
    return rates, rates * random.normal(size=(fingers, modes)), random.normal(size=fingers)


FREQUENCIES = np.geomspace(0.1, 1e6, 61)


@pytest.mark.parametrize("modes", [0, 1, 4, 5, 12])
def test_transfer_is_the_sum_of_its_poles(kernel, modes):
    rates, residues, direct = given(modes=modes)
    found = transfer_over_frequency(rates, residues, direct, FREQUENCIES)
    s = 2j * np.pi * FREQUENCIES
    terms = residues[:, :, np.newaxis] / (s + rates[:, :, np.newaxis])
    expected = direct[:, np.newaxis] + terms.sum(axis=1)
    size = np.abs(direct)[:, np.newaxis] + np.abs(terms).sum(axis=1)
    assert np.max(np.abs(found - expected) / size) < 1e-14
    factor = np.linspace(1, 2, len(direct))
    square = mean_square_over_frequency(rates, residues, direct, FREQUENCIES, factor=factor)
    assert np.max(np.abs(square - factor[:, np.newaxis] * np.abs(expected) ** 2 / 2) / size**2) < 1e-13


def test_frequency_zero_is_the_static_response(kernel):
    rates, residues, direct = given()
    found = transfer_over_frequency(rates, residues, direct, [0.0])[:, 0]
    assert np.allclose(found, direct + (residues / rates).sum(axis=1), rtol=1e-12)


@pytest.mark.parametrize("terms", [1, 2, 4])
def test_cole_cole_is_its_formula(kernel, terms):
    random = np.random.default_rng(terms)
    fingers = 29
    high, loss = random.uniform(1, 5, fingers), 10 ** random.uniform(0, 6, fingers)
    strengths = 10 ** random.uniform(0, 6, (fingers, terms))
    times, alpha = 10 ** random.uniform(-9, 1, (fingers, terms)), random.uniform(0, 0.6, (fingers, terms))
    alpha[0] = 0.0
    found = cole_cole_over_frequency(high, strengths, times, alpha, loss, FREQUENCIES)
    w = 2 * np.pi * FREQUENCIES
    shape = (slice(None), slice(None), np.newaxis)
    relaxing = strengths[shape] / (1 + (1j * w * times[shape]) ** (1 - alpha[shape]))
    expected = high[:, np.newaxis] + relaxing.sum(axis=1) + loss[:, np.newaxis] / (1j * w)
    assert np.max(np.abs(found - expected) / np.abs(expected)) < 2e-14


@pytest.mark.parametrize("threads", [1, 2])
def test_a_finger_does_not_depend_on_the_company(kernel, threads):
    rates, residues, direct = given(fingers=131, modes=12)
    whole = transfer_over_frequency(rates, residues, direct, FREQUENCIES, threads=threads)
    square = mean_square_over_frequency(rates, residues, direct, FREQUENCIES, threads=threads)
    for part in (slice(0, 1), slice(5, 18), slice(129, 131)):
        some = rates[part], residues[part], direct[part]
        assert np.array_equal(transfer_over_frequency(*some, FREQUENCIES), whole[part])
        assert np.array_equal(mean_square_over_frequency(*some, FREQUENCIES), square[part])


def test_what_disagrees_is_refused():
    with pytest.raises(InputError, match="shapes"):
        transfer_over_frequency([[1.0]], [[1.0, 2.0]], [0.0], [1.0])
    with pytest.raises(InputError, match="positive"):
        cole_cole_over_frequency([1.0], [[1.0]], [[0.0]], [[0.0]], [0.0], [1.0])
    with pytest.raises(InputError, match="wrong shape"):
        cole_cole_over_frequency([1.0, 2.0], [[1.0]], [[1.0]], [[0.0]], [0.0], [1.0])
    with pytest.raises(InputError, match="terms"):
        cole_cole_over_frequency([1.0], [[1.0]], [[1.0, 2.0]], [[0.0]], [0.0], [1.0])


def test_memory_for_the_result_is_used_and_checked(kernel):
    rates, residues, direct = given()
    for function, kind in ((transfer_over_frequency, complex), (mean_square_over_frequency, float)):
        memory = np.full((len(direct), FREQUENCIES.size), np.nan, kind)
        assert function(rates, residues, direct, FREQUENCIES, out=memory) is memory
        assert np.array_equal(memory, function(rates, residues, direct, FREQUENCIES))
        with pytest.raises(InputError, match="out has shape"):
            function(rates, residues, direct, FREQUENCIES, out=memory[1:])
    layer = np.ones(3), np.ones((3, 1)), np.ones((3, 1)), np.zeros((3, 1)), np.zeros(3), [1.0]
    memory = np.zeros((3, 1), complex)
    assert cole_cole_over_frequency(*layer, out=memory) is memory
    assert np.allclose(memory, 1 + 1 / (1 + 2j * np.pi), rtol=1e-14)
