"""Limits of a value for several fingers."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.study.check import checked
from electrovib.study.check.result import FAIL
from electrovib.study.design.parameter.scale import first_values

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.study.check import CheckResult, LimitsSource
    from electrovib.study.design.robust.sample import DrawnFingers
    from electrovib.study.design.robust.share import Covered

MOST_FINGERS: Final = 8
"""Draws that are compared with the limits beside the scenario as it is."""
TRIED: Final = 24
"""Number of times that the distance between a value within the limits and one that exceeds them is halved."""


class MemberLimits:
    """The limits for the scenario as it is and for those draws that have the largest quantity at the value `at`."""

    def __init__(self, fingers: DrawnFingers, at: float, limits: Sequence[LimitsSource]) -> None:
        self._fingers, self._limits = fingers, list(limits)
        order = np.argsort(-fingers.each_at(at), kind="stable")
        self._chosen: list[int] = order[:MOST_FINGERS].tolist()
        self._order = list(range(self.count + 1))

    @property
    def count(self) -> int:
        """Number of draws that are compared."""
        return len(self._chosen)

    def worst(self, at: float) -> CheckResult:
        """Return the check of the member that comes nearest to a limit, or exceeds it most."""
        return max((self._check(each, at) for each in range(self.count + 1)), key=_excess)

    def _check(self, place: int, at: float) -> CheckResult:
        """Return the check of one member at a value; member 0 is the scenario as it is."""
        fingers, free = self._fingers, self._fingers.wanted.free
        member = (
            fingers.member(self._chosen[place - 1], at) if place else fingers.scenario.replace({free: at})
        )
        return checked(member, limits=self._limits)

    def best_within(self, covered: Covered, failing: float) -> float | None:
        """Return the value with the largest share of the draws that exceeds no limit; None if none is found.

        It is sought on a grid on either side of the failing value, and the limit there is bracketed.
        """
        wanted = self._fingers.wanted
        values = first_values(wanted.low, wanted.high, wanted.begin)
        sides = (values[values < failing][::-1], values[values > failing])
        found = [self._last_allowed([failing, *side.tolist()]) for side in sides]
        known = [each for each in found if each is not None]
        return max(known, key=covered.number_at, default=None)

    def _last_allowed(self, values: list[float]) -> float | None:
        """Return the value nearest to the first one, towards the last one, that exceeds no limit; the first one does."""
        ends = next((pair for pair in itertools.pairwise(values) if self._allows(pair[1])), None)
        if ends is None:
            return None
        forbidden, allowed = ends
        for _ in range(TRIED):
            middle = _middle(allowed, forbidden)
            if self._allows(middle):
                allowed = middle
            else:
                forbidden = middle
        return allowed

    def _allows(self, at: float) -> bool:
        """Return whether no limit is exceeded at a value; False where that cannot be computed."""
        for place in self._order:
            try:
                failed = bool(self._check(place, at).failed)
            except ElectrovibError:
                failed = True
            if failed:  # this member is asked first from now on
                self._order.remove(place)
                self._order.insert(0, place)
                return False
        return True


def _middle(first: float, second: float) -> float:
    """Return the geometric mean of two numbers above 0 that are far apart, else their mean."""
    low, high = sorted((first, second))
    return math.sqrt(low * high) if low > 0 and high > 2 * low else (low + high) / 2


def _excess(result: CheckResult) -> tuple[bool, float]:
    """Return whether a limit is exceeded, and the largest value over its limit [1]."""
    shares = [
        1 / row.margin if row.margin else math.inf
        for row in result.rows
        if row.margin is not None and (row.state == FAIL or not result.failed)
    ]
    return bool(result.failed), max(shares, default=0.0)
