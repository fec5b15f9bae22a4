"""Distributions: quantiles, cumulative probabilities, truncation."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from electrovib.core.errors import InputError
from electrovib.scenario.distributions import (
    Empirical,
    LogNormal,
    LogUniform,
    Normal,
    Triangular,
    Truncated,
    Uniform,
)

LOGNORMAL, MEASURED = LogNormal(median=3.0, factor=1.5), Empirical(values=(3.0, 1.0, 2.0))
REFERENCES = [
    (Uniform(low=2.0, high=5.0), stats.uniform(2, 3)),
    (LogUniform(low=2.0, high=5.0), stats.loguniform(2, 5)),
    (Normal(mean=1.0, deviation=2.0), stats.norm(1, 2)),
    (Normal(mean=1.0, deviation=2.0, low=0.0, high=2.5), stats.truncnorm(-0.5, 0.75, loc=1, scale=2)),
    (LOGNORMAL, stats.lognorm(math.log(1.5), scale=3)),
    (Triangular(low=1.0, likely=2.0, high=5.0), stats.triang(0.25, loc=1, scale=4)),
]
EVERY = [*(ours for ours, _ in REFERENCES), MEASURED, LOGNORMAL.truncated(2.0, 3.5)]
IDS = {"ids": lambda each: type(each).__name__}


@pytest.mark.parametrize(("ours", "reference"), REFERENCES, **IDS)
def test_values_and_probabilities_are_those_of_scipy(ours, reference):
    shares = np.linspace(0.001, 0.999, 999)
    np.testing.assert_allclose(ours.value(shares), reference.ppf(shares), rtol=1e-9, atol=1e-12)
    for value in (-3.0, 0.5, 1.5, 2.2, 4.0, 6.0):
        assert ours.share(value) == pytest.approx(reference.cdf(value), rel=1e-12, abs=1e-15)
        assert ours.share_above(value) == pytest.approx(reference.sf(value), rel=1e-9, abs=1e-15)


def test_a_small_probability_above_a_value_has_its_digits():
    normal, lognormal = Normal(mean=0.0, deviation=1.0), LogNormal(median=1.0, factor=math.e)
    assert normal.share_above(7.0) == pytest.approx(stats.norm.sf(7), rel=1e-12)
    assert lognormal.share_above(math.exp(7)) == pytest.approx(stats.norm.sf(7), rel=1e-12)


@given(st.sampled_from(EVERY), st.floats(2.0**-53, 1 - 2.0**-53))
def test_no_value_lies_beyond_the_ends_and_probabilities_add_up(ours, share):
    low, high = ours.ends
    value = float(ours.value(np.array(share)))
    assert low <= value <= high
    assert ours.share(value) + ours.share_above(value) == pytest.approx(1, abs=1e-12)


def test_measured_values_are_equally_likely():
    found = MEASURED.value((np.arange(300) + 0.5) / 300)
    assert [int(np.count_nonzero(found == value)) for value in (1.0, 2.0, 3.0)] == [100, 100, 100]


def test_a_truncated_distribution_is_the_other_one_between_the_ends():
    whole, shares = stats.lognorm(math.log(1.5), scale=3), np.linspace(0.01, 0.99, 99)
    ours, low, high = LOGNORMAL.truncated(2.0, 3.5), whole.cdf(2.0), whole.cdf(3.5)
    np.testing.assert_allclose(ours.value(shares), whole.ppf(low + (high - low) * shares), rtol=1e-12)
    assert ours.share(2.5) == pytest.approx((whole.cdf(2.5) - low) / (high - low), rel=1e-12)
    assert ours.share_above(2.5) == pytest.approx((high - whole.cdf(2.5)) / (high - low), rel=1e-12)
    # each family keeps the nearer ends
    twice = LOGNORMAL.truncated(1.0, 4.0).truncated(2.0, 9.0)
    assert twice == Truncated(distribution=LOGNORMAL, low=2.0, high=4.0)
    normal = Normal(mean=1.0, deviation=1.0, low=0.5)
    assert normal.truncated(0.0, 2.0) == Normal(mean=1.0, deviation=1.0, low=0.5, high=2.0)
    assert MEASURED.truncated(1.5, 3.0) == Empirical(values=(3.0, 2.0))


STANDARD = {"mean": 0.0, "deviation": 1.0}
NOTHING_LEFT = "the ends keep a share of"


@pytest.mark.parametrize(
    ("kind", "numbers", "ends", "words"),
    [
        (Normal, STANDARD | {"low": 6.0}, (), NOTHING_LEFT),
        (LogNormal, {"median": 1.0, "factor": 1.1}, (2.0, 3.0), NOTHING_LEFT),
        (Empirical, {"values": (1.0, 2.0)}, (3.0, 4.0), NOTHING_LEFT),
        (Uniform, {"low": 2.0, "high": 2.0}, (), "expected more than low"),
        (LogUniform, {"low": 0.0, "high": 2.0}, (), "expected more than 0"),
        (Normal, STANDARD | {"deviation": 0.0}, (), "deviation = 0"),
        (LogNormal, {"median": 1.0, "factor": 1.0}, (), "factor = 1"),
        (Triangular, {"low": 1.0, "likely": 3.0, "high": 2.0}, (), "in this order"),
        (Empirical, {"values": ()}, (), "at least one"),
        (Truncated, {"distribution": Normal(**STANDARD), "low": 1.0, "high": 0.0}, (), "more than low"),
    ],
)
def test_numbers_that_define_no_distribution_are_refused(kind, numbers, ends, words):
    with pytest.raises(InputError, match=words):
        kind(**numbers).truncated(*ends or (-math.inf, math.inf))
