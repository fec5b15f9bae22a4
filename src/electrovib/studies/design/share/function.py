"""The value of one parameter at which a quantity is as wanted for a share of a population."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from electrovib.core.errors import InputError, Problem, gathered, refuse
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.scenario.space import Space, SpaceSource, read_space
from electrovib.scenario.space.relations import checked_draws, checked_seed
from electrovib.solve.meter import Meter, measured
from electrovib.studies.check import CheckResult, LimitsSource, checked, declared_limits, several_limits
from electrovib.studies.design.limits import Limited, Sampled, obtainable, widths_of
from electrovib.studies.design.search import Function, explore, first_values
from electrovib.studies.design.share.result import (
    MOST_VALUES,
    Covered,
    DesignedForShare,
    DrawnFingers,
    ShareAt,
    by_gain,
    by_solution,
    needed_draws,
)
from electrovib.studies.design.wanted import FreeSource, Wanted, WantSource, read_wanted
from electrovib.studies.widths import SAMPLING, Width, clopper_pearson, quantile_ranks

RESAMPLED: Final = 400
"""Bootstrap samples of the value with the largest share."""
MOST_FINGERS: Final = 8
"""Draws that are compared with the limits beside the scenario as it is."""
_FEWEST: Final = 20
PERCENTAGES: Final = (5, 25, 50, 75, 95)
"""Shares of the draws, in per cent, for which the value is stated beside the wanted one."""


@measured()
def value_for_share(
    scenario: Source,
    *,
    want: WantSource,
    free: FreeSource,
    space: SpaceSource,
    share: float,
    seed: int,
    n: int = 1000,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    progress: Callable[[int, int], None] | None = None,
) -> DesignedForShare:
    """Find the value of one parameter at which a quantity is as wanted for a share of a population.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    want : str or mapping
        Quantity and least value, ``"mean electrostatic_force = 50 mN"``, or the band in which it has to lie,
        ``"mean electrostatic_force = 20 mN:60 mN"`` or ``{"mean electrostatic_force": (0.02, 0.06)}``.
    free : str or mapping
        Dotted path of the parameter that is sought, with or without the range, as for `electrovib.find_value`.
    space : str, Path, mapping or Space
        Distributions of what differs between fingers, as for `electrovib.read_space`: ``"fingers"``.
    share : float
        Share of the fingers that have to have the quantity [1].
    seed : int
        Seed of the draws from the space.
    n : int
        Number of draws; as many further ones confirm the share.
    limits : str, Path, mapping, Limits, or a list of them, optional
        Further limits beside those of the scenario; the strictest counts.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    progress : callable, optional
        Function of the number of draws done and of all draws.

    Returns
    -------
    DesignedForShare
        The value with its widths and the values for other shares; `scenario` has it where no limit forbids it.

    Raises
    ------
    InputError
        For every mistake in the arguments.

    Examples
    --------
    >>> import electrovib as ev
    >>> wanted = {"want": "mean electrostatic_force = 1 mN", "free": "drive.amplitude"}
    >>> found = ev.value_for_share("bau_2010/sine", **wanted, space="fingers", share=0.9, seed=1, n=100)
    >>> found.value > 0
    True
    """
    base = read_scenario(scenario, changes=set)
    wanted, over = _asked(base, want, free, space, share=share, seed=seed, n=n)
    given = several_limits(limits)
    declared_limits(base, given)  # a mistake is reported at once
    numbers = 2 * len(over.paths)
    meter = Meter.of_cases("this design", f"{n} draws", n, numbers=numbers, remedy="choose a smaller n")
    drawn = DrawnFingers(base, wanted, over.draw(seed, 0, n))
    quadratic = drawn.is_quadratic()
    cover = functools.partial(by_gain if quadratic else by_solution, progress=meter.reporting(progress))
    fresh = replace(drawn, draws=over.draw(seed, n, 2 * n))
    ends = wanted.value, wanted.upper
    sampled = _Sampled(drawn, fresh, cover(drawn, *ends), ends, share, seed)
    top = (found := sampled.found()) or sampled.top()
    method = f"solved at up to {MOST_VALUES} values of the parameter, and between them by Brent's method"
    if quadratic:
        method = "proportional to the square of the parameter, one solution each"
    result = DesignedForShare(
        base=base,
        wanted=wanted,
        space=over,
        share=share,
        n=n,
        seed=seed,
        found=found,
        widths=() if top is None else _widths(sampled, cover, top.value, over.paths),
        ranges=tuple(sampled.covered.where(needed_draws(share, n))),
        others=sampled.others(),
        top=top,
        shares=sampled.covered.shares(),
        method=method,
        limits=given,
    )
    return result if result.top is None else _compared(result, result.top, sampled)


def _asked(
    base: Scenario, want: WantSource, free: FreeSource, space: SpaceSource, *, share: float, seed: int, n: int
) -> tuple[Wanted, Space]:
    """Read what is wanted and the space, and report every mistake at once."""
    problems: list[str | Problem] = []
    with gathered(problems):
        wanted = read_wanted(base, want=want, free=free, banded=True)
    with gathered(problems):
        over = read_space(base, space)
    with gathered(problems):
        checked_seed(seed)
    if isinstance(share, bool) or not isinstance(share, (int, float)) or not 0 < share < 1:
        problems.append(f"share = {share!r}: expected a number above 0 and below 1, for instance 0.9")
    with gathered(problems):
        checked_draws(n, fewest=_FEWEST, example=1000)
    refuse(problems)
    if wanted.free in over.paths:
        raise InputError(
            f"free: {wanted.free} differs between the fingers of the space; remove it there, or seek another parameter"
        )
    return wanted, over


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


@dataclass(frozen=True)
class _Sampled:
    """Intervals of the draws, and further draws that confirm a share."""

    fingers: DrawnFingers
    fresh: DrawnFingers
    covered: Covered
    ends: tuple[float, float]
    share: float
    seed: int

    @property
    def is_banded(self) -> bool:
        """Whether the quantity has to lie in a band."""
        return math.isfinite(self.ends[1])

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
        edges = [edge for each in self.covered.where(least) for edge in each]
        ends = {self.fingers.wanted.low, self.fingers.wanted.high}  # of the search, where nothing is crossed
        crossed = [edge for edge in edges if edge not in ends]
        return min(crossed or edges, key=lambda edge: abs(edge - near), default=math.inf)

    def value(self) -> float:
        """Return the value for the wanted share; NaN if it is not reached."""
        least = needed_draws(self.share, self.covered.count)
        value, most = self.covered.best()
        if most < least:
            return math.nan
        return value if self.is_banded else self.value_with(least, self.fingers.wanted.begin)

    def others(self) -> dict[float, float]:
        """Return the values at which the shares of `PERCENTAGES` are just reached; none of a band, whose shares rise and fall."""
        count, begin = self.covered.count, self.fingers.wanted.begin
        several = () if self.is_banded else PERCENTAGES
        found = {each / 100: self.value_with(needed_draws(each / 100, count), begin) for each in several}
        return {share: value if math.isfinite(value) else math.nan for share, value in found.items()}

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

    def estimate(self) -> Sampled:
        """Return the value between the ends of its 95 % confidence interval, in the unit of the parameter."""
        count, value = self.covered.count, self.value()
        if math.isnan(value):
            return (math.nan,) * 3
        if self.is_banded:
            random = np.random.default_rng([self.seed, count])
            samples = (self.covered.resampled(random.integers(0, count, count)) for _ in range(RESAMPLED))
            values = np.array([each.best()[0] for each in samples])
            low, high = np.quantile(values[np.isfinite(values)], [0.025, 0.975])
            return float(low), value, float(high)
        ranks = quantile_ranks(self.share, count)
        ends = [self.value_with(rank, value) if 0 < rank <= count else math.inf for rank in ranks]
        return min(ends), value, max(ends)


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
