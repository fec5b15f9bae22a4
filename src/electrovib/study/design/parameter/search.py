"""All values of one variable at which a function has a wanted value, its extremes, and where it cannot be computed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import ElectrovibError
from electrovib.study.design.parameter.scale import coordinate

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

CLOSE: Final = 1e-9
"""Relative deviation from the wanted value up to which an extreme value counts as a solution."""
MISSED: Final = 1e-6
"""Relative deviation above which a change of sign is a discontinuity and no solution."""
BENT: Final = 0.03
"""Relative deviation from the chord of its neighbours above which a value asks for values beside it."""
ROUNDS: Final = 4
"""Largest number of rounds of added values."""
MOST_ADDED: Final = 120
"""Largest number of values that are added where the function is bent, if nothing else is requested."""
MOST_SOLUTIONS: Final = 30
"""Largest number of solutions that are refined."""
_HALVINGS: Final = 40
"""Number of bisections for the end of an interval."""
_OF_INTERVAL: Final = 2
"""Number of first values with the wanted value that are an interval, and not the neighbourhood of an extreme."""
_SAME: Final = 1e-7
"""Relative distance up to which two solutions are one."""


class CannotBeComputedError(Exception):
    """The function has no value here; ends a refinement."""


@dataclass(frozen=True)
class Solution:
    """A value of the variable at which the function has the wanted value.

    Parameters
    ----------
    value : float
        Of the variable, in its unit.
    reached : float
        Of the function, in its unit.
    until : float or None
        Other end of an interval in which the function has the wanted value throughout.
    is_extreme : bool
        Whether the function reaches the wanted value without crossing it.
    """

    value: float
    reached: float
    until: float | None = None
    is_extreme: bool = False


@dataclass
class Function:
    """A function of one variable that remembers its values and where it has none.

    Parameters
    ----------
    compute : callable
        Function of the variable.
    values : dict of float to float
        Computed values; NaN where there is none.
    refused : dict of float to str
        Reason where it has none.
    coarse : set of float
        Values of the variable at which it was computed before any refinement.
    """

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
            except ElectrovibError as error:
                self.values[at] = math.nan
                self.refused[at] = str(error.problems[0])
        return self.values[at]

    def certain(self, at: float) -> float:
        """Return the value, or raise CannotBeComputedError."""
        value = self(at)
        if not math.isfinite(value):
            raise CannotBeComputedError
        return value

    @property
    def known(self) -> list[tuple[float, float]]:
        """Variable and value, finite, in increasing order of the variable."""
        return sorted((at, value) for at, value in self.values.items() if math.isfinite(value))


def explore(function: Function, values: Iterable[float], *, most_added: int = MOST_ADDED) -> None:
    """Compute a function at given values, and at more of them where it is bent.

    Parameters
    ----------
    function : Function
        Remembers what is computed.
    values : iterable of float
        First values of the variable.
    most_added : int
        Largest number of values that are added where the function is bent.
    """
    for each in values:
        function(each)
        function.coarse.add(float(each))
    added = 0
    seen: set[float] = set()
    for _ in range(ROUNDS):
        asked: dict[float, None] = {}
        points = function.known
        for before, here, after in zip(points, points[1:], points[2:], strict=False):
            if here[0] not in seen and _is_bent(before, here, after):
                asked |= dict.fromkeys([middle(before[0], here[0]), middle(here[0], after[0])])
        fresh = [each for each in asked if each not in function.values][: most_added - added]
        if not fresh:
            return
        added += len(fresh)
        for each in fresh:
            function(each)


def middle(first: float, second: float) -> float:
    """Return the value half way between two in their natural coordinate."""
    if coordinate(first, second):
        return math.copysign(math.sqrt(abs(first)) * math.sqrt(abs(second)), first)
    return 0.5 * (first + second)


def _is_bent(before: tuple[float, float], here: tuple[float, float], after: tuple[float, float]) -> bool:
    """Tell whether a value deviates from the chord of its neighbours, in logarithms where these exist."""
    (a, fa), (b, fb), (c, fc) = before, here, after
    ratio = coordinate(a, c) and coordinate(a, b)
    share = math.log(b / a) / math.log(c / a) if ratio else (b - a) / (c - a)
    if coordinate(fa, fb) and coordinate(fb, fc):
        chord = math.log(abs(fa)) + share * math.log(abs(fc / fa))
        return abs(math.log(abs(fb)) - chord) > BENT
    scale = max(abs(fa), abs(fb), abs(fc))
    return scale > 0 and abs(fb - fa - share * (fc - fa)) > BENT * scale


def sharpen_extremes(function: Function, target: float) -> None:
    """Refine the extremes of a function that can decide whether the wanted value is reached.

    Parameters
    ----------
    function : Function
        After `explore`.
    target : float
        Wanted value.

    Notes
    -----
    Those between which the function could reach the wanted value, and the largest and the smallest value of all.
    """
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
        open_gap = 0 < side * (target - values[i]) <= room
        if open_gap or i in {top, bottom}:
            _extreme(function, points[i - 1][0], points[i + 1][0], side)


def _turn(before: float, here: float, after: float) -> int:
    """Return 1 at a local maximum, -1 at a local minimum, else 0."""
    if here >= max(before, after) and here > min(before, after):
        return 1
    if here <= min(before, after) and here < max(before, after):
        return -1
    return 0


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


def coordinates(low: float, high: float) -> tuple[Callable[[float], float], tuple[float, float]]:
    """Return the inverse of the natural coordinate between two values, and their coordinates."""
    if not coordinate(low, high):
        return (lambda u: u), (low, high)
    sign = math.copysign(1.0, low)
    first, second = math.log(abs(low)), math.log(abs(high))

    def inverse(u: float) -> float:
        return low if u == first else high if u == second else sign * math.exp(u)

    if first < second:
        return inverse, (first, second)
    return inverse, (second, first)


def solutions(function: Function, target: float) -> tuple[list[Solution], list[float], bool]:
    """Find all values at which a function has a wanted value, between the values at which it is known.

    Parameters
    ----------
    function : Function
        After `explore` and `sharpen_extremes`.
    target : float
        Wanted value.

    Returns
    -------
    found : list of Solution
        In increasing order of the variable.
    jumps : list of float
        Values of the variable at which the function passes the wanted value discontinuously.
    is_all : bool
        False if the function passes the wanted value more often than `MOST_SOLUTIONS`.
    """
    points = function.known
    met = _met(points, target)
    found = _exact(function, points, met, target)
    jumps: list[float] = []
    crossings = [
        (first, second)
        for (first, second), (at_first, at_second) in zip(
            itertools.pairwise(points), itertools.pairwise(met), strict=True
        )
        if (first[1] - target) * (second[1] - target) < 0 and not (at_first or at_second)
    ]
    for first, second in crossings[:MOST_SOLUTIONS]:
        at = _root(function, first, second, target)
        if at is None:
            continue
        if _is_close(function(at), target, first[1], second[1], MISSED):
            found.append(Solution(at, function(at)))
        else:
            jumps.append(at)
    return _merged(found), jumps, len(crossings) <= MOST_SOLUTIONS


def _met(points: Sequence[tuple[float, float]], target: float) -> list[bool]:
    """Tell which of the known values are the wanted one already."""
    scale = max((abs(value) for _, value in points), default=0.0)
    return [abs(value - target) <= CLOSE * (abs(target) or scale * 1e-6) for _, value in points]


def _exact(
    function: Function, points: Sequence[tuple[float, float]], met: Sequence[bool], target: float
) -> list[Solution]:
    """Return known values that are solutions already: extremes, values met by chance, and intervals."""
    found: list[Solution] = []
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
            found.append(Solution(*best, is_extreme=len(beside) == 2 and beside[0] * beside[1] > 0))
        else:
            before, after = indices[0] - 1, indices[-1] + 1
            begin = _edge(function, points[before][0], first, target) if before >= 0 else first
            end = _edge(function, points[after][0], last, target) if after < len(points) else last
            found.append(Solution(*begin, until=end[0]))
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


def _merged(found: list[Solution]) -> list[Solution]:
    """Return solutions in order, with those that rounding has separated as one."""
    kept: list[Solution] = []
    for each in sorted(found, key=lambda solution: solution.value):
        if kept and abs(each.value - kept[-1].value) <= _SAME * abs(each.value):
            kept[-1] = Solution(each.value, each.reached, is_extreme=True)
            continue
        kept.append(each)
    return kept
