"""All crossings of a wanted value, extremes, intervals, discontinuities, and the nearest value within limits, in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.studies.check.result import FAIL, PASS, UNKNOWN, CheckResult, CheckRow
from electrovib.studies.design.limits import Limited, obtainable
from electrovib.studies.design.search import (
    EVEN,
    Function,
    explore,
    first_values,
    look_between,
    near_root,
    sharpen_extremes,
    solutions,
)

BUMP = math.exp(-1)
"""The largest value of x exp(-x), at 1."""


def found(compute, target, low=1e-3, high=1e3, begin=1.0):
    function = Function(compute)
    explore(function, first_values(low, high, begin))
    sharpen_extremes(function, target)
    return (*solutions(function, target), function)


def bump(x):
    return x * math.exp(-x)


def test_first_values_are_spaced_in_the_logarithm_over_decades_and_evenly_within_one():
    values = first_values(1e-6, 1e6, 0.5)
    ratios = np.diff(np.log10(np.setdiff1d(values, [0.5])))
    assert ratios == pytest.approx(np.full(len(ratios), 12 / len(ratios)))
    assert np.max(ratios) <= 0.25
    assert 0.5 in values
    assert (values[0], values[-1]) == (1e-6, 1e6)
    assert len(first_values(1e-6, 1e6, 0.5, sparse=True)) == pytest.approx(len(values) / 2, abs=2)
    assert first_values(2.0, 10.0, 50.0) == pytest.approx(np.linspace(2, 10, EVEN))
    assert first_values(-10.0, -2.0, 50.0) == pytest.approx(np.linspace(-10, -2, EVEN))
    values = first_values(-1e5, 1e5, 10.0)
    assert 0 in values
    assert np.min(values[values > 0]) == np.min(-values[values < 0]) == pytest.approx(1e-3)
    assert (values[0], values[-1]) == (-1e5, 1e5)
    assert first_values(0.0, 1e5, 0.0)[1] == pytest.approx(0.1)


def test_a_power_law_needs_no_added_values_and_has_both_signs():
    roots, jumps, beyond, function = found(lambda x: 3 * x**2, 12.0, 1e-6, 1e6)
    assert [each.value for each in roots] == [pytest.approx(2, rel=1e-12)]
    assert not jumps
    assert not beyond
    assert len(function.values) < 60
    roots, *_ = found(lambda x: x**2, 9.0, -1e5, 1e5)
    assert [each.value for each in roots] == [pytest.approx(-3, rel=1e-12), pytest.approx(3, rel=1e-12)]


def test_a_narrow_resonance_between_the_first_values_has_two_solutions():
    """With a quality factor of 30 the half-power points lie within 3 % of the resonance, between two first values."""
    quality, at = 30.0, 1.2345
    roots, *_ = found(lambda x: 1 / math.hypot(1 - (x / at) ** 2, x / at / quality), 25.0, 1e-4, 1e4, 7.0)
    y = np.roots([1, quality**-2 - 2, 1 - 25.0**-2])
    assert [each.value for each in roots] == pytest.approx(sorted(at * np.sqrt(y)), rel=1e-9)


def test_an_extreme_value_is_one_solution_that_is_not_crossed_and_above_it_there_is_none():
    (root,), *_ = found(bump, BUMP, begin=5.0)
    assert root.is_extreme
    assert root.value == pytest.approx(1, rel=1e-4)
    assert root.reached == pytest.approx(BUMP, rel=1e-9)
    roots, *_, function = found(bump, 1.001 * BUMP, begin=5.0)
    assert not roots
    assert max(value for _, value in function.known) == pytest.approx(BUMP, rel=1e-12)
    roots, *_, function = found(lambda x: x + 1 / x, 1.9, begin=5.0)
    assert not roots
    assert min(value for _, value in function.known) == pytest.approx(2, rel=1e-12)


@pytest.mark.parametrize("share", [1 - 1e-4, 1 - 1e-7])
def test_close_below_an_extreme_value_there_are_two(share):
    roots, *_ = found(bump, share * BUMP, begin=5.0)
    width = math.sqrt(2 * (1 - share))
    assert [each.value for each in roots] == pytest.approx((1 - width, 1 + width), rel=width**2)


def test_a_bump_beside_a_first_value_is_resolved():
    """Without the values that the deviation from the chord asks for, only the last of three crossings is seen."""

    def compute(x):
        return x * (1 + 1.5 * math.exp(-(((math.log(x) - 0.25) / 0.2) ** 2)))

    roots, *_ = found(compute, 2.5)
    assert [compute(each.value) for each in roots] == pytest.approx([2.5] * 3, rel=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_a_local_extreme_that_is_not_that_of_the_whole_range_is_refined(side):
    def compute(x):
        return side * (math.exp(-(math.log(x / 1.2) ** 2)) + 3 * (x / 1e3) ** 4)

    low, high, far = (each.value for each in found(compute, side * 0.999999)[0])
    assert (low, high) == pytest.approx((1.2 * math.exp(-1e-3), 1.2 * math.exp(1e-3)), rel=1e-6)
    assert far > 100


def test_a_discontinuity_is_no_solution_and_an_interval_is_one():
    roots, jumps, *_ = found(lambda x: 1.0 if x < 2.5 else 3.0, 2.0, 0.1, 100.0)
    assert not roots
    assert jumps == [pytest.approx(2.5, rel=1e-12)]
    (root,), *_ = found(lambda x: min(x, 2.0), 2.0, 0.1, 100.0)
    assert root.until == 100
    assert root.value == pytest.approx(2, rel=1e-8)


def test_more_crossings_than_are_refined_are_reported_and_what_cannot_be_computed_is_passed_over():
    roots, _, beyond, _ = found(math.sin, 0.5, 1.0, 1e4)
    assert beyond > 0
    assert all(math.sin(each.value) == pytest.approx(0.5, abs=1e-6) for each in roots)

    def partly(x):
        if x > 10:
            raise InputError("x: too large")
        return math.nan if x < 0.1 else x

    roots, _, _, function = found(partly, 3.0)
    assert [each.value for each in roots] == [pytest.approx(3, rel=1e-12)]
    assert set(function.refused.values()) == {"x: too large"}


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


POWERS = st.floats(-3, 3).filter(lambda p: abs(p) > 0.05)


@settings(max_examples=60, deadline=None)
@given(POWERS, st.floats(1e-3, 1e3), st.floats(1e-2, 1e2), st.floats(0, 1e3))
def test_round_trip_of_monotone_functions(power, factor, at, constant):
    def compute(x):
        return constant + factor * x**power

    (root,), *_ = found(compute, compute(at))
    assert root.reached == pytest.approx(compute(at), rel=1e-9)


@pytest.mark.parametrize("guess", [0.3, 2.0, 9.0])
def test_a_root_near_a_guess(guess):
    function = Function(lambda x: 3 * x**2)
    assert near_root(function, 12.0, 0.1, 100.0, guess, 1e-7) == pytest.approx(2, rel=1e-7)
    assert len(function.values) < 12
    at = near_root(Function(lambda x: -3 * x), 12.0, -100.0, -0.1, -guess, 1e-7)
    assert at == pytest.approx(-4, rel=1e-7)
    function = Function(lambda x: x)
    assert near_root(function, guess, 0.1, 20.0, guess, 1e-7) == pytest.approx(guess)
    assert len(function.values) == 1, "a guess that is the root is computed once"


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


# the nearest value within limits

SCENARIO = ev.load("vezzoli_2014/fig6")
COMPARED = {"title": "", "duration": 1, "comparisons": (), "numbers": (), "notes": (), "scenario": SCENARIO}


def limited(*, state="", **shares):
    """Limits of 1 that are compared with functions of the parameter."""

    def row(name, value):
        said = {"quantity": name, "value": value, "state": state or (PASS if value <= 1 else FAIL)}
        return CheckRow(**said, limit=1.0, unit="V", source="a test", text=name)

    return Limited(
        lambda at: CheckResult(rows=tuple(row(name, share(at)) for name, share in shares.items()), **COMPARED)
    )


def several(*shares):
    """One limit of 1 for several experiments."""
    return Limited(*(limited(one=share) for share in shares))


def refused(_):
    raise InputError("no check")


def nearest(compute, limits, target, low=1e-3, high=1e3, begin=1.0):
    function = Function(compute)
    explore(function, first_values(low, high, begin), most_added=0)
    return obtainable(function, limits, target, begin)


def test_the_end_of_the_allowed_range_from_below_and_from_above():
    found = nearest(lambda x: x**2, limited(one=lambda x: x / 5), 1e5)
    assert found.value == pytest.approx(5, rel=1e-9)
    assert found.value <= 5
    assert (found.reached, found.row.quantity) == (found.value**2, "one")
    found = nearest(lambda x: x**2, limited(one=lambda x: 5 / x), 1e-5)
    assert found.value == pytest.approx(5, rel=1e-9)
    assert found.value >= 5


def test_the_better_end_of_two_allowed_ranges_and_a_second_limit_before_the_first_are_found():
    """The second limit is exceeded from 2.2 to 3.05 only, between two neighbouring values at which it is not."""
    limits = limited(one=lambda x: min(x / 0.3, 5 / x))
    found = nearest(lambda x: 7.2 * x if x < 1 else 8 / x, limits, 100.0)
    assert (found.value, found.reached) == (pytest.approx(0.3, rel=1e-9), pytest.approx(2.16, rel=1e-9))
    limits = limited(one=lambda x: x / 3, two=lambda x: 1 + (x - 2.2) * (3.05 - x))
    found = nearest(lambda x: x, limits, 1e5)
    assert (found.value, found.row.quantity) == (pytest.approx(2.2, rel=1e-9), "two")


def test_without_a_limit_the_nearest_value_of_all_and_of_equals_the_one_nearest_to_the_beginning():
    free = limited(one=lambda _: 0.5)
    found = nearest(lambda x: x, free, 1e5)
    assert (found.value, found.row) == (1e3, None)
    assert nearest(lambda _: 1.0, free, 5.0, begin=30.0).value == 30
    assert nearest(lambda x: x**2, free, 1e9, low=-10.0, high=10.0, begin=-3.0).value == -10
    assert nearest(lambda x: x, limited(one=lambda _: 2.0), 1e5) is None, "every value is forbidden"


def test_a_check_that_cannot_be_made_allows_nothing_also_as_one_of_several():
    limits = Limited(refused)
    assert nearest(lambda x: x, limits, 1e5) is None
    assert limits.failed(1.0) == ()
    for each in (limits, Limited(several(lambda x: x / 5), refused)):
        assert each(2.0) is None
        assert not each.allows(2.0)
        assert each.problem(2.0) == "no check"


def test_of_several_experiments_the_one_that_comes_nearest_to_a_limit_counts():
    limits = several(lambda x: x / 5, lambda x: x / 3, lambda x: x / 4)
    assert limits(2.0).rows[0].value == pytest.approx(2 / 3)
    assert [limits.allows(at) for at in (2.9, 3.1, 2.9)] == [True, False, True]
    assert len(limits.failed(4.5)) == 2
    found = nearest(lambda x: x**2, limits, 1e5)
    assert (found.value, found.row.value) == (pytest.approx(3, rel=1e-9), pytest.approx(1, rel=1e-9))
    assert several(lambda _: 0.999, lambda x: x)(2.0).rows[0].value == 2, "exceeded before nearer"
    assert several(lambda _: 1.001, lambda _: 1.0)(2.0).rows[0].value == 1.001
    doubtful = limited(one=lambda _: 9.0, state=UNKNOWN)
    assert Limited(doubtful, limited(one=lambda _: 2.0))(1.0).rows[0].value == 2, "it decides nothing"
    assert Limited(doubtful)(1.0).rows[0].value == 9
