"""The values of a parameter at which each draw has a quantity, and that for a share of them, in sentences and numbers."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from electrovib.core.answer import REFERENCE, Curve, Document, Panel, as_sentence
from electrovib.core.arrays import Real
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import words_at
from electrovib.core.units import format_quantity
from electrovib.scenario import Scenario
from electrovib.scenario.space import Space
from electrovib.solve.quantities.answer import validity
from electrovib.studies.check.result import not_in_rows, not_shown, shown
from electrovib.studies.design import search
from electrovib.studies.design.result import Designed
from electrovib.studies.design.wanted import Evaluation, Wanted
from electrovib.studies.widths import sentences

Progress: TypeAlias = Callable[[int, int], None]
MOST_VALUES: Final = 17
"""Largest number of values of the free parameter at which every finger is solved first."""
_QUADRATIC: Final = 1e-7
"""Largest relative deviation from the square of the free parameter, at any of the values at which it is compared."""
_FEW: Final = 3
"""Fingers with which a shortcut is compared with the general solution."""
ROUNDED: Final = 1e-9
"""Part of one member of the sample that counts as rounding."""


def silent(_done: int, _of: int) -> None:
    """Report no progress."""


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

    def each_at(self, at: float, *, progress: Progress = silent) -> Real:
        """Compute the quantity of every finger at one value of the free parameter; one that is not known is refused."""
        together = self.together_at(at, progress=progress)
        if together is not None:
            return together
        found = np.empty(self.count)
        for finger in range(self.count):
            progress(finger, self.count)
            found[finger] = self.one_at(finger, at)
        return found

    def together_at(self, at: float, *, progress: Progress = silent) -> Real | None:
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


def by_gain(fingers: DrawnFingers, low: float, high: float, *, progress: Progress = silent) -> Covered:
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


def by_solution(fingers: DrawnFingers, low: float, high: float, *, progress: Progress = silent) -> Covered:
    """Return the intervals of fingers whose quantity depends on the free parameter in any form.

    Ends are refined by Brent's method between the values at which every finger was solved. A band that the
    quantity enters and leaves between two neighbouring values is not found.
    """
    wanted = fingers.wanted
    values = search.first_values(wanted.low, wanted.high, wanted.begin)
    if len(values) > MOST_VALUES:
        values = values[np.round(np.linspace(0, len(values) - 1, MOST_VALUES)).astype(int)]

    def begun(*_: int) -> None:
        progress(0, fingers.count)

    together = {at: fingers.together_at(at, progress=begun) for at in values.tolist()}

    def quantity(finger: int, at: float) -> float:
        row = together.get(at)
        return fingers.one_at(finger, at) if row is None else float(row[finger])

    found: list[tuple[float, float, int]] = []
    for finger in range(fingers.count):
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
        begun = np.searchsorted(np.sort(self.starts), edges, side="right")
        finished = (np.searchsorted(np.sort(self.ends), edges, side=side) for side in ("left", "right"))
        numbers = np.column_stack([begun - each for each in finished]).ravel()  # at an edge, and after it
        both = np.repeat(edges, 2)
        return both[:-1], both[1:], numbers[:-1]

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


def needed_draws(share: float, count: int) -> int:
    """Return the smallest number of members that is at least a share of them, one at least."""
    return max(1, math.ceil(share * count - ROUNDED))


@dataclass(frozen=True, kw_only=True)
class ShareAt:
    """Share of the fingers that have the wanted quantity at one value of the free parameter.

    `share` is that of the draws from which the value was found; `fresh_share` that of as many further draws, and `interval` its
    95 % confidence interval (Clopper and Pearson).
    """

    value: float
    share: float
    fresh_share: float
    interval: tuple[float, float]


@dataclass(frozen=True, kw_only=True, repr=False)
class DesignedForShare(Designed):
    """Value of one parameter at which a quantity is as wanted for a share of a population.

    - `base`, `space`: the values that all fingers share, and distributions of what differs between them.
    - `wanted`: quantity with its smallest and its largest wanted value, which may be infinite, and the free parameter.
    - `share`: the wanted one; `n`, `seed`: number of draws, and their seed.
    - `found`: the value; None if the share is not reached anywhere in the range.
    - `ranges`: where the wanted share of the draws is reached; `others`: share of the draws to the value at which it is just
      reached, NaN where it never is; empty for a band.
    - `top`: `found`, or the value with the largest share where the wanted one is not reached; None if no draw
      has the wanted quantity.
    - `shares`: values of the parameter, and the share of the draws at each.
    - `check`: of the draw that comes nearest to a limit, or exceeds it most, at `top`; `checked`: number of
      draws that were compared with the limits; `unchecked`: why they cannot be compared.
    - `within`: largest share within the limits, where the value exceeds one.
    """

    form = "parameter for a share of a population"
    base: Scenario
    wanted: Wanted
    space: Space
    share: float
    n: int
    seed: int
    found: ShareAt | None
    ranges: tuple[tuple[float, float], ...]
    others: Mapping[float, float]
    top: ShareAt | None
    shares: tuple[Real, Real]
    method: str
    checked: int = 0
    unchecked: str = ""
    within: ShareAt | None = None

    @property
    def value(self) -> float:
        """Value of the free parameter within the limits, in its SI unit; NaN if there is none."""
        return self.found.value if self.found is not None and self.is_achieved else math.nan

    @property
    def value_interval(self) -> tuple[float, float]:
        """95 % interval of the value for the number of draws; NaN without a value, infinite where they are too few for an end."""
        return (math.nan, math.nan) if self.found is None else self.widths[0].interval or (math.nan, math.nan)

    @property
    def is_achieved(self) -> bool:
        """Whether the share is reached and no limit is exceeded."""
        return self.found is not None and not self.failed

    @property
    def scenario(self) -> Scenario | None:
        """Scenario with the value; None if the share is not reached within the limits."""
        return self.base.replace({self.wanted.free: self.value}) if self.is_achieved else None

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with its own values and the value that was found, beyond those that the check states."""
        judged = self.base if self.top is None else self.base.replace({self.wanted.free: self.top.value})
        return not_in_rows(validity(judged))

    @property
    def document(self) -> Document:
        """The answer, its uncertainty and the limits; the values for other shares, and how they were found; the share."""
        known = {share: value for share, value in self.others.items() if math.isfinite(value)}
        others = ", ".join(f"{_percent(share)}: {_number(self, value)}" for share, value in known.items())
        remarks = (
            *([f"{self.wanted.free} at which a share of the draws has it: {others}."] if known else []),
            f"{self.n} draws, seed {self.seed}; the quantity of each: {self.method}.",
            *self.space.remarks,
        )
        said = (_answer(self), *_uncertainty(self), *_limits(self))
        return self._document(said, remarks=remarks, figures=[self._figure()])

    def _figure(self) -> Panel:
        """The share of the draws over the free parameter, with the wanted one and the value."""
        free, (x, y) = self.wanted.free, self.shares
        at = np.array([] if self.top is None else [(self.top.value, self.top.share)]).reshape(-1, 2).T
        curves = (
            Curve(label="share of the draws", x=x, y=y),
            Curve(label="wanted", x=x, y=np.full_like(y, self.share), kind="dashed", look=REFERENCE),
            Curve(label="value", x=at[0], y=at[1], kind="points", look=1),
        )  # fmt: skip
        title = f"Share of the fingers with {wish(self)}"
        log = len(x) > 0 and x[0] > 0 and x[-1] > 30 * x[0]
        x_axis, said = (words_at(self.base, free), self.wanted.declared.unit), f"{self.n} draws."
        return Panel(
            id="share", title=title, caption=said, x=x_axis, y=("share", "1"), curves=curves, log_x=log
        )

    def numbers(self) -> dict[str, Any]:
        """Return all numbers as nested tables."""
        wanted = self.wanted
        return {
            "quantity": {"name": wanted.name, "unit": wanted.unit, "low": wanted.value, "high": wanted.upper},
            "free": wanted.free_numbers(),
            "share": self.share,
            "space": self.space.as_table(),
            "n": self.n,
            "seed": self.seed,
            "value": self.value,
            "found": self.found and vars(self.found),
            "value_interval": self.value_interval,
            "ranges": self.ranges,
            "values_for_shares": {f"{each:g}": value for each, value in self.others.items()},
            "largest_share": None if self.found or not self.top else vars(self.top),
            "largest_share_within_limits": self.within and vars(self.within),
            "limits": self.check and self.check.to_dict()["limits"],
            "draws_compared_with_limits": self.checked,
            "method": self.method,
            "scenario": self.scenario and self.scenario.to_dict(),
        }


def wish(design: DesignedForShare) -> str:
    """Return the wanted quantity in words."""
    name = design.wanted.name.replace("_", " ")
    low, high = (
        design.wanted.quantity(each) if math.isfinite(each) else ""
        for each in (design.wanted.value, design.wanted.upper)
    )
    return f"{name} from {low} to {high}" if high else f"{name} of at least {low}"


def _answer(design: DesignedForShare) -> str:
    wanted, found, top = design.wanted, design.found, design.top
    if top is None:
        reach = f"from {wanted.parameter(wanted.low)} to {wanted.parameter(wanted.high)}"
        return f"No draw has a {wish(design)} for {wanted.free} {reach}."
    if found is None:
        return (
            f"A {wish(design)} is not reached for {_percent(design.share)} of the population: the largest share is"
            f" {_percent(top.share)}, at {_place(design, top)} (95 % interval of the share {_interval(top)})."
        )
    text = (
        f"{_place(design, found)} gives a {wish(design)} for {_percent(found.share)} of the draws; wanted:"
        f" {_percent(design.share)}."
    )
    if design.failed:
        text += f" It exceeds the limits: {', '.join(row.quantity for row in design.failed)}."
    return text


def _uncertainty(design: DesignedForShare) -> list[str]:
    widths = sentences(design.widths)
    if design.found is None:
        return [*widths]
    ranges = " and ".join(_range(design, low, high) for low, high in design.ranges)
    return [
        f"{widths[0]} The share is reached from {ranges}.",
        *widths[1:],
        f"Of {design.n} further draws {_percent(design.found.fresh_share)} have it there: 95 % interval of the share of the"
        f" population {_interval(design.found)}.",
    ]


def _range(design: DesignedForShare, low: float, high: float) -> str:
    """Write a range; an end that is only the end of the search is called so."""
    begins = "the beginning of the searched range, " if low <= design.wanted.low else ""
    ends = "the end of the searched range, " if high >= design.wanted.high else ""
    return f"{begins}{_number(design, low)} to {ends}{_number(design, high)}"


def _limits(design: DesignedForShare) -> list[str]:
    if design.check is None:
        return [f"The limits could not be compared: {design.unchecked}"] if design.unchecked else []
    lines = [
        f"{row.text} ({shown(row.value, row.unit)} of {shown(row.limit, row.unit)})" for row in design.failed
    ]
    if design.within is not None:
        each = design.within
        lines.append(
            f"Within the limits the largest share of the draws is {_percent(each.share)}, at {_place(design, each)}"
            f" (95 % interval of the share of the population {_interval(each)})."
        )
    elif design.failed:
        lines.append("No value that was tried is within the limits.")
    lines += map(as_sentence, not_shown(design.check.rows))
    lines.append(
        f"The limits were compared for the scenario as it is and for {design.checked} draws, those with the largest quantity and"
        " those at either end of every drawn parameter, not for all draws."
    )
    return lines


def _place(design: DesignedForShare, at: ShareAt) -> str:
    return f"{design.wanted.free} = {_number(design, at.value)}"


def _number(design: DesignedForShare, value: float) -> str:
    return format_quantity(value, design.wanted.declared.unit, digits=4)


def _percent(share: float) -> str:
    return f"{100 * share:.4g} %"


def _interval(each: ShareAt) -> str:
    return f"{100 * each.interval[0]:.3g} to {100 * each.interval[1]:.3g} %"
