"""Result of the search for one parameter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from electrovib.study.design.parameter.tables import tables_of
from electrovib.study.design.parameter.words import lines_of, verdict_of

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckResult, CheckRow, LimitsSource
    from electrovib.study.design.parameter.roots import Root
    from electrovib.study.design.parameter.uncertain import NeededValues
    from electrovib.study.design.parameter.wanted import Wanted
    from electrovib.study.design.parameter.within import Obtainable
    from electrovib.study.elasticity import Elasticity
    from electrovib.study.reproduction import Table


@dataclass(frozen=True, kw_only=True)
class FoundValue:
    """A value of the free parameter that gives the wanted quantity, compared with the limits.

    - `value`, `reached`: of the free parameter, and of the quantity through the full model.
    - `until`: other end of an interval whose every value gives the wanted quantity; None for a single value.
    - `is_extreme`: whether the quantity reaches the wanted value here without crossing it.
    - `check`, `problem`: comparison with the limits; None where it cannot be made, and why.
    """

    value: float
    until: float | None
    is_extreme: bool
    reached: float
    check: CheckResult | None
    problem: str = ""

    @property
    def failed(self) -> tuple[CheckRow, ...]:
        """Limits that are exceeded."""
        return () if self.check is None else self.check.failed

    @property
    def is_allowed(self) -> bool:
        """Whether no limit is exceeded, as far as they could be compared."""
        return not self.failed


@dataclass(frozen=True, kw_only=True)
class Explored:
    """Where the quantity was computed, at `count` values of the free parameter.

    `lowest` and `highest` are such a value and the quantity there, `refused` has the reasons where nothing
    could be computed, and `unknown` values have no known quantity. The quantity passes the wanted value
    discontinuously at the `jumps`, and `beyond` the listed solutions; `is_settled` is False if finer values
    kept showing further ones.
    """

    count: int
    lowest: tuple[float, float]
    highest: tuple[float, float]
    refused: dict[float, str]
    unknown: int
    jumps: tuple[float, ...]
    beyond: int
    is_settled: bool

    @property
    def is_all(self) -> bool:
        """Whether every solution that was seen is listed, and none appeared between finer values."""
        return self.is_settled and not self.beyond


@dataclass(frozen=True, kw_only=True, repr=False)
class DesignedParameter:
    """Values of one parameter that give a wanted quantity.

    - `base`: scenario from which the search began.
    - `wanted`: quantity, its value, and the free parameter with its range.
    - `solutions`: those within the limits first, and of these those with the sign of the value in the
      scenario, the nearest to it first.
    - `explored`: where the quantity was computed.
    - `obtainable`: nearest value of the quantity within the limits, where no solution is allowed; else None.
    - `influences`: how the first solution follows other parameters, the largest first.
    - `distribution`: of the value that is needed, over a space; None without one.
    - `diagnostics`: of the first solution, else of the scenario as it is, beyond those that the check states.
    - `limits`: further limits that were given.
    """

    base: Scenario
    wanted: Wanted
    solutions: tuple[FoundValue, ...]
    explored: Explored
    obtainable: Obtainable | None
    influences: tuple[Elasticity, ...]
    distribution: NeededValues | None
    diagnostics: tuple[Diagnostic, ...]
    limits: tuple[LimitsSource, ...]

    @property
    def best(self) -> FoundValue | None:
        """First solution within the limits; None if there is none."""
        return next((each for each in self.solutions if each.is_allowed), None)

    @property
    def value(self) -> float:
        """First value of the free parameter within the limits, in its SI unit; NaN if there is none."""
        return math.nan if self.best is None else self.best.value

    @property
    def values(self) -> tuple[float, ...]:
        """All values of the free parameter within the limits, in its SI unit."""
        return tuple(each.value for each in self.solutions if each.is_allowed)

    @property
    def scenario(self) -> Scenario | None:
        """Scenario with the first value within the limits; None if there is none."""
        return None if self.best is None else self.base.replace({self.wanted.free: self.best.value})

    @property
    def is_achieved(self) -> bool:
        """Whether a value gives the wanted quantity within the limits."""
        return self.best is not None

    @property
    def verdict(self) -> tuple[str, ...]:
        """The sentences among `lines` that are needed first, warnings included."""
        return verdict_of(self)

    @property
    def lines(self) -> tuple[str, ...]:
        """Sentences and numbers for people, the answer first."""
        return lines_of(self)

    @property
    def tables(self) -> list[Table]:
        """Solutions, percentiles and elasticities as tables of words."""
        return tables_of(self)

    def __repr__(self) -> str:
        return "\n".join(self.lines)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as nested tables with numbers in SI; what is not known is None."""
        wanted, nearest, spread = self.wanted, self.obtainable, self.distribution
        return {
            "form": "parameter",
            "quantity": {"name": wanted.name, "unit": wanted.unit, "wanted": wanted.value},
            "free": {
                "path": wanted.free,
                "unit": wanted.declared.unit,
                "in_the_scenario": wanted.begin,
                "low": wanted.low,
                "high": wanted.high,
            },
            "value": _plain(self.value),
            "solutions": [_solution_table(each) for each in self.solutions],
            "reachable": {
                "lowest": {"at": self.explored.lowest[0], "quantity": self.explored.lowest[1]},
                "highest": {"at": self.explored.highest[0], "quantity": self.explored.highest[1]},
                "discontinuities": list(self.explored.jumps),
                "is_all": self.explored.is_all,
                "beyond": self.explored.beyond,
                "evaluations": self.explored.count,
            },
            "obtainable_within_limits": None
            if nearest is None
            else {
                "at": nearest.value,
                "quantity": nearest.reached,
                "limit": None if nearest.row is None else nearest.row.text,
            },
            "elasticities": {each.path: each.value for each in self.influences},
            "distribution": None if spread is None else spread.to_dict(),
            "diagnostics": [each.to_dict() for each in self.diagnostics],
            "scenario": None if self.scenario is None else self.scenario.to_dict(),
            "text": list(self.lines),
        }


def found_value(solution: Root, check: CheckResult | None, problem: str) -> FoundValue:
    """Return a solution of the search with its comparison with the limits."""
    return FoundValue(
        value=solution.value,
        until=solution.until,
        is_extreme=solution.is_extreme,
        reached=solution.reached,
        check=check,
        problem=problem,
    )


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _solution_table(each: FoundValue) -> dict[str, Any]:
    return {
        "value": each.value,
        "until": each.until,
        "is_extreme": each.is_extreme,
        "quantity": each.reached,
        "is_allowed": each.is_allowed,
        "limits": None if each.check is None else each.check.to_dict()["limits"],
        "not_compared": each.problem or None,
    }
