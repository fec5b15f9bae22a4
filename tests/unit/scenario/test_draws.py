"""Distributions, and draws from them that depend on seed and index alone."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
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
from electrovib.scenario.space import Group, Grouping, Space
from electrovib.scenario.space.relations import uniform_shares

LOGNORMAL, MEASURED = LogNormal(median=3.0, factor=1.5), Empirical(values=(3.0, 1.0, 2.0))
REFERENCES = [
    (Uniform(low=2.0, high=5.0), stats.uniform(2, 3)),
    (LogUniform(low=2.0, high=5.0), stats.loguniform(2, 5)),
    (Normal(mean=1.0, deviation=2.0), stats.norm(1, 2)),
    (Normal(mean=1.0, deviation=2.0).truncated(0.0, 2.5), stats.truncnorm(-0.5, 0.75, loc=1, scale=2)),
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
    low, high = getattr(ours, "low", -math.inf), getattr(ours, "high", math.inf)
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
    normal = Normal(mean=1.0, deviation=1.0).truncated(0.5, math.inf)
    assert normal.truncated(0.0, 2.0) == Normal(mean=1.0, deviation=1.0).truncated(0.5, 2.0)
    assert MEASURED.truncated(1.5, 3.0) == Empirical(values=(3.0, 2.0))


STANDARD = {"mean": 0.0, "deviation": 1.0}
NOTHING_LEFT = "the ends keep a share of"


@pytest.mark.parametrize(
    ("kind", "numbers", "ends", "words"),
    [
        (Normal, STANDARD, (6.0, math.inf), NOTHING_LEFT),
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


DRY = Group(share=0.3, distributions={"d": LogNormal(median=1.0, factor=1.2)})
MOIST = Group(share=0.7, distributions={"d": LogNormal(median=10.0, factor=1.2)})
UNIFORM = Uniform(low=0.0, high=1.0)
THREE = {"a": Normal(mean=0.0, deviation=1.0), "b": LogNormal(median=1.0, factor=2.0), "c": UNIFORM}
CORRELATIONS = {("a", "b"): 0.6, ("a", "d"): -0.4}
GROUPS = {"moisture": Grouping(groups={"dry": DRY, "moist": MOIST})}
PINNED = ["0x1.a453d802e4bf9p-1", "0x1.511ec72ceab02p-2"]
MANY = 50_000


def space(distributions=THREE, **more):
    return Space(distributions=distributions, **more)


WHOLE = space(correlations=CORRELATIONS, relations=(("a", "b"),), groupings=GROUPS)
INDEPENDENT = space(groupings=GROUPS)


def likely(values, distribution):
    return stats.kstest(values, distribution).pvalue > 1e-3


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**64 - 1), st.integers(0, 2**40), st.lists(st.integers(1, 40), min_size=1, max_size=6))
def test_a_draw_is_the_same_bit_for_bit_in_any_chunk(seed, start, sizes):
    whole = WHOLE.draw(seed, start, start + sum(sizes))
    groups = WHOLE.draw_groups(seed, start, start + sum(sizes))["moisture"]
    first = start
    for size in sizes:
        inside = slice(first - start, first - start + size)
        for path, values in WHOLE.draw(seed, first, first + size).items():
            assert values.tobytes() == whole[path][inside].tobytes()
        assert list(WHOLE.draw_groups(seed, first, first + size)["moisture"]) == list(groups[inside])
        first += size


def test_blocks_inside_a_call_change_nothing():
    whole = WHOLE.draw(5, 3, 40_003)
    for start in (3, 4096, 16_380, 32_771):
        part = WHOLE.draw(5, start, start + 2000)
        assert all((part[path] == whole[path][start - 3 : start + 1997]).all() for path in part)
    assert {path: values.shape for path, values in WHOLE.draw(1, 5, 5).items()} == dict.fromkeys("abcd", (0,))


def test_another_seed_or_path_gives_other_numbers_and_another_parameter_changes_none():
    draws = INDEPENDENT.draw(1, 0, 1000)
    assert not (INDEPENDENT.draw(2, 0, 1000)["a"] == draws["a"]).any()
    assert (space({"b": THREE["b"]}).draw(1, 0, 1000)["b"] == draws["b"]).all()
    assert abs(stats.spearmanr(draws["a"], draws["c"])[0]) < 0.1


def test_the_draws_of_today_are_those_of_tomorrow():
    """Studies are resumed and compared: the numbers of a seed are part of the interface."""
    found = uniform_shares("stack.gap.thickness", seed=1, start=1_000_000, stop=1_000_002)
    assert [share.hex() for share in found.tolist()] == PINNED


def test_shares_stay_inside_0_and_1_and_are_uniform():
    shares = uniform_shares("a", seed=0, start=1, stop=100_002)
    assert likely(shares, "uniform")
    assert 2.0**-53 <= shares.min() < shares.max() <= 1 - 2.0**-53
    repeated = uniform_shares("a", seed=0, start=1, stop=100_002, attempt=1)
    assert abs(np.corrcoef(shares, repeated)[0, 1]) < 0.02


def test_draws_have_the_declared_distributions_and_groups():
    draws, groups = INDEPENDENT.draw(3, 0, MANY), INDEPENDENT.draw_groups(3, 0, MANY)["moisture"]
    assert likely(draws["a"], "norm")
    assert likely(draws["b"], stats.lognorm(math.log(2)).cdf)
    assert likely(draws["c"], "uniform")
    assert np.mean(groups == "dry") == pytest.approx(0.3, abs=0.01)
    for name, median in (("dry", 1.0), ("moist", 10.0)):
        assert np.median(draws["d"][groups == name]) == pytest.approx(median, rel=0.01)


def test_correlations_are_those_of_a_gaussian_copula():
    correlated = space(correlations=CORRELATIONS, groupings=GROUPS)
    draws, groups = correlated.draw(3, 0, MANY), correlated.draw_groups(3, 0, MANY)["moisture"]
    rank = stats.spearmanr(draws["a"], draws["b"])[0]
    assert rank == pytest.approx(6 / math.pi * math.asin(0.3), abs=0.015)
    assert likely(draws["b"], stats.lognorm(math.log(2)).cdf)
    within = stats.spearmanr(draws["a"][groups == "dry"], draws["d"][groups == "dry"])[0]
    assert within == pytest.approx(-6 / math.pi * math.asin(0.2), abs=0.03)


def test_a_full_correlation_makes_one_parameter_a_function_of_another():
    same = space(correlations={("a", "b"): -1.0, ("b", "c"): 1.0, ("a", "c"): -1.0}).draw(1, 0, 1000)
    np.testing.assert_allclose(np.log(same["b"]) / math.log(2), -same["a"], rtol=1e-9, atol=1e-12)
    # with b the same as a, c cannot follow one more than the other
    with pytest.raises(InputError, match="no quantities have these correlations"):
        space(correlations={("a", "b"): 1.0, ("a", "c"): 0.5, ("b", "c"): 0.2})


@pytest.mark.parametrize("first", np.linspace(0.1, 1.2, 12))
def test_correlations_of_directions_in_a_plane_are_possible(first):
    """Coefficients cos(angle) between three directions in a plane: the third variable follows from the other two."""
    angles = {"a": 0.0, "b": first, "c": first + 0.7}
    given = {(x, y): math.cos(angles[x] - angles[y]) for x, y in ("ab", "bc", "ac")}
    draws = space(correlations=given).draw(1, 0, 200)
    a, b, c = draws["a"], np.log(draws["b"]) / math.log(2), stats.norm.ppf(draws["c"])
    share = [math.sin(0.7) / math.sin(first + 0.7), math.sin(first) / math.sin(first + 0.7)]
    np.testing.assert_allclose(b, share[0] * a + share[1] * c, atol=1e-6)


def test_relations_hold_and_leave_the_rest_as_it_was():
    draws, before = WHOLE.draw(3, 0, MANY), INDEPENDENT.draw(3, 0, MANY)
    assert (draws["a"] < draws["b"]).all()
    assert (draws["c"] == before["c"]).all()
    assert (WHOLE.draw_groups(3, 0, 999)["moisture"] == INDEPENDENT.draw_groups(3, 0, 999)["moisture"]).all()
    pair = space({"a": UNIFORM, "b": UNIFORM}, relations=(("a", "b"),)).draw(1, 0, MANY)
    assert likely(pair["a"], lambda x: 1 - (1 - x) ** 2)  # the conditional distributions
    assert likely(pair["b"], lambda x: x**2)


def test_a_relation_that_is_hardly_ever_fulfilled_is_named_with_its_share():
    distributions = {"a": Uniform(low=1.0, high=2.0), "b": UNIFORM, "c": Uniform(low=0.0, high=3.0)}
    never = space(distributions, relations=(("a", "c"), ("a", "b")))
    with pytest.raises(InputError, match="a < b: draw 7; a share of 0 of the draws fulfils"):
        never.draw(1, 7, 8)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((-1, 0, 1), "seed = -1"),
        ((2**64, 0, 1), "seed"),
        ((1.5, 0, 1), "seed = 1.5"),
        ((True, 0, 1), "seed = True"),
        ((1, 3, 2), "0 <= start <= stop"),
        ((1, -1, 2), "0 <= start"),
    ],
)
def test_a_seed_or_a_range_that_is_not_possible_is_refused(arguments, words):
    with pytest.raises(InputError, match=words):
        WHOLE.draw(*arguments)
    with pytest.raises(TypeError):
        WHOLE.draw(start=0, stop=1)


def test_parameters_that_depend_on_each_other_are_one_input():
    assert list(WHOLE.inputs) == ["groups of moisture + a + b", "c"]
    assert list(INDEPENDENT.inputs) == ["a", "b", "c", "groups of moisture"]
