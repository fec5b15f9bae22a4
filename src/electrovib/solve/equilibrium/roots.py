"""All crossings of two curves that fall ever less: branch and bound with bounds from monotony and convexity."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from electrovib.core.errors import ElectrovibError

NOISE = 64 * 2.0**-52
"""Relative rounding of a value or slope of either curve: differences below it have no sign."""
MOST_INTERVALS = 20_000
"""More have never been needed; curves that are not convex might ask for them."""

Curve = Callable[[float], tuple[float, float]]
"""Value and slope at a place."""


@dataclass(frozen=True)
class Crossing:
    """A place where two curves meet.

    Parameters
    ----------
    place : float
        Where.
    fold : bool
        The curves touch within rounding, or cross twice closer than rounding tells.
    iterations : int
        Halvings of the range and steps of the bracketing that led to it.
    """

    place: float
    fold: bool
    iterations: int


@dataclass(frozen=True)
class _Point:
    """Both curves at one place."""

    x: float
    upper: float
    upper_slope: float
    lower: float
    lower_slope: float

    @property
    def difference(self) -> float:
        return self.upper - self.lower

    @property
    def noise(self) -> float:
        return NOISE * (abs(self.upper) + abs(self.lower))


@dataclass(frozen=True)
class _Interval:
    left: _Point
    right: _Point
    depth: int


def crossings(first: Curve, second: Curve, low: float, high: float) -> tuple[Crossing, ...]:
    """Find every place where two decreasing convex curves meet.

    Parameters
    ----------
    first, second : callable
        Place to value and slope; decreasing and convex between low and high.
    low, high : float
        Range, both ends included.

    Returns
    -------
    tuple of Crossing
        In rising order.

    Raises
    ------
    ElectrovibError
        If the bounds do not close, as with curves that are not convex.

    Notes
    -----
    On an interval each curve lies below its chord and above its tangents at the ends, and its slope between
    those at the ends. So the difference is bounded, and the interval left out where the bounds exclude 0; where
    the slopes exclude a turning point a change of sign is solved by bracketing; otherwise it is halved, until
    the difference is below rounding everywhere in it: there the curves touch, reported once.
    """
    ends = _point(first, second, low), _point(first, second, high)
    found = sorted(_search(first, second, _Interval(*ends, 0)), key=lambda part: part[0])
    return tuple(_merged(found, ends))


def _point(first: Curve, second: Curve, x: float) -> _Point:
    return _Point(x, *first(x), *second(x))


_Part = tuple[float, float, Crossing]
"""Both ends of the interval in which something was found, and what."""


def _search(first: Curve, second: Curve, whole: _Interval) -> Iterator[_Part]:
    waiting, opened = [whole], 0
    while waiting:
        part, opened = waiting.pop(), opened + 1
        if opened > MOST_INTERVALS:
            raise ElectrovibError(
                "equilibrium: the bounds do not close; are both curves decreasing and convex over the whole range of gaps?"
            )
        left, right, noise = part.left, part.right, max(part.left.noise, part.right.noise)
        below, above = _bounds(part)
        if below > noise or above < -noise:
            continue
        if _turns_nowhere(part):
            if left.difference * right.difference <= 0:
                place, steps = _bracketed(first, second, part)
                yield left.x, right.x, Crossing(place, False, part.depth + steps)
            continue
        middle = (left.x + right.x) / 2
        if (below >= -noise and above <= noise) or not left.x < middle < right.x:
            nearest = min(left, right, key=lambda point: abs(point.difference))
            yield left.x, right.x, Crossing(nearest.x, True, part.depth)
            continue
        centre = _point(first, second, middle)
        waiting += [_Interval(left, centre, part.depth + 1), _Interval(centre, right, part.depth + 1)]


def _bounds(part: _Interval) -> tuple[float, float]:
    """Give the least and the most that the difference can be."""
    a, b = part.left, part.right
    ends = min(a.difference, b.difference), max(a.difference, b.difference)
    width = b.x - a.x
    if width <= 0:
        return ends
    below, above = ends
    x = _kink(a.x, a.upper, a.upper_slope, b.x, b.upper, b.upper_slope)
    tangent = a.upper + a.upper_slope * (x - a.x)
    below = min(below, tangent - (a.lower + (b.lower - a.lower) * (x - a.x) / width))
    x = _kink(a.x, a.lower, a.lower_slope, b.x, b.lower, b.lower_slope)
    tangent = a.lower + a.lower_slope * (x - a.x)
    above = max(above, a.upper + (b.upper - a.upper) * (x - a.x) / width - tangent)
    return below, above


def _kink(a: float, at_a: float, slope_a: float, b: float, at_b: float, slope_b: float) -> float:
    """Place where the tangents at both ends meet."""
    if slope_b <= slope_a:  # straight, but for rounding
        return a
    x = (at_a - at_b + slope_b * b - slope_a * a) / (slope_b - slope_a)
    return min(max(x, a), b)


def _turns_nowhere(part: _Interval) -> bool:
    """Tell whether the slope of the difference cannot be 0."""
    a, b = part.left, part.right
    noise = NOISE * (abs(a.upper_slope) + abs(a.lower_slope))
    return a.upper_slope - b.lower_slope > noise or b.upper_slope - a.lower_slope < -noise


def _bracketed(first: Curve, second: Curve, part: _Interval) -> tuple[float, int]:
    from scipy.optimize import brentq

    for end in (part.left, part.right):
        if end.difference == 0:
            return end.x, 0
    place, told = brentq(
        lambda x: first(x)[0] - second(x)[0],
        part.left.x,
        part.right.x,
        xtol=1e-300,
        rtol=4 * 2.0**-52,
        maxiter=500,
        full_output=True,
    )
    return float(place), int(told.iterations)


def _merged(found: list[_Part], ends: tuple[_Point, _Point]) -> Iterator[Crossing]:
    """Report once what neighbouring intervals share: a crossing on their common end, the parts of a fold."""
    scale = max(abs(end.x) for end in ends)
    groups: list[list[_Part]] = []
    for part in found:
        last = groups[-1][-1] if groups else None
        touching = last is not None and part[0] <= last[1]
        same = last is not None and abs(part[2].place - last[2].place) <= 4 * 2.0**-52 * scale
        folded = last is not None and (part[2].fold or last[2].fold)
        if touching and (same or folded):
            groups[-1].append(part)
        else:
            groups.append([part])
    for group in groups:
        folds = [part[2] for part in group if part[2].fold]
        one = (folds or [part[2] for part in group])[len(folds) // 2 if folds else 0]
        yield Crossing(one.place, bool(folds), max(part[2].iterations for part in group))
