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
    """Return the spans in which a finger touches the plate and does not move."""
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

    `times` (n,) [s]; returns `weight` (n,).
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

    `times` (n,); returns `weight` (n,).
    """
    weight = np.zeros(np.shape(times))
    for begin, end in spans:
        inside = times > begin
        last = np.minimum(times, end)
        weight += np.where(inside, np.exp(last - times) - np.exp(np.minimum(begin - times, 0.0)), 0.0)
    return weight


def spans_of(times: Real, wrong: NDArray[np.bool_]) -> Spans:
    """Return the spans in which a condition holds.

    `times` (n,) [s], `wrong` (n,).
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], wrong, [False]]).astype(int)))
    stamps = np.append(times, np.inf)
    return tuple(
        (-np.inf if begin == 0 else float(stamps[begin]), float(stamps[end]))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    )
