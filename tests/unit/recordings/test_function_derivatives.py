"""Derivatives of a function that is fitted: by differences where an imaginary step does not give them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from electrovib.recordings.fit.function import fit_function
from electrovib.recordings.fit.least_squares import FreeParameter

X = np.linspace(0.1, 2.0, 20)
RATE = 2e6


def decay(x, time):
    """Not analytic in `time`: an imaginary step has no effect on it."""
    return np.exp(-x / (RATE * np.abs(time)))


def slope(time):
    return X / (RATE * time**2) * decay(X, time)


@pytest.mark.parametrize("value", [1.0, -1.0], ids=["positive", "negative"])
def test_a_function_that_is_not_analytic_is_fitted_by_differences(value):
    found = fit_function(lambda x, a: np.abs(a) * x, X, 3.0 * X, start={"a": value})
    assert abs(found.values["a"]) == pytest.approx(3.0, rel=1e-9)


@pytest.mark.parametrize(
    ("start", "lower", "upper"),
    [(1e-6, 0.0, math.inf), (1.5e-6, 5e-7, 1.5e-6), (5e-7, 5e-7, 1.0)],
    ids=["free", "from the upper bound", "from the lower bound"],
)
def test_a_function_is_evaluated_within_the_bounds_only(start, lower, upper):
    """The derivative at the estimate gives the covariance."""
    seen = []

    def within(x, time):
        seen.append(np.real(time))
        return decay(x, time)

    free = FreeParameter(start=start, lower=lower, upper=upper)
    found = fit_function(within, X, decay(X, 1e-6), start={"time": free}, noise=1e-3)
    assert lower <= min(seen) <= max(seen) <= upper
    assert found.values["time"] == pytest.approx(1e-6, rel=1e-6)
    expected = 1e-3 / np.linalg.norm(slope(1e-6))
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(expected, rel=1e-6)
    if upper == math.inf:
        assert np.sqrt(found.covariance[0, 0]) == pytest.approx(expected, rel=1e-11)
