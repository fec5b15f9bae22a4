"""A number of a source is compared with the one computed here, and can disagree."""

from __future__ import annotations

import math

import pytest

from electrovib.core.checks import STATUSES, Check


class Doubling:
    def twice(self, x):
        return 2 * x


def check(**changes):
    given = {"name": "twice", "expect": 4.0, "rtol": 0.01, "source": "table 1", "given": {"x": 2.0}}
    return Check(**(given | changes))


def test_a_method_is_asked():
    assert check().value(Doubling()) == 4.0
    assert check().accepts(check().value(Doubling()))


def test_a_computation_is_asked():
    assert check(compute=lambda: 4).value() == 4.0


@pytest.mark.parametrize("value", [4.0, 3.9601, 4.0399])
def test_within_the_tolerance(value):
    assert check().accepts(value)


@pytest.mark.parametrize("value", [3.88, 4.12, -4.0, 0.0, math.nan, math.inf])
def test_beyond_the_tolerance(value):
    assert not check().accepts(value)


def test_negative_numbers_have_tolerances_too():
    assert check(expect=-58.0).accepts(-58.5)
    assert not check(expect=-58.0).accepts(-60.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"status": "unverified"},
        {"status": "rumour"},
        {"expect": 0.0},
        {"rtol": 0.0},
        {"rtol": 1.0},
        {"rtol": -0.1},
        {"rtol": math.nan},
    ],
)
def test_what_cannot_check_is_refused(changes):
    with pytest.raises(TypeError):
        check(**changes)


def test_statuses_go_from_best_to_none():
    assert STATUSES[0] == "full text"
    assert STATUSES[-1] == "unverified"
