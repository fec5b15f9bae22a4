"""Sobol indices of functions with published values and closed forms, and of scenarios."""

import itertools
import math

import numpy as np
import pytest
from scipy.stats import sobol_indices

import electrovib as ev
from electrovib.core.budget import BudgetError, budget
from electrovib.core.errors import InputError
from electrovib.scenario.distributions import Normal, Uniform
from electrovib.scenario.space import Group, Grouping, Space
from electrovib.solve.quantities import cases
from electrovib.studies.sensitivity import _bootstrap, _estimates, _terms, sobol

STATIC = "vezzoli_2014/fig6_static"
AREA, VOLTAGE = "contact.area", "drive.high"
LOG_NORMAL = {
    AREA: {"model": "LogNormal", "median": "1 cm2", "factor": math.exp(0.3)},
    VOLTAGE: {"model": "LogNormal", "median": "500 V", "factor": math.exp(0.2)},
}
UNIT = Uniform(low=0.0, high=1.0)
LINEAR = Space(
    distributions={name: Normal(mean=0.0, deviation=1.0) for name in "abc"}, correlations={("a", "b"): 0.5}
)


def sensitivity(space=LOG_NORMAL, scenario=STATIC, **asked):
    return ev.sensitivity(scenario, space, **{"quantity": "peak electrostatic_force", "seed": 1} | asked)


def total(at):
    return sum(at.values())


def test_the_ishigami_function_has_its_published_indices():
    """T. Ishigami, T. Homma 1990, with 7 and 0.1: exact values from its variance decomposition."""
    space = Space(distributions={name: Uniform(low=-math.pi, high=math.pi) for name in "abc"})

    def ishigami(at):
        x, y, z = (at[name] for name in "abc")
        return np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)

    found = sobol(space, ishigami, n=2**14, seed=1)
    np.testing.assert_allclose(found.first, [0.3139, 0.4424, 0.0], atol=0.01)
    np.testing.assert_allclose(found.total, [0.5576, 0.4424, 0.2437], atol=0.01)
    for index, ends in ((found.first, found.first_interval), (found.total, found.total_interval)):
        assert ((ends[0] < index) & (index < ends[1])).all()
        assert (ends[1] - ends[0] < 0.06).all()


def test_the_g_function_has_its_published_indices():
    """I. M. Sobol 1998 with a = 0, 1, 4.5, 9, 99: first and total indices in closed form."""
    a = np.array([0, 1, 4.5, 9, 99])

    def g(at):
        return math.prod((np.abs(4 * at[str(i)] - 2) + a[i]) / (1 + a[i]) for i in range(5))

    found = sobol(Space(distributions={str(i): UNIT for i in range(5)}), g, n=4096, seed=2)
    partial = 1 / (3 * (1 + a) ** 2)
    whole = np.prod(1 + partial) - 1
    np.testing.assert_allclose(found.first, partial / whole, atol=0.01)
    np.testing.assert_allclose(found.total, partial / (1 + partial) * (1 + whole) / whole, atol=0.01)
    assert found.first[0] == pytest.approx(0.716, abs=0.012)  # as printed for a longer list of a


@pytest.mark.slow
def test_the_static_law_has_the_indices_of_a_product_of_log_normal_factors():
    """The force of a static law is area times voltage squared, so its variance decomposes in closed form."""
    found = sensitivity(n=1024, seed=3)
    spread = {AREA: math.exp(0.3**2) - 1, VOLTAGE: math.exp(0.4**2) - 1}
    whole = math.prod(1 + each for each in spread.values()) - 1
    assert [each.name for each in found.indices] == [VOLTAGE, AREA]
    for each in found.indices:
        assert each.first == pytest.approx(spread[each.name] / whole, abs=0.02)
        others = math.prod(1 + value for name, value in spread.items() if name != each.name)
        assert each.total == pytest.approx(spread[each.name] * others / whole, abs=0.02)
    mean = 56.553e-3 * 0.25 * math.exp(0.3**2 / 2 + 0.4**2 / 2)
    assert found.mean == pytest.approx(mean, rel=0.01)
    assert found.deviation == pytest.approx(mean * math.sqrt(whole), rel=0.05)
    assert found.headline.startswith(f"Measure {VOLTAGE} first")
    assert found.evaluations == 1024 * 4


def test_parameters_that_depend_on_each_other_are_one_input():
    """For a < b, both uniform, a is 1/18 and their covariance 1/36: a + b has a variance of 1/6."""
    found = sobol(LINEAR, total, n=2048, seed=1)
    assert list(LINEAR.inputs) == ["a + b", "c"]
    for each in (found.first, found.total):
        np.testing.assert_allclose(each, [3 / 4, 1 / 4], atol=0.01)
    assert found.sample.var() == pytest.approx(4, rel=0.02)
    related = Space(distributions=dict.fromkeys("abc", UNIT), relations=(("a", "b"),))
    values = []
    found = sobol(related, lambda at: values.append(at) or total(at), n=4096, seed=1)
    assert list(related.inputs) == ["a + b", "c"]
    np.testing.assert_allclose(found.first, [2 / 3, 1 / 3], atol=0.03)
    assert all((at["a"] < at["b"]).all() for at in values)
    dry, moist = (Group(share=0.5, distributions={"a": Uniform(low=low, high=low + 1)}) for low in (0.0, 4.0))
    moisture = {"moisture": Grouping(groups={"dry": dry, "moist": moist})}
    grouped = Space(distributions={"b": UNIT}, groupings=moisture)
    found = sobol(grouped, total, n=1024, seed=1)
    assert list(grouped.inputs) == ["b", "groups of moisture"]
    np.testing.assert_allclose(found.first, [1 / 50, 49 / 50], atol=0.01)  # 1/12 against 1/12 + 2 squared


def test_the_intervals_contain_the_index_as_often_as_they_state():
    """Random draws, by a relation that always holds: for those the bootstrap is made."""
    high = Uniform(low=2.0, high=4.0)
    distributions = {"a": UNIT, "b": high, "c": UNIT, "d": high}
    space = Space(distributions=distributions, relations=(("a", "b"), ("c", "d")))
    inside = []
    for seed in range(60):
        found = sobol(space, lambda at: at["a"] + at["b"] + 2 * (at["c"] + at["d"]), n=128, seed=seed)
        intervals = found.first_interval, found.total_interval
        inside += [ends[0, 0] < 0.2 < ends[1, 0] for ends in intervals]
    assert 0.89 < np.mean(inside) < 0.99


def test_the_bootstrap_resamples_the_estimators_of_scipy():
    generator = np.random.default_rng(1)
    a, b = generator.normal(3, 1, (2, 512))
    mixed = np.stack([a + 0.1 * b, b])
    found = sobol_indices(func={"f_A": a[None], "f_B": b[None], "f_AB": mixed[:, None]}, n=512)
    expected = found.bootstrap(confidence_level=0.95, n_resamples=999)
    terms = _terms(a, b, mixed)
    ours = _estimates(np.full((1, 512), 1 / 512), terms)[0]
    np.testing.assert_allclose(ours, [found.first_order, found.total_order], rtol=1e-12)
    low, high = _bootstrap(terms, generator)
    for ours, theirs in ((0, expected.first_order), (1, expected.total_order)):
        np.testing.assert_allclose(low[ours], np.ravel(theirs.confidence_interval.low), atol=0.03)
        np.testing.assert_allclose(high[ours], np.ravel(theirs.confidence_interval.high), atol=0.03)


def test_one_parameter_has_all_of_the_influence_and_an_elasticity_at_the_end_of_a_range_is_not_defined():
    """Indices of 1 by definition, within the error of the estimate; the answer names the parameter."""
    found = sensitivity({AREA: LOG_NORMAL[AREA]}, n=256)
    (index,) = found.indices
    assert (index.first, index.total) == (pytest.approx(1, abs=0.05), pytest.approx(1, abs=0.05))
    assert index.first_interval[0] < index.first_interval[1]
    assert AREA in found.headline
    vacuum = {"stack.insulator.material.permittivity": {"model": "Empirical", "values": [1]}}
    found = sensitivity(vacuum | LOG_NORMAL, n=4)
    assert math.isnan(found.elasticities[0].value)
    assert "not defined" in found.tables[1].rows[0]


def test_chunks_change_nothing_and_the_seed_something(monkeypatch):
    whole = sensitivity(n=8)
    monkeypatch.setattr(cases, "_CHUNK", 3)
    again = sensitivity(n=8)
    assert again.indices == whole.indices
    assert again.sample.tobytes() == whole.sample.tobytes()
    assert sensitivity(n=8, seed=2).indices != whole.indices
    slopes = {each.path: each.value for each in whole.elasticities}
    assert slopes == {AREA: pytest.approx(1, rel=1e-9), VOLTAGE: pytest.approx(2, rel=1e-8)}
    with pytest.raises(TypeError, match="seed"):
        ev.sensitivity(STATIC, LOG_NORMAL, quantity="peak electrostatic_force", n=8)


def test_the_answer_names_what_cannot_be_distinguished_and_what_has_no_influence():
    free = LOG_NORMAL | {"friction.coefficient": {"model": "Uniform", "low": 0.4, "high": 0.6}}
    free[VOLTAGE] = {"model": "LogNormal", "median": "500 V", "factor": math.exp(0.15)}
    found = sensitivity(free, n=32)
    first, second = found.indices[:2]
    assert {first.name, second.name} == {AREA, VOLTAGE}
    assert f"not distinguishable from that of {second.name}" in found.headline
    assert found.headline.endswith("Without influence (total index below 0.01): friction.coefficient.")
    shares = (first.first, *first.first_interval)
    fall, least, most = (f"{100 * (1 - math.sqrt(1 - min(max(each, 0), 1))):.0f}" for each in shares)
    assert f"would fall by {fall} % on average ({least} to {most} %, " in found.headline


REFUSED = {
    "no power": ({"n": 100}, "n = 100: expected a power of 2, for instance 128"),
    "one": ({"n": 1}, "power of 2"),
    "no whole number": ({"n": 64.5}, "whole number"),
    "seed": ({"seed": -1}, "seed = -1"),
    "quantity": ({"quantity": "peak electrostatic_forc"}, "Did you mean"),
    "space": ({"space": "finger"}, "Did you mean 'fingers'"),
    "constant": ({"space": {"friction.coefficient": 0.5}}, "same value for every draw"),
    "scenario": ({"scenario": "vezzoli_2014/fig"}, "vezzoli_2014"),
}


@pytest.mark.parametrize("wrong", REFUSED)
def test_mistakes_are_one_sentence(wrong):
    changes, words = REFUSED[wrong]
    with pytest.raises(InputError, match=words):
        sensitivity(**{"n": 4} | changes)


def test_progress_counts_every_evaluation_and_too_many_or_those_not_finite_are_refused():
    seen = []
    sensitivity(n=4, progress=lambda *at: seen.append(at))
    assert seen == [(done, 16) for done in range(16)]
    assert all(done < whole for (done, whole), _ in itertools.pairwise(seen))
    for n, said in ((2**30, "4294967296 evaluations; .*"), (2**18, "1048576 evaluations, of which .*")):
        with budget(time=5.0), pytest.raises(BudgetError, match=f"for {said}Choose a smaller n"):
            sensitivity(n=n)
    with pytest.raises(InputError, match=r"share of 0\.5 of the draws, for instance at a = -"):
        sobol(LINEAR, lambda at: np.where(at["a"] < 0, np.nan, 1.0), n=4096, seed=1)
