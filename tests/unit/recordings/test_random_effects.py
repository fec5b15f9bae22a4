"""Spread between groups, and their mean, against published numbers and groups of known spread."""

import numpy as np
import pytest
from scipy.stats import chi2, t

from electrovib.recordings.fit.sessions import random_effects

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
    assert found.between_lower**2 == pytest.approx(0.1302, rel=0.02)
    assert found.between_upper**2 == pytest.approx(1.1812, rel=0.02)
    assert found.between_lower < found.between < found.between_upper


def test_groups_without_noise_have_the_textbook_intervals():
    values = np.array([1.6, 1.9, 2.3, 2.0])
    found = random_effects(values, np.zeros(4))
    deviation = values.std(ddof=1)
    assert (found.mean, found.between) == pytest.approx((values.mean(), deviation), rel=1e-9)
    ends = deviation * np.sqrt(3 / chi2.ppf([0.975, 0.025], 3))
    assert (found.between_lower, found.between_upper) == pytest.approx(ends, rel=0.01)
    assert found.standard_error == pytest.approx(deviation / 2, rel=1e-9)
    half = t.ppf(0.975, 3) * deviation / 2
    assert (found.lower, found.upper) == pytest.approx((1.95 - half, 1.95 + half), rel=0.01)


def test_equal_groups_with_known_noise_have_the_weighted_mean():
    found = random_effects(EQUAL, [0.1, 0.2, 0.4])
    assert (found.between, found.between_lower) == (0.0, 0.0)
    weights = np.array([100, 25, 6.25])
    assert found.mean == pytest.approx(weights @ EQUAL / weights.sum(), rel=1e-12)
    assert found.standard_error == pytest.approx(weights.sum() ** -0.5, rel=1e-12)
    known = random_effects(EQUAL, [0.1, 0.2, 0.4], freedom=[1e6] * 3)
    assert known.between_upper == pytest.approx(found.between_upper, rel=1e-3)


def test_noise_known_from_few_points_lowers_the_lower_end():
    values, errors = [1.4, 2.0, 2.5], [0.1, 0.2, 0.3]
    known, estimated = random_effects(values, errors), random_effects(values, errors, freedom=[2] * 3)
    assert known.between_lower > 0.1
    assert estimated.between_lower < 0.5 * known.between_lower
    assert estimated.between == known.between


EQUAL = [2.0, 2.1, 1.9]


def covered(count, *, groups, freedom, spread, seed):
    """Share of intervals of the spread, and of the mean, that contain the truth."""
    rng, inside = np.random.default_rng(seed), np.zeros(2)
    for _ in range(count):
        noise = rng.choice([0.02, 0.05, 0.2, 0.5], groups)
        values = 2 + spread * rng.normal(size=groups) + noise * rng.normal(size=groups)
        errors = noise * np.sqrt(rng.chisquare(freedom, groups) / freedom)
        found = random_effects(values, errors, freedom=[freedom] * groups)
        inside += (
            found.between_lower <= spread <= found.between_upper,
            found.lower <= 2 <= found.upper,
        )
    return inside / count


def test_a_spread_of_few_groups_lies_within_its_interval():
    spread, mean = covered(60, groups=4, freedom=6, spread=0.3, seed=1)
    assert min(spread, mean) >= 0.87


@pytest.mark.slow
@pytest.mark.parametrize(("groups", "freedom"), [(4, 6), (6, 2)])
def test_a_spread_of_0_3_lies_within_its_interval_in_95_of_100(groups, freedom):
    spread, _ = covered(1000, groups=groups, freedom=freedom, spread=0.3, seed=2)
    assert 0.93 <= spread <= 0.97
