"""What is not known of a friction: at rest, and behind a memory until that has forgotten the rest."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.motion import Motion
    from electrovib.solve.mechanics.filters.filter import Filter

Spans: TypeAlias = "tuple[tuple[float, float], ...]"
"""Begins and ends [s], the first perhaps minus infinity; the end is outside."""
COUNTS = 1e-6
"""Share of an output that may stand on what is not known: as far as the mechanics is followed."""


def resting(motion: Motion) -> Spans:
    """Find when a finger touches and does not move.

    Parameters
    ----------
    motion : Motion
        Speed and distance over time.

    Returns
    -------
    tuple of (float, float)
        Spans of rest [s], from before time 0 on.
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
    """Share of a filter's output that stands on an input that is not known.

    Parameters
    ----------
    filter_ : Filter
        What the input goes through.
    spans : tuple of (float, float)
        When the input is not known [s].
    times : ndarray, shape (n,)
        s.

    Returns
    -------
    ndarray, shape (n,)
        Largest weight of the unknown input over the response to a constant one: 0 for all known, 1 or more for none.
    """
    share = abs(filter_.direct) * np.any([(times >= begin) & (times < end) for begin, end in spans], axis=0)
    for pole, gain in zip(filter_.poles, filter_.gains, strict=True):
        weight = abs(gain) * abs(pole) / -pole.real * (2.0 if pole.imag else 1.0)
        share = share + weight * remembered(
            -pole.real * times, [(-pole.real * a, -pole.real * b) for a, b in spans]
        )
    return np.asarray(share / abs(filter_.at_rest()))


def remembered(times: Real, spans: list[tuple[float, float]]) -> Real:
    """Weight that spans have in a memory of rate 1.

    Parameters
    ----------
    times : ndarray, shape (n,)
        In units of the memory's time constant.
    spans : list of (float, float)
        Begins and ends in the same unit.

    Returns
    -------
    ndarray, shape (n,)
        From 0 to 1.
    """
    weight = np.zeros(np.shape(times))
    for begin, end in spans:
        inside = times > begin
        last = np.minimum(times, end)
        weight += np.where(inside, np.exp(last - times) - np.exp(np.minimum(begin - times, 0.0)), 0.0)
    return weight


def spans_of(times: Real, wrong: NDArray[np.bool_]) -> Spans:
    """Collect the times at which something holds to spans.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing [s].
    wrong : ndarray of bool, shape (n,)
        Whether it holds from each time until the next.

    Returns
    -------
    tuple of (float, float)
        Spans [s]; what holds at the first time has always held.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], wrong, [False]]).astype(int)))
    stamps = np.append(times, np.inf)
    return tuple(
        (-np.inf if begin == 0 else float(stamps[begin]), float(stamps[end]))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    )
