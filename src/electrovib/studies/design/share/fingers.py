"""The wanted quantity of draws from a space, and the values of the free parameter at which each of them has it."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.studies.design import search
from electrovib.studies.design.wanted import Evaluation, Wanted

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.scenario import Scenario


MOST_VALUES: Final = 17
"""Largest number of values of the free parameter at which every finger is solved first."""
_QUADRATIC: Final = 1e-7
"""Largest relative deviation from the square of the free parameter, at any of the values at which it is compared."""
_FEW: Final = 3
"""Fingers with which a shortcut is compared with the general solution."""
ROUNDED: Final = 1e-9
"""Part of one member of the sample that counts as rounding."""


@dataclass(frozen=True)
class DrawnFingers:
    """Draws from a space, values in SI by dotted path, and the quantity of each of them, which is computed once."""

    scenario: Scenario
    wanted: Wanted
    draws: Mapping[str, Real]
    known: dict[Any, Any] = field(default_factory=dict, init=False)

    @property
    def count(self) -> int:
        """Number of fingers."""
        return len(next(iter(self.draws.values())))

    @functools.cached_property
    def evaluation(self) -> Evaluation:
        """The quantity as a function of the parameters that vary."""
        return Evaluation(self.scenario, self.wanted, (*self.draws, self.wanted.free))

    def point(self, finger: int, at: float) -> dict[str, float]:
        """Return the values of a finger and of the free parameter, in SI."""
        return {path: float(values[finger]) for path, values in self.draws.items()} | {self.wanted.free: at}

    def each_at(self, at: float, *, progress: Callable[[int, int], None] | None = None) -> Real:
        """Compute the quantity of every finger at one value of the free parameter; one that is not known is refused."""
        together = self.together_at(at, progress=progress)
        if together is not None:
            return together
        found = np.empty(self.count)
        for finger in range(self.count):
            if progress is not None:
                progress(finger, self.count)
            found[finger] = self.one_at(finger, at)
        return found

    def together_at(self, at: float, *, progress: Callable[[int, int], None] | None = None) -> Real | None:
        """Compute the quantity of every finger in arrays at one value of the free parameter; None where there are none."""
        if at not in self.known:
            held = self.scenario.replace({self.wanted.free: at})
            others = {path: values for path, values in self.draws.items() if path != self.wanted.free}
            self.known[at] = Evaluation(held, self.wanted, tuple(others)).of_many(others, progress=progress)
        found: Real | None = self.known[at]
        return found

    def one_at(self, finger: int, at: float) -> float:
        """Compute the quantity of one finger by the general solution; one that is not known is refused."""
        where = f"draw {finger}, {self.wanted.free} = {self.wanted.parameter(at)}"
        if (finger, at) in self.known:
            return float(self.known[finger, at])
        try:
            value = self.known[finger, at] = self.evaluation(self.point(finger, at))
        except ElectrovibError as error:
            raise InputError(f"{where}: {error.problems[0]}") from error
        if math.isnan(value):
            raise InputError(f"{where}: {self.wanted.name} is not known")
        return value

    def some(self) -> list[int]:
        """Return the indices of a few fingers: the first, the middle and the last one."""
        return [int(each) for each in np.unique(np.linspace(0, self.count - 1, _FEW).astype(int))]

    @functools.cached_property
    def reference(self) -> float:
        """Value of the free parameter at which gains are computed: the present one, or the middle of the range."""
        wanted = self.wanted
        if wanted.low <= wanted.begin <= wanted.high and wanted.begin > 0:
            return wanted.begin
        return math.sqrt(wanted.low * wanted.high) if wanted.low > 0 else (wanted.low + wanted.high) / 2

    def is_quadratic(self) -> bool:
        """Return whether a quantity, or its amplitude, is proportional to the square of the free parameter for a few fingers."""
        wanted, begin = self.wanted, self.reference
        others = {begin / 2, 2 * begin, wanted.low, wanted.high} - {begin}
        others = {each for each in others if each > 0 and wanted.low <= each <= wanted.high}
        for finger in self.some():
            try:
                first = wanted.amplitude(self.one_at(finger, begin))
                for at in others:
                    expected = first * (at / begin) ** 2
                    reached = wanted.amplitude(self.one_at(finger, at))
                    if not abs(reached - expected) <= _QUADRATIC * abs(expected):
                        return False
            except ElectrovibError:
                return False
            if not first > 0:
                return False
        return bool(others)


def by_gain(
    fingers: DrawnFingers, low: float, high: float, *, progress: Callable[[int, int], None] | None = None
) -> Covered:
    """Return the intervals of fingers whose quantity is proportional to the square of the free parameter.

    The gain g of each finger follows from one solution; with the quantity g x^2, or the amplitude of a level, x is from
    sqrt(low/g) to sqrt(high/g), as far as it lies in the range of the parameter. `high` may be infinite.
    """
    wanted, at = fingers.wanted, fingers.reference
    low, high = wanted.amplitude(low), wanted.amplitude(high)
    gains = wanted.amplitude(fingers.each_at(at, progress=progress)) / at**2
    positive = gains > 0
    gains = np.where(positive, gains, 1.0)
    starts, ends = np.sqrt(max(low, 0.0) / gains), np.sqrt(high / gains)
    kept = positive & (starts <= wanted.high) & (ends >= max(wanted.low, 0.0))
    starts, ends = np.maximum(starts[kept], wanted.low), np.minimum(ends[kept], wanted.high)
    return Covered(starts, ends, np.flatnonzero(kept), fingers.count)


def by_solution(
    fingers: DrawnFingers, low: float, high: float, *, progress: Callable[[int, int], None] | None = None
) -> Covered:
    """Return the intervals of fingers whose quantity depends on the free parameter in any form.

    Ends are refined by Brent's method between the values at which every finger was solved. A band that the
    quantity enters and leaves between two neighbouring values is not found.
    """
    wanted = fingers.wanted
    values = search.first_values(wanted.low, wanted.high, wanted.begin)
    if len(values) > MOST_VALUES:
        values = values[np.round(np.linspace(0, len(values) - 1, MOST_VALUES)).astype(int)]
    begun = None if progress is None else (lambda *_: progress(0, fingers.count))
    together = {at: fingers.together_at(at, progress=begun) for at in values.tolist()}

    def quantity(finger: int, at: float) -> float:
        row = together.get(at)
        return fingers.one_at(finger, at) if row is None else float(row[finger])

    found: list[tuple[float, float, int]] = []
    for finger in range(fingers.count):
        if progress is not None:
            progress(finger, fingers.count)
        pieces = search.inside_band(functools.partial(quantity, finger), values, low, high)
        found += [(start, end, finger) for start, end in pieces]
    starts, ends, members = np.array(found).reshape(-1, 3).T
    return Covered(starts, ends, members.astype(np.intp), fingers.count)


@dataclass(frozen=True)
class Covered:
    """Values of a variable at which each member of a sample fulfils a condition: closed intervals.

    `starts`, `ends` and `members`, shape (intervals,), give their ends and the member to which each belongs;
    those of one member are disjoint. `count` includes members without an interval.
    """

    starts: Real
    ends: Real
    members: NDArray[np.intp]
    count: int

    def number_at(self, at: float) -> int:
        """Return how many members fulfil the condition at a value of the variable."""
        return int(np.count_nonzero((self.starts <= at) & (at <= self.ends)))

    def steps(self) -> tuple[Real, Real, NDArray[np.intp]]:
        """Return the pieces on which the same members fulfil the condition: starts, ends and numbers of members."""
        edges = np.unique(np.concatenate([self.starts, self.ends]))
        if not len(edges):
            return np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.intp)
        begun = np.searchsorted(np.sort(self.starts), edges, side="right")
        finished = np.searchsorted(np.sort(self.ends), edges, side="left")
        after = begun - np.searchsorted(np.sort(self.ends), edges, side="right")
        starts = np.concatenate([edges, edges[:-1]])
        ends = np.concatenate([edges, edges[1:]])
        numbers = np.concatenate([begun - finished, after[:-1]])
        order = np.lexsort((ends, starts))
        return starts[order], ends[order], numbers[order]

    def shares(self) -> tuple[Real, Real]:
        """Return the ends of these pieces, and the share of the members that fulfil the condition there."""
        starts, ends, numbers = self.steps()
        return np.column_stack([starts, ends]).ravel(), np.repeat(numbers / self.count, 2)

    def where(self, least: int) -> list[tuple[float, float]]:
        """Return the intervals of the variable on which at least so many members fulfil the condition."""
        starts, ends, numbers = self.steps()
        found: list[tuple[float, float]] = []
        for start, end, number in zip(starts.tolist(), ends.tolist(), numbers.tolist(), strict=True):
            if number < least:
                continue
            if found and start <= found[-1][1]:
                found[-1] = found[-1][0], max(found[-1][1], end)
            else:
                found.append((start, end))
        return found

    def best(self) -> tuple[float, int]:
        """Return the value at which the most members fulfil the condition, NaN without any interval, and their number."""
        starts, ends, numbers = self.steps()
        if not len(numbers):
            return math.nan, 0
        most = int(np.max(numbers))
        places = np.flatnonzero(numbers == most)
        place = places[int(np.argmax(ends[places] - starts[places]))]
        low, high = float(starts[place]), float(ends[place])
        return (math.sqrt(low * high) if low > 0 else (low + high) / 2), most

    def resampled(self, chosen: NDArray[np.intp]) -> Covered:
        """Return the intervals of a sample drawn from this one with replacement, whose members are `chosen` (count,)."""
        times = np.bincount(chosen, minlength=self.count)[self.members]
        return Covered(
            np.repeat(self.starts, times),
            np.repeat(self.ends, times),
            np.repeat(self.members, times),
            len(chosen),
        )


def needed(share: float, count: int) -> int:
    """Return the smallest number of members that is at least a share of them, one at least."""
    return max(1, math.ceil(share * count - ROUNDED))
