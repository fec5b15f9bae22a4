"""Zero of a sensor from the sections free of load, and the uncertainty due to its choice."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.interval import Interval
from electrovib.recordings.swipe.parts import SHORTEST

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.recordings.recording import Recording
    from electrovib.recordings.spans import Span
    from electrovib.recordings.swipe.parts import Touch

BLOCKS = 10
"""Number of parts of a window from whose scatter the statistical error is computed."""
_COVERAGE = 2.262
"""Standard errors on either side of an interval: 95 % for a mean of ten parts (Student's t)."""


def over_baselines(choices: Mapping[str, float], best: str, standard_error: float) -> Interval:
    """Make the interval of a number over the choices of the baseline, extended by 2.26 standard errors (95 %) on either side."""
    half = _COVERAGE * standard_error
    return Interval(
        value=choices[best],
        lower=min(choices.values()) - half,
        upper=max(choices.values()) + half,
        standard_error=standard_error,
        choices=choices,
        method="choices of the zero of the sensors, and scatter within the window",
    )


@dataclass(frozen=True, kw_only=True)
class Zero:
    """Zeros of both force sensors in one section free of load: median readings, with errors without the drift."""

    time: float
    normal: float
    lateral: float
    normal_error: float
    lateral_error: float


def zeros_beside(recording: Recording, contact: Touch, window: Span) -> dict[str, Zero]:
    """Compute the zeros before and after a contact from the nearest samples free of load."""
    longest = window[1] - window[0]
    found = {}
    if contact.before is not None:
        found["before"] = _zero(
            recording, (max(contact.before[0], contact.before[1] - longest), contact.before[1])
        )
    if contact.after is not None:
        found["after"] = _zero(
            recording, (contact.after[0], min(contact.after[1], contact.after[0] + longest))
        )
    if not found:
        raise InputError(
            f"{recording.source}: no section of {SHORTEST:g} s is free of load before or after the contact that begins at"
            f" {recording.time[contact.span[0]]:.3g} s, so the zero of the sensors is unknown."
        )
    return found


def _zero(recording: Recording, span: Span) -> Zero:
    part = slice(*span)
    normal, lateral = recording.normal_force[part], recording.lateral_force[part]
    return Zero(
        time=float(np.mean(recording.time[part])),
        normal=float(np.median(normal)),
        lateral=float(np.median(lateral)),
        normal_error=standard_error(_detrended(block_means(recording.normal_force, span, median=True))),
        lateral_error=standard_error(_detrended(block_means(recording.lateral_force, span, median=True))),
    )


def choices_of(zeros: dict[str, Zero], *, at: float) -> dict[str, tuple[float, float]]:
    """Return the zeros of normal and lateral force for each simple choice of the baseline; the line is evaluated at `at`."""
    found = {name: (zero.normal, zero.lateral) for name, zero in zeros.items()}
    if len(zeros) == 2:
        before, after = zeros["before"], zeros["after"]
        part = (at - before.time) / (after.time - before.time)
        for name, weight in (("mean", 0.5), ("interpolated", part)):
            normal = (1 - weight) * before.normal + weight * after.normal
            found[name] = (normal, (1 - weight) * before.lateral + weight * after.lateral)
    return found


def block_means(values: NDArray[np.float64], span: Span, *, median: bool = False) -> NDArray[np.float64]:
    """Return the means of `BLOCKS` equal parts of a section, or medians, which a brief touch changes less."""
    blocks = np.array_split(values[slice(*span)], BLOCKS)
    return np.array([np.median(block) if median else np.mean(block) for block in blocks])


def standard_error(means: NDArray[np.float64]) -> float:
    """Return the standard error of the mean of independent numbers."""
    return float(np.std(means, ddof=1) / np.sqrt(len(means)))


def _detrended(means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Subtract a straight line, because a drift is covered by the choice of the baseline."""
    place = np.arange(len(means)) - (len(means) - 1) / 2
    return means - place * (place @ means) / (place @ place)
