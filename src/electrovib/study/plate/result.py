"""Result of the design of a plate: all candidates, the Pareto set, the best one and what binds there."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.core.arrays import Real
from electrovib.solve.quantities.answer import validity
from electrovib.study.check.result import not_in_rows
from electrovib.study.plate.choice import Gain, best_of, efficient, gains_of

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckResult
    from electrovib.study.plate.candidates import PlateCandidate
    from electrovib.study.plate.objectives import Objective
    from electrovib.study.reproduction import Table


@dataclass(frozen=True, kw_only=True)
class PlateDesign:
    """Candidates of a plate, compared with every limit.

    - `scenario`: as it was given; `layer`: whose material is varied, empty where the material is kept.
    - `axes`, `units`: dotted path to the values that were asked for, in SI, and to their unit.
    - `objectives`: the first one decides which candidate is the best.
    - `candidates`: all of them.
    - `check`: `electrovib.check` of the best candidate; None if there is none.
    - `notes`: what was assumed, and what was not compared.
    """

    scenario: Scenario
    layer: str
    axes: Mapping[str, Real]
    units: Mapping[str, str]
    objectives: tuple[Objective, ...]
    candidates: tuple[PlateCandidate, ...]
    check: CheckResult | None
    notes: tuple[str, ...]

    @functools.cached_property
    def allowed(self) -> tuple[PlateCandidate, ...]:
        """Candidates that exceed no limit."""
        return tuple(each for each in self.candidates if each.is_allowed)

    @functools.cached_property
    def best(self) -> PlateCandidate | None:
        """Best candidate within all limits; None if there is none."""
        return best_of(self.candidates, self.objectives)

    @functools.cached_property
    def pareto(self) -> tuple[PlateCandidate, ...]:
        """Candidates within all limits of which no other one is better in one objective and no worse in the others."""
        return tuple(efficient(self.candidates, self.objectives))

    @functools.cached_property
    def gains(self) -> tuple[Gain, ...]:
        """Limits that bind at the best candidate, and what is reached with one of them relaxed."""
        best = self.best
        return () if best is None else tuple(gains_of(best, self.candidates, self.objectives))

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Warnings of the best candidate, or of the scenario where there is none, beyond those that the limits state."""
        return not_in_rows(validity(self.scenario)) if self.best is None else self.best.diagnostics

    @property
    def answer(self) -> str:
        """Which candidate is the best, what binds there, and what a less strict limit would gain."""
        from electrovib.study.plate.words import answer

        return answer(self)

    @property
    def tables(self) -> tuple[Table, ...]:
        """Limits at the best candidate, the Pareto set, and how many candidates each limit forbids."""
        from electrovib.study.plate.words import tables

        return tables(self)
