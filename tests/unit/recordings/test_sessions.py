"""Spread between sessions, and their mean, against published numbers; and exponents of known power laws."""

import numpy as np
import pytest
from scipy.stats import chi2, linregress, t

from electrovib.core.errors import InputError
from electrovib.recordings.fit.misfit import random_effects
from electrovib.recordings.fit.power_law import fit_power_law

TRIALS = np.array([
    (4, 119, 11, 128), (6, 300, 29, 274), (3, 228, 11, 209), (62, 13536, 248, 12619), (33, 5036, 47, 5761),
    (180, 1361, 372, 1079), (8, 2537, 10, 619), (505, 87886, 499, 87892), (29, 7470, 45, 7232),
    (17, 1699, 65, 1600), (186, 50448, 141, 27197), (5, 2493, 3, 2338), (27, 16886, 29, 17825),
], dtype=float)  # fmt: skip
"""Counts of 13 vaccination trials, Colditz et al. 1994, table I."""


def test_the_interval_of_thirteen_trials_is_the_published_one():
    """Q profile of the variance of their logarithmic odds ratios: 0.1302 to 1.1812 (metafor, van Houwelingen et al. 2002)."""
    ill, well, ill_without, well_without = TRIALS.T
    found = random_effects(
        np.log(ill * well_without / (well * ill_without)), np.sqrt((1 / TRIALS).sum(axis=1))
    )
    assert found.between.lower**2 == pytest.approx(0.1302, rel=0.02)
    assert found.between.upper**2 == pytest.approx(1.1812, rel=0.02)
    assert found.between.lower < found.between.value < found.between.upper


def test_groups_without_noise_have_the_textbook_intervals():
    values = np.array([1.6, 1.9, 2.3, 2.0])
    found = random_effects(values, np.zeros(4))
    deviation = values.std(ddof=1)
    assert (found.mean.value, found.between.value) == pytest.approx((values.mean(), deviation), rel=1e-9)
    ends = deviation * np.sqrt(3 / chi2.ppf([0.975, 0.025], 3))
    assert found.between.ends == pytest.approx(ends, rel=0.01)
    assert found.mean.standard_error == pytest.approx(deviation / 2, rel=1e-9)
    half = t.ppf(0.975, 3) * deviation / 2
    assert found.mean.ends == pytest.approx((1.95 - half, 1.95 + half), rel=0.01)


EQUAL = [2.0, 2.1, 1.9]


def test_equal_groups_with_known_noise_have_the_weighted_mean_and_one_of_few_points_lowers_the_lower_end():
    found = random_effects(EQUAL, [0.1, 0.2, 0.4])
    assert (found.between.value, found.between.lower) == (0.0, 0.0)
    weights = np.array([100, 25, 6.25])
    assert found.mean.value == pytest.approx(weights @ EQUAL / weights.sum(), rel=1e-12)
    assert found.mean.standard_error == pytest.approx(weights.sum() ** -0.5, rel=1e-12)
    known = random_effects(EQUAL, [0.1, 0.2, 0.4], freedom=[1e6] * 3)
    assert known.between.upper == pytest.approx(found.between.upper, rel=1e-3)
    values, errors = [1.4, 2.0, 2.5], [0.1, 0.2, 0.3]
    known, estimated = random_effects(values, errors), random_effects(values, errors, freedom=[2] * 3)
    assert known.between.lower > 0.1
    assert estimated.between.lower < 0.5 * known.between.lower
    assert estimated.between.value == known.between.value


@pytest.mark.slow
@pytest.mark.parametrize(("groups", "freedom"), [(4, 6), (6, 2)])
def test_a_spread_of_0_3_lies_within_its_interval_in_95_of_100(groups, freedom):
    rng, inside = np.random.default_rng(2), 0
    for _ in range(1000):
        noise = rng.choice([0.02, 0.05, 0.2, 0.5], groups)
        values = 2 + 0.3 * rng.normal(size=groups) + noise * rng.normal(size=groups)
        errors = noise * np.sqrt(rng.chisquare(freedom, groups) / freedom)
        found = random_effects(values, errors, freedom=[freedom] * groups)
        inside += found.between.lower <= 0.3 <= found.between.upper
    assert 930 <= inside <= 970


VOLTS = np.geomspace(20, 200, 8)


def recorded(rng, *, sessions=1, between=0.0, exponents=None, scatter=0.05):
    """A power law of every session, with a factor of its own."""
    exponents = 2.0 + between * rng.normal(size=sessions) if exponents is None else np.asarray(exponents)
    scatter = np.broadcast_to(scatter, exponents.shape)[:, None]
    factors = 1e-6 * np.exp(0.3 * rng.normal(size=(exponents.size, 1)))
    noise = np.exp(scatter * rng.normal(size=(exponents.size, VOLTS.size)))
    y = factors * VOLTS ** exponents[:, None] * noise
    names = np.repeat(np.arange(exponents.size).astype(str), VOLTS.size)
    return np.tile(VOLTS, exponents.size), y.ravel(), names


def test_one_session_is_a_regression_of_the_logarithms():
    exact = fit_power_law(VOLTS, 3e-6 * VOLTS**1.7)
    assert exact.exponent == pytest.approx(1.7, rel=1e-12)
    assert exact.sessions["all"].factor == pytest.approx(3e-6, rel=1e-10)
    assert exact.sessions["all"].scatter < 1e-12
    assert "this session only" in exact.sentence
    x, y, _ = recorded(np.random.default_rng(1))
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
    assert found.between.between.value == pytest.approx(0.2, rel=0.3)
    assert found.between.between.lower < 0.2 < found.between.between.upper
    assert "too narrow" in found.sentence
    x, y, names = recorded(np.random.default_rng(3), sessions=5)
    alike = fit_power_law(x, y, session=names)
    assert alike.between.between.lower == 0
    assert "explains the differences" in alike.sentence


def test_one_noisy_session_does_not_hide_that_the_others_differ():
    """Three sessions whose exponents differ by many times their errors, and one with a scatter of 1.5 in ln y."""
    exponents, scatter = [1.6, 2.0, 2.3, 1.9], [0.03, 0.03, 0.03, 1.5]
    x, y, names = recorded(np.random.default_rng(4), exponents=exponents, scatter=scatter)
    found = fit_power_law(x, y, session=names)
    assert found.between.chi_squared > 100
    assert found.between.between.lower > 0.1
    assert found.between.between.lower < np.std(exponents[:3], ddof=1) < found.between.between.upper
    assert "differs between sessions by more than the noise" in found.sentence
    assert abs(found.exponent - np.mean(exponents[:3])) < 0.1  # the noisy one hardly counts
    errors = [each.standard_error for each in found.sessions.values()]
    assert errors[3] > 10 * max(errors[:3])


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
