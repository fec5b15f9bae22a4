"""Result of a check: a row for each limit, and comparisons that decide nothing."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.limits import TITLES
from electrovib.solve.quantities.answer import validity

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario

PASS: Final = "pass"  # noqa: S105  # the state of a row
FAIL: Final = "fail"
UNKNOWN: Final = "unknown"
STATES: Final = (PASS, UNKNOWN, FAIL)
"""From best to worst."""
BREAKDOWN: Final = ("film strength", "Paschen", "field emission")
"""Beginnings of the names of the diagnostics of breakdown."""


@dataclass(frozen=True, kw_only=True)
class CheckRow:
    """One quantity and its limit, both in the SI unit `unit`.

    - `value`: the largest value reached; infinite where it has no bound, None where it is not known.
    - `limit`: None where none is declared or known.
    - `source`: who declared the limit, or where it was published; how to declare it where there is none.
    - `state`: ``"pass"``, also at exactly the limit; ``"fail"`` above it; or ``"unknown"``.
    - `text`: one sentence about the comparison, with its conditions.
    """

    quantity: str
    value: float | None
    limit: float | None
    unit: str
    source: str
    state: str
    text: str

    @property
    def is_refused(self) -> bool:
        """Whether the limit is exceeded, or was declared and could not be compared."""
        return self.state == FAIL or (self.state == UNKNOWN and self.value is None and self.limit is not None)

    @property
    def margin(self) -> float | None:
        """Limit over value [1], 1 at the limit; None where one of them is not known."""
        if self.value is None or self.limit is None:
            return None
        return math.inf if self.value == 0 else self.limit / self.value


@dataclass(frozen=True, kw_only=True)
class CheckNumber:
    """A number that has no limit of its own, in its SI unit; None where it is not known."""

    quantity: str
    value: float | None
    unit: str


@dataclass(frozen=True, kw_only=True)
class CheckResult:
    """Largest values of a drive in a scenario compared with limits.

    - `title`: of the scenario, and the drive where it is another one.
    - `duration`: time from 0 up to which the drive was checked [s].
    - `rows`: declared limits, then breakdown of each layer and of air.
    - `comparisons`: published currents, which do not decide whether the check fails.
    - `numbers`: root-mean-square values and slew rate.
    - `notes`: what was assumed, and what the check does not state.
    - `scenario`: experiment with the drive that was checked.
    """

    title: str
    duration: float
    rows: tuple[CheckRow, ...]
    comparisons: tuple[CheckRow, ...]
    numbers: tuple[CheckNumber, ...]
    notes: tuple[str, ...]
    scenario: Scenario

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario that no row states."""
        return not_in_rows(validity(self.scenario))

    @property
    def state(self) -> str:
        """Return ``"fail"`` if a row fails, ``"pass"`` if all pass, else ``"unknown"``."""
        return max((row.state for row in self.rows), key=STATES.index, default=UNKNOWN)

    @property
    def failed(self) -> tuple[CheckRow, ...]:
        """Rows whose limit is exceeded."""
        return tuple(row for row in self.rows if row.state == FAIL)

    def refuse(self, consequence: str = "Nothing was written") -> None:
        """Raise an error if a limit is exceeded, or a declared one could not be compared."""
        refused = sorted((row for row in self.rows if row.is_refused), key=lambda row: row.state != FAIL)
        problems = [f"{row.text}. {consequence}" for row in refused]
        if problems:
            raise InputError(problems)

    def value(self, quantity: str) -> float | None:
        """Return the value of a row or number such as ``"peak voltage"``, in its unit; None where it is not known."""
        both: list[CheckRow | CheckNumber] = [*self.rows, *self.numbers]
        for each in both:
            if each.quantity == quantity:
                return each.value
        raise KeyError(quantity)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as nested tables; an infinite number is the text ``"infinite"``."""

        def plain(value: Any) -> Any:
            return "infinite" if isinstance(value, float) and math.isinf(value) else value

        def table(each: CheckRow | CheckNumber) -> dict[str, Any]:
            content = asdict(each)
            if isinstance(each, CheckRow):
                content["margin"] = each.margin
            return {name: plain(value) for name, value in content.items()}

        return {
            "title": self.title,
            "duration": self.duration,
            "state": self.state,
            "limits": [table(row) for row in self.rows],
            "comparisons": [table(row) for row in self.comparisons],
            "numbers": [table(number) for number in self.numbers],
            "notes": list(self.notes),
            "diagnostics": [each.to_dict() for each in self.diagnostics],
        }


def not_in_rows(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return the diagnostics that the rows of a check do not state: all but those of breakdown and of declared limits."""
    return tuple(
        each for each in diagnostics if each.name not in TITLES and not each.name.startswith(BREAKDOWN)
    )


def shown(value: float | None, unit: str) -> str:
    """Write a value with its unit for people: ``1 kV``; ``no bound`` and ``not known`` where there is no number."""
    if value is None:
        return "not known"
    return "no bound" if math.isinf(value) else format_quantity(value, unit, digits=4)
