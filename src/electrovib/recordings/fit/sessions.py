"""How a parameter differs between sessions: variance within and between them, and the interval of the mean."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.units import format_quantity
from electrovib.recordings.fit.random_effects import random_effects

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.fit.estimate import LeastSquaresEstimate


@dataclass(frozen=True, kw_only=True)
class BetweenSessions:
    """One parameter over several sessions, or over recordings that were fitted separately, as `group` says.

    - `within`: standard deviation of the estimate of one session by its own noise, root mean square over the
      sessions.
    - `between`: standard deviation between sessions, beyond what the noise of each explains; 0 if that
      explains it. Its 95 % interval is NaN where the noise of fewer than two sessions is known.
    - `standard_error`: of the mean, from the scatter of the sessions.
    """

    values: Mapping[str, float]
    mean: float
    within: float
    between: float
    between_lower: float
    between_upper: float
    standard_error: float
    group: str = "session"

    def interval(self, *, level: float = 0.95) -> tuple[float, float]:
        """Interval of the mean over sessions, by Student's t with one degree of freedom less than sessions."""
        from scipy.stats import t

        half = float(t.ppf(0.5 + level / 2, len(self.values) - 1)) * self.standard_error
        return self.mean - half, self.mean + half

    def in_words(self, unit: str) -> str:
        """State both scatters with their unit, and which of them limits the mean."""
        ratio = self.between / self.within if self.within else math.inf
        within, between, lower, upper = (
            format_quantity(each, unit, digits=3)
            for each in (self.within, self.between, self.between_lower, self.between_upper)
        )
        one = self.group
        interval = f" (95 % interval {lower} to {upper})" if math.isfinite(self.between_upper) else ""
        return f"scatter within a {one} {within}, between {one}s {between}{interval}" + (
            f": {ratio:.2g} times as much, so that an interval from one {one} would be too narrow"
            if ratio > 1
            else ""
        )


def between_sessions(estimate: LeastSquaresEstimate, names: Mapping[str, str]) -> BetweenSessions:
    """Summarise the estimates of one parameter in several sessions.

    In the mean the sessions count alike: their scatter has the variance between them plus that within,
    whatever the sizes, so that Student's t holds for the mean when the sessions are alike in size.
    """
    deviations = estimate.standard_deviations
    return spread_of(
        {session: estimate.values[name] for session, name in names.items()},
        [deviations[name] for name in names.values()],
    )


def spread_of(
    values: Mapping[str, float], deviations: Sequence[float], *, group: str = "session"
) -> BetweenSessions:
    """Summarise at least two separate estimates of one parameter, with the spread between them of `random_effects`."""
    found = np.array(list(values.values()))
    scatter = float(np.var(found, ddof=1))
    within = float(np.sqrt(np.mean(np.square(deviations))))
    known = [
        (value, each) for value, each in zip(found.tolist(), deviations, strict=True) if math.isfinite(each)
    ]
    spread = random_effects(*zip(*known, strict=True)) if len(known) > 1 else None
    return BetweenSessions(
        values=dict(values),
        mean=float(np.mean(found)),
        within=within,
        between=math.sqrt(scatter) if spread is None else spread.between,
        between_lower=math.nan if spread is None else spread.between_lower,
        between_upper=math.nan if spread is None else spread.between_upper,
        standard_error=math.sqrt(scatter / found.size),
        group=group,
    )
