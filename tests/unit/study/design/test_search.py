"""All crossings of a wanted value, extremes, intervals and discontinuities of functions that are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.study.design.search import (
    EVEN,
    Function,
    explore,
    first_values,
    look_between,
    near_root,
    sharpen_extremes,
    solutions,
)


def found(compute, target, low, high, begin=1.0):
    function = Function(compute)
    explore(function, first_values(low, high, begin))
    sharpen_extremes(function, target)
    return (*solutions(function, target), function)


def test_a_range_that_spans_decades_is_spaced_in_the_logarithm():
    values = first_values(1e-6, 1e6, 0.5)
    ratios = np.diff(np.log10(np.setdiff1d(values, [0.5])))
    assert ratios == pytest.approx(np.full(len(ratios), 12 / len(ratios)))
    assert np.max(ratios) <= 0.25
    assert 0.5 in values
    assert (values[0], values[-1]) == (1e-6, 1e6)


def test_a_narrow_range_is_spaced_evenly():
    assert first_values(2.0, 10.0, 50.0) == pytest.approx(np.linspace(2, 10, EVEN))
    assert first_values(-10.0, -2.0, 50.0) == pytest.approx(np.linspace(-10, -2, EVEN))


def test_zero_within_a_range_has_the_logarithm_on_either_side():
    values = first_values(-1e5, 1e5, 10.0)
    assert 0 in values
    assert np.min(values[values > 0]) == pytest.approx(1e-3)
    assert np.min(-values[values < 0]) == pytest.approx(1e-3)
    assert (values[0], values[-1]) == (-1e5, 1e5)
    assert first_values(0.0, 1e5, 0.0)[1] == pytest.approx(0.1)


def test_half_as_many_values_where_each_takes_long():
    dense, sparse = (first_values(1e-6, 1e6, 0.5, sparse=each) for each in (False, True))
    assert len(sparse) == pytest.approx(len(dense) / 2, abs=2)


def test_a_power_law_needs_no_added_values():
    roots, jumps, beyond, function = found(lambda x: 3 * x**2, 12.0, 1e-6, 1e6)
    assert [each.value for each in roots] == [pytest.approx(2, rel=1e-12)]
    assert not jumps
    assert not beyond
    assert len(function.values) < 60


def test_both_signs_of_a_square_root():
    roots, *_ = found(lambda x: x**2, 9.0, -1e5, 1e5)
    assert [each.value for each in roots] == [pytest.approx(-3, rel=1e-12), pytest.approx(3, rel=1e-12)]


def test_a_narrow_resonance_between_the_first_values_has_two_solutions():
    """With a quality factor of 30 the half-power points lie within 3 % of the resonance, between two first values."""
    quality, at = 30.0, 1.2345

    def gain(x):
        return 1 / math.hypot(1 - (x / at) ** 2, x / at / quality)

    roots, *_ = found(gain, 25.0, 1e-4, 1e4, begin=7.0)
    y = np.roots([1, quality**-2 - 2, 1 - 25.0**-2])
    assert [each.value for each in roots] == pytest.approx(sorted(at * np.sqrt(y)), rel=1e-9)


def test_an_extreme_value_is_one_solution_that_is_not_crossed():
    roots, *_ = found(lambda x: x * math.exp(-x), math.exp(-1), 1e-3, 1e3, begin=5.0)
    assert len(roots) == 1
    assert roots[0].is_extreme
    assert roots[0].value == pytest.approx(1, rel=1e-4)
    assert roots[0].reached == pytest.approx(math.exp(-1), rel=1e-9)


@pytest.mark.parametrize("share", [1 - 1e-4, 1 - 1e-7])
def test_close_below_an_extreme_value_there_are_two(share):
    roots, *_ = found(lambda x: x * math.exp(-x), share * math.exp(-1), 1e-3, 1e3, begin=5.0)
    low, high = (each.value for each in roots)
    width = math.sqrt(2 * (1 - share))
    assert (low, high) == pytest.approx((1 - width, 1 + width), rel=width**2)


def test_above_an_extreme_value_there_is_none_and_the_extreme_is_known():
    roots, *_, function = found(lambda x: x * math.exp(-x), 1.001 * math.exp(-1), 1e-3, 1e3, begin=5.0)
    assert not roots
    assert max(value for _, value in function.known) == pytest.approx(math.exp(-1), rel=1e-12)


def test_a_bump_beside_a_first_value_is_resolved():
    """Without the values that the deviation from the chord asks for, only the last of three crossings is seen."""

    def compute(x):
        return x * (1 + 1.5 * math.exp(-(((math.log(x) - 0.25) / 0.2) ** 2)))

    roots, *_ = found(compute, 2.5, 1e-3, 1e3)
    assert len(roots) == 3
    assert [compute(each.value) for each in roots] == pytest.approx([2.5] * 3, rel=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_a_local_extreme_that_is_not_that_of_the_whole_range_is_refined(side):
    def compute(x):
        return side * (math.exp(-(math.log(x / 1.2) ** 2)) + 3 * (x / 1e3) ** 4)

    roots, *_ = found(compute, side * 0.999999, 1e-3, 1e3)
    low, high, far = (each.value for each in roots)
    assert (low, high) == pytest.approx((1.2 * math.exp(-1e-3), 1.2 * math.exp(1e-3)), rel=1e-6)
    assert far > 100


def test_a_minimum_is_refined_too():
    roots, *_, function = found(lambda x: x + 1 / x, 1.9, 1e-3, 1e3, begin=5.0)
    assert not roots
    assert min(value for _, value in function.known) == pytest.approx(2, rel=1e-12)


def test_a_discontinuity_is_no_solution():
    roots, jumps, *_ = found(lambda x: 1.0 if x < 2.5 else 3.0, 2.0, 0.1, 100.0)
    assert not roots
    assert jumps == [pytest.approx(2.5, rel=1e-12)]


def test_an_interval_is_one_solution():
    roots, *_ = found(lambda x: min(x, 2.0), 2.0, 0.1, 100.0)
    assert len(roots) == 1
    assert roots[0].until == 100
    assert roots[0].value == pytest.approx(2, rel=1e-8)


def test_where_nothing_can_be_computed_the_rest_is_searched():
    def partly(x):
        if x > 10:
            msg = "x: too large"
            raise InputError(msg)
        return math.nan if x < 0.1 else x

    roots, _, _, function = found(partly, 3.0, 1e-3, 1e3)
    assert [each.value for each in roots] == [pytest.approx(3, rel=1e-12)]
    assert set(function.refused.values()) == {"x: too large"}


def test_more_crossings_than_are_refined_are_reported():
    roots, _, beyond, _ = found(math.sin, 0.5, 1.0, 1e4)
    assert beyond > 0
    assert all(math.sin(each.value) == pytest.approx(0.5, abs=1e-6) for each in roots)


def sparse_sine():
    """A sine over 20 periods, at 47 values."""
    function = Function(math.sin)
    for at in np.linspace(0.0, 40 * math.pi, 47):
        function(at)
    return function


def test_a_function_that_goes_up_and_down_is_looked_at_between_its_crossings():
    """sin x = 0.9 forty times; a few values in a period show fewer."""
    roots, _, beyond = solutions(sparse_sine(), 0.9)
    assert len(roots) + beyond < 40
    function = sparse_sine()
    assert look_between(function, 0.9, most_added=2000)
    roots, _, beyond = solutions(function, 0.9)
    assert len(roots) + beyond == 40
    assert not look_between(sparse_sine(), 0.9, most_added=50)


@settings(max_examples=60, deadline=None)
@given(
    st.floats(-3, 3).filter(lambda p: abs(p) > 0.05),
    st.floats(1e-3, 1e3),
    st.floats(1e-2, 1e2),
    st.floats(0, 1e3),
)
def test_round_trip_of_monotone_functions(power, factor, at, constant):
    def compute(x):
        return constant + factor * x**power

    roots, *_ = found(compute, compute(at), 1e-3, 1e3, begin=1.0)
    assert len(roots) == 1
    assert roots[0].reached == pytest.approx(compute(at), rel=1e-9)


@pytest.mark.parametrize("guess", [0.3, 2.0, 9.0])
def test_a_root_near_a_guess(guess):
    function = Function(lambda x: 3 * x**2)
    at = near_root(function, 12.0, 0.1, 100.0, guess, 1e-7)
    assert at == pytest.approx(2, rel=1e-7)
    assert len(function.values) < 12
    assert near_root(Function(lambda x: -3 * x), 12.0, -100.0, -0.1, -guess, 1e-7) == pytest.approx(
        -4, rel=1e-7
    )


@pytest.mark.parametrize(
    ("compute", "guess"),
    [
        (lambda x: x, 0.0),
        (lambda x: x, 50.0),  # beyond the range
        (lambda x: x / 100, 3.0),  # its root is beyond the range
        (lambda _: 1.0, 3.0),
        (lambda _: math.nan, 3.0),
    ],
)
def test_no_root_near_a_guess_is_nan(compute, guess):
    assert math.isnan(near_root(Function(compute), 5.0, 0.1, 20.0, guess, 1e-7))


def test_a_guess_that_is_the_root_is_computed_once():
    function = Function(lambda x: x)
    assert near_root(function, 5.0, 0.1, 20.0, 5.0, 1e-7) == pytest.approx(5.0)
    assert len(function.values) == 1
