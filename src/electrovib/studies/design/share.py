"""The value of one parameter at which a quantity is as wanted for a share of a population."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Panel
from electrovib.core.errors import InputError, Problem, gathered, refuse
from electrovib.core.paths import words_at
from electrovib.core.units import format_quantity
from electrovib.scenario.space import Space, SpaceSource, read_space
from electrovib.scenario.space.relations import checked_draws, checked_seed
from electrovib.solve.meter import Meter, measured
from electrovib.solve.quantities.answer import validity
from electrovib.studies.check import CheckResult, CheckRow, LimitsSource, checked
from electrovib.studies.check.result import not_in_rows, not_shown, shown
from electrovib.studies.design import uncertain
from electrovib.studies.design.limits import Limited, obtainable, several_limits
from electrovib.studies.design.result import Designed
from electrovib.studies.design.search import Function, explore, first_values
from electrovib.studies.design.uncertain import Covered, DrawnFingers
from electrovib.studies.design.wanted import BetweenSource, Wanted, read_band
from electrovib.studies.design.widths import Sampled, widths_of
from electrovib.studies.widths import SAMPLING, Width, clopper_pearson, quantile_ranks, sentences

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario

RESAMPLED: Final = 400
"""Bootstrap samples of the value with the largest share."""
MOST_FINGERS: Final = 8
"""Draws that are compared with the limits beside the scenario as it is."""
_FEWEST: Final = 20


@measured()
def design_for_share(
    scenario: Scenario,
    *,
    share: float,
    want: str,
    free: str,
    space: SpaceSource,
    seed: int,
    band: str | Sequence[Any] | None = None,
    between: BetweenSource | None = None,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    n: int = 1000,
    progress: Callable[[int, int], None] | None = None,
) -> DesignedForShare:
    """Find the value of one parameter at which a quantity is as wanted for a share of the fingers of a space.

    Every draw has the wanted quantity in intervals of the free parameter. At least a value: the result is the
    order statistic at which the share is just reached, its interval that of the binomial ranks, whatever the
    distribution. In a band: the value with the largest share, its interval from a bootstrap over the draws.
    Where the quantity is proportional to the square of the parameter, one solution of each draw suffices. As
    many further draws confirm the share.
    """
    problems: list[str | Problem] = []
    with gathered(problems):
        wanted, ends = read_band(scenario, want=want, band=band, free=free, between=between)
    with gathered(problems):
        over = read_space(scenario, space)
        if free in over.paths:
            raise InputError(
                f"free: {free} differs between the fingers of the space; remove it there, or seek another parameter"
            )
    with gathered(problems):
        checked_seed(seed)
    if isinstance(share, bool) or not isinstance(share, (int, float)) or not 0 < share < 1:
        problems.append(f"share = {share!r}: expected a number above 0 and below 1, for instance 0.9")
    with gathered(problems):
        checked_draws(n, fewest=_FEWEST, example=1000)
    refuse(problems)
    given = several_limits(limits, scenario)
    numbers = 2 * len(over.paths)
    meter = Meter.of_cases("this design", f"{n} draws", n, numbers=numbers, remedy="choose a smaller n")
    fingers = DrawnFingers(scenario, wanted, over.draw(seed, 0, n))
    quadratic = fingers.is_quadratic()
    by = uncertain.by_gain if quadratic else uncertain.by_solution
    cover = functools.partial(by, progress=meter.reporting(progress))
    fresh = replace(fingers, draws=over.draw(seed, n, 2 * n))
    sampled = _Sampled(fingers, fresh, cover(fingers, *ends), ends, share, seed, band is not None)
    top = (found := sampled.found()) or sampled.top()
    result = DesignedForShare(
        base=scenario,
        wanted=wanted,
        band=ends,
        space=over,
        share=share,
        n=n,
        seed=seed,
        found=found,
        widths=() if top is None else _widths(sampled, cover, top.value, over.paths),
        ranges=tuple(sampled.covered.where(uncertain.needed(share, n))),
        top=top,
        shares=sampled.covered.shares(),
        method="proportional to the square of the parameter, one solution each"
        if quadratic
        else f"solved at up to {uncertain.MOST_VALUES} values of the parameter, and between them by Brent's method",
        limits=given,
    )
    return result if result.top is None else _compared(result, result.top, sampled)


def _widths(
    sampled: _Sampled, cover: Callable[..., Covered], value: float, drawn: Collection[str]
) -> tuple[Width, ...]:
    """Return the widths of a value: the same question for other thresholds and a force that the law misses."""
    fingers, n = sampled.fingers, sampled.covered.count
    named = {fingers.wanted: fingers}

    def needed(wanted: Wanted, factor: float) -> Sampled:
        of = named.setdefault(wanted, replace(fingers, wanted=wanted))
        low, high = (wanted.with_force(each, factor) for each in sampled.ends)
        return replace(sampled, fingers=of, covered=cover(of, low, high), ends=(low, high)).estimate()

    main, unit, text = sampled.estimate(), fingers.wanted.declared.unit, f"the 95 % interval for {n} draws"
    sampling = Width(name=SAMPLING, text=text, interval=main[::2], unit=unit)
    if math.isnan(main[1]):
        main, sampling = (value,) * 3, Width(name=SAMPLING, text="the share is not reached")
    return widths_of(fingers.scenario, fingers.wanted, main, sampling=sampling, drawn=drawn, needed=needed)


@dataclass(frozen=True, kw_only=True)
class ShareAt:
    """Share of the fingers that have the wanted quantity at one value of the free parameter.

    `share` is that of the draws from which the value was found; `fresh_share`, of as many further draws, is
    no estimate at a value chosen with the same draws; `interval` is its 95 % confidence interval (Clopper and
    Pearson).
    """

    value: float
    share: float
    fresh_share: float
    interval: tuple[float, float]


@dataclass(frozen=True, kw_only=True, repr=False)
class DesignedForShare(Designed):
    """Value of one parameter at which a quantity is as wanted for a share of a population.

    - `base`, `space`: the values that all fingers share, and distributions of what differs between them.
    - `wanted`, `band`: quantity and free parameter, and smallest and largest wanted value, the largest may be
      infinite.
    - `share`: the wanted one; `n`, `seed`: number of draws, and their seed.
    - `found`: the value; None if the share is not reached anywhere in the range.
    - `ranges`: where the wanted share of the draws is reached.
    - `top`: `found`, or the value with the largest share where the wanted one is not reached; None if no draw
      has the wanted quantity.
    - `shares`: values of the parameter, and the share of the draws at each.
    - `method`: how the quantity of each finger was computed.
    - `check`: of the draw that comes nearest to a limit, or exceeds it most, at `top`; `checked`: number of
      draws that were compared with the limits; `unchecked`: why they cannot be compared.
    - `within`: largest share within the limits, where the value exceeds one.
    """

    form = "parameter for a share of a population"
    base: Scenario
    wanted: Wanted
    band: tuple[float, float]
    space: Space
    share: float
    n: int
    seed: int
    found: ShareAt | None
    ranges: tuple[tuple[float, float], ...]
    top: ShareAt | None
    shares: tuple[Real, Real]
    method: str
    check: CheckResult | None = None
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
    def failed(self) -> tuple[CheckRow, ...]:
        """Limits that are exceeded at the value."""
        return () if self.check is None else self.check.forbidding

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
    def sentences(self) -> tuple[str, ...]:
        """The answer, its uncertainty and the limits."""
        return (_answer(self), *_uncertainty(self), *_limits(self))

    @property
    def details(self) -> tuple[str, ...]:
        """How the quantity of each draw was computed, and what of the space is unverified."""
        return (
            f"{self.n} draws, seed {self.seed}; the quantity of each: {self.method}.",
            *self.space.remarks,
        )

    @property
    def figures(self) -> tuple[Panel, ...]:
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
        return (
            Panel(
                id="share", title=title, caption=said, x=x_axis, y=("share", "1"), curves=curves, log_x=log
            ),
        )

    def numbers(self) -> dict[str, Any]:
        """Return all numbers as nested tables."""
        wanted, low, high = self.wanted, *self.band
        return {
            "quantity": {"name": wanted.name, "unit": wanted.unit, "low": low, "high": high},
            "free": wanted.free_numbers(),
            "share": self.share,
            "space": self.space.as_table(),
            "n": self.n,
            "seed": self.seed,
            "value": self.value,
            "found": self.found and vars(self.found),
            "value_interval": self.value_interval,
            "ranges": self.ranges,
            "largest_share": None if self.found or not self.top else vars(self.top),
            "largest_share_within_limits": self.within and vars(self.within),
            "limits": self.check and self.check.to_dict()["limits"],
            "draws_compared_with_limits": self.checked,
            "method": self.method,
            "scenario": self.scenario and self.scenario.to_dict(),
        }


@dataclass(frozen=True)
class _Sampled:
    """Intervals of the draws, and further draws that confirm a share."""

    fingers: DrawnFingers
    fresh: DrawnFingers
    covered: Covered
    ends: tuple[float, float]
    share: float
    seed: int
    is_banded: bool

    def at(self, value: float) -> ShareAt:
        """Return the shares at a value of the free parameter; those of the further draws by their full solution."""
        low, high = self.ends
        quantity = self.fresh.each_at(value)
        number = int(np.count_nonzero((low <= quantity) & (quantity <= high)))
        return ShareAt(
            value=value,
            share=self.covered.number_at(value) / self.covered.count,
            fresh_share=number / self.fresh.count,
            interval=clopper_pearson(number, self.fresh.count),
        )

    def value_with(self, least: int, near: float) -> float:
        """Return the value at which so many draws are just reached, the nearest one; infinite if they never are."""
        wanted = self.fingers.wanted
        edges = [
            edge
            for start, end in self.covered.where(least)
            for edge, limit in ((start, wanted.low), (end, wanted.high))
            if edge != limit
        ] or [edge for each in self.covered.where(least) for edge in each]
        return min(edges, key=lambda edge: abs(edge - near), default=math.inf)

    def value(self) -> float:
        """Return the value for the wanted share; NaN if it is not reached."""
        least = uncertain.needed(self.share, self.covered.count)
        value, most = self.covered.best()
        if most < least:
            return math.nan
        return value if self.is_banded else self.value_with(least, self.fingers.wanted.begin)

    def estimate(self) -> Sampled:
        """Return the value with its 95 % interval."""
        value = self.value()
        low, high = (math.nan, math.nan) if math.isnan(value) else self.value_interval(value)
        return low, value, high

    def found(self) -> ShareAt | None:
        """Return the shares at the value for the wanted share; None if it is not reached."""
        value = self.value()
        return None if math.isnan(value) else self.at(value)

    def top(self) -> ShareAt | None:
        """Return the value with the largest share; None if no draw is reached."""
        value, most = self.covered.best()
        wanted = self.fingers.wanted
        if not self.is_banded:  # beyond the last draw the share of the population goes on rising
            ends = [each for each in (wanted.low, wanted.high) if self.covered.number_at(each) == most]
            value = ends[-1] if ends else value
        return None if most == 0 else self.at(value)

    def value_interval(self, value: float) -> tuple[float, float]:
        """Return the 95 % confidence interval of a value, in the unit of the parameter."""
        count = self.covered.count
        if self.is_banded:
            random = np.random.default_rng([self.seed, count])
            samples = (self.covered.resampled(random.integers(0, count, count)) for _ in range(RESAMPLED))
            values = np.array([each.best()[0] for each in samples])
            low, high = np.quantile(values[np.isfinite(values)], [0.025, 0.975])
            return float(low), float(high)
        ranks = quantile_ranks(self.share, count)
        ends = [self.value_with(rank, value) if 0 < rank <= count else math.inf for rank in ranks]
        return min(ends), max(ends)


def _compared(result: DesignedForShare, top: ShareAt, sampled: _Sampled) -> DesignedForShare:
    """Compare a value with the limits; where one is exceeded, find the largest share within them.

    They are compared for the scenario as it is, for the draws that have the largest quantity, and for those at either end of
    every drawn parameter: the thinnest film breaks down first, and need not be that of the largest quantity.
    """
    fingers, covered, wanted = sampled.fingers, sampled.covered, result.wanted

    def member(finger: int | None, at: float) -> CheckResult:
        point = {wanted.free: at} if finger is None else fingers.point(finger, at)
        return checked(result.base.replace(point), limits=list(result.limits))

    largest = np.argsort(-fingers.each_at(top.value), kind="stable")[:MOST_FINGERS].tolist()
    ends = [int(end) for values in fingers.draws.values() for end in (np.argmin(values), np.argmax(values))]
    chosen = list(dict.fromkeys([*largest, *ends]))
    limited = Limited(*(functools.partial(member, each) for each in (None, *chosen)))
    check, within = limited(top.value), None
    if check is not None and check.forbidding:
        function = Function(lambda at: covered.number_at(at) / covered.count)
        places = np.append(first_values(wanted.low, wanted.high, wanted.begin), top.value)
        explore(function, places, most_added=0)
        near = obtainable(function, limited, 1.0, top.value)
        within = None if near is None else sampled.at(near.value)
    return replace(
        result, check=check, checked=len(chosen), unchecked=limited.problem(top.value), within=within
    )


def wish(design: DesignedForShare) -> str:
    """Return the wanted quantity in words."""
    name = design.wanted.name.replace("_", " ")
    low, high = (design.wanted.quantity(each) if math.isfinite(each) else "" for each in design.band)
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
    lines += [f"{each[0].upper()}{each[1:]}." for each in not_shown(design.check.rows)]
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
