"""A prediction against what was measured: ratio, coverage, width, log score, and the score of the shape alone."""

from __future__ import annotations

import math
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
IGNORANT: Final = -math.log(12 * DECADE)
"""Log score of a prediction that knows nothing within twelve decades, which every useful law exceeds."""


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
