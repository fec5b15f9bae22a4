"""Sums and products of transfers against arithmetic on their values, and on their free parts in time."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.solve.stack.transfer import Transfer

FREQUENCY = np.geomspace(1e-3, 1e9, 61)
ROUNDING = 1e-13  # of the sum of the sizes of all terms


def transfer(rates, gains, *rest):
    given = dict(zip(("direct", "slope", "free", "static"), rest, strict=False))
    return Transfer(rates=np.array(rates, float), gains=np.array(gains, float), **given)


def size(*parts):
    """Largest value a transfer could take, were all its terms of one sign."""
    return np.prod([np.abs(one.gains).sum() + abs(one.direct) for one in parts])


SLOW = transfer([0.0, 2.0, 300.0], [0.0, 1.5, -0.4], 0.2, 1e-9, np.array([0.7, 0.1, -0.3]))
QUIET = replace(SLOW, slope=0.0)
FILTER = transfer([5.0, 7e4], [0.3, 2.0], 0.1)


def test_value_at_a_frequency():
    s = 2j * np.pi * FREQUENCY
    by_hand = 0.2 + 1e-9 * s + 1.5 * 2 / (s + 2) - 0.4 * 300 / (s + 300)
    assert np.max(np.abs(SLOW.at(FREQUENCY) / by_hand - 1)) < 1e-14
    assert SLOW.at(0.0) == pytest.approx(0.2 + 1.5 - 0.4, rel=1e-15)
    assert SLOW.at(FREQUENCY.reshape(1, -1)).shape == (1, 61)
    assert SLOW.at(FREQUENCY).dtype == complex
    assert transfer([0.0], [0.0], 0.0, 0.0, np.array([3.0])).at(0.0) == 0  # trapped charge is not driven
    assert np.array_equal(FILTER.free, [0, 0])


def test_a_known_static_value_keeps_the_digits_of_a_small_response():
    """A current: 1/(R (1 + 1/(s tau))) at a frequency 1e-12 of its rate, where direct and gain cancel."""
    rate = 1e9
    current = transfer([rate], [-1.0], 1.0, 0.0, np.zeros(1), 0.0)
    s = 2j * np.pi * FREQUENCY
    assert np.max(np.abs(current.at(FREQUENCY) / (s / (s + rate)) - 1)) < 1e-14
    careless = transfer([rate], [-1.0], 1.0)
    assert np.max(np.abs(careless.at(FREQUENCY) / (s / (s + rate)) - 1)) > 1e-9
    assert current.at(0.0) == 0
    assert current.at_rest() == 0
    assert FILTER.at_rest() == pytest.approx(2.4, rel=1e-15)


@pytest.mark.parametrize("operation", ["sum", "difference", "multiple", "product"])
def test_static_value_of_a_combination(operation):
    current = transfer([1e9, 30.0], [-1.0, -2.0], 3.0 + 1e-20, 0.0, np.zeros(2), 1e-20)
    combined, expected = {
        "sum": (current + current, 2e-20),
        "difference": (current - current * 0.5, 0.5e-20),
        "multiple": (-4.0 * current, -4e-20),
        "product": (FILTER * current, 2.4e-20),
    }[operation]
    assert combined.static == pytest.approx(expected, rel=1e-14)
    mixed = current + FILTER
    assert mixed.static == pytest.approx(2.4, rel=1e-14)
    assert np.max(np.abs(mixed.at(FREQUENCY) - current.at(FREQUENCY) - FILTER.at(FREQUENCY))) < ROUNDING * 8


@pytest.mark.parametrize("other", [FILTER, SLOW, SLOW * -0.5], ids=["other modes", "itself", "common modes"])
def test_sum_difference_and_multiple(other):
    for combined, sign in ((SLOW + other, 1), (SLOW - other, -1)):
        expected = SLOW.at(FREQUENCY) + sign * other.at(FREQUENCY)
        assert np.max(np.abs(combined.at(FREQUENCY) - expected)) < ROUNDING * (size(SLOW) + size(other))
        assert combined.free.sum() == pytest.approx(SLOW.free.sum() + sign * other.free.sum(), abs=1e-15)
    assert len((SLOW + SLOW * 2.0).rates) == 3  # common modes stay common
    for doubled in (SLOW * 2, 2 * SLOW, SLOW * np.float64(2)):
        assert isinstance(doubled, Transfer)
        assert np.array_equal(doubled.at(FREQUENCY), 2 * SLOW.at(FREQUENCY))
        assert np.array_equal(doubled.free, 2 * SLOW.free)


def exponents(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


filters = st.lists(
    st.tuples(exponents(-3, 9), st.floats(-5, 5)), min_size=1, max_size=6, unique_by=lambda m: m[0]
)


@settings(max_examples=100, deadline=None)
@given(first=filters, second=filters, directs=st.tuples(st.floats(-2, 2), st.floats(-2, 2)))
def test_product(first, second, directs):
    first, second = (
        transfer([r for r, _ in modes], [g for _, g in modes], direct)
        for modes, direct in zip((first, second), directs, strict=True)
    )
    apart = np.abs(np.log(first.rates[:, None] / second.rates[None, :]))
    if apart.min() < 1e-3:  # a rate in common is outside what a product promises
        return
    for product in (first * second, second * first):
        expected = first.at(FREQUENCY) * second.at(FREQUENCY)
        # close rates amplify by their inverse distance
        scale = (size(first, second) + 1e-300) / min(apart.min(), 1)
        assert np.max(np.abs(product.at(FREQUENCY) - expected)) < 1e-12 * scale
        assert product.direct == directs[0] * directs[1]


def test_free_part_goes_through_the_filter_from_rest():
    """The filter sees sum f exp(-r t) from time 0: convolution with each of its modes, in closed form."""
    time = np.concatenate([[0.0], np.geomspace(1e-7, 10, 50)])
    expected = FILTER.direct * np.exp(-np.outer(time, SLOW.rates)) @ SLOW.free
    for rate, gain in zip(FILTER.rates, FILTER.gains, strict=True):
        for free, slow in zip(SLOW.free, SLOW.rates, strict=True):
            decayed = np.exp(-slow * time) - np.exp(-rate * time)
            expected = expected + gain * rate * free * decayed / (rate - slow)
    for product in (FILTER * QUIET, QUIET * FILTER):
        found = np.exp(-np.outer(time, product.rates)) @ product.free
        assert np.max(np.abs(found - expected)) < 1e-13
    constant = transfer([], [], 3.0)
    for product in (constant * QUIET, QUIET * constant):
        assert np.max(np.abs(product.at(FREQUENCY) - 3 * QUIET.at(FREQUENCY))) < ROUNDING * size(QUIET)
        assert np.allclose(product.free, 3 * QUIET.free, rtol=1e-15, atol=0)


@pytest.mark.parametrize(("first", "second"), [(SLOW, SLOW), (FILTER, SLOW), (SLOW, FILTER)])
def test_products_of_two_free_parts_or_with_a_slope_have_no_meaning(first, second):
    with pytest.raises(ValueError, match="free part"):
        first * second
