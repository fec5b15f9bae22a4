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
    assert found.sessions["all"].factor == pytest.approx(3e-6, rel=1e-10)
    assert found.sessions["all"].scatter < 1e-12
    assert "this session only" in found.sentence


def test_one_session_is_a_regression_of_the_logarithms():
    from scipy.stats import linregress

    x, y, _ = recorded(np.random.default_rng(1), sessions=1, between=0.0)
    found, known = fit_power_law(x, y), linregress(np.log(x), np.log(y))
    assert (found.exponent, found.standard_error) == pytest.approx((known.slope, known.stderr), rel=1e-10)
    assert found.sessions["all"].degrees_of_freedom == 6
    assert found.upper - found.exponent == pytest.approx(2.4469 * known.stderr, rel=1e-4)  # t(0.975, 6)
    assert found.between is None


@pytest.mark.slow
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


def test_the_noise_of_each_session_and_the_spread_between_them_are_stated():
    x, y, names = recorded(np.random.default_rng(5), sessions=40, between=0.2)
    found = fit_power_law(x, y, session=names)
    spread = np.sum((np.log(VOLTS) - np.log(VOLTS).mean()) ** 2)
    errors = [each.standard_error for each in found.sessions.values()]
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(0.05 / np.sqrt(spread), rel=0.1)
    assert found.between.between == pytest.approx(0.2, rel=0.3)
    assert found.between.between_lower < 0.2 < found.between.between_upper
    assert "too narrow" in found.sentence


def test_one_noisy_session_does_not_hide_that_the_others_differ():
    """Three sessions whose exponents differ by many times their errors, and one with a scatter of 1.5 in ln y."""
    rng, x, y, names = np.random.default_rng(4), [], [], []
    for at, (exponent, scatter) in enumerate([(1.6, 0.03), (2.0, 0.03), (2.3, 0.03), (1.9, 1.5)]):
        x.append(VOLTS)
        y.append(1e-6 * VOLTS**exponent * np.exp(scatter * rng.normal(size=VOLTS.size)))
        names += [f"day {at}"] * VOLTS.size
    found = fit_power_law(np.concatenate(x), np.concatenate(y), session=names)
    assert found.between.chi_squared > 100
    assert found.between.between_lower > 0.1
    assert found.between.between_lower < np.std([1.6, 2.0, 2.3], ddof=1) < found.between.between_upper
    assert "differs between sessions by more than the noise" in found.sentence
    assert abs(found.exponent - np.mean([1.6, 2.0, 2.3])) < 0.1  # the noisy one hardly counts
    errors = [each.standard_error for each in found.sessions.values()]
    assert errors[3] > 10 * max(errors[:3])


def test_sessions_without_a_difference_are_said_to_agree():
    x, y, names = recorded(np.random.default_rng(3), sessions=5, between=0.0)
    found = fit_power_law(x, y, session=names)
    assert found.between.between_lower == 0
    assert "explains the differences" in found.sentence


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
