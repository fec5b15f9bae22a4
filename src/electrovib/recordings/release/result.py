"""Result of the fit of a release and of the oscillation after it."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.recordings.release.parts import Decay, Extremum

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.recordings.release.uncertainty import Uncertainty


@dataclass(frozen=True, kw_only=True, repr=False)
class FittedRelease:
    """A fitted release and the damped oscillation after it; times are after the end of the drive unless stated otherwise.

    Parameters
    ----------
    drive_end : float
        Time of the end of the drive on the clock of the record [s]: mean of its last sample and the next.
    delay : float
        Mean delay of the fall of the force after the end of the drive [s]: the dead time plus the time constant of the
        exponential decay after it. A record rarely determines the two separately.
    fall_time : float
        Time constant of the decay that fits best [s].
    fall_time_interval : tuple of float
        Lowest and highest time constant that fit as well, 95 % on either side [s]; the lowest is 0 if a
        discontinuity fits as well.
    held, after : float
        Force before the release and long after it [N].
    frequency, quality : float
        Natural frequency [Hz] and quality factor [1] of the one resonance that fits best. It is that of the load cell
        with its load, which is lower than that of the bare cell.
    uncertainty : mapping of str to Uncertainty
        Uncertainty of ``delay``, ``frequency`` and ``quality``, with its components.
    misfit, misfit_without : float
        Rms of the residual over the rms of the force about its last level, after the end of the drive [1]: with the
        resonance, and for the best exponential release recorded by a sensor without resonance.
    scatter : float
        Standard deviation of the force before the release [N].
    missing : int
        Number of rows that were omitted because they held a NaN.
    extrema : tuple of Extremum
        Turning points that exceed the noise.
    early, late : Decay or None
        Damped sines fitted from the first turning point on, and from three quarters of a period later.
    time, force, model, model_without : ndarray, shape (n,)
        Fitted samples: times after the end of the drive [s], forces [N], and both fits [N].
    words : tuple of str
        Sentences that state what the record determines and what it does not.
    """

    drive_end: float
    delay: float
    fall_time: float
    fall_time_interval: tuple[float, float]
    held: float
    after: float
    frequency: float
    quality: float
    uncertainty: Mapping[str, Uncertainty]
    misfit: float
    misfit_without: float
    scatter: float
    missing: int
    extrema: tuple[Extremum, ...]
    early: Decay | None
    late: Decay | None
    time: NDArray[np.float64]
    force: NDArray[np.float64]
    model: NDArray[np.float64]
    model_without: NDArray[np.float64]
    words: tuple[str, ...]

    @property
    def half_periods(self) -> tuple[float, ...]:
        """Frequencies from the intervals between successive turning points [Hz]."""
        times = [extremum.time for extremum in self.extrema]
        return tuple(1 / (2 * (later - earlier)) for earlier, later in itertools.pairwise(times))

    def __repr__(self) -> str:
        """Return the sentences that state the result."""
        return "\n".join(self.words)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and texts for JSON, in SI, without the samples."""
        plain = (
            "drive_end", "delay", "fall_time", "held", "after", "frequency", "quality", "misfit", "misfit_without",
            "scatter", "missing",
        )  # fmt: skip
        return {name: getattr(self, name) for name in plain} | {
            "fall_time_interval": list(self.fall_time_interval),
            "uncertainty": {name: found.to_dict() for name, found in self.uncertainty.items()},
            "extrema": [{"time": extremum.time, "force": extremum.force} for extremum in self.extrema],
            "half_periods": list(self.half_periods),
            "early": self.early.to_dict() if self.early else None,
            "late": self.late.to_dict() if self.late else None,
            "words": list(self.words),
        }
