"""The bias by curvature, compared with exact ones."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.recordings.fit.of_scenario import curvature_bias


def problem(predicted, sloped, noise):
    return SimpleNamespace(
        prediction=lambda values: np.asarray(predicted(**values)),
        derivatives=lambda values, names: np.asarray(sloped(**values))[:, : len(names)] / noise,
        weights=1 / noise,
    )


def test_the_root_of_a_noisy_square():
    """Of y = p^2 the estimate sqrt(y) is too small by s^2/(8 p^3) on average, which is s/(4 p^2) of its deviation."""
    p, s = 3.0, 0.2
    made = problem(lambda p: [p**2], lambda p: [[2 * p]], s)
    covariance = np.array([[(s / (2 * p)) ** 2]])
    found = curvature_bias(made, {"p": p}, ["p"], covariance)
    assert found["p"] == pytest.approx(-s / (4 * p**2), rel=1e-9)


def test_a_line_has_none():
    x = np.linspace(0, 1, 9)
    slopes = np.column_stack([x, np.ones(9)])
    made = problem(lambda a, b: a * x + b, lambda a, b: slopes, 0.1)  # noqa: ARG005
    found = curvature_bias(made, {"a": 2.0, "b": 1.0}, ["a", "b"], 0.01 * np.linalg.inv(slopes.T @ slopes))
    assert found == pytest.approx({"a": 0.0, "b": 0.0}, abs=1e-9)


def test_two_correlated_parameters_as_simulated():
    x, s = np.linspace(0.1, 2, 30), 0.02
    model = lambda a, b: a * np.exp(-b * x)  # noqa: E731
    sloped = lambda a, b: np.column_stack([np.exp(-b * x), -a * x * np.exp(-b * x)])  # noqa: E731
    covariance = s**2 * np.linalg.inv(sloped(0.1, 1.0).T @ sloped(0.1, 1.0))
    found = curvature_bias(problem(model, sloped, s), {"a": 0.1, "b": 1.0}, ["a", "b"], covariance)
    rng, estimates = np.random.default_rng(1), []
    for _ in range(300):
        noise = s * rng.normal(size=x.size)
        for side in (1, -1):  # pairs of opposite noise cancel all but the bias
            at = np.array([0.1, 1.0])
            for _ in range(12):
                step, *_ = np.linalg.lstsq(sloped(*at), model(0.1, 1.0) + side * noise - model(*at))
                at = at + step
            estimates.append(at)
    bias = (np.mean(estimates, axis=0) - [0.1, 1.0]) / np.sqrt(np.diag(covariance))
    assert [found["a"], found["b"]] == pytest.approx(bias, rel=0.3)


def test_where_there_is_no_prediction_the_bias_is_unknown():
    def refused(p):
        if p != 1.0:
            raise InputError("no such value")
        return [1.0]

    made = problem(refused, lambda p: [[1.0]], 1.0)  # noqa: ARG005
    assert math.isinf(curvature_bias(made, {"p": 1.0}, ["p"], np.eye(1))["p"])
