"""The wanted quantity of draws from a space: the share of them that has it, and the value that each of them needs."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.tables import stored_changes
from electrovib.scenario.space import Space, SpaceSource, read_space
from electrovib.scenario.space.relations import checked_draws, checked_seed
from electrovib.solve.meter import Meter
from electrovib.studies.design import search
from electrovib.studies.design.wanted import Evaluation, Wanted
from electrovib.studies.sensitivity import Elasticity, slope
from electrovib.studies.widths import SAMPLING, Width, quantile_ranks

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


PERCENTILES: Final = (5, 25, 50, 75, 95)
"""Percentiles of the distribution that are stated."""
EXACT: Final = 1e-7
"""Relative deviation of the quantity from the wanted value, up to which a draw counts as solved."""
_DRAWS: Final = 200
"""Number of draws from a space."""
_NO_INPUTS: Final = ("time", "frequency", "limits")
"""Parts of a scenario that are no inputs of the model."""


@dataclass(frozen=True)
class Draws:
    """A space with the options of its draws."""

    space: Space
    n: int
    seed: int
    meter: Meter


@dataclass(frozen=True)
class NeededValues:
    """Distribution of the value that is needed, over draws from a space.

    `values` has NaN where a draw has none in the range; `remarks` state what of the space is unverified or
    was not drawn.
    """

    title: str
    values: Real
    seed: int
    remarks: tuple[str, ...]
    paths: tuple[str, ...]

    def sampling(self, unit: str) -> Width:
        """Return the 95 % interval of the median for the number of draws; infinite where they are too few."""
        known = np.sort(self.values[np.isfinite(self.values)])
        below, above = quantile_ranks(0.5, len(known))
        ends = (known[below - 1], known[above - 1]) if below and above <= len(known) else (math.inf,) * 2
        text = f"the 95 % interval of the median of {len(known)} draws"
        return Width(name=SAMPLING, text=text, interval=(float(ends[0]), float(ends[1])), unit=unit)

    @property
    def unsolved(self) -> int:
        """Number of draws without a value."""
        return int(np.sum(~np.isfinite(self.values)))

    def percentiles(self) -> dict[int, float]:
        """Return the percentiles of the draws that have a value, in the SI unit of the free parameter."""
        known = self.values[np.isfinite(self.values)]
        return {each: float(np.percentile(known, each)) if len(known) else math.nan for each in PERCENTILES}

    def to_dict(self) -> dict[str, Any]:
        """Return percentiles, draws and the method as a table."""
        known = {str(each): value for each, value in self.percentiles().items() if math.isfinite(value)}
        return {
            "space": self.title,
            "method": "each draw solved anew",
            "seed": self.seed,
            "percentiles": known,
            "without_a_value": self.unsolved,
            "draws": self.values,
            "remarks": self.remarks,
        }


def read_draws(
    scenario: Scenario, space: SpaceSource | None, *, n: int | None, seed: int | None
) -> Draws | None:
    """Read the space and check its options before anything is computed."""
    if space is None:
        given = [name for name, value in (("n", n), ("seed", seed)) if value is not None]
        if given:
            raise InputError(
                "belongs to the draws from a space, and none is given; add space, or omit it", path=given[0]
            )
        return None
    count = _DRAWS if n is None else n
    checked_draws(count)
    fingers = read_space(scenario, space)
    if seed is None:
        raise InputError(
            "missing: the draws from the space are those of a seed; add one, for instance 1", path="seed"
        )
    numbers = len(fingers.paths)
    meter = Meter.of_cases(
        "this design", f"{count} draws", count, numbers=numbers, remedy="choose a smaller n"
    )
    return Draws(fingers, count, checked_seed(seed), meter)


def inputs_of(scenario: Scenario, free: str) -> tuple[str, ...]:
    """Return the parameters other than the free one that an elasticity can be computed of: those that are not 0."""
    value = value_at(scenario, free)
    moved, _ = stored_changes(scenario, {free: 0.9 * value or 1.0})
    own = {*moved, free}
    return tuple(
        path
        for path, value, _ in scenario.parameters()
        if value and path not in own and path.partition(".")[0] not in _NO_INPUTS
    )


def influences(
    evaluation: Evaluation, at: Mapping[str, float], paths: tuple[str, ...]
) -> tuple[Elasticity, ...]:
    """Compute how the free parameter follows others, the largest first; empty where its own derivative is 0 or not known.

    With the quantity q(x, p), d ln x / d ln p = -(dq / d ln p) / (dq / d ln x).
    """
    own = slope(evaluation, at, evaluation.wanted.free)
    if not math.isfinite(own) or abs(own) <= 1e-9 * abs(evaluation.wanted.value):
        return ()
    scenario = evaluation.prepared.base
    found = []
    for path in paths:
        by_other = slope(evaluation, at, path)
        if math.isfinite(by_other):
            unit = quantity_at(scenario, path).unit
            found.append(Elasticity(path=path, at=at[path], unit=unit, value=-by_other / own + 0.0))
    return tuple(sorted(found, key=lambda each: -abs(each.value)))


def propagated(
    scenario: Scenario,
    wanted: Wanted,
    over: Draws,
    *,
    start: float,
    progress: Callable[[int, int], None] | None,
) -> NeededValues:
    """Compute the value that is needed for each draw; each search begins at its linear prediction from the medians."""
    report, space = over.meter.reporting(progress), over.space
    drawn = space.draw(over.seed, 0, over.n)
    fingers = DrawnFingers(
        scenario, wanted, {path: values for path, values in drawn.items() if path != wanted.free}
    )
    remarks = list(space.remarks)
    if len(fingers.draws) < len(drawn):
        remarks.append(f"{wanted.free} is not drawn: it is the parameter that is sought")
    middle = space.values({stream: np.array([0.5]) for stream in space.streams})
    medians = {path: float(middle[path][0]) for path in fingers.draws}
    center = solved(fingers.evaluation, medians, start)
    logs = np.zeros(over.n)
    if math.isfinite(center):
        at = medians | {wanted.free: center}
        for each in influences(fingers.evaluation, at, tuple(path for path in medians if medians[path])):
            ratio = drawn[each.path] / medians[each.path]
            if np.all(ratio > 0):
                logs += each.value * np.log(ratio)
    guesses = (center if math.isfinite(center) else start) * np.exp(np.clip(logs, -50, 50))
    values = np.empty(over.n)
    for finger, guess in enumerate(guesses.tolist()):
        report(finger, over.n)
        values[finger] = solved(fingers.evaluation, fingers.point(finger, guess), guess)
    return NeededValues(space.title, values, over.seed, tuple(remarks), tuple(fingers.draws))


def solved(evaluation: Evaluation, others: Mapping[str, float], guess: float) -> float:
    """Return the value of the free parameter for given other parameters, near a first guess; NaN if there is none."""
    wanted = evaluation.wanted
    function = search.Function(lambda at: evaluation({**others, wanted.free: at}))
    found = search.near_root(function, wanted.value, wanted.low, wanted.high, guess, EXACT)
    if math.isfinite(found):
        return found
    begin = guess if wanted.low < guess < wanted.high else wanted.high
    search.explore(function, search.first_values(wanted.low, wanted.high, begin))
    several = [each.value for each in search.solutions(function, wanted.value)[0]]
    return min(several, key=lambda each: _distance(each, guess), default=math.nan)


def _distance(value: float, other: float) -> float:
    return abs(math.log(value / other)) if search.has_ratio(value, other) else 1e6 + abs(value - other)
