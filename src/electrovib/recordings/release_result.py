"""What is known of a release and of the ringing behind it."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.recordings.release_parts import (
    Decay,
    Extremum,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.recordings.release_uncertainty import Uncertainty


@dataclass(frozen=True, kw_only=True)
class Ringing:
    """A release and the ringing after it. Times are s after the drive ends unless they say otherwise.

    Parameters
    ----------
    drive_end : float
        When the drive ends, on the clock of the record [s]: half way between its last sample and the next.
    delay : float
        Mean time by which the force lets go behind the drive [s]: of a fall that begins after a while and then
        dies away exponentially, the while and the time constant together. The two apart are hardly ever determined.
    fall_time : float
        Time constant of the fall that fits best [s].
    fall_time_interval : tuple of float
        Between which values it fits as well, 95 % on either side [s]; from 0 where a jump does.
    held, after : float
        Force before and long after the release [N].
    frequency, quality : float
        Natural frequency [Hz] and quality factor [1] of the one resonance that fits best: that of the whole
        assembly, load cell with everything that hangs on it, which is lower than that of the bare cell.
    uncertainty : mapping of str to Uncertainty
        Of ``delay``, ``frequency`` and ``quality``, with its components.
    misfit, misfit_without : float
        rms of what is left over rms of the force about its last level, after the drive ends [1]: with the
        resonance, and with the best exponential release that the sensor would follow at once.
    scatter : float
        Standard deviation before the release [N].
    missing : int
        Rows that were left out because they held a NaN.
    extrema : tuple of Extremum
        Turning points that stand out from the scatter.
    early, late : Decay or None
        Damped sines from the first turning point, and from three quarters of a period later.
    time, force, model, model_without : ndarray, shape (n,)
        The samples that were fitted: s after the drive ends, and N.
    words : tuple of str
        What the record says, and what it does not determine.
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
        """Frequencies [Hz] that successive turning points give."""
        times = [extremum.time for extremum in self.extrema]
        return tuple(1 / (2 * (later - earlier)) for earlier, later in itertools.pairwise(times))

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers and words for JSON, in SI, without the samples."""
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
