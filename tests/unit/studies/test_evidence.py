"""Laws judged by measurements: scores against closed forms, a planted law that wins, and refusals."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy import stats
from scipy.special import logsumexp

import electrovib as ev
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.physics.force import ForceLaw
from electrovib.studies.evidence import Measurement, predicted
from electrovib.studies.evidence.measurement import numbers_of
from electrovib.studies.evidence.plan import ODDS, _values, _worst, plan_experiment
from electrovib.studies.evidence.predicted import (
    CONSTANT,
    RANGE,
    SQUARE,
    ModelPrediction,
    candidates,
    null_predictions,
    predict,
    prediction,
)
from electrovib.studies.evidence.quantities import takes_columns
from electrovib.studies.evidence.result import Evidence, _rounded, _words
from electrovib.studies.evidence.standing import (
    DECADE,
    SURPRISE,
    comparisons,
    judge,
    over_groups,
    typical_factor,
)

VOLTAGES = (50.0, 100.0, 200.0)
GAP = {"model": "LogUniform", "low": 1e-6, "high": 4e-6, "choice": "a range of this test"}
FORCE = "final electrostatic_force"
OTHERS = tuple(name for name in find_members(ForceLaw) if name != "MaxwellStressInGap")


def step(voltage=100.0):
    changes = {"drive": {"model": "Step", "level": voltage}, "load.normal_force": 0.0}
    return ev.load("vezzoli_2014/fig6_gap", changes={**changes, "time.duration": 1e-3})


def page(found, title):
    """The table of an answer that has this title."""
    return next(each for each in found.document.pages if each.title == title)


def measured(values=(1e-3, 4e-3, 16e-3), spread=0.1, **more):
    content = {
        "title": "made up", "source": "this test", "scenario": step(), "quantity": FORCE, "unit": "N", "values": values,
        "spread": (spread,) * len(values), "spread_of": "repeats", "group": "nobody", "how": "printed", "status": "full text",
        "over": "drive.level", "at": VOLTAGES, "unknown": {"stack.gap.thickness": GAP},
    }  # fmt: skip
    return Measurement(**content | more)


def judged(values, found, spread=0.1, **more):
    alone = {"over": "", "at": (), "unknown": {}} if len(values) == 1 else {"at": VOLTAGES[: len(values)]}
    return judge("m", measured(values, spread, **alone | more), ModelPrediction("law", np.array(found)))


def test_the_score_of_one_sharp_prediction_is_the_density_of_a_log_normal():
    """A surprise of 1 % is left to deviations of the order of decades, so that the worse of two wrong laws scores less."""
    width = math.sqrt(math.log1p(0.1**2))
    for ratio in (1.0, 1.1, 0.7):
        sharp = stats.norm.pdf(math.log(ratio), scale=width)
        tail = stats.cauchy.pdf(math.log(ratio), scale=math.log(10))
        expected = math.log((1 - SURPRISE) * sharp + SURPRISE * tail)
        found = judged([2.0], [[2.0 * ratio]] * 50)
        assert found.score == pytest.approx(expected, rel=1e-12)
        assert found.ratio == pytest.approx(ratio)
        assert math.isnan(found.shape)
    lost = judged([2.0], [[0.0]] * 50)
    assert -20 < lost.score < judged([2.0], [[2e-6]] * 50).score < judged([2.0], [[0.02]] * 50).score < -3
    assert lost.covered == 0
    assert lost.ratio == pytest.approx(0.0, abs=1e-200)


def test_the_score_of_many_draws_is_that_of_their_mixture_and_the_interval_includes_the_spread():
    draws = np.exp(np.random.default_rng(1).normal(0.0, 0.5, 20000))
    found = judged([1.3], draws[:, None], spread=0.2)
    width = math.sqrt(0.25 + math.log1p(0.04))
    assert found.score == pytest.approx(stats.norm.logpdf(math.log(1.3), scale=width), abs=0.03)
    edge = math.exp(stats.norm.ppf(0.95) * width)
    for inside, value in ((1.0, 0.97 * edge), (0.0, 1.03 * edge)):
        assert judged([value], draws[:, None], spread=0.2).covered == inside
    assert found.low == pytest.approx(math.exp(stats.norm.ppf(0.05) * 0.5) / 1.3, rel=0.02)


def test_the_shape_does_not_know_a_common_factor_and_sees_a_wrong_exponent():
    squares = np.array([[1.0, 4.0, 16.0]])
    exact = judged([1.0, 4.0, 16.0], squares)
    for factor in (1e-3, 50.0):
        assert judged([1.0, 4.0, 16.0], factor * squares).shape == pytest.approx(exact.shape, rel=1e-12)
    assert judged([1.0, 2.0, 4.0], squares).shape < exact.shape - 3
    width = math.sqrt(math.log1p(0.01) * 2 / 3)  # a third of the variance went into the factor
    assert exact.shape == pytest.approx(stats.norm.logpdf(0.0, scale=width), abs=0.02)


def test_a_prediction_runs_over_what_is_not_printed_and_the_laws_that_cannot_say_why():
    found, refused = predict(measured(), n=32, seed=3)
    by_law = {each.model: each.values for each in found}
    assert by_law["MaxwellStressInGap"].shape == (32, 3)
    np.testing.assert_allclose(
        by_law["MaxwellStressInGap"][:, 1] / by_law["MaxwellStressInGap"][:, 0], 4, rtol=1e-6
    )
    assert "mean_gap" in refused["Persson2018RoughGap"]
    draws = ev.read_space(step(), {"space": {"stack.gap.thickness": GAP}}).draw(3, 0, 32)
    one = step(200.0).replace({"stack.gap.thickness": draws["stack.gap.thickness"][5]})
    alone = ev.sweep(one, {}, quantity=[FORCE])[FORCE]
    assert by_law["MaxwellStressInGap"][5, 2] == pytest.approx(float(alone), rel=1e-6)
    own = {"stack.gap": None, "force.mean_gap": {"model": "Uniform", "low": 1e-6, "high": 2e-6, "choice": "of this test"},
           "force.rms_gap": {"model": "Uniform", "low": 3e-7, "high": 5e-7, "choice": "of this test"}}  # fmt: skip
    found, refused = predict(measured(of_model={"Persson2018RoughGap": own}), n=8)
    assert "Persson2018RoughGap" in {each.model for each in found}
    function = measured(quantity=lambda scenario: 1.0 / scenario.stack.layers["gap"].thickness, unit="1/m")
    assert predict(function, n=8)[0][0].values.shape == (8, 3)
    thrice = predict(replace(function, scale=3.0), n=8)[0][0].values
    np.testing.assert_allclose(thrice, 3.0 * predict(function, n=8)[0][0].values, rtol=1e-12)
    printed = measured(values=(1.0,), unknown={}, over="", at=())  # every parameter is printed
    (found,) = (each for each in predict(printed, n=8)[0] if each.model == "MaxwellStressInGap")
    alone = float(ev.sweep(step(), {}, quantity=[FORCE])[FORCE])
    np.testing.assert_allclose(found.values, np.full((8, 1), alone), rtol=1e-9)
    ratio = replace(printed, per="peak electrostatic_force", scale=3.0, unit="1")
    (found,) = (each for each in predict(ratio, n=2)[0] if each.model == "MaxwellStressInGap")
    peak = float(ev.sweep(step(), {}, quantity=["peak electrostatic_force"])["peak electrostatic_force"])
    np.testing.assert_allclose(found.values, np.full((2, 1), 3.0 * alone / peak), rtol=1e-9)


def test_a_function_is_called_once_for_each_set_of_values():
    calls = []

    def inverse(scenario):
        calls.append(scenario.stack.layers["gap"].thickness)
        return 1.0 / calls[-1]

    listed = {"model": "Empirical", "values": [1e-6, 3e-6], "choice": "of this test"}
    made = measured(quantity=inverse, unit="1/m", unknown={"stack.gap.thickness": listed}, made=OTHERS)
    (found,) = predict(made, n=20)[0]
    assert len(calls) == 2 * len(VOLTAGES)
    gaps = ev.read_space(step(), {"space": {"stack.gap.thickness": listed}}).draw(0, 0, 20)
    np.testing.assert_array_equal(found.values[:, 1], 1.0 / gaps["stack.gap.thickness"])


def of_the_gap(asked):
    """Predicted values of the stress in the gap."""
    (found,) = (each for each in predict(asked, n=4)[0] if each.model == "MaxwellStressInGap")
    return found.values


def test_a_quantity_is_divided_by_that_under_other_conditions_with_the_same_draws():
    ratio = {"values": (4.0,), "over": "", "at": (), "unit": "1"}
    squares = measured(**ratio, per_changes={"drive.level": 50.0})
    np.testing.assert_allclose(of_the_gap(squares), 4.0, rtol=1e-9)  # of 100 V
    np.testing.assert_allclose(of_the_gap(replace(squares, unknown={})), 4.0, rtol=1e-9)
    whole = {
        "drive": {"model": "Step", "level": 50.0}
    }  # a level that is drawn is not that of the other drive
    drawn = {"drive.level": {"model": "Uniform", "low": 200.0, "high": 201.0, "choice": "of this test"}}
    found = of_the_gap(measured(**ratio, per_changes=whole, unknown=drawn))
    assert found.min() >= 16.0
    assert found.max() <= 16.2
    over = measured(values=(1.0, 4.0, 16.0), unit="1", per_changes={"drive.level": 50.0})
    np.testing.assert_allclose(of_the_gap(over), np.tile([1.0, 4.0, 16.0], (4, 1)), rtol=1e-6)
    gap = replace(squares, quantity=lambda each: each.stack.layers["gap"].thickness)
    np.testing.assert_allclose(of_the_gap(gap), 1.0, rtol=1e-12)
    twice = {"stack.gap.thickness": 2e-6}
    own = of_the_gap(replace(gap, per_changes=twice)) * 2e-6
    assert len(np.unique(own)) == 4
    other = replace(squares, per="peak electrostatic_force")
    plain = of_the_gap(measured(values=(1.0,), over="", at=(), unit="1", per="peak electrostatic_force"))
    np.testing.assert_allclose(of_the_gap(other), 4.0 * plain, rtol=1e-6)
    with pytest.raises(InputError, match="in 1; give the values in it"):
        measured(per_changes={"drive.level": 50.0})
    with pytest.raises(InputError, match=r"drive\.levl"):
        measured(**ratio, per_changes={"drive.levl": 50.0})


def test_null_models_of_one_quantity_under_two_conditions_leave_nothing_open():
    asked = measured(values=(3.0, 9.0, 27.0), unit="1", per_changes={"drive.level": 50.0})
    other = replace(asked, group="other", values=(1e3,) * 3)
    found = {each.model: each.values for _, each in null_predictions({"a": asked}, {"b": other}, n=11)}
    np.testing.assert_array_equal(found[CONSTANT], 1.0)
    np.testing.assert_allclose(found[SQUARE], np.tile([1.0, 4.0, 16.0], (11, 1)), rtol=1e-12)
    assert found[RANGE].max() > 500.0  # of all that was measured of this quotient
    by_gap = replace(other, per_changes={"stack.gap.thickness": 1e-6})
    found = {each.model: each.values for _, each in null_predictions({"a": by_gap}, {"b": asked}, n=11)}
    assert found[RANGE].min() > 300.0  # a quotient by another parameter is another quantity
    np.testing.assert_array_equal(found[SQUARE], np.tile(found[SQUARE][0], (11, 1)))
    current = replace(asked, unknown={**asked.unknown, "drive.level": GAP | {"low": 10.0, "high": 20.0}}, over="", at=(),
                      values=(2.0,), spread=(0.1,))  # fmt: skip
    found = {each.model: each.values for _, each in null_predictions({"a": current}, {}, n=3)}
    np.testing.assert_array_equal(found[SQUARE], 1.0)  # the voltage is not known


def quotient(scenario):
    """Fail for one law as a wrong number does, in the middle of its draws."""
    if type(scenario.force).__name__ == "EffectiveMedium":
        return 1.0 / (scenario.load.normal_force - scenario.load.normal_force)
    return 1.0 / scenario.stack.layers["gap"].thickness


def raising(error):
    def broken(scenario):
        if type(scenario.force).__name__ == "EffectiveMedium":
            raise error
        return 1.0

    return broken


def test_a_function_that_fails_for_one_law_is_a_reason_and_an_error_of_its_author_is_not():
    found, refused = predict(measured(quantity=quotient), n=4)
    assert "MaxwellStressInGap" in {each.model for each in found}
    assert refused["EffectiveMedium"] == (
        "quotient() of 'made up' failed with ZeroDivisionError: float division by zero"
    )
    for error in (ValueError("no root"), FloatingPointError("underflow"), OverflowError("too large")):
        assert str(error) in predict(measured(quantity=raising(error)), n=4)[1]["EffectiveMedium"]
    for wrong in (TypeError("a mistake"), KeyError("gap"), AttributeError("thicknes")):
        with pytest.raises(type(wrong)) as caught:
            predict(measured(quantity=raising(wrong)), n=4)
        assert caught.value.__notes__ == ["in broken() of 'made up'"]
    own = raising(InputError("friction: has no coefficient"))
    assert predict(measured(quantity=own), n=4)[1]["EffectiveMedium"] == "friction: has no coefficient"


def planted(law, seed, names):
    """Return twins of the measurements: values that a law gives at one draw of what is not printed, with the spread."""
    rng, found = np.random.default_rng(seed), {}
    for name, (each, predictions) in names.items():
        values = predictions[law][rng.integers(len(predictions[law]))]
        found[name] = replace(
            each,
            values=tuple((values * np.exp(np.array(each.spread) * rng.normal(size=values.size))).tolist()),
        )
    return found


@pytest.mark.slow
def test_a_planted_law_wins_its_own_twins_in_95_of_100_seeds():
    thin = {"model": "LogUniform", "low": 3e-6, "high": 3.3e-6, "choice": "a range of this test"}
    several = {
        "voltage": measured(),
        "thickness": measured(
            over="stack.insulator.thickness", at=(20e-6, 90e-6), values=(1.0, 1.0), group="somebody"
        ),
        "gap": measured(unknown={"stack.gap.thickness": thin}, group="a third"),
    }
    made = {
        name: (each, {one.model: one.values for one in predict(each, n=64)[0]})
        for name, each in several.items()
    }
    for law in ("MaxwellStressInGap", "EffectiveMedium", "MaxwellStressInInsulator"):
        won = 0
        for seed in range(100):
            twins = planted(law, seed, made)
            scores = [
                judge(name, twins[name], ModelPrediction(model, values))
                for name, (_, predictions) in made.items()
                for model, values in predictions.items()
            ]
            won += best(scores)[0] == law
        assert won >= 95, law


def best(scores):
    """Candidates by their mean score over groups, the best first."""
    found = {each.model: [one for one in scores if one.model == each.model] for each in scores}
    means = {
        law: np.mean(list(over_groups(own, lambda each: each.score).values())) for law, own in found.items()
    }
    return sorted(means, key=means.get, reverse=True)


@pytest.mark.slow
def test_a_planted_law_wins_on_the_twins_of_all_that_was_measured():
    """Of 100 seeds, on the measurements that it predicts with others: first, or beside one that predicts nearly the same."""
    laws = find_members(ForceLaw)  # those of other tests among them
    ours = {name for name, law in laws.items() if law.__module__.startswith("electrovib.")}
    predicted = {
        name: (each, {one.model: one.values for one in predict(each, n=64)[0] if one.model in ours})
        for name, each in ev.measurements().items()
        if each.judges == "force" and not each.bound
    }
    several = {name: each for name, each in predicted.items() if len(each[1]) > 1}
    assert len(several) > 12
    for law in {law for _, predictions in several.values() for law in predictions}:
        made = {name: each for name, each in several.items() if law in each[1]}
        if sum(len(each.values) for each, _ in made.values()) < 4:
            continue  # Vezzoli2014PerFrequency: two squares of the voltage, which all laws have, and one number
        common = set.intersection(*(set(predictions) for _, predictions in made.values()))
        first = 0
        for seed in range(100):
            twins = planted(law, seed, made)
            scores = [
                judge(name, twins[name], ModelPrediction(model, values))
                for name, (_, predictions) in made.items()
                for model, values in predictions.items()
                if model in common
            ]
            first += law in best(scores)[:2]
        assert first >= 95, law


def one(law, name, group, score, **more):
    numbers = frozenset({(name, "0")})
    content = {"model": law, "measurement": name, "group": group, "score": score, "numbers": numbers}
    return replace(judged([1.0], [[1.0]] * 9), **content | {"narrow": score, "wide": score} | more)


def test_skill_is_the_score_over_the_best_null_model_with_the_jackknife_over_groups():
    """Of a mean the jackknife is the standard error; by hand for groups with the skills 1, 2 and 6."""
    law = [
        one("law", str(place), group, score)
        for place, (group, score) in enumerate(zip("ghi", (1, 2, 6), strict=True))
    ]
    zero, worse = (
        [one(name, str(place), group, score) for place, group in enumerate("ghi")]
        for name, score in (("zero", 0.0), ("worse", -1.0))
    )
    (found,) = comparisons("force", law, [*zero, *worse])
    (standing,) = found.standings
    assert (found.null, found.groups, found.numbers) == ("zero", 3, 3)
    assert standing.skill == pytest.approx(3.0)
    half = stats.t.ppf(0.95, 2) * np.std([1, 2, 6], ddof=1) / math.sqrt(3)
    assert (standing.low, standing.high) == pytest.approx((3 - half, 3 + half))
    assert (standing.least, standing.most) == (1.5, 4.0)
    assert not standing.has_skill
    (alone,) = comparisons("force", law[:1], [*zero, *worse])
    assert math.isnan(alone.standings[0].low)
    assert not alone.standings[0].has_skill
    (sure,) = comparisons("force", [replace(each, score=2.0) for each in law], [*zero, *worse])
    assert sure.standings[0].has_skill


def test_laws_are_compared_on_the_measurements_that_all_of_them_predict():
    scores = [
        *(one("a", name, "g", -1.0) for name in "123"),
        *(one("b", name, "g", -2.0) for name in "12"),
        one("c", "1", "g", -3.0),
    ]
    nulls = [one("null", name, "g", -1.5) for name in "123"]
    found = list(comparisons("force", scores, nulls))
    assert [(each.names, [one.model for one in each.standings]) for each in found] == [
        (("1",), ["a", "b", "c"]),
        (("1", "2"), ["a", "b"]),
        (("1", "2", "3"), ["a"]),
    ]
    assert [each.skill for each in found[0].standings] == [0.5, -0.5, -1.5]
    assert next(comparisons("force", scores[::-1], nulls[::-1])).standings == found[0].standings


def test_ranks_and_skill_with_one_group_less_and_other_widths_stand_beside_each_law():
    steady = [one("steady", str(place), group, -1.0, narrow=-0.5) for place, group in enumerate("ghi")]
    erratic = [
        one("erratic", str(place), group, score, wide=-4.0)
        for place, (group, score) in enumerate(zip("ghi", (-5, 0, 0), strict=True))
    ]
    nulls = [one("null", str(place), group, -2.0) for place, group in enumerate("ghi")]
    (found,) = comparisons("force", [*steady, *erratic], nulls)
    ranks = {each.model: (each.first, each.last, each.narrow, each.wide) for each in found.standings}
    assert ranks == {"steady": (1, 2, 1.5, 1.0), "erratic": (1, 2, pytest.approx(1 / 3), -2.0)}


def test_every_group_counts_once_and_numbers_that_share_their_errors_count_as_one():
    line = frozenset({("g", "a source", "a line")})
    scores = [
        one("law", "1", "g", -1.0, numbers=line),
        one("law", "2", "g", -3.0, numbers=line),
        one("law", "3", "g", -6.0),
        one("law", "4", "h", 0.0),
    ]
    assert over_groups(scores, lambda each: each.score) == {"g": -4.0, "h": 0.0}
    nulls = [one("null", name, each.group, 0.0) for name, each in zip("1234", scores, strict=True)]
    (found,) = comparisons("force", scores, nulls)
    assert (found.numbers, found.groups) == (3, 2)
    assert found.standings[0].skill == -2.0
    assert typical_factor([replace(scores[0], ratio=2.0), replace(scores[3], ratio=0.125)]) == pytest.approx(
        4.0
    )
    several = measured(error_of="a figure")
    assert numbers_of("name", several) == {("nobody", "this test", "a figure")}
    assert len(numbers_of("name", measured())) == 3


def test_a_bound_is_scored_by_the_probability_to_keep_it():
    """Of a log-normal prediction about 1, which a bound of 2 cuts; the probability has a closed form."""
    draws = np.exp(stats.norm.ppf((np.arange(4000) + 0.5) / 4000) * 0.5)[:, None]
    width = math.sqrt(0.25 + math.log1p(0.01))
    for bound, sign in (("at least", -1), ("at most", 1)):
        found = judged([2.0], draws, bound=bound)
        expected = (1 - SURPRISE) * stats.norm.cdf(sign * math.log(2) / width)
        expected += SURPRISE * 0.5
        assert found.score == pytest.approx(math.log(expected), abs=0.04)  # kernels widen the draws
        assert math.isnan(found.shape)
    far = {"at least": (0.0, 1.0), "at most": (1.0, 0.0)}
    for bound, covered in far.items():
        assert tuple(judged([value], draws, bound=bound).covered for value in (100.0, 0.01)) == covered
    with pytest.raises(InputError, match="'at least' or 'at most'"):
        measured(bound="below")


def test_the_width_is_that_of_the_interval_in_decades():
    """A log-uniform prediction of two decades has 1.8 between the 5 and 95 %; the spread of the measurement does not enter."""
    draws = np.geomspace(0.1, 10.0, 2001)[:, None]
    assert judged([1.0], draws, spread=3.0).width == pytest.approx(1.8, rel=1e-3)


def test_null_models_take_other_groups_alone_and_know_no_set_up():
    """By hand: stresses 1 and 100 of two groups, so that a third is predicted as 10, whatever its voltage and area."""
    area = step().contact_area
    known = {
        "low": measured(values=(area,), over="", at=(), group="one"),
        "low again": measured(values=(area,), over="", at=(), group="one"),
        "high": measured(values=(100.0 * area,), over="", at=(), group="two"),
    }
    asked = {"asked": measured(values=(7.0 * area,) * 3)}
    found = {each.model: each.values for _, each in null_predictions(asked, known, n=1001)}
    assert np.median(found[CONSTANT], axis=0) == pytest.approx([10.0 * area] * 3)
    assert np.std(np.log(found[CONSTANT])) == pytest.approx(DECADE, rel=1e-2)  # each group counts once
    squares = np.array(VOLTAGES) ** 2 / 100.0**2
    assert np.median(found[SQUARE], axis=0) == pytest.approx(10.0 * area * squares)
    assert (found[RANGE].min(), found[RANGE].max()) == pytest.approx((area, 100.0 * area), rel=5e-3)
    alone = {each.model: each.values for _, each in null_predictions(asked, {}, n=1001)}
    np.testing.assert_array_equal(alone[CONSTANT], alone[RANGE])
    assert alone[RANGE].max() / alone[RANGE].min() == pytest.approx(10.0, rel=5e-3)
    ratio = {"ratio": measured(per="peak electrostatic_force", unit="1")}
    assert next(null_predictions(ratio, known, n=11))[1].values.max() < 16e-3 * 10  # not of forces


def test_narrow_and_wide_ranges_are_half_and_twice_as_wide_in_the_logarithm():
    (found,) = (each for each in predict(measured(), n=64)[0] if each.model == "MaxwellStressInGap")
    assert found.narrow is not None
    assert found.wide is not None
    gaps = ev.read_space(step(), {"space": {"stack.gap.thickness": GAP}}).draw(0, 0, 64)[
        "stack.gap.thickness"
    ]
    middle = np.median(gaps)
    for values, factor in ((found.narrow, 0.5), (found.values, 1.0), (found.wide, 2.0)):
        moved = step().replace({"stack.gap.thickness": float(middle * (gaps[3] / middle) ** factor)})
        alone = float(ev.sweep(moved, {}, quantity=[FORCE])[FORCE])
        assert values[3, 1] == pytest.approx(alone, rel=1e-6)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"values": (1.0, 2.0)}, "one number for each point"),
        ({"values": (1.0, 0.0, 1.0)}, "positive numbers"),
        ({"how": "heard"}, "read from a figure"),
        ({"spread_of": "mood"}, "people, repeats"),
        ({"status": "derived"}, "neither derived nor cited from memory"),
        ({"status": "unverified"}, "neither derived nor cited from memory"),
    ],
)
def test_a_measurement_that_cannot_be_scored_is_refused(more, words):
    with pytest.raises(InputError, match="made up") as caught:
        measured(**more)
    assert words in str(caught.value)


@pytest.mark.usefixtures("blank_pictures")
def test_the_answer_has_its_tables_and_names_what_exceeds_a_limit(tmp_path):
    found = ev.evidence({"test/forces": measured()}, n=16, seed=1)
    text = repr(found)
    assert text.startswith("A law or model can miss ")
    for words in (
        "MaxwellStressInGap",
        "16 draws",
        "3 values: 3 printed",
        "no skill",
        "Null model 'a constant'",
    ):
        assert words in text
    assert "force.mean_gap" in str(page(found, "Cannot predict"))
    beyond = ev.evidence({"high": measured(scenario=step(1e3))}, n=2)
    assert "electrowetting" in {each.name for each in beyond.warned["high"]}
    assert "1 set-ups exceed a limit of validity" in repr(beyond)
    assert "661 V" in str(page(beyond, "Set-ups beyond a limit"))
    ev.save(found, tmp_path / "evidence")
    tables = {file.name for file in (tmp_path / "evidence").iterdir() if file.suffix != ".pdf"}
    assert tables == {"report.html", "laws.csv", "measurements.csv", "nulls.csv", "calibrated.csv"}
    assert ev.evidence({"test/forces": measured()}, n=16, seed=1).scores[0].score == found.scores[0].score
    with pytest.raises(InputError, match="Groups that measured: "):
        ev.measurements("no such word")


def test_what_lies_wholly_outside_is_counted_apart_from_what_lies_in_part_outside():
    """Values of 1 kN lie above every law; the first of three values that is inside makes it a part."""
    inside, none, part = (1e-3, 4e-3, 16e-3), (1e3, 4e3, 16e3), (1e-3, 4e3, 16e3)
    for values, said in (
        ((none,), "1 lie outside the interval of every candidate, 1 of them wholly."),
        ((part, inside), "1 lie outside the interval of every candidate, 0 of them wholly."),
        ((part, none, inside, none), "3 lie outside the interval of every candidate, 2 of them wholly."),
    ):
        found = ev.evidence({f"m{place}": measured(each) for place, each in enumerate(values)}, n=8)
        assert found.document.sentences[1].endswith(said)


def test_what_decides_is_covered_by_a_narrow_interval_while_another_law_misses():
    narrow, wide = [[1.0]] * 64, np.geomspace(1e-3, 1e3, 64)[:, None]
    right, wrong, vague = judged([1.0], narrow), judged([100.0], narrow), judged([1.0], wide)
    content = {
        "measured": {"m": measured()},
        "nulls": (right,),
        "refused": {},
        "warned": {},
        "n": 64,
        "seed": 0,
    }
    for scores, decides, nothing in (
        ((right, wrong), ["m"], []),
        ((vague, wrong), [], []),
        ((right, vague), [], ["m"]),
    ):
        found = Evidence(scores=scores, **content)
        assert (found.decides, found.decides_nothing) == (decides, nothing)
    assert Evidence(scores=(vague,), **content).can_be_missed == frozenset()
    assert Evidence(scores=(right,), **content).can_be_missed == right.numbers


def test_a_row_of_the_picture_says_who_measured_what_and_the_unit():
    part = measured(values=(0.5,), per="peak electrostatic_force", unit="1", over="", at=(), on="pad")
    drawing = ev.evidence({"forces": measured(), "left": part}, n=4).document.figures[0]
    figure = Figure()
    drawing.plot(figure)
    (ax,) = figure.axes
    assert "Maxwell stress in gap" in {each.get_text() for each in ax.get_legend().get_texts()}
    assert [each.called for each in (part, measured(source="doi:10.1/2, abstract"))] == [
        "this test",
        "nobody",
    ]
    assert [each.get_text() for each in ax.texts] == [
        *("this test, finger", "made up [N]"),
        *("this test, pad", "made up [ratio]"),
    ]


@pytest.mark.slow
def test_the_picture_shows_the_laws_of_a_set_of_three_groups_or_more():
    own = {"stack.gap": None, "force.mean_gap": {"model": "Uniform", "low": 1e-6, "high": 2e-6, "choice": "of this test"},
           "force.rms_gap": {"model": "Uniform", "low": 3e-7, "high": 5e-7, "choice": "of this test"}}  # fmt: skip
    rough = measured(of_model={"Persson2018RoughGap": own})
    (values,) = (each.values for each in predict(rough, n=4)[0] if each.model == "Persson2018RoughGap")
    rough = replace(rough, values=tuple(values[0]))  # which this law predicts best
    asked = {name: measured(group=name) for name in ("one", "two")}
    found = ev.evidence({"rough": rough, **asked}, n=4)
    assert [each.groups for each in found.comparisons] == [1, 3]
    assert found.comparisons[0].standings[0].model == "Persson2018RoughGap"
    assert "Persson2018RoughGap" not in found.document.figures[0].plot.keywords["models"]
    alone = ev.evidence({"rough": rough}, n=4).document.figures[0].plot.keywords["models"]
    assert alone[0] == "Persson2018RoughGap"
    assert _words("a constant times V^2") == "A constant times V^2"


def test_the_odds_of_two_sharp_laws_grow_as_the_repeats_and_the_square_of_their_distance():
    """Of two Gaussians of one width the expected logarithm of the odds is r (a - b)^2/(2 s^2), by hand."""
    sharp = np.stack([np.full((2, 1500), each) for each in (1e-2, 4e-2)], axis=1)
    for repeats in (1, 4):
        expected = 2 * repeats * (3e-2) ** 2 / (2 * 0.1**2)
        assert _worst(sharp, repeats, (0.0, 0.1)) == pytest.approx(expected, rel=0.15)
    assert _worst(sharp[:, [0, 0]], 64, (0.0, 0.1)) == pytest.approx(0.0, abs=1e-3)
    near = np.stack([np.full((1, 1500), each) for each in (2.0, 2.2)], axis=1)
    for noise in ((0.1, 0.0), (0.1, 1e-6)):  # relative alone, or a sensor that adds nothing
        assert _worst(near, 9, noise) == pytest.approx(9 * math.log(1.1) ** 2 / (2 * 0.1**2), rel=0.1)
    rng = np.random.default_rng(1)
    wide = np.exp(rng.normal(size=(2, 1, 400)))
    same = np.concatenate([wide, 1.3 * wide[::-1]], axis=1)[:1]
    assert _worst(same, 4096, (0.1, 1e-3)) < 0.2, (
        "what is not known hides a factor, however often one measures"
    )
    together = np.repeat(
        np.exp(rng.normal(size=(1, 1, 400))), 2, axis=0
    )  # a second point with a factor of its own tells
    shapes = np.concatenate([together, together * np.array([1.0, 3.0])[:, None, None]], axis=1)
    assert _worst(shapes, 64, (0.1, 1e-3)) > 3


RANGES = {
    "stack.gap.thickness": (5e-7, 1e-5),
    "stack.gap.material.conductivity": (1e-12, 1e-8),
    "stack.stratum_corneum.material.conductivity": (1.8e-7, 1.8e-5),
    "friction.coefficient": (0.3, 0.6),
}
FINGERS = {
    "space": {
        path: {"model": "LogUniform", "low": low, "high": high, "choice": "a range"}
        for path, (low, high) in RANGES.items()
    }
}
PULSES = {
    "drive.high": [500.0, 1000.0],
    "drive.rise": [1e-4, 1e-3, 1e-2, 1e-1, 1.0],
    "drive.hold": [0.01, 0.1],
}


def log_odds_of_twins(plan, experiment, repeats, *, n=192):
    """Simulate fingers with noise in every repeat, and judge each mean by fingers that are drawn anew.

    The mean of the logarithm of the odds for the true law is returned for that law for which it is smaller.
    """
    made, known = (
        {
            law: np.array(
                [
                    _values(
                        plan.scenario.replace({"force": {"model": law}, **point}),
                        FINGERS, plan.quantity, n=n, seed=seed,
                    )
                    for point in experiment.points
                ]
            )
            for law in plan.laws
        }
        for seed in (7, 8)
    )  # fmt: skip
    (relative, absolute), rng = plan.noise, np.random.default_rng(9)
    found = []
    for true, other in (plan.laws, plan.laws[::-1]):
        each = rng.standard_normal((*made[true].shape, repeats))
        mean = made[true] + np.hypot(relative * made[true], absolute) * np.mean(each, axis=-1)

        def log_density(law, mean=mean):
            values = known[law]
            places = np.arcsinh(values / absolute)
            between = stats.gaussian_kde(places).covariance
            widths = np.hypot(relative * values, absolute) / np.hypot(values, absolute) / math.sqrt(repeats)
            logs = [
                stats.multivariate_normal(place, between + np.diag(width**2)).logpdf(
                    np.arcsinh(mean / absolute).T
                )
                for place, width in zip(places.T, widths.T, strict=True)
            ]
            return logsumexp(logs, axis=0)

        found.append(np.mean(log_density(true) - log_density(other)))
    return min(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    "laws",
    [
        ("Vezzoli2014Causal", "MaxwellStressInGap"),
        ("EffectiveMedium", "MaxwellStressInGap"),
        ("MaxwellStressInInsulator", "MaxwellStressInGap"),
    ],
)
def test_a_planned_experiment_needs_a_fifth_of_the_repeats_of_the_founding_pulse(laws):
    """A friction of 0.25 N that fluctuates by 20 mN; the twins are other fingers, and judged by a second route."""
    found = plan_experiment("vezzoli_2014/fig6_gap", laws, over=PULSES, space=FINGERS, noise=(0.1, 20e-3))
    assert found.own.repeats >= 5 * found.best.repeats
    least = int(found.best.repeats) // len(found.best.points)
    assert log_odds_of_twins(found, found.best, least) > 0.9 * math.log(ODDS)
    assert log_odds_of_twins(found, found.own, 5 * int(found.best.repeats)) < math.log(ODDS) - 1


def test_a_plan_names_points_repeats_and_what_a_limit_forbids():
    space = {"space": {"stack.gap.thickness": GAP}}
    content = {
        "over": {"drive.high": [100.0, 300.0, 1e4]},
        "space": space,
        "quantity": "peak electrostatic_force",
        "noise": (0.1, 1e-3),
        "n": 16,
    }
    pulse = "vezzoli_2014/fig6_gap"
    found = plan_experiment(
        pulse,
        ["MaxwellStressInGap", "MaxwellStressInStratumCorneum"],
        set={"limits.voltage": 1000.0},
        **content,
    )
    assert found.left_out == {"drive.high = 10000": "a limit forbids it"}
    text = repr(found)
    for words in ("Measure at drive.high", "the scenario as it stands", "odds of 20", "10 %"):
        assert words in text
    sensor_alone = plan_experiment(pulse, found.laws, **content | {"noise": (0.0, 1e-3)})
    assert sensor_alone.own.log_odds[-1] >= found.own.log_odds[-1]
    again = plan_experiment(
        pulse, found.laws, **content | {"over": ["drive.high=100V:300V:2"], "noise": ("10 %", "1 mN")}
    )
    np.testing.assert_array_equal(again.own.log_odds, found.own.log_odds)
    for wrong, words in (
        ({"noise": ("ten", 0.0)}, "such as '10 %, 20 mN'"),
        ({"noise": (0.0, 0.0)}, "one of them above 0"),
        ({"models": ["MaxwellStressInGap"]}, "two different"),
        ({"models": ["MaxwellStressInGap", "EffectiveMediums"]}, "Did you mean 'EffectiveMedium'"),
        ({"over": {"drive.high": list(range(1, 300))}}, "299 points"),
    ):
        asked = {"models": ["MaxwellStressInGap", "EffectiveMedium"], **content} | wrong
        with pytest.raises(InputError, match=re.escape(words)):
            plan_experiment(pulse, **asked)


def test_a_measurement_fails_only_if_no_candidate_covers_it():
    """A wide law that covers is no failure of all, although a sharp one that does not cover has the better score."""
    sharp, wide = judged([1.0], [[1.25]] * 64), judged([1.0], np.geomspace(1e-3, 1e3, 64)[:, None])
    assert (sharp.covered, wide.covered) == (0, 1)
    assert sharp.score > wide.score
    content = {
        "measured": {"m": measured()},
        "nulls": (sharp,),
        "refused": {},
        "warned": {},
        "n": 64,
        "seed": 0,
    }
    covered, missed = (Evidence(scores=scores, **content) for scores in ((sharp, wide), (sharp,)))
    assert (covered.failures, list(covered.document.tables)) == ([], [])
    assert (missed.failures, len(missed.document.tables)) == ([sharp], 1)


def test_each_group_states_its_worst_failure_with_the_likely_cause():
    worse, bad = (
        replace(judged([1.0], [[ratio]] * 64), measurement=name)
        for ratio, name in ((9.0, "worse"), (4.0, "bad"))
    )
    other = replace(judged([1.0], [[5.0]] * 64), measurement="other")
    nulls = tuple(replace(score, model="null") for score in (bad, other, worse))
    content = {"nulls": nulls, "refused": {}, "warned": {}, "n": 64, "seed": 0}
    each = {
        "bad": measured(cause="Likely cause: the gap. A smaller one would decide."),
        "other": measured(group="another"),
        "worse": measured(cause="Likely cause: the gap. A smaller one would decide."),
    }
    found = Evidence(measured=each, scores=(bad, other, worse), **content)
    said = found.document.sentences
    assert [text.partition(" ")[0] for text in said[3:-1]] == ["worse", "other"]
    assert said[3].endswith("covers 0 % of its 3 values. Likely cause: the gap. A smaller one would decide.")
    causes = page(found, "Why no law or model reaches them")
    assert causes.rows == (("worse, bad", "the gap. A smaller one would decide."), ("other", "not known"))


@pytest.mark.parametrize(
    ("over", "at"),
    [("drive.frequency", (50.0, 200.0, 50.0)), ("stack.insulator.thickness", (2e-5, 9e-5, 5e-5))],
)
def test_every_point_of_a_measurement_is_what_its_scenario_gives(over, at):
    """Where all points are computed together, and where one comes after the other because their times differ."""
    sine = step().replace(
        {
            "drive": {"model": "Sine", "amplitude": 100.0, "frequency": 100.0},
            "time.initial_state": {"model": "PeriodicState"},
        }
    )
    several = measured(
        scenario=sine,
        quantity="mean electrostatic_force",
        over=over,
        at=at,
        values=(1.0,) * 3,
        per="peak drive_voltage",
        scale=3.0,
    )
    (found,) = (each for each in predict(several, n=33, seed=4)[0] if each.model == "MaxwellStressInGap")
    draws = ev.read_space(sine, {"space": {"stack.gap.thickness": GAP}}).draw(4, 0, 33)["stack.gap.thickness"]
    for place in (0, 1, 2):
        for draw in (0, 32):
            changes = {
                over: at[place],
                "stack.gap.thickness": float(draws[draw]),
                "force": {"model": "MaxwellStressInGap"},
            }
            names = ["mean electrostatic_force", "peak drive_voltage"]
            force = ev.prepare(sine.replace(changes), free=[over], quantity=names)({over: at[place]})
            expected = 3.0 * force["mean electrostatic_force"] / force["peak drive_voltage"]
            assert found.values[draw, place] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(("value", "shown"), [(163.2, "160"), (0.0423, "0.042"), (26.0, "26"), (1.0, "1")])
def test_ratios_are_written_without_powers_of_ten(value, shown):
    assert _rounded(value) == shown


@pytest.mark.parametrize(
    ("name", "model"),
    [
        ("plutchik_1963/phase", "palmar_1995/dry_men"),
        ("rosell_1988/palm", "gabriel_1996/wet"),
        ("rauf_2025/capacitance_2mm", "BearingArea"),
        ("rauf_2025/capacitance_2mm", "PerssonSurface"),
        ("rauf_2025/capacitance_2mm", "LinearSpring"),
    ],
)
def test_a_function_of_columns_gives_what_it_gives_for_each_row_alone(name, model, monkeypatch):
    measured = ev.measurements(name)[name]
    content = candidates(measured)[model]
    together = prediction(measured, model, content, n=6, seed=2)
    calls = []
    known = predicted._of_function
    monkeypatch.setattr(predicted, "_of_function", lambda *given: calls.append(1) or known(*given))
    prediction(measured, model, content, n=6, seed=2)
    assert len(calls) == 2  # the first and the last row, which are compared
    monkeypatch.setattr(predicted, "_in_columns", lambda *_: None)
    alone = prediction(measured, model, content, n=6, seed=2)
    for one, other in ((together.values, alone.values), (together.narrow, alone.narrow)):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def test_a_function_that_is_wrong_on_columns_or_declares_none_is_called_row_by_row():
    def gap(scenario):
        return 1.0 / scenario.stack.layers["gap"].thickness

    @takes_columns
    def first(scenario):
        return np.ravel(gap(scenario))[0]  # of all rows that of the first

    @takes_columns
    def fails(scenario):
        return float(gap(scenario))

    expected = predict(measured(quantity=gap, unit="1/m"), n=5)[0][0].values
    assert len(np.unique(expected)) == 5
    for function in (first, fails):
        found = predict(measured(quantity=function, unit="1/m"), n=5)[0][0].values
        np.testing.assert_array_equal(found, expected)
