"""The nearest value within limits, of functions and limits that are known in closed form."""

from __future__ import annotations

import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.study.check.result import FAIL, PASS, UNKNOWN, CheckResult, CheckRow
from electrovib.study.design.limits import Limited, obtainable
from electrovib.study.design.search import Function, explore, first_values

EMPTY = {"title": "", "duration": 1, "comparisons": (), "numbers": (), "notes": ()}
EMPTY["scenario"] = ev.load("vezzoli_2014/fig6")


def limited(*, state="", **shares):
    """Limits of 1 that are compared with functions of the parameter."""

    def check(at):
        rows = [
            CheckRow(
                quantity=name,
                value=share(at),
                limit=1.0,
                unit="V",
                source="a test",
                state=state or (PASS if share(at) <= 1 else FAIL),
                text=name,
            )
            for name, share in shares.items()
        ]
        return CheckResult(
            title="",
            duration=1,
            rows=tuple(rows),
            comparisons=(),
            numbers=(),
            notes=(),
            scenario=ev.load("vezzoli_2014/fig6"),
        )

    return Limited(check)


def several(*shares):
    """One limit of 1 for several experiments."""
    return Limited(*(limited(one=share) for share in shares))


def nearest(compute, limits, target, low=1e-3, high=1e3, begin=1.0):
    function = Function(compute)
    explore(function, first_values(low, high, begin), most_added=0)
    return obtainable(function, limits, target, begin)


def test_the_end_of_the_allowed_range():
    found = nearest(lambda x: x**2, limited(one=lambda x: x / 5), 1e5)
    assert found.value == pytest.approx(5, rel=1e-9)
    assert found.value <= 5
    assert found.reached == found.value**2
    assert found.row.quantity == "one"


def test_from_above():
    found = nearest(lambda x: x**2, limited(one=lambda x: 5 / x), 1e-5)
    assert found.value == pytest.approx(5, rel=1e-9)
    assert found.value >= 5


def test_of_two_allowed_ranges_the_better_end_counts_although_its_first_value_is_farther():
    def compute(x):
        return 7.2 * x if x < 1 else 8 / x

    found = nearest(compute, limited(one=lambda x: min(x / 0.3, 5 / x)), 100.0)
    assert found.value == pytest.approx(0.3, rel=1e-9)
    assert found.reached == pytest.approx(2.16, rel=1e-9)


def test_a_second_limit_before_the_first_is_found():
    """It is exceeded from 2.2 to 3.05 only, between two neighbouring values at which it is not."""
    limits = limited(one=lambda x: x / 3, two=lambda x: 1 + (x - 2.2) * (3.05 - x))
    found = nearest(lambda x: x, limits, 1e5)
    assert found.value == pytest.approx(2.2, rel=1e-9)
    assert found.row.quantity == "two"


def test_without_a_limit_the_nearest_value_of_all():
    found = nearest(lambda x: x, limited(one=lambda _: 0.5), 1e5)
    assert (found.value, found.row) == (1e3, None)


def test_every_value_is_forbidden():
    assert nearest(lambda x: x, limited(one=lambda _: 2.0), 1e5) is None


def test_a_check_that_cannot_be_made_allows_nothing():
    def check(at):
        msg = "no check"
        raise InputError(msg)

    limits = Limited(check)
    assert nearest(lambda x: x, limits, 1e5) is None
    assert limits.problem(1.0) == "no check"
    assert limits.failed(1.0) == ()


def test_of_several_experiments_the_one_that_comes_nearest_to_a_limit_counts():
    limits = several(lambda x: x / 5, lambda x: x / 3, lambda x: x / 4)
    assert limits(2.0).rows[0].value == pytest.approx(2 / 3)
    assert [limits.allows(at) for at in (2.9, 3.1, 2.9)] == [True, False, True]
    assert len(limits.failed(4.5)) == 2
    found = nearest(lambda x: x**2, limits, 1e5)
    assert found.value == pytest.approx(3, rel=1e-9)
    assert found.row.value == pytest.approx(1, rel=1e-9)


def test_an_experiment_that_exceeds_a_limit_comes_before_one_that_is_nearer_to_another():
    assert several(lambda _: 0.999, lambda x: x)(2.0).rows[0].value == 2
    assert several(lambda _: 1.001, lambda _: 1.0)(2.0).rows[0].value == 1.001


def test_a_comparison_that_decides_nothing_is_not_nearer_than_a_limit_that_is_exceeded():
    doubtful = limited(one=lambda _: 9.0, state=UNKNOWN)
    exceeded = limited(one=lambda _: 2.0)
    assert Limited(doubtful, exceeded)(1.0).rows[0].value == 2
    assert Limited(doubtful)(1.0).rows[0].value == 9


def test_one_check_that_cannot_be_made_among_several():
    def check(_):
        msg = "no check"
        raise InputError(msg)

    limits = several(lambda x: x / 5)
    limits = Limited(limits, check)
    assert limits(2.0) is None
    assert not limits.allows(2.0)
    assert limits.problem(2.0) == "no check"


def test_of_equal_values_the_one_nearest_to_the_beginning_counts():
    found = nearest(lambda _: 1.0, limited(one=lambda _: 0.5), 5.0, begin=30.0)
    assert found.value == 30
    found = nearest(lambda x: x**2, limited(one=lambda _: 0.5), 1e9, low=-10.0, high=10.0, begin=-3.0)
    assert found.value == -10
