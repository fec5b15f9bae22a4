"""Exponents of known power laws."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.recordings.fit.power_law import fit_power_law

VOLTS = np.geomspace(20, 200, 8)


def recorded(rng, *, sessions, between, scatter=0.05, exponent=2.0):
    names, x, y = [], [], []
    for at in range(sessions):
        own = exponent + between * rng.normal()
        factor = 1e-6 * np.exp(0.3 * rng.normal())
        names += [f"day {at}"] * VOLTS.size
        x.append(VOLTS)
        y.append(factor * VOLTS**own * np.exp(scatter * rng.normal(size=VOLTS.size)))
    return np.concatenate(x), np.concatenate(y), names


def test_exact_points_give_the_exponent_and_factor():
    found = fit_power_law(VOLTS, 3e-6 * VOLTS**1.7)
    assert found.exponent == pytest.approx(1.7, rel=1e-12)
    assert found.factors["all"] == pytest.approx(3e-6, rel=1e-10)
    assert found.scatter < 1e-12
    assert "this session only" in found.sentence


def test_one_session_is_a_regression_of_the_logarithms():
    from scipy.stats import linregress

    x, y, _ = recorded(np.random.default_rng(1), sessions=1, between=0.0)
    found, known = fit_power_law(x, y), linregress(np.log(x), np.log(y))
    assert (found.exponent, found.standard_error) == pytest.approx((known.slope, known.stderr), rel=1e-10)
    assert found.degrees_of_freedom == 6
    assert found.upper - found.exponent == pytest.approx(2.4469 * known.stderr, rel=1e-4)  # t(0.975, 6)
    assert np.isnan(found.between)


@pytest.mark.parametrize("sessions", [2, 6])
def test_the_interval_covers_when_sessions_differ(sessions):
    rng, inside, errors = np.random.default_rng(sessions), 0, []
    for _ in range(1000):
        x, y, names = recorded(rng, sessions=sessions, between=0.2)
        found = fit_power_law(x, y, session=names)
        inside += found.lower <= 2.0 <= found.upper
        errors.append(found.exponent - 2.0)
    assert 930 <= inside <= 970
    assert abs(np.mean(errors)) < 0.1 * np.std(errors)


def test_both_scatters_are_stated():
    x, y, names = recorded(np.random.default_rng(5), sessions=40, between=0.2)
    found = fit_power_law(x, y, session=names)
    spread = np.sum((np.log(VOLTS) - np.log(VOLTS).mean()) ** 2)
    assert found.within == pytest.approx(0.05 / np.sqrt(spread), rel=0.1)
    assert found.between == pytest.approx(0.2, rel=0.3)
    assert "too narrow" in found.sentence


@pytest.mark.parametrize(
    ("x", "y", "session", "words"),
    [
        ([1, 2, 3], [1, -2, 3], None, "above 0"),
        ([1, 2, 3], [1, 2], None, "same length"),
        ([1, 2, 3], [1, 2, 3], ["a", "a"], "2 names for 3"),
        ([1, 2, 3, 4], [1, 2, 3, 4], ["a", "a", "a", "b"], "session 'b': 1 points"),
        ([2, 2, 2], [1, 2, 3], None, "at 1 values of x"),
    ],
)
def test_mistakes_are_named(x, y, session, words):
    with pytest.raises(InputError, match=words):
        fit_power_law(x, y, session=session)
