"""What can be obtained within the limits: the nearest value of the quantity that no limit forbids."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import ElectrovibError
from electrovib.study.check.result import FAIL
from electrovib.study.design.parameter.scale import coordinate
from electrovib.study.design.parameter.search import CannotBeComputedError, Function, coordinates

if TYPE_CHECKING:
    from electrovib.study.check import CheckResult, CheckRow

_TRIES: Final = 4
"""Number of limits that can be found one behind the other between two values."""
_NEAR: Final = 0.01
"""Relative distance below which two values are not both compared with the limits."""


@dataclass(frozen=True)
class Obtainable:
    """The value of the quantity nearest to the wanted one that no limit forbids.

    `row` is the limit that is reached there; None where the quantity itself does not come nearer.
    """

    value: float
    reached: float
    row: CheckRow | None


class Limited:
    """The limits as a function of the free parameter, each value checked once by `check`."""

    def __init__(self, check: Callable[[float], CheckResult]) -> None:
        self._check = check
        self._known: dict[float, CheckResult | None] = {}
        self._problems: dict[float, str] = {}

    def __call__(self, at: float) -> CheckResult | None:
        """Return the check at a value of the free parameter; None where it cannot be made."""
        if at not in self._known:
            try:
                self._known[at] = self._check(at)
            except ElectrovibError as error:
                self._known[at], self._problems[at] = None, str(error.problems[0])
        return self._known[at]

    def problem(self, at: float) -> str:
        """Return why the check cannot be made; empty where it could be."""
        return self._problems.get(at, "")

    def failed(self, at: float) -> tuple[CheckRow, ...]:
        """Return the limits that are exceeded; empty also where the check cannot be made."""
        result = self(at)
        return () if result is None else result.failed

    def allows(self, at: float) -> bool:
        """Return whether the check can be made and no limit is exceeded."""
        result = self(at)
        return result is not None and not result.failed


def obtainable(function: Function, limited: Limited, target: float, begin: float) -> Obtainable | None:
    """Find the value of a function nearest to the wanted one that no limit forbids; None if every known value exceeds one.

    Known values are checked in the order of their distance from the wanted one; of two that give the same,
    the one with the sign of `begin` counts. Where an allowed value has a neighbour that is nearer to the
    wanted one and is forbidden, the value at which the limit is reached is found by Brent's method.
    """
    points = _thinned(function.known)
    best: Obtainable | None = None
    order = sorted(range(len(points)), key=lambda i: (abs(points[i][1] - target), points[i][0] * begin < 0))
    for i in order:
        at, value = points[i]
        beside = [points[j] for j in (i - 1, i + 1) if 0 <= j < len(points)]
        nearest = min(abs(reached - target) for _, reached in [points[i], *beside])
        if (best is not None and nearest >= abs(best.reached - target)) or not limited.allows(at):
            continue
        found = [
            _at_limit(function, limited, at, other)
            for other, reached in beside
            if limited.failed(other) and abs(reached - target) < abs(value - target)
        ]
        for each in [*(each for each in found if each is not None), Obtainable(at, value, None)]:
            if best is None or abs(each.reached - target) < abs(best.reached - target):
                best = each
    return best


def _thinned(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Omit values that lie closely beside another one, as refinements have left them."""
    kept: list[tuple[float, float]] = []
    for at, value in points:
        if kept and coordinate(at, kept[-1][0]) and abs(math.log(at / kept[-1][0])) < _NEAR:
            continue
        kept.append((at, value))
    return kept


def _at_limit(function: Function, limited: Limited, allowed: float, forbidden: float) -> Obtainable | None:
    """Return the last allowed value towards a forbidden one."""
    from scipy.optimize import brentq

    row = None
    for _ in range(_TRIES):
        names = {each.quantity for each in limited.failed(forbidden)}
        inverse, ends = coordinates(allowed, forbidden)

        def excess(u: float, names: set[str] = names, inverse: Callable[[float], float] = inverse) -> float:
            return _excess(limited(inverse(u)), names)

        try:
            u = float(brentq(excess, *ends, xtol=1e-13 * max(map(abs, ends)) + 1e-300, rtol=1e-13))
        except (CannotBeComputedError, ValueError):
            return None
        at = _stepped_back(limited, inverse(u), allowed, names)
        result = limited(at)
        if result is None:
            return None
        row = max((each for each in result.rows if each.quantity in names), key=_share)
        if not result.failed:
            value = function(at)
            return Obtainable(at, value, row) if math.isfinite(value) else None
        forbidden = at
    return None


def _stepped_back(limited: Limited, at: float, allowed: float, names: set[str]) -> float:
    """Return a value next to a refined one at which none of these limits is exceeded by rounding."""
    step = 1e-12
    while step < 1e-6 and names & {each.quantity for each in limited.failed(at)}:
        at += step * (allowed - at)
        step *= 10
    return at


def _excess(result: CheckResult | None, names: set[str]) -> float:
    """Return the largest logarithm of value over limit of some limits; above 0 where one is exceeded."""
    if result is None:
        raise CannotBeComputedError
    shares = [_share(each) for each in result.rows if each.quantity in names]
    largest = max(shares, default=0.0)
    return math.log(max(min(largest, 1e300), 1e-300)) if largest > 0 else -700.0


def _share(row: CheckRow) -> float:
    """Return value over limit [1]; that of an unknown value is 0."""
    if row.value is None or not row.limit:
        return math.inf if row.state == FAIL else 0.0
    return row.value / row.limit
