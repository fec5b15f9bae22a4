"""Numbers with a 95 % interval, of one edge and as a mean over edges."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

_LEVEL = 0.975


@dataclass(frozen=True, kw_only=True)
class Interval:
    """A number with its 95 % interval; `scatter` is the standard deviation between edges; what there is none of is NaN."""

    value: float
    lower: float
    upper: float
    standard_error: float
    scatter: float = math.nan
    count: int = 1
    method: str

    def to_dict(self) -> dict[str, float | int | str]:
        """Return plain numbers for tables."""
        return asdict(self)


def from_noise(value: float, standard_error: float, *, freedom: float = math.inf) -> Interval:
    """Make the interval of a number of one edge by Student's t; without ends if the standard error is not finite."""
    from scipy.stats import t

    if not math.isfinite(standard_error):
        return none(value, "the samples do not determine it")
    half = float(t.ppf(_LEVEL, min(freedom, 1e9))) * standard_error
    return Interval(
        value=value, lower=value - half, upper=value + half, standard_error=standard_error,
        method="noise of one edge",
    )  # fmt: skip


def none(value: float, why: str) -> Interval:
    """Make a number without an interval."""
    return Interval(value=value, lower=math.nan, upper=math.nan, standard_error=math.nan, method=why)


def over_edges(each: Sequence[Interval], *, of: str = "edge") -> Interval:
    """Compute the mean of a number over edges, by Student's t over the edges; one edge keeps its own interval."""
    from scipy.stats import t

    if len(each) == 1:
        return each[0]
    values = np.array([one.value for one in each])
    mean, scatter = float(values.mean()), float(values.std(ddof=1))
    error = scatter / math.sqrt(len(each))
    half = float(t.ppf(_LEVEL, len(each) - 1)) * error
    return Interval(
        value=mean, lower=mean - half, upper=mean + half, standard_error=error, scatter=scatter, count=len(each),
        method=f"Student's t over {len(each)} {of}s",
    )  # fmt: skip
