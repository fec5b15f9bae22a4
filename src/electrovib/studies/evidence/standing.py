"""A prediction scored against what was measured, and candidates on what all of them predict: skill over the best null model."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.studies.evidence.measurement import AT_MOST, numbers_of

if TYPE_CHECKING:
    from electrovib.studies.evidence.measurement import Measurement
    from electrovib.studies.evidence.predicted import ModelPrediction

LEVEL: Final = 0.9
"""Probability of the predictive intervals."""
DECADE: Final = math.log(10)
SURPRISE: Final = 0.01
"""Probability that is left to a Cauchy distribution of one decade around each draw, so that no score is without bound."""
NOTHING: Final = 1e-300
"""What a prediction of 0 or less counts as."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """A candidate on one measurement.

    - `measurement`, `model`, `group`: names; `numbers`: what counts as one number each, as `numbers_of` has it.
    - `ratio`: median of predicted over measured over draws and points; `low`, `high`: ends of its 90 % interval.
    - `covered`: share of the points that lie in the 90 % interval of the prediction with the spread of the measurement; of
      bounds, which this interval reaches.
    - `width`: of this interval without the spread, in decades, median over the points.
    - `score`: mean over the points of the logarithm of the predictive density of the logarithm of the value; of bounds, of
      the probability to keep them. `narrow`, `wide`: the same with ranges of half and twice the width, NaN where they are
      not known.
    - `shape`: the score with one common factor left free in every draw; NaN for a single point, and for bounds.
    - `band`: 5, 50 and 95 % of the prediction without the spread of the measurement (3, points).
    """

    measurement: str
    model: str
    group: str
    numbers: frozenset[tuple[str, ...]]
    ratio: float
    low: float
    high: float
    covered: float
    width: float
    score: float
    narrow: float
    wide: float
    shape: float
    band: Real


def judge(name: str, measured: Measurement, found: ModelPrediction) -> Score:
    """Score a prediction. A value that a law predicts as 0 or less is one that it rules out."""
    log_values = np.log(np.array(measured.values))
    widths = np.sqrt(np.log1p(np.array(measured.spread) ** 2))
    ends = [(1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2]

    def off_by(values: Real) -> Real:
        found: Real = np.log(np.maximum(values, NOTHING)) - log_values
        return found

    def scored(values: Real | None) -> float:
        return math.nan if values is None else _log_score(off_by(values), widths, measured.bound)

    off = off_by(found.values)
    quantiles = np.quantile(off, ends, axis=0)
    ratios = np.exp(np.quantile(off, ends, method="inverted_cdf"))
    low, high = np.quantile(_with_spread(off, widths), [ends[0], ends[-1]], axis=0)
    inside = {"": (low <= 0) & (high >= 0), AT_MOST: low <= 0}.get(measured.bound, high >= 0)
    has_shape = log_values.size > 1 and not measured.bound
    return Score(
        measurement=name,
        model=found.model,
        group=measured.group,
        numbers=numbers_of(name, measured),
        ratio=float(ratios[1]),
        low=float(ratios[0]),
        high=float(ratios[2]),
        covered=float(np.mean(inside)),
        width=float(np.median(quantiles[-1] - quantiles[0])) / DECADE,
        score=_log_score(off, widths, measured.bound),
        narrow=scored(found.narrow),
        wide=scored(found.wide),
        shape=_log_score(*_shape(off, widths)) if has_shape else math.nan,
        band=np.quantile(found.values, ends, axis=0),
    )


def _with_spread(off: Real, widths: Real) -> Real:
    """Add to every draw a deviation of the measurement; the same ones each time, evenly spaced in probability."""
    from scipy.special import ndtri

    count = len(off)
    steps = ndtri((np.arange(count) + 0.5) / count)
    order = np.random.default_rng(0).permuted(np.tile(steps[:, None], (1, off.shape[1])), axis=0)
    spread: Real = off + widths * order
    return spread


def _shape(off: Real, widths: Real) -> tuple[Real, Real]:
    """Remove from every draw its mean deviation; what is left varies less, by the weight of each point in the mean."""
    weights = widths**-2 / np.sum(widths**-2)
    return off - (off @ weights)[:, None], widths * np.sqrt(1 - weights)


def _log_score(off: Real, widths: Real, bound: str = "") -> float:
    """Average the logarithm of the density, of bounds that of the probability, over the points.

    Kernels are at least as wide as the draws are apart (Scott).
    """
    widths = np.sqrt(widths**2 + np.var(off, axis=0) * len(off) ** -0.4)
    if bound:
        from scipy.special import ndtr

        inside = -off if bound == AT_MOST else off
        likely, surprising = ndtr(inside / widths), 0.5 + np.arctan(inside / DECADE) / math.pi
    else:
        likely = np.exp(-0.5 * (off / widths) ** 2) / (widths * math.sqrt(2 * math.pi))
        surprising = 1 / (math.pi * DECADE * (1 + (off / DECADE) ** 2))
    return float(np.mean(np.log(np.mean((1 - SURPRISE) * likely + SURPRISE * surprising, axis=0))))


FEW = 3
"""Groups of the common set that is shown first, at least, where there is such a set."""
NARROW = 1.0
"""Width of an interval in decades, below which a law can miss a number."""
Number = Callable[[Score], float]


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A candidate on a common set of measurements: every group counts once, whatever it has published.

    - `model`; `can_miss`: numbers for which its interval spans less than a decade; `width`: median width in decades.
    - `ratio`: geometric mean of the median ratios; `off`: typical factor by which a group's ratio deviates from 1.
    - `score`, `skill`: mean score, and what it is above that of the best null model; `low`, `high`: the 90 % interval of the
      skill by the jackknife over groups, NaN for a single one.
    - `least`, `most`: the skill with one group less; `first`, `last`: its rank there, of all candidates.
    - `narrow`, `wide`: the skill with ranges of half and twice the width.
    """

    model: str
    can_miss: int
    covered: float
    width: float
    ratio: float
    off: float
    score: float
    skill: float
    low: float
    high: float
    least: float
    most: float
    first: int
    last: int
    narrow: float
    wide: float
    shape: float

    @property
    def has_skill(self) -> bool:
        """Whether the interval of the skill lies above 0."""
        return self.low > 0


@dataclass(frozen=True, kw_only=True)
class CommonSet:
    """Candidates for one place on the measurements that all of them predict, the best first, and the best null model."""

    place: str
    names: tuple[str, ...]
    numbers: int
    groups: int
    null: str
    standings: tuple[Standing, ...]


def shown_first(sets: Sequence[CommonSet]) -> CommonSet:
    """Return the common set with the most candidates among those of `FEW` groups or more, or else among all."""
    return next((each for each in sets if each.groups >= FEW), sets[0])


def over_groups(scores: Iterable[Score], number: Number) -> dict[str, float]:
    """Average a figure over what counts as one number, and then over these, for each group."""
    found: dict[str, dict[frozenset[tuple[str, ...]], list[float]]] = {}
    for each in scores:
        if math.isfinite(value := number(each)):
            found.setdefault(each.group, {}).setdefault(each.numbers, []).append(value)
    return {group: _mean([_mean(each) for each in parts.values()]) for group, parts in found.items()}


def typical_factor(scores: Iterable[Score]) -> float:
    """Return the typical factor by which the median ratio of a group deviates from 1."""
    return math.exp(_mean(list(over_groups(scores, lambda each: abs(_log_ratio(each))).values())))


def comparisons(place: str, scores: Sequence[Score], nulls: Sequence[Score]) -> Iterator[CommonSet]:
    """Compare the candidates of one place on each set of measurements that all of them predict, the most candidates first."""
    by_model: dict[str, dict[str, Score]] = {}
    of: dict[str, set[str]] = {}
    for each in scores:
        by_model.setdefault(each.model, {})[each.measurement] = each
        of.setdefault(each.measurement, set()).add(each.model)
    for models in sorted(
        {frozenset(each) for each in of.values()}, key=lambda each: (-len(each), sorted(each))
    ):
        names = tuple(name for name, each in of.items() if models <= each)
        null: dict[str, dict[str, Score]] = {}
        for each in nulls:
            if each.measurement in names:
                null.setdefault(each.model, {})[each.measurement] = each
        own = {model: [by_model[model][name] for name in names] for model in sorted(models)}
        yield _comparison(place, names, own, {model: list(each.values()) for model, each in null.items()})


def _comparison(
    place: str,
    names: tuple[str, ...],
    own: Mapping[str, list[Score]],
    nulls: Mapping[str, list[Score]],
) -> CommonSet:
    any_scores = next(iter(own.values()))
    groups = sorted({each.group for each in any_scores})
    (best, skills), (_, narrow), (_, wide) = (
        _skills(own, nulls, groups, operator.attrgetter(name)) for name in ("score", "narrow", "wide")
    )
    fewer = [[each for each in groups if each != out] for out in groups if len(groups) > 1]
    without = [_skills(own, nulls, each, operator.attrgetter("score"))[1] for each in fewer]
    found = []
    for model, scores in own.items():
        left = np.array([each[model] for each in without])
        places = [1 + sum(other > each[model] for other in each.values()) for each in without or [skills]]
        low, high = _jackknife(skills[model], left)
        means = {
            name: _mean_over_groups(scores, operator.attrgetter(name))
            for name in ("covered", "score", "shape")
        }
        found.append(
            Standing(
                model=model,
                can_miss=len({key for each in scores if each.width < NARROW for key in each.numbers}),
                width=float(np.median([each.width for each in scores])),
                ratio=math.exp(_mean_over_groups(scores, _log_ratio)),
                off=typical_factor(scores),
                skill=skills[model],
                low=low,
                high=high,
                least=min(left.tolist(), default=math.nan),
                most=max(left.tolist(), default=math.nan),
                first=min(places),
                last=max(places),
                narrow=narrow[model],
                wide=wide[model],
                **means,
            )
        )
    return CommonSet(
        place=place,
        names=names,
        numbers=len({key for each in any_scores for key in each.numbers}),
        groups=len(groups),
        null=best,
        standings=tuple(sorted(found, key=lambda each: (-each.skill, each.model))),
    )


def _skills(
    own: Mapping[str, list[Score]],
    nulls: Mapping[str, list[Score]],
    groups: Sequence[str],
    number: Number,
) -> tuple[str, dict[str, float]]:
    """Return the best null model on some groups, and what the score of each candidate is above its."""

    def means(of: Mapping[str, list[Score]]) -> dict[str, float]:
        return {
            model: _mean_over_groups([each for each in scores if each.group in groups], number)
            for model, scores in of.items()
        }

    null = means(nulls)
    best = max(null, key=lambda name: null[name])
    return best, {model: each - null[best] for model, each in means(own).items()}


def _jackknife(skill: float, without: Real) -> tuple[float, float]:
    """Return the interval of a skill from those with one group less, by Student's t with one degree less than groups."""
    from scipy.stats import t

    count = len(without)
    if count < 2:
        return math.nan, math.nan
    error = math.sqrt((count - 1) / count * float(np.sum((without - without.mean()) ** 2)))
    half = float(t.ppf((1 + LEVEL) / 2, count - 1)) * error
    return skill - half, skill + half


def _mean_over_groups(scores: Iterable[Score], number: Number) -> float:
    return _mean(list(over_groups(scores, number).values()))


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values) if values else math.nan


def _log_ratio(each: Score) -> float:
    return math.log(max(each.ratio, 1e-300))


def several(count: int, what: str) -> str:
    """Write a count with its word: ``1 group``, ``2 groups``."""
    return f"{count} {what}{'s' if count != 1 else ''}"
