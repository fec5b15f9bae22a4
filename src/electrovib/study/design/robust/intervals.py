"""Values of the free parameter at which each finger has the wanted quantity."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.study.design.parameter.scale import coordinate, first_values
from electrovib.study.design.robust.sample import reference
from electrovib.study.design.robust.share import Covered

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.study.design.robust.sample import DrawnFingers

MOST_VALUES: Final = 17
"""Largest number of values of the free parameter at which every finger is solved first."""
_CLOSE: Final = 1e-9
"""Relative accuracy of the ends of an interval."""


def by_gain(
    fingers: DrawnFingers, low: float, high: float, *, progress: Callable[[int, int], None] | None = None
) -> Covered:
    """Return the intervals of fingers whose quantity is proportional to the square of the free parameter.

    The gain g of each finger follows from one solution; with the quantity g x^2, x is from sqrt(low/g) to
    sqrt(high/g), as far as it lies in the range of the parameter. `high` may be infinite.
    """
    wanted = fingers.wanted
    at = reference(wanted)
    gains = fingers.each_at(at, progress=progress) / at**2
    positive = gains > 0
    gains = np.where(positive, gains, 1.0)
    starts = np.sqrt(max(low, 0.0) / gains)
    ends = np.sqrt(high / gains) if math.isfinite(high) else np.full(len(gains), np.inf)
    kept = positive & (starts <= wanted.high) & (ends >= max(wanted.low, 0.0))
    members = np.flatnonzero(kept)
    return Covered(
        np.maximum(starts[kept], wanted.low), np.minimum(ends[kept], wanted.high), members, fingers.count
    )


def by_solution(
    fingers: DrawnFingers, low: float, high: float, *, progress: Callable[[int, int], None] | None = None
) -> Covered:
    """Return the intervals of fingers whose quantity depends on the free parameter in any form.

    Ends are refined by Brent's method between the values at which every finger was solved. A band that the
    quantity enters and leaves between two neighbouring values is not found.
    """
    wanted = fingers.wanted
    values = _thinned(first_values(wanted.low, wanted.high, wanted.begin))
    begun = None if progress is None else (lambda *_: progress(0, fingers.count))
    together = {at: fingers.together_at(at, progress=begun) for at in values.tolist()}
    evaluation = fingers.evaluation()
    starts: list[float] = []
    ends: list[float] = []
    members: list[int] = []
    for finger in range(fingers.count):
        if progress is not None:
            progress(finger, fingers.count)

        def quantity(at: float, finger: int = finger) -> float:
            row = together.get(at)
            return fingers.one_at(evaluation, finger, at) if row is None else float(row[finger])

        for start, end in intervals_of(quantity, values, low, high):
            starts.append(start)
            ends.append(end)
            members.append(finger)
    return Covered(np.array(starts), np.array(ends), np.array(members, dtype=np.intp), fingers.count)


def intervals_of(
    quantity: Callable[[float], float], values: Real, low: float, high: float
) -> list[tuple[float, float]]:
    """Return the intervals of a variable in which a function lies in a band, sought between increasing values."""
    points = [(at, quantity(at)) for at in values.tolist()]
    found: list[tuple[float, float]] = []
    for before, after in itertools.pairwise(points):
        crossings = [
            (_crossing(quantity, before, after, level), level)
            for level in (low, high)
            if (before[1] - level) * (after[1] - level) < 0
        ]
        edges = sorted([before, *crossings, after])
        for (start, first), (end, last) in itertools.pairwise(edges):
            if not (low <= first <= high and low <= last <= high):
                continue
            if found and found[-1][1] >= start:
                found[-1] = found[-1][0], end
            else:
                found.append((start, end))
    return found


def _crossing(
    quantity: Callable[[float], float], before: tuple[float, float], after: tuple[float, float], level: float
) -> float:
    """Return the value of the variable between two others at which the function has a value that lies between theirs."""
    from scipy.optimize import brentq

    (a, _), (b, _) = before, after
    if coordinate(a, b):
        sign = math.copysign(1.0, a)

        def shifted(u: float) -> float:
            return quantity(sign * math.exp(u)) - level

        ends = math.log(abs(a)), math.log(abs(b))
        return sign * math.exp(float(brentq(shifted, *ends, xtol=_CLOSE)))
    return float(brentq(lambda at: quantity(at) - level, a, b, xtol=_CLOSE * max(abs(a), abs(b))))


def _thinned(values: Real) -> Real:
    """Return at most `MOST_VALUES` of some values, the ends among them."""
    if len(values) <= MOST_VALUES:
        return values
    return np.asarray(values[np.round(np.linspace(0, len(values) - 1, MOST_VALUES)).astype(int)])
