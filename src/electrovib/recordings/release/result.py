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

    - `drive_end`: end of the drive on the clock of the record: mean of its last sample and the next.
    - `delay`: mean delay of the fall of the force: the dead time plus the time constant of the exponential
      decay after it. A record rarely determines the two separately.
    - `fall_time`: time constant of the decay that fits best; `fall_time_interval` has the lowest and highest
      one that fit as well, 95 % on either side, the lowest 0 if a discontinuity fits as well.
    - `frequency`, `quality`: of the one resonance that fits best. It is that of the load cell with its load,
      which is lower than that of the bare cell.
    - `misfit`, `misfit_without`: rms of the residual over the rms of the force about its last level, after
      the end of the drive: with the resonance, and for the best exponential release recorded by a sensor
      without resonance.
    - `held`, `after`, `scatter`: force before the release, long after it, and its standard deviation before
      it.
    - `missing`: number of rows that were omitted because they held a NaN.
    - `early`, `late`: damped sines fitted from the first turning point on, and from three quarters of a
      period later, or None.
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
