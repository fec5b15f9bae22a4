"""Value of one parameter at which a quantity is as wanted for a share of a population."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, Problem, gathered
from electrovib.scenario.space import read_space
from electrovib.scenario.space.counter import checked_seed
from electrovib.solve.meter import Meter, measured
from electrovib.study.check import declared_limits
from electrovib.study.design.parameter.wanted import BetweenSource, read_wanted
from electrovib.study.design.robust.intervals import MOST_VALUES, by_gain, by_solution
from electrovib.study.design.robust.limits import MemberLimits
from electrovib.study.design.robust.result import DesignedForShare, ShareAt
from electrovib.study.design.robust.sample import DrawnFingers
from electrovib.study.design.robust.share import Covered, clopper_pearson, needed, quantile_ranks

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.scenario.space import Space, SpaceSource
    from electrovib.study.check import LimitsSource
    from electrovib.study.design.parameter.wanted import Wanted

RESAMPLED: Final = 400
"""Bootstrap samples of the value with the largest share."""
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
    wanted, ends, over = _read(scenario, share, want, band, free, between, space, seed, n)
    given = tuple(limits) if isinstance(limits, (list, tuple)) else () if limits is None else (limits,)
    declared_limits(scenario, list(given))
    what, remedy = "this design", "choose a smaller n"
    meter = Meter.of_cases(what, f"{n} draws", n, numbers=2 * len(over.paths), remedy=remedy)
    fingers = DrawnFingers(scenario, wanted, over.draw(seed, 0, n))
    quadratic = fingers.is_quadratic()
    covered = (by_gain if quadratic else by_solution)(fingers, *ends, progress=meter.reporting(progress))
    fresh = replace(fingers, draws=over.draw(seed, n, 2 * n))
    sampled = _Sampled(fingers, fresh, covered, ends, share, seed, is_banded=band is not None)
    found = sampled.found()
    top = found or sampled.top()
    result = DesignedForShare(
        base=scenario,
        wanted=wanted,
        band=ends,
        space=over,
        share=share,
        n=n,
        seed=seed,
        found=found,
        value_interval=(math.nan, math.nan) if found is None else sampled.value_interval(found.value),
        ranges=tuple(covered.where(needed(share, n))),
        top=top,
        check=None,
        checked=0,
        within=None,
        method="proportional to the square of the parameter, one solution each"
        if quadratic
        else f"solved at up to {MOST_VALUES} values of the parameter, and between them by Brent's method",
        limits=given,
    )
    return result if top is None else _compared(result, top, sampled, given)


def _read(
    scenario: Scenario,
    share: float,
    want: str,
    band: str | Sequence[Any] | None,
    free: str,
    between: BetweenSource | None,
    space: SpaceSource,
    seed: int,
    n: int,
) -> tuple[Wanted, tuple[float, float], Space]:
    """Read all arguments, and refuse every mistake at once."""
    problems: list[str | Problem] = []
    wanted: Wanted | None = None
    over: Space | None = None
    ends = math.nan, math.inf
    with gathered(problems):
        wanted, ends = _wanted(scenario, want, band, free, between)
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
    if isinstance(n, bool) or not isinstance(n, int) or n < _FEWEST:
        problems.append(f"n = {n!r}: expected a whole number of draws, {_FEWEST} or more, for instance 1000")
    if problems or wanted is None or over is None:
        raise InputError(problems)
    return wanted, ends, over


def _wanted(
    scenario: Scenario, want: str, band: Any, free: str, between: BetweenSource | None
) -> tuple[Wanted, tuple[float, float]]:
    """Read the quantity with its smallest and largest wanted value."""
    if band is None:
        text = want.replace(">=", "=") if isinstance(want, str) else want
        wanted = read_wanted(scenario, want=text, free=free, between=between)
        return wanted, (wanted.value, math.inf)
    if not isinstance(want, str) or "=" in want:
        raise InputError(
            f"want = {want!r}: with a band, name the quantity alone, for instance 'mean electrostatic_force'"
        )
    parts = band.split(":") if isinstance(band, str) else list(band)
    if len(parts) != 2:
        raise InputError(f"band = {band!r}: expected LOW:HIGH, for instance '20 mN:60 mN'")
    low, high = (read_wanted(scenario, want={want: each}, free=free, between=between) for each in parts)
    if not low.value < high.value:
        raise InputError(f"band = {band!r}: expected the smaller value first")
    return low, (low.value, high.value)


class _Sampled:
    """Intervals of the draws, and further draws that confirm a share."""

    def __init__(
        self,
        fingers: DrawnFingers,
        fresh: DrawnFingers,
        covered: Covered,
        ends: tuple[float, float],
        share: float,
        seed: int,
        *,
        is_banded: bool,
    ) -> None:
        self.fingers, self.fresh, self.covered = fingers, fresh, covered
        self.ends, self.share, self.seed, self.is_banded = ends, share, seed, is_banded

    def at(self, value: float) -> ShareAt:
        """Return the shares at a value of the free parameter; those of the further draws by their full solution."""
        low, high = self.ends
        quantity: Real = self.fresh.each_at(value)
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

    def found(self) -> ShareAt | None:
        """Return the value for the wanted share; None if it is not reached."""
        least = needed(self.share, self.covered.count)
        value, most = self.covered.best()
        if most < least:
            return None
        return self.at(value if self.is_banded else self.value_with(least, self.fingers.wanted.begin))

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
        if self.is_banded:
            return self._bootstrapped()
        low, high = quantile_ranks(self.share, self.covered.count)
        ends = [
            self.value_with(rank, value) if 0 < rank <= self.covered.count else math.inf
            for rank in (low, high)
        ]
        return min(ends), max(ends)

    def _bootstrapped(self) -> tuple[float, float]:
        random = np.random.default_rng([self.seed, self.covered.count])
        count = self.covered.count
        values = [
            self.covered.resampled(random.integers(0, count, count)).best()[0] for _ in range(RESAMPLED)
        ]
        known = np.array([each for each in values if math.isfinite(each)])
        return float(np.quantile(known, 0.025)), float(np.quantile(known, 0.975))


def _compared(
    result: DesignedForShare, at: ShareAt, sampled: _Sampled, limits: tuple[LimitsSource, ...]
) -> DesignedForShare:
    """Compare a value with the limits; where one is exceeded, find the largest share within them."""
    members = MemberLimits(sampled.fingers, at.value, limits)
    check = members.worst(at.value)
    within = None
    if check is not None and check.failed:
        value = members.best_within(sampled.covered, at.value)
        within = None if value is None else sampled.at(value)
    return replace(result, check=check, checked=members.count, within=within)
