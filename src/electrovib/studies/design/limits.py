"""The limits of a design: what they forbid at each value, how far a drive is from them; the widths of a designed value."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.limits import MEAN_SQUARES, limited
from electrovib.physics.perception import Perception
from electrovib.scenario import Scenario
from electrovib.studies import check, widths
from electrovib.studies.check.amplifier import PLACE, own_limits
from electrovib.studies.check.function import checked_values
from electrovib.studies.design.search import CannotBeComputedError, Function, Point, crossing, has_ratio
from electrovib.studies.design.wanted import Wanted
from electrovib.studies.widths import Width

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
    row: check.CheckRow | None


class Limited:
    """The limits as a function of the free parameter, of one experiment or several, each checked once at a value."""

    def __init__(self, *checks: Callable[[float], check.CheckResult]) -> None:
        self._checks = [functools.cache(functools.partial(_made, each)) for each in checks]
        self._first_asked = list(self._checks)

    def _known(self, at: float) -> list[check.CheckResult]:
        return [each for one in self._checks if not isinstance(each := one(at), str)]

    def __call__(self, at: float) -> check.CheckResult | None:
        """Return the check that comes nearest to a limit, or exceeds it most; None where one cannot be made."""
        return None if self.problem(at) else max(self._known(at), key=_nearness)

    def problem(self, at: float) -> str:
        """Return why a check cannot be made; empty where all can be."""
        return next((each for one in self._checks if isinstance(each := one(at), str)), "")

    def rows(self, at: float) -> list[check.CheckRow]:
        """Return the rows of all checks that can be made."""
        return [row for each in self._known(at) for row in each.rows]

    def failed(self, at: float) -> tuple[check.CheckRow, ...]:
        """Return the limits that are exceeded; empty also where the check cannot be made."""
        return tuple(row for row in self.rows(at) if row.forbids)

    def allows(self, at: float) -> bool:
        """Return whether all checks can be made and no limit is exceeded."""
        for one in self._first_asked:
            result = one(at)
            if isinstance(result, str) or result.forbidding:  # this one is asked first from now on
                self._first_asked.remove(one)
                self._first_asked.insert(0, one)
                return False
        return True

    def excess(self, at: float, names: set[str]) -> float:
        """Return the largest logarithm of value over limit of some limits; above 0 where one is exceeded."""
        if self(at) is None:
            raise CannotBeComputedError
        largest = max((_share(row) for row in self.rows(at) if row.quantity in names), default=0.0)
        return math.log(max(min(largest, 1e300), 1e-300)) if largest > 0 else -700.0


def _made(compare: Callable[[float], check.CheckResult], at: float) -> check.CheckResult | str:
    """Return a check, or why it cannot be made."""
    try:
        return compare(at)
    except ElectrovibError as error:
        return str(error.problems[0])


def obtainable(function: Function, limited: Limited, target: float, begin: float) -> Obtainable | None:
    """Find the value of a function nearest to the wanted one that no limit forbids; None if every known value exceeds one.

    Of several known values that give the same, the one with the sign of `begin` and nearest to it counts. Where an allowed value
    has a neighbour that is nearer to the wanted one and is forbidden, the limit is reached between them (Brent's method).
    """
    points = _thinned(function.known)
    best: Obtainable | None = None

    def rank(i: int) -> tuple[float, bool, float]:
        at, value = points[i]
        return abs(value - target), at * begin < 0, abs(at - begin)

    for i in sorted(range(len(points)), key=rank):
        at, value = points[i]
        beside = [points[j] for j in (i - 1, i + 1) if 0 <= j < len(points)]
        nearest = min(abs(reached - target) for _, reached in [points[i], *beside])
        if (best is not None and nearest >= abs(best.reached - target)) or not limited.allows(at):
            continue
        found = [
            _at_limit(function, limited, at, other)
            for other, reached in beside
            if abs(reached - target) < abs(value - target) and limited.failed(other)
        ]
        for each in [*(each for each in found if each is not None), Obtainable(at, value, None)]:
            if best is None or abs(each.reached - target) < abs(best.reached - target):
                best = each
    return best


def _thinned(points: list[Point]) -> list[Point]:
    """Omit values that lie closely beside another one, as refinements have left them."""
    kept: list[Point] = []
    for at, value in points:
        if kept and has_ratio(at, kept[-1][0]) and abs(math.log(at / kept[-1][0])) < _NEAR:
            continue
        kept.append((at, value))
    return kept


def _at_limit(function: Function, limited: Limited, allowed: float, forbidden: float) -> Obtainable | None:
    """Return the last allowed value towards a forbidden one."""
    for _ in range(_TRIES):
        names = {each.quantity for each in limited.failed(forbidden)}
        try:
            at = crossing(functools.partial(limited.excess, names=names), allowed, forbidden)
        except (CannotBeComputedError, ValueError):
            return None
        at = _stepped_back(limited, at, allowed, names)
        if limited(at) is None:
            return None
        if not limited.failed(at):
            row = max((each for each in limited.rows(at) if each.quantity in names), key=_share)
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


def _share(row: check.CheckRow) -> float:
    """Return value over limit [1]; that of an unknown value is 0."""
    if row.value is None or not row.limit:
        return math.inf if row.forbids else 0.0
    return row.value / row.limit


def _nearness(result: check.CheckResult) -> tuple[bool, float]:
    """Return whether a limit is exceeded, and the largest value over its limit [1]."""
    rows = result.forbidding or result.rows
    return bool(result.forbidding), max(map(_share, rows), default=0.0)


@dataclass(frozen=True)
class Bounds:
    """The strictest declared limits of a drive, and its largest voltage without saturation of its amplifier [V]."""

    declared: dict[str, check.DeclaredLimit]
    largest_drive: float

    @classmethod
    def of(cls, scenario: Scenario, limits: check.LimitsSource | Sequence[check.LimitsSource]) -> Bounds:
        """Return the strictest limits of a scenario, of its amplifier and of further places."""
        own = {"voltage": "its saturation", "current": "the largest that it supplies"}
        several = [*check.several_limits(limits), check.LimitsFrom(PLACE, own_limits(scenario), own)]
        return cls(check.declared_limits(scenario, several), scenario.circuit.supply.largest_input)

    def value(self, name: str) -> float | None:
        """Return a limit in its unit, by its name in `Limits`; None if it is not declared."""
        limit = self.declared.get(name)
        return None if limit is None else limit.value

    def overload(self, scenario: Scenario) -> dict[str, float]:
        """Return the largest value of a drive over each declared limit, NaN where it is not known.

        Of a quantity that grows with a power of the drive it is the root, so that each is proportional to the drive.
        """
        averaged = any(name in MEAN_SQUARES for name in self.declared)
        values = checked_values(scenario, mean_squares=averaged).largest
        ratios = {name: values[name] / limit.value for name, limit in self.declared.items()}
        return {name: float(each ** (1 / limited(name).order)) for name, each in ratios.items()}


def worst_of(ratios: Mapping[str, float]) -> float:
    """Return the largest known ratio of a value and its limit [1]; 0 without any."""
    return max((each for each in ratios.values() if not math.isnan(each)), default=0.0)


def refuse_exceeded(ratios: Mapping[str, float], what: str) -> None:
    """Refuse a drive that still exceeds a limit."""
    over = ", ".join(f"limits.{name}" for name, each in ratios.items() if each > 1)
    if over:
        raise InputError(f"no {what} was found that holds {over}; raise the limit or lower the target")


Sampled: TypeAlias = tuple[float, float, float]
"""Lower end for the number of draws, value, and upper end; NaN where no value gives what is wanted."""


def widths_of(
    scenario: Scenario,
    wanted: Wanted,
    main: Sampled,
    *,
    sampling: Width,
    drawn: Collection[str],
    needed: Callable[[Wanted, float], Sampled],
) -> tuple[Width, ...]:
    """Return the widths of the value `main`; `needed` computes it for another quantity, where the force has a factor."""
    unit, known = wanted.declared.unit, widths.factor_of(scenario, wanted.name)
    is_felt, factor = wanted.name == widths.LEVEL, known or 1.0
    names = (widths.HIGHEST_LEVEL, widths.LOWEST_LEVEL) if is_felt else (wanted.name, wanted.name)
    best, worst = (replace(wanted, name=name) for name in names)

    def alone(*cases: tuple[Wanted, float]) -> tuple[float, float]:
        return _between(*((value,) * 3 for _, value, _ in (main, *(needed(*case) for case in cases))))

    found, apart = [sampling], list[Width]()
    if is_felt:
        person = scenario.perception or Perception()
        has_skin = bool(person.compliance or scenario.finger)
        interval = alone((best, 1.0), (worst, 1.0))
        found.append(widths.threshold_width(person, interval, unit=unit, has_skin=has_skin))
        apart = [] if "perception.threshold" in drawn else [widths.BETWEEN_PEOPLE]
    missed = alone((wanted, factor), (wanted, 1 / factor)) if known else None
    found.append(widths.law_width(type(scenario.force).__name__, known, missed, unit=unit))
    parts = [each.name for each in found if each.interval and (each is not sampling or main[0] < main[2])]
    if len(parts) > 1:
        interval = _between(main, needed(best, factor), needed(worst, 1 / factor))
        text = ", ".join(parts)
        found.append(Width(name=widths.TOGETHER, text=text, interval=interval, unit=unit))
    return (*found, *apart)


def _between(main: Sampled, first: Sampled, second: Sampled) -> tuple[float, float]:
    """Return the ends of three values; NaN on the side on which no value gives what is wanted."""
    known = [each for each in (first, second) if not math.isnan(each[1])]
    low, high = min(each[0] for each in (main, *known)), max(each[2] for each in (main, *known))
    if len(known) == 2:
        return low, high
    is_below = bool(known) and known[0][1] < main[1]
    return low if is_below else math.nan, high if known and not is_below else math.nan
