"""All values of one variable at which a function has a wanted value, its extremes, and where it cannot be computed.

The function is computed at first values in the natural scale of the variable, and at more of them where it is bent;
extremes are refined by `scipy.optimize.minimize_scalar`, and each change of sign by Brent's method.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.budget import BudgetError
from electrovib.core.errors import ElectrovibError

PER_DECADE: Final = 4
"""Values in a decade of a range that spans decades."""
EVEN: Final = 25
"""Values of a range that does not."""
BENT: Final = 0.03
"""Relative deviation from the chord of its neighbours above which a value asks for values beside it."""
MOST_ADDED: Final = 120
"""Largest number of values that are added where the function is bent, if nothing else is requested."""
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
_DECADES: Final = 10.0
"""Ratio of the ends of a range from which on it counts as spanning decades."""
_BELOW: Final = 1e-4
"""Smallest value beside zero over the value in the scenario."""
_SMALLEST: Final = 1e-9
"""Smallest value beside zero over the largest value."""
_ROUNDS: Final = 4
"""Largest number of rounds of added values."""
_HALVINGS: Final = 40
"""Number of bisections for the end of an interval."""
_OF_INTERVAL: Final = 2
"""Number of first values with the wanted value that are an interval, and not the neighbourhood of an extreme."""
_SAME: Final = 1e-7
"""Relative distance up to which two solutions are one."""

Point: TypeAlias = tuple[float, float]
"""Variable and value."""


class CannotBeComputedError(Exception):
    """The function has no value here; ends a refinement."""


@dataclass
class Function:
    """A function of one variable that remembers its values, NaN where it has none, and there the reason in `refused`."""

    compute: Callable[[float], float]
    values: dict[float, float] = field(default_factory=dict)
    refused: dict[float, str] = field(default_factory=dict)
    coarse: set[float] = field(default_factory=set)

    def __call__(self, at: float) -> float:
        """Return the value; NaN where it cannot be computed."""
        at = float(at)
        if at not in self.values:
            try:
                self.values[at] = float(self.compute(at))
            except BudgetError:  # of all evaluations
                raise
            except ElectrovibError as error:
                self.values[at] = math.nan
                self.refused[at] = str(error.problems[0])
        return self.values[at]

    def certain(self, at: float) -> float:
        """Return the value; where there is none, CannotBeComputedError ends a refinement."""
        value = self(at)
        if not math.isfinite(value):
            raise CannotBeComputedError
        return value

    @property
    def known(self) -> list[Point]:
        """Variable and value, finite, in increasing order of the variable."""
        return sorted((at, value) for at, value in self.values.items() if math.isfinite(value))


@dataclass(frozen=True)
class Root:
    """A value, or an interval up to `until`, at which the function has the wanted value.

    At an extreme the function has this value without crossing it.
    """

    value: float
    reached: float
    until: float | None = None
    is_extreme: bool = False


def has_ratio(first: float, second: float) -> bool:
    """Return whether the logarithm is the natural coordinate between two values: same sign, none is zero."""
    return first * second > 0


def coordinates(low: float, high: float) -> tuple[Callable[[float], float], tuple[float, float]]:
    """Return the inverse of the natural coordinate between two values, and their own coordinates, the smaller first."""
    if not has_ratio(low, high):
        return (lambda u: u), (low, high)
    sign = math.copysign(1.0, low)
    first, second = math.log(abs(low)), math.log(abs(high))

    def inverse(u: float) -> float:
        return low if u == first else high if u == second else sign * math.exp(u)

    return inverse, (min(first, second), max(first, second))


def middle(first: float, second: float) -> float:
    """Return the geometric mean of two values of the same sign, else the arithmetic one."""
    if has_ratio(first, second):
        return math.copysign(math.sqrt(abs(first)) * math.sqrt(abs(second)), first)
    return 0.5 * (first + second)


def crossing(compute: Callable[[float], float], first: float, second: float) -> float:
    """Return where a function changes its sign between two values, by Brent's method in their natural coordinate."""
    from scipy.optimize import brentq

    inverse, ends = coordinates(first, second)
    precision = 1e-14 * max(map(abs, ends)) + 1e-300
    return inverse(float(brentq(lambda u: compute(inverse(u)), *ends, xtol=precision, rtol=1e-14)))


def first_values(low: float, high: float, begin: float, *, sparse: bool = False) -> Real:
    """Return the increasing values of a parameter at which a quantity is computed first, `begin` among them.

    They are evenly spaced in the logarithm where the range spans a decade, else evenly spaced. A range with
    zero has the value zero and both scales on either side of it, down to 1e-4 of `begin`, or 1e-9 of the
    larger end where that is greater.
    """
    if low >= 0:
        found = _side(low, high, begin, sparse)
    elif high <= 0:
        found = -_side(-high, -low, -begin, sparse)[::-1]
    else:
        found = np.concatenate([-_side(0.0, -low, -begin, sparse)[::-1], _side(0.0, high, begin, sparse)])
    values = np.unique(np.append(found, begin if low < begin < high else low))
    values[0], values[-1] = low, high
    return np.asarray(values)


def _side(low: float, high: float, begin: float, sparse: bool) -> Real:
    """Return values from `low` >= 0 to `high` > 0."""
    each = 2 if sparse else 1
    even = np.linspace(low, high, 1 + (EVEN - 1) // each)
    if low > 0 and high / low < _DECADES:
        return even
    start = low
    if low == 0:
        size = abs(begin)
        start = max(_SMALLEST * high, _BELOW * size) if 0 < size < high else 1e-6 * high
    count = max(len(even), 1 + math.ceil(PER_DECADE / each * math.log10(high / start)))
    spread = np.geomspace(start, high, count)
    return spread if low > 0 else np.concatenate([[0.0], spread])


def explore(function: Function, values: Iterable[float], *, most_added: int = MOST_ADDED) -> None:
    """Compute a function at given values, and at more of them where it is bent."""
    for each in values:
        function(each)
        function.coarse.add(float(each))
    added = 0
    for _ in range(_ROUNDS):
        points = function.known
        asked: dict[float, None] = {}
        for before, here, after in zip(points, points[1:], points[2:], strict=False):
            if _is_bent(before, here, after):
                asked |= dict.fromkeys([middle(before[0], here[0]), middle(here[0], after[0])])
        fresh = [each for each in asked if each not in function.values][: most_added - added]
        if not fresh:
            return
        added += len(fresh)
        for each in fresh:
            function(each)


def _is_bent(before: Point, here: Point, after: Point) -> bool:
    """Tell whether a value deviates from the chord of its neighbours, in logarithms where these exist."""
    (a, fa), (b, fb), (c, fc) = before, here, after
    ratio = has_ratio(a, c) and has_ratio(a, b)
    share = math.log(b / a) / math.log(c / a) if ratio else (b - a) / (c - a)
    if has_ratio(fa, fb) and has_ratio(fb, fc):
        return abs(math.log(fb / fa) - share * math.log(fc / fa)) > BENT
    scale = max(abs(fa), abs(fb), abs(fc))
    return scale > 0 and abs(fb - fa - share * (fc - fa)) > BENT * scale


def sharpen_extremes(function: Function, target: float) -> None:
    """Refine the extremes of a function that can decide whether the wanted value is reached."""
    points = function.known
    values = [value for _, value in points]
    if len(points) < 3:
        return
    top, bottom = values.index(max(values)), values.index(min(values))
    for i in range(1, len(points) - 1):
        side = _turn(*values[i - 1 : i + 2])
        if side == 0:
            continue
        room = max(abs(values[i] - values[i - 1]), abs(values[i] - values[i + 1]))
        if i in {top, bottom} or 0 < side * (target - values[i]) <= room:
            _extreme(function, points[i - 1][0], points[i + 1][0], side)


def _turn(before: float, here: float, after: float) -> int:
    """Return 1 at a local maximum, -1 at a local minimum, else 0."""
    if here >= max(before, after) and here > min(before, after):
        return 1
    return -1 if here <= min(before, after) and here < max(before, after) else 0


def _extreme(function: Function, low: float, high: float, side: int) -> None:
    from scipy.optimize import minimize_scalar

    inverse, ends = coordinates(low, high)
    try:
        minimize_scalar(
            lambda u: -side * function.certain(inverse(u)),
            bounds=ends,
            method="bounded",
            options={"xatol": 1e-8 * (ends[1] - ends[0]), "maxiter": 60},
        )
    except CannotBeComputedError:
        return


def look_between(function: Function, target: float, *, most_added: int) -> bool:
    """Halve the distances of the values among many crossings until no further crossing appears.

    Returned is whether their number has settled.
    """
    added, quiet = 0, 0
    counted = len(_crossings(function.known, target))
    while counted >= MANY and quiet < QUIET:
        fresh = [middle(first[0], second[0]) for first, second in itertools.pairwise(function.known)]
        added += len(fresh)
        if added > most_added:
            return False
        for each in fresh:
            function(each)
        before, counted = counted, len(_crossings(function.known, target))
        quiet = quiet + 1 if counted == before else 0
    return True


def solutions(function: Function, target: float) -> tuple[list[Root], list[float], int]:
    """Find all roots in increasing order, the values at which the function jumps across, and the number of further ones."""
    points = function.known
    found = _exact(function, points, target)
    jumps: list[float] = []
    between = _crossings(points, target)
    for first, second in between[:MOST_SOLUTIONS]:
        try:
            at = crossing(_departure(function, first, second, target), first[0], second[0])
        except CannotBeComputedError:
            continue
        reached = function(at)
        if abs(reached - target) <= MISSED * (abs(target) or max(abs(first[1]), abs(second[1]))):
            found.append(Root(at, reached))
        else:
            jumps.append(at)
    return _merged(found), jumps, max(len(between) - MOST_SOLUTIONS, 0)


def _departure(function: Function, first: Point, second: Point, target: float) -> Callable[[float], float]:
    """Return the departure of a function from the wanted value between two points, in logarithms where these exist."""
    logarithmic = has_ratio(first[1], target) and has_ratio(second[1], target)

    def off(at: float) -> float:
        value = function.certain(at)
        if logarithmic and value * target > 0:
            return math.log(value / target)
        return (value - target) / abs(target) if logarithmic else value - target

    return off


def _crossings(points: Sequence[Point], target: float) -> list[tuple[Point, Point]]:
    """Return the neighbouring values between which a function passes the wanted value."""
    met = _met(points, target)
    return [
        (points[i], points[i + 1])
        for i in range(len(points) - 1)
        if (points[i][1] - target) * (points[i + 1][1] - target) < 0 and not (met[i] or met[i + 1])
    ]


def _met(points: Sequence[Point], target: float) -> list[bool]:
    """Tell which of the known values are the wanted one already."""
    scale = max((abs(value) for _, value in points), default=0.0)
    return [abs(value - target) <= CLOSE * (abs(target) or scale * 1e-6) for _, value in points]


def _exact(function: Function, points: Sequence[Point], target: float) -> list[Root]:
    """Return known values that are solutions already: extremes, values met by chance, and intervals."""
    found: list[Root] = []
    met = _met(points, target)
    for is_met, run in itertools.groupby(range(len(points)), key=lambda i: met[i]):
        if not is_met:
            continue
        indices = list(run)
        before, after = indices[0] - 1, indices[-1] + 1
        if len({points[i][0] for i in indices} & function.coarse) < _OF_INTERVAL:
            beside = [points[i][1] - target for i in (before, after) if 0 <= i < len(points)]
            best = min((points[i] for i in indices), key=lambda point: abs(point[1] - target))
            found.append(Root(*best, is_extreme=len(beside) == 2 and beside[0] * beside[1] > 0))
            continue
        begin, end = points[indices[0]], points[indices[-1]]
        if before >= 0:
            begin = _edge(function, points[before][0], begin, target)
        if after < len(points):
            end = _edge(function, points[after][0], end, target)
        found.append(Root(*begin, until=end[0]))
    return found


def _edge(function: Function, outside: float, inside: Point, target: float) -> Point:
    """Return the last value, from the inside of an interval to a value outside, at which the wanted value is met."""
    for _ in range(_HALVINGS):
        at = middle(outside, inside[0])
        value = function(at)
        if abs(value - target) <= CLOSE * abs(target):
            inside = (at, value)
        else:
            outside = at
    return inside


def _merged(found: list[Root]) -> list[Root]:
    """Return solutions in order, with those that rounding has separated as one."""
    kept: list[Root] = []
    for each in sorted(found, key=lambda solution: solution.value):
        if kept and abs(each.value - kept[-1].value) <= _SAME * abs(each.value):
            kept[-1] = Root(each.value, each.reached, is_extreme=True)
            continue
        kept.append(each)
    return kept


def near_root(
    function: Function, target: float, low: float, high: float, guess: float, close: float
) -> float:
    """Return a root near a first guess by the secant method in logarithms; NaN where it leaves the range or finds none.

    A value within a relative deviation `close` of the wanted one counts as the root.
    """
    from scipy.optimize import newton

    if not guess:
        return math.nan
    sign, begin = math.copysign(1.0, guess), math.log(abs(guess))

    def off(u: float) -> float:
        at = sign * math.exp(u)
        if not low <= at <= high:
            raise CannotBeComputedError
        value = function.certain(at)
        if abs(value - target) <= close * abs(target):
            return 0.0
        return (
            math.log(value / target) if has_ratio(value, target) else (value - target) / (abs(target) or 1.0)
        )

    try:
        step = -0.5 * max(-1.0, min(1.0, off(begin)))
        if not step:
            return sign * math.exp(begin)
        return sign * math.exp(float(newton(off, begin, x1=begin + step, tol=1e-300, maxiter=25)))
    except (CannotBeComputedError, RuntimeError, OverflowError):
        return math.nan


def inside_band(
    compute: Callable[[float], float], values: Real, low: float, high: float
) -> list[tuple[float, float]]:
    """Return the intervals of a variable in which a function lies in a band, sought between increasing values."""
    points = [(at, compute(at)) for at in values.tolist()]
    found: list[tuple[float, float]] = []
    for before, after in itertools.pairwise(points):
        crossed = [
            _passed(compute, before, after, level)
            for level in (low, high)
            if (before[1] - level) * (after[1] - level) < 0
        ]
        for (start, first), (end, last) in itertools.pairwise(sorted([before, *crossed, after])):
            if not (low <= first <= high and low <= last <= high):
                continue
            if found and found[-1][1] >= start:
                found[-1] = found[-1][0], end
            else:
                found.append((start, end))
    return found


def _passed(compute: Callable[[float], float], before: Point, after: Point, level: float) -> Point:
    return crossing(lambda at: compute(at) - level, before[0], after[0]), level
