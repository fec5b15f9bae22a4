"""A prediction against what was measured: ratio, coverage, log score, and the score of the shape alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.arrays import Real

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from electrovib.studies.evidence.measurement import Measurement
    from electrovib.studies.evidence.predicted import ModelPrediction

LEVEL: Final = 0.9
"""Probability of the predictive intervals."""
DECADE: Final = math.log(10)
SURPRISE: Final = 0.01
"""Probability that is left to a Cauchy distribution of one decade around each draw, so that no score is without bound."""
IGNORANT: Final = -math.log(12 * DECADE)
"""Log score of a prediction that knows nothing within twelve decades, which every useful law exceeds."""


_NOTHING: Final = 1e-300
"""What a prediction of 0 or less counts as."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """A candidate on one measurement.

    - `measurement`, `model`, `group`: names.
    - `ratio`: median of predicted over measured over draws and points; `low`, `high`: ends of its 90 % interval.
    - `covered`: share of the points that lie in the 90 % interval of the prediction with the spread of the measurement.
    - `score`: mean over the points of the logarithm of the predictive density of the logarithm of the value.
    - `shape`: the same with one common factor left free in every draw; NaN for a single point.
    - `band`: 5, 50 and 95 % of the prediction without the spread of the measurement (3, points).
    """

    measurement: str
    model: str
    group: str
    ratio: float
    low: float
    high: float
    covered: float
    score: float
    shape: float
    band: Real


def judge(name: str, measured: Measurement, found: ModelPrediction) -> Score:
    """Score a prediction. A value that a law predicts as 0 or less is one that it rules out."""
    logs = np.log(np.maximum(found.values, _NOTHING))
    log_values = np.log(np.array(measured.values))
    widths = np.sqrt(np.log1p(np.array(measured.spread) ** 2))
    off = logs - log_values
    ends = [(1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2]
    ratios = np.exp(np.quantile(off, ends, method="inverted_cdf"))
    low, high = np.quantile(_with_spread(off, widths), [ends[0], ends[-1]], axis=0)
    return Score(
        measurement=name,
        model=found.model,
        group=measured.group,
        ratio=float(ratios[1]),
        low=float(ratios[0]),
        high=float(ratios[2]),
        covered=float(np.mean((low <= 0) & (high >= 0))),
        score=_log_score(off, widths),
        shape=_log_score(*_shape(off, widths)) if log_values.size > 1 else math.nan,
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


def _log_score(off: Real, widths: Real) -> float:
    """Average the logarithm of the density over the points; kernels are at least as wide as the draws are apart (Scott)."""
    widths = np.sqrt(widths**2 + np.var(off, axis=0) * len(off) ** -0.4)
    densities = np.exp(-0.5 * (off / widths) ** 2) / (widths * math.sqrt(2 * math.pi))
    tails = 1 / (math.pi * DECADE * (1 + (off / DECADE) ** 2))
    return float(np.mean(np.log(np.mean((1 - SURPRISE) * densities + SURPRISE * tails, axis=0))))


ODDS: Final = 20.0
"""Odds at which one law counts as told apart from another; further evidence against the same rival adds nothing."""


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A candidate over all measurements that it can predict: every group counts once, whatever it has published.

    `groups` and `points` are their numbers; `ratio` is the geometric mean of the median ratios, `off` the typical factor
    by which a group's ratio deviates from 1. `odds` is the geometric mean of the odds for it against each rival, at least
    1/`ODDS` and at most `ODDS`, on the measurements that both predict, and `beaten_by` names the rivals with the odds
    `ODDS` against it: both are comparable between candidates that predict different measurements.
    """

    model: str
    groups: int
    points: int
    ratio: float
    off: float
    covered: float
    odds: float
    beaten_by: tuple[str, ...]
    score: float
    shape: float


def standings(scores: Iterable[Score]) -> list[Standing]:
    """Average the scores of every candidate over its groups; the one with the best odds against its rivals first."""
    by_model: dict[str, dict[str, Score]] = {}
    for each in scores:
        by_model.setdefault(each.model, {})[each.measurement] = each
    found = [_standing(model, by_model) for model in by_model]
    return sorted(found, key=lambda each: (-each.odds, -each.groups, each.model))


def log_odds(one: Mapping[str, Score], other: Mapping[str, Score]) -> float:
    """Return the logarithm of the odds for one candidate: the score differences of groups, each a mean, in all."""
    of_group: dict[str, list[float]] = {}
    for name in one.keys() & other.keys():
        of_group.setdefault(one[name].group, []).append(one[name].score - other[name].score)
    return math.fsum(math.fsum(each) / len(each) for each in of_group.values())


def _standing(model: str, by_model: Mapping[str, Mapping[str, Score]]) -> Standing:
    own, most = by_model[model], math.log(ODDS)
    groups: dict[str, list[Score]] = {}
    for each in own.values():
        groups.setdefault(each.group, []).append(each)

    def over_groups(number: Callable[[Score], float]) -> float:
        known = [
            [value for each in group if math.isfinite(value := number(each))] for group in groups.values()
        ]
        means = [math.fsum(values) / len(values) for values in known if values]
        return math.fsum(means) / len(means) if means else math.nan

    def log_ratio(each: Score) -> float:
        return math.log(max(each.ratio, _NOTHING))

    against = {rival: log_odds(own, scores) for rival, scores in by_model.items() if rival != model}
    held = [min(max(each, -most), most) for each in against.values()]
    return Standing(
        model=model,
        groups=len(groups),
        points=sum(each.band.shape[1] for each in own.values()),
        ratio=math.exp(over_groups(log_ratio)),
        off=math.exp(over_groups(lambda each: abs(log_ratio(each)))),
        covered=over_groups(lambda each: each.covered),
        odds=math.exp(math.fsum(held) / len(held)) if held else 1.0,
        beaten_by=tuple(sorted(rival for rival, each in against.items() if each <= -most)),
        score=over_groups(lambda each: each.score),
        shape=over_groups(lambda each: each.shape),
    )
