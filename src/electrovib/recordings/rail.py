"""Sensors at the end of their range: a reading that stands still where it is highest or lowest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.recordings.recording import Recording
    from electrovib.recordings.spans import Span
    from electrovib.recordings.swipe_parts import Touch

_FEWEST = 10
"""Equal samples that may be chance."""
_MORE = 3
"""So many times more often than any reading inside the range does the extreme one occur."""
_NOISE = 0.5
"""Inside the range neighbouring changes differ by more than as many steps of the converter."""
_MOST = 0.5
"""Share of a window at a rail from which on nothing is told of it."""


def at_rail(reading: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Find where a sensor sits at its highest or lowest reading.

    Parameters
    ----------
    reading : ndarray, shape (n,)
        Any unit.

    Returns
    -------
    ndarray of bool, shape (n,)
        True where the reading is the extreme one, if that occurs much more often than any other.

    Notes
    -----
    A converter at the end of its range gives one number again and again, while a force within the range comes with
    noise. A reading without noise, or with less than a step of the converter, is never at a rail here; nor is one that
    an amplifier before the converter limits, because that keeps the converter's noise. A dead band, in which a small
    force reads exactly 0, looks the same as a rail and hides the zero of the sensor as a rail does.
    """
    extremes = (reading.min(), reading.max())
    found = np.zeros(len(reading), dtype=np.bool_)
    inside = (reading != extremes[0]) & (reading != extremes[1])
    change = np.diff(reading)
    together = inside[2:] & inside[1:-1] & inside[:-2]
    step = float(np.min(np.abs(change[change != 0]), initial=np.inf))
    noise = np.abs(np.diff(change))[together]
    if not len(noise) or not np.median(noise) > _NOISE * step:
        return found
    often = int(np.max(np.unique(reading[inside], return_counts=True)[1]))
    for extreme in extremes:
        at = reading == extreme
        if np.count_nonzero(at) >= max(_FEWEST, _MORE * often):
            found |= at
    return found


def about_rails(recording: Recording, contact: Touch, window: Span) -> tuple[str, ...]:
    """Refuse forces that are only the end of a sensor's range; say where part of what is used is.

    Parameters
    ----------
    recording : Recording
        With the samples at a rail.
    contact : Touch
        The touch, with the unloaded samples on either side.
    window : tuple of int
        Samples of which the forces are means.

    Returns
    -------
    tuple of str
        Sentences; none where no sensor was at a rail.

    Raises
    ------
    InputError
        If a sensor sits at a rail for most of the window: its force is larger than it can tell.
    """
    said = []
    for name, railed in recording.at_rail.items():
        shares = {"the window": float(np.mean(railed[slice(*window)]))}
        for when, side in (("before", contact.before), ("after", contact.after)):
            if side is not None:
                shares[f"the unloaded part {when} the contact"] = float(np.mean(railed[slice(*side)]))
        if shares["the window"] > _MOST:
            raise InputError(
                f"{recording.source}: the sensor of the {name} force sits at its rail, the same highest or lowest reading"
                f" again and again, for {shares['the window']:.0%} of the time from"
                f" {recording.time[window[0]]:.2f} to {recording.time[window[1] - 1]:.2f} s: the force is beyond its range"
                f" and cannot be told. Is {name}.column the right one? Otherwise record with a larger range."
            )
        for where, share in shares.items():
            if share > 0:
                said.append(
                    f"Warning: the sensor of the {name} force sits at its rail, or in a dead band, for {share:.1%} of"
                    f" {where}: what is told of it is wrong by an unknown amount."
                )
    return tuple(said)
