"""Times at which a friction is unknown: at rest, and behind a memory until the memory has decayed."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.motion import Motion
    from electrovib.solve.mechanics.filters.filter import Filter

Spans: TypeAlias = "tuple[tuple[float, float], ...]"
"""Begin and end of each span [s], the first begin may be minus infinity; the end is excluded."""
COUNTS = 1e-6
"""Largest weight of unknown input in a known output [1]: the tolerance of the mechanics."""


def resting(motion: Motion) -> Spans:
    """Return the spans in which a finger touches the plate and does not move.

    Parameters
    ----------
    motion : Motion
        Speed and distance over time.

    Returns
    -------
    spans : tuple of (float, float)
        Begin and end of each rest [s], also before time 0.
    """
    breaks = np.array(motion.breaks())
    begins, ends = np.append(-np.inf, breaks), np.append(breaks, np.inf)
    rests = motion.rests(np.append(breaks[:1] - 1.0, breaks))
    found: list[tuple[float, float]] = []
    for begin, end in zip(begins[rests].tolist(), ends[rests].tolist(), strict=True):
        if found and found[-1][1] == begin:
            found[-1] = (found[-1][0], end)
        else:
            found.append((begin, end))
    return tuple(found)


def not_known(filter_: Filter, spans: Spans, times: Real) -> Real:
    """Return the weight of an unknown input in the output of a filter.

    Parameters
    ----------
    filter_ : Filter
        Filter of the input.
    spans : tuple of (float, float)
        Spans in which the input is unknown [s].
    times : ndarray, shape (n,)
        Times of the output [s].

    Returns
    -------
    weight : ndarray, shape (n,)
        Largest weight of the unknown input over the response to a constant one [1]: 0 where all of the input is known, 1
        or more where none is.
    """
    share = abs(filter_.direct) * np.any([(times >= begin) & (times < end) for begin, end in spans], axis=0)
    for pole, gain in zip(filter_.poles, filter_.gains, strict=True):
        weight = abs(gain) * abs(pole) / -pole.real * (2.0 if pole.imag else 1.0)
        share = share + weight * remembered(
            -pole.real * times, [(-pole.real * a, -pole.real * b) for a, b in spans]
        )
    return np.asarray(share / abs(filter_.at_rest()))


def remembered(times: Real, spans: list[tuple[float, float]]) -> Real:
    """Return the weight of spans in an exponential memory.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times over the time constant of the memory [1].
    spans : list of (float, float)
        Begin and end of each span in the same unit.

    Returns
    -------
    weight : ndarray, shape (n,)
        Weight of the spans at each time, from 0 to 1 [1].
    """
    weight = np.zeros(np.shape(times))
    for begin, end in spans:
        inside = times > begin
        last = np.minimum(times, end)
        weight += np.where(inside, np.exp(last - times) - np.exp(np.minimum(begin - times, 0.0)), 0.0)
    return weight


def spans_of(times: Real, wrong: NDArray[np.bool_]) -> Spans:
    """Return the spans in which a condition holds.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing [s].
    wrong : ndarray of bool, shape (n,)
        Whether the condition holds from each time until the next.

    Returns
    -------
    spans : tuple of (float, float)
        Begin and end of each span [s]; a condition that holds at the first time has always held.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], wrong, [False]]).astype(int)))
    stamps = np.append(times, np.inf)
    return tuple(
        (-np.inf if begin == 0 else float(stamps[begin]), float(stamps[end]))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    )
