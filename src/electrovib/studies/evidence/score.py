"""A prediction against what was measured: ratio, coverage, log score, and the score of the shape alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.arrays import Real

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

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


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A candidate over all measurements that it can predict: every group counts once, whatever it has published.

    `groups` and `points` are their numbers; `ratio` is the geometric mean of the median ratios, `off` the typical factor
    by which a group's ratio deviates from 1; `behind` is the mean distance of its score from the best one of the same
    measurement, which alone is comparable between candidates that predict different measurements.
    """

    model: str
    groups: int
    points: int
    ratio: float
    off: float
    covered: float
    behind: float
    score: float
    shape: float


def standings(scores: Iterable[Score]) -> list[Standing]:
    """Average the scores of every candidate over its groups; the one least behind the best of each measurement first."""
    listed = list(scores)
    best: dict[str, float] = {}
    by_model: dict[str, dict[str, list[Score]]] = {}
    for each in listed:
        best[each.measurement] = max(each.score, best.get(each.measurement, -math.inf))
        by_model.setdefault(each.model, {}).setdefault(each.group, []).append(each)
    found = [_standing(model, list(groups.values()), best) for model, groups in by_model.items()]
    return sorted(found, key=lambda each: (each.behind, -each.groups, each.model))


def _standing(model: str, groups: Sequence[Sequence[Score]], best: Mapping[str, float]) -> Standing:
    def over_groups(number: Callable[[Score], float]) -> float:
        known = [[value for each in group if math.isfinite(value := number(each))] for group in groups]
        means = [math.fsum(values) / len(values) for values in known if values]
        return math.fsum(means) / len(means) if means else math.nan

    def log_ratio(each: Score) -> float:
        return math.log(max(each.ratio, _NOTHING))

    return Standing(
        model=model,
        groups=len(groups),
        points=sum(each.band.shape[1] for group in groups for each in group),
        ratio=math.exp(over_groups(log_ratio)),
        off=math.exp(over_groups(lambda each: abs(log_ratio(each)))),
        covered=over_groups(lambda each: each.covered),
        behind=over_groups(lambda each: best[each.measurement] - each.score),
        score=over_groups(lambda each: each.score),
        shape=over_groups(lambda each: each.shape),
    )
