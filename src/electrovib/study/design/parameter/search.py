"""All values of one variable at which a function has a wanted value, its extremes, and where it cannot be computed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from electrovib.core.budget import BudgetError
from electrovib.core.errors import ElectrovibError
from electrovib.study.design.parameter.scale import coordinate

if TYPE_CHECKING:
    from collections.abc import Iterable

BENT: Final = 0.03
"""Relative deviation from the chord of its neighbours above which a value asks for values beside it."""
ROUNDS: Final = 4
"""Largest number of rounds of added values."""
MOST_ADDED: Final = 120
"""Largest number of values that are added where the function is bent, if nothing else is requested."""


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
    def known(self) -> list[tuple[float, float]]:
        """Variable and value, finite, in increasing order of the variable."""
        return sorted((at, value) for at, value in self.values.items() if math.isfinite(value))


def explore(function: Function, values: Iterable[float], *, most_added: int = MOST_ADDED) -> None:
    """Compute a function at given values, and at more of them where it is bent."""
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
    """Return the geometric mean of two values of the same sign, else the arithmetic one."""
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
    """Return the inverse of the natural coordinate between two values, and their own coordinates, the smaller first."""
    if not coordinate(low, high):
        return (lambda u: u), (low, high)
    sign = math.copysign(1.0, low)
    first, second = math.log(abs(low)), math.log(abs(high))

    def inverse(u: float) -> float:
        return low if u == first else high if u == second else sign * math.exp(u)

    if first < second:
        return inverse, (first, second)
    return inverse, (second, first)
