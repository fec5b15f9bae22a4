"""All values of one variable at which an explored function has a wanted value."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from electrovib.study.design.parameter.scale import coordinate
from electrovib.study.design.parameter.search import CannotBeComputedError, Function, coordinates, middle

CLOSE: Final = 1e-9
"""Relative deviation from the wanted value up to which an extreme value counts as a solution."""
MISSED: Final = 1e-6
"""Relative deviation above which a change of sign is a discontinuity and no solution."""
MOST_SOLUTIONS: Final = 30
"""Largest number of solutions that are refined."""
MANY: Final = 6
"""Number of crossings from which on the function is one that goes up and down, of which more may lie between the values."""
QUIET: Final = 2
"""Number of halvings in succession that have to show no further crossing."""
_HALVINGS: Final = 40
"""Number of bisections for the end of an interval."""
_OF_INTERVAL: Final = 2
"""Number of first values with the wanted value that are an interval, and not the neighbourhood of an extreme."""
_SAME: Final = 1e-7
"""Relative distance up to which two solutions are one."""

_Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class Root:
    """A value, or an interval up to `until`, at which the function has the wanted value.

    At an extreme the function has this value without crossing it.
    """

    value: float
    reached: float
    until: float | None = None
    is_extreme: bool = False


def solutions(function: Function, target: float) -> tuple[list[Root], list[float], int]:
    """Find all roots in increasing order, the values at which the function jumps across, and the number of further ones."""
    points = function.known
    met = _met(points, target)
    found = _exact(function, points, met, target)
    jumps: list[float] = []
    between = _crossings(points, met, target)
    for first, second in between[:MOST_SOLUTIONS]:
        at = _root(function, first, second, target)
        if at is None:
            continue
        if _is_close(function(at), target, first[1], second[1], MISSED):
            found.append(Root(at, function(at)))
        else:
            jumps.append(at)
    return _merged(found), jumps, max(len(between) - MOST_SOLUTIONS, 0)


def look_between(function: Function, target: float, *, most_added: int) -> bool:
    """Halve the distances of the values among many crossings until no further crossing appears.

    Returned is whether their number has settled.
    """
    added, quiet = 0, 0
    counted = _count(function, target)
    while counted >= MANY and quiet < QUIET:
        places = [at for at, _ in function.known]
        fresh = [middle(first, second) for first, second in itertools.pairwise(places)]
        added += len(fresh)
        if added > most_added:
            return False
        for each in fresh:
            function(each)
        before, counted = counted, _count(function, target)
        quiet = quiet + 1 if counted == before else 0
    return True


def _count(function: Function, target: float) -> int:
    return len(_crossings(function.known, _met(function.known, target), target))


def _crossings(points: Sequence[_Point], met: Sequence[bool], target: float) -> list[tuple[_Point, _Point]]:
    """Return the neighbouring values between which a function passes the wanted value."""
    return [
        (first, second)
        for (first, second), (at_first, at_second) in zip(
            itertools.pairwise(points), itertools.pairwise(met), strict=True
        )
        if (first[1] - target) * (second[1] - target) < 0 and not (at_first or at_second)
    ]


def _met(points: Sequence[tuple[float, float]], target: float) -> list[bool]:
    """Tell which of the known values are the wanted one already."""
    scale = max((abs(value) for _, value in points), default=0.0)
    return [abs(value - target) <= CLOSE * (abs(target) or scale * 1e-6) for _, value in points]


def _exact(
    function: Function, points: Sequence[tuple[float, float]], met: Sequence[bool], target: float
) -> list[Root]:
    """Return known values that are solutions already: extremes, values met by chance, and intervals."""
    found: list[Root] = []
    for is_met, run in itertools.groupby(range(len(points)), key=lambda i: met[i]):
        if not is_met:
            continue
        indices = list(run)
        first, last = points[indices[0]], points[indices[-1]]
        if len({points[i][0] for i in indices} & function.coarse) < _OF_INTERVAL:
            beside = [
                points[i][1] - target for i in (indices[0] - 1, indices[-1] + 1) if 0 <= i < len(points)
            ]
            best = min((points[i] for i in indices), key=lambda point: abs(point[1] - target))
            found.append(Root(*best, is_extreme=len(beside) == 2 and beside[0] * beside[1] > 0))
        else:
            before, after = indices[0] - 1, indices[-1] + 1
            begin = _edge(function, points[before][0], first, target) if before >= 0 else first
            end = _edge(function, points[after][0], last, target) if after < len(points) else last
            found.append(Root(*begin, until=end[0]))
    return found


def _edge(
    function: Function, outside: float, inside: tuple[float, float], target: float
) -> tuple[float, float]:
    """Return the last value, from the inside of an interval to a value outside, at which the wanted value is met."""
    for _ in range(_HALVINGS):
        at = middle(outside, inside[0])
        value = function(at)
        if abs(value - target) <= CLOSE * abs(target):
            inside = (at, value)
        else:
            outside = at
    return inside


def _root(
    function: Function, first: tuple[float, float], second: tuple[float, float], target: float
) -> float | None:
    """Refine a crossing by Brent's method, in logarithms where these exist; None where the function has no value."""
    from scipy.optimize import brentq

    inverse, ends = coordinates(first[0], second[0])
    logarithmic = coordinate(first[1], target) and coordinate(second[1], target)

    def off(u: float) -> float:
        value = function.certain(inverse(u))
        if logarithmic and value * target > 0:
            return math.log(value / target)
        return (value - target) / abs(target) if logarithmic else value - target

    try:
        return inverse(float(brentq(off, *ends, xtol=1e-14 * max(map(abs, ends)) + 1e-300, rtol=1e-14)))
    except CannotBeComputedError:
        return None


def _is_close(value: float, target: float, first: float, second: float, share: float) -> bool:
    return abs(value - target) <= share * (abs(target) or max(abs(first), abs(second)))


def _merged(found: list[Root]) -> list[Root]:
    """Return solutions in order, with those that rounding has separated as one."""
    kept: list[Root] = []
    for each in sorted(found, key=lambda solution: solution.value):
        if kept and abs(each.value - kept[-1].value) <= _SAME * abs(each.value):
            kept[-1] = Root(each.value, each.reached, is_extreme=True)
            continue
        kept.append(each)
    return kept
