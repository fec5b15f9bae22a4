"""Candidates on the measurements that all of them predict: skill over the best null model, without any one group."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from electrovib.core.arrays import Real
from electrovib.studies.evidence.score import LEVEL, Score

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
    best, skills = _skills(own, nulls, groups, lambda each: each.score)
    ranks = {model: 1 + sum(other > skill for other in skills.values()) for model, skill in skills.items()}
    fewer = [[each for each in groups if each != out] for out in groups if len(groups) > 1]
    without = [_skills(own, nulls, each, lambda one: one.score)[1] for each in fewer]
    narrow, wide = (
        _skills(own, nulls, groups, number)[1]
        for number in (lambda each: each.narrow, lambda each: each.wide)
    )
    found = []
    for model, scores in own.items():
        left = np.array([each[model] for each in without])
        places = [1 + sum(other > each[model] for other in each.values()) for each in without]
        low, high = _jackknife(skills[model], left)
        found.append(
            Standing(
                model=model,
                can_miss=len({key for each in scores if each.width < NARROW for key in each.numbers}),
                covered=_mean_over_groups(scores, lambda each: each.covered),
                width=float(np.median([each.width for each in scores])),
                ratio=math.exp(_mean_over_groups(scores, _log_ratio)),
                off=typical_factor(scores),
                score=_mean_over_groups(scores, lambda each: each.score),
                skill=skills[model],
                low=low,
                high=high,
                least=float(left.min()) if left.size else math.nan,
                most=float(left.max()) if left.size else math.nan,
                first=min(places, default=ranks[model]),
                last=max(places, default=ranks[model]),
                narrow=narrow[model],
                wide=wide[model],
                shape=_mean_over_groups(scores, lambda each: each.shape),
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
