"""Transfer functions of many fingers over frequency, from their complex formulas."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels import (
    choice,
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


@pytest.mark.parametrize("scale", [1e-60, 1e-40, 1e37, 1e60])
def test_rates_and_frequencies_far_from_one_do_not_overflow(kernel, scale):
    rates, residues, direct = given(modes=12)
    whole = transfer_over_frequency(rates, residues, direct, FREQUENCIES)
    scaled = transfer_over_frequency(rates * scale, residues * scale, direct, FREQUENCIES * scale)
    assert np.allclose(scaled, whole, rtol=1e-12, atol=1e-12 * np.abs(whole).max())
    few = mean_square_over_frequency(rates * scale, residues * scale, direct, FREQUENCIES * scale)
    assert np.allclose(few, np.abs(whole) ** 2 / 2, rtol=1e-12, atol=1e-12 * np.abs(whole).max() ** 2)
    rates[3, 2], residues[3, 2] = scale, 0.0
    some = transfer_over_frequency(rates, residues, direct, FREQUENCIES)
    others = np.arange(len(direct)) != 3
    assert np.array_equal(some[others], whole[others])
    assert np.isfinite(some).all()


@pytest.mark.parametrize("count", [1, 7, 8, 61, 64])
@pytest.mark.parametrize("offset", [0, 1, 5])
def test_large_tables_are_written_past_the_caches_with_the_same_bits(monkeypatch, count, offset):
    sweeps = pytest.importorskip("electrovib.solve.population.kernels.compiled.sweeps")
    if choice.compiled() is None:
        pytest.skip("The compiled kernels are not chosen.")
    rates, residues, direct = given(fingers=19)
    frequency = FREQUENCIES[:count] if count <= 61 else np.geomspace(0.1, 1e6, count)
    layer = direct, np.abs(residues), 1 / rates, np.full(rates.shape, 0.2), direct, frequency
    cases = [
        (transfer_over_frequency, (rates, residues, direct, frequency), complex),
        (mean_square_over_frequency, (rates, residues, direct, frequency), float),
        (cole_cole_over_frequency, layer, complex),
    ]
    for function, arguments, kind in cases:
        monkeypatch.setattr(sweeps, "_PAST", 1 << 60)
        expected = function(*arguments)
        monkeypatch.setattr(sweeps, "_PAST", 0)
        numbers = expected.view(float).size
        around = np.full(numbers + 16, np.nan)
        memory = around[offset : offset + numbers].view(kind).reshape(expected.shape)
        assert np.array_equal(function(*arguments, out=memory), expected)
        assert np.isnan(around[:offset]).all()
        assert np.isnan(around[offset + numbers :]).all()


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
