"""How a parameter differs between sessions: variance within and between them, and the interval of the mean."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from electrovib.recordings.fit.estimate import LeastSquaresEstimate


@dataclass(frozen=True, kw_only=True)
class BetweenSessions:
    """One parameter over several sessions.

    Parameters
    ----------
    values : mapping of str to float
        LeastSquaresEstimate of each session, in the parameter's unit.
    mean : float
        Of the sessions.
    within : float
        Standard deviation of the estimate of one session by its own noise, root mean square over the sessions.
    between : float
        Standard deviation of the parameter between sessions, beyond what the noise within them explains; 0 if that
        explains it.
    standard_error : float
        Of the mean, from the scatter of the sessions.
    """

    values: Mapping[str, float]
    mean: float
    within: float
    between: float
    standard_error: float

    def interval(self, *, level: float = 0.95) -> tuple[float, float]:
        """Interval of the mean over sessions, by Student's t with one degree of freedom less than sessions.

        Parameters
        ----------
        level : float
            Probability, between 0 and 1.

        Returns
        -------
        lower : float
            In the parameter's unit.
        upper : float
            Likewise.
        """
        from scipy.stats import t

        half = float(t.ppf(0.5 + level / 2, len(self.values) - 1)) * self.standard_error
        return self.mean - half, self.mean + half

    @property
    def sentence(self) -> str:
        """Both scatters, and which of them counts."""
        ratio = self.between / self.within if self.within else math.inf
        return f"scatter within a session {self.within:.3g}, between sessions {self.between:.3g}" + (
            f": {ratio:.2g} times as much, so that an interval from one session would be too narrow"
            if ratio > 1
            else ""
        )


def between_sessions(estimate: LeastSquaresEstimate, names: Mapping[str, str]) -> BetweenSessions:
    """Summarise the estimates of one parameter in several sessions.

    Parameters
    ----------
    estimate : LeastSquaresEstimate
        Of all unknowns.
    names : mapping of str to str
        Session to the name of the unknown.

    Returns
    -------
    BetweenSessions
        With a variance between sessions by the method of moments, not below 0.

    Notes
    -----
    The sessions count alike: their scatter has the variance between them plus that within, whatever the sizes, so that
    Student's t holds for the mean when the sessions are alike in size.
    """
    found = np.array([estimate.values[name] for name in names.values()])
    deviations = np.array([estimate.standard_deviations[name] for name in names.values()])
    scatter = float(np.var(found, ddof=1))
    within = float(np.sqrt(np.mean(deviations**2)))
    return BetweenSessions(
        values={session: estimate.values[name] for session, name in names.items()},
        mean=float(np.mean(found)),
        within=within,
        between=math.sqrt(max(scatter - within**2, 0.0)) if math.isfinite(within) else math.sqrt(scatter),
        standard_error=math.sqrt(scatter / found.size),
    )
