"""Draws depend on seed and index alone, and have the declared distributions, correlations, relations and groups."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from electrovib.core.errors import InputError
from electrovib.scenario.distributions import LogNormal, Normal, Uniform
from electrovib.scenario.space import Group, Grouping, Space
from electrovib.scenario.space.counter import uniform_shares

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
