"""Sensors at the end of their range, recognised by a highest or lowest reading that repeats exactly."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.recordings.recording import Recording
    from electrovib.recordings.spans import Span
    from electrovib.recordings.swipe.parts import Touch

_FEWEST = 10
"""Number of equal extreme samples from which on they are no coincidence."""
_MORE = 3
"""Factor by which the extreme reading occurs more often than any other in its half of the range."""
_NOISE = 0.5
"""Median difference of successive changes inside the range, in steps of the converter, below which there is no noise."""
_BETWEEN = 0.1
"""Smallest share of samples between the extremes; a square wave has fewer."""
_MOST = 0.5
"""Largest fraction of a window at the end of the range with which a force is still computed."""


def at_rail(reading: Real) -> NDArray[np.bool_]:
    """Find the samples at which a sensor is at the end of its range, at a reading that occurs much more often than any other.

    A converter at the end of its range repeats one number, while a force within the range comes with noise. A
    reading whose noise is less than a step of the converter is never found, nor one that is limited by an
    amplifier before the converter, because it keeps the noise of the converter. A dead band, in which a small
    force reads exactly 0, cannot be distinguished from the end of the range; it hides the zero of the sensor
    too.
    """
    found = at_extreme(reading)
    inside = (reading != reading.min()) & (reading != reading.max())
    change = np.diff(reading)
    together = inside[2:] & inside[1:-1] & inside[:-2]
    step = float(np.min(np.abs(change[change != 0]), initial=np.inf))
    noise = np.abs(np.diff(change))[together]
    return found if len(noise) and np.median(noise) > _NOISE * step else np.zeros_like(found)


def at_extreme(reading: Real) -> NDArray[np.bool_]:
    """Find the samples at a highest or lowest reading that repeats, at a rail or because the quantity is constant."""
    low, high = reading.min(), reading.max()
    found = np.zeros(len(reading), dtype=np.bool_)
    for extreme in (low, high):
        at = reading == extreme
        near = reading[(np.abs(reading - extreme) <= (high - low) / 2) & ~at]
        often = int(np.max(np.unique(near, return_counts=True)[1], initial=0))
        if low < high and np.count_nonzero(at) >= max(_FEWEST, _MORE * often):
            found |= at
    return found if np.mean((reading != low) & (reading != high)) >= _BETWEEN else np.zeros_like(found)


def about_rails(recording: Recording, contact: Touch, window: Span) -> tuple[str, ...]:
    """Refuse forces beyond the range of a sensor for most of the window, and state where part of the samples used are."""
    said = []
    for name, railed in recording.at_rail.items():
        shares = {"the window": float(np.mean(railed[slice(*window)]))}
        for when, side in (("before", contact.before), ("after", contact.after)):
            if side is not None:
                shares[f"the unloaded part {when} the contact"] = float(np.mean(railed[slice(*side)]))
        if shares["the window"] > _MOST:
            raise InputError(
                f"{recording.source}: the sensor of the {name} force is at its rail (its highest or lowest reading, repeated"
                f" exactly) for {shares['the window']:.0%} of the time from {recording.time[window[0]]:.2f} to"
                f" {recording.time[window[1] - 1]:.2f} s, so the force is beyond its range and cannot be determined."
                f" Is {name}.column the right one? Otherwise record with a larger range."
            )
        still = at_extreme(getattr(recording, f"{name}_force"))[slice(*window)] & ~railed[slice(*window)]
        if np.any(still):
            said.append(
                f"Warning: the {name} force is exactly its highest or lowest reading for {np.mean(still):.1%} of the window:"
                " its sensor is at its rail there, or the force is constant within the resolution."
            )
        for where, share in shares.items():
            if share > 0:
                said.append(
                    f"Warning: the sensor of the {name} force is at its rail, or in a dead band, for {share:.1%} of"
                    f" {where}: values derived from it have an error of unknown size."
                )
    return tuple(said)
