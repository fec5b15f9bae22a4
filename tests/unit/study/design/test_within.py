"""The nearest value within limits, of functions and limits that are known in closed form."""

from __future__ import annotations

import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.study.check.result import FAIL, PASS, CheckResult, CheckRow
from electrovib.study.design.limits import Limited, obtainable
from electrovib.study.design.search import Function, explore, first_values

EMPTY = {"title": "", "duration": 1, "comparisons": (), "numbers": (), "notes": ()}
EMPTY["scenario"] = ev.load("vezzoli_2014/fig6")


def limited(**shares):
    """Limits of 1 that are compared with functions of the parameter."""

    def check(at):
        rows = [
            CheckRow(
                quantity=name,
                value=share(at),
                limit=1.0,
                unit="V",
                source="a test",
                state=PASS if share(at) <= 1 else FAIL,
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
