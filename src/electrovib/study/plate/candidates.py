"""Candidates of a plate: every combination of materials and parameters, solved and compared with every limit."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.study.check.result import FAIL
from electrovib.study.plate.objectives import LARGEST, LIMITED, PARAMETER, Objective
from electrovib.study.plate.rows import FELT, is_doubtful, judged_limits, rows_of
from electrovib.study.sweep import sweep_cases

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckRow, DeclaredLimit
    from electrovib.study.sweep import Case

AS_IT_IS: Final = ""
"""Name of the material where the scenario keeps its own."""


@dataclass(frozen=True, kw_only=True)
class PlateCandidate:
    """One plate with its drive.

    - `material`: of the insulator; empty where the scenario keeps its own.
    - `at`: dotted path to value in SI; `values`: objective to its value, NaN where it is not known.
    - `rows`: comparison with every limit; a row in the state ``"fail"`` forbids the candidate.
    - `diagnostics`: those of the run that are warnings and belong to no row.
    - `refined`: whether it was added between the values that were asked for.
    """

    material: str
    at: Mapping[str, float]
    values: Mapping[str, float]
    rows: tuple[CheckRow, ...]
    diagnostics: tuple[Diagnostic, ...]
    refined: bool = False

    @functools.cached_property
    def forbidden_by(self) -> tuple[str, ...]:
        """Quantities whose limit is exceeded."""
        return tuple(row.quantity for row in self.rows if row.state == FAIL)

    @property
    def is_allowed(self) -> bool:
        """Whether no limit is exceeded."""
        return not self.forbidden_by

    def is_allowed_with(self, relaxed: Collection[str], factor: float) -> bool:
        """Return whether no limit is exceeded when some are multiplied by a factor; an infinite one omits them."""
        return all(
            row.quantity in relaxed
            and (math.isinf(factor) or (row.margin is not None and row.margin * factor >= 1))
            for row in self.rows
            if row.state == FAIL
        )

    @functools.cached_property
    def doubts(self) -> tuple[str, ...]:
        """Sentences on breakdown strengths that are unverified or may not apply to this layer."""
        return tuple(row.text for row in self.rows if is_doubtful(row))


@dataclass(frozen=True, kw_only=True)
class Plates:
    """What the candidates have in common; `perceived` states whether a detection threshold is calibrated."""

    members: Mapping[str, Scenario]
    declared: Mapping[str, DeclaredLimit]
    objectives: tuple[Objective, ...]
    perceived: bool

    def solve(
        self,
        over: Mapping[str, Sequence[float] | Real],
        *,
        materials: Sequence[str],
        refined: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> list[PlateCandidate]:
        """Solve every combination of materials and values, the last path running fastest."""
        found: list[PlateCandidate] = []
        names = [each.name for each in self.objectives if each.kind not in (LARGEST, PARAMETER)]
        names += [FELT] if self.perceived and FELT not in names else []
        names = names or ["mean electrostatic_force"]  # a run is needed for the limits
        for place, material in enumerate(materials):

            def counted(done: int, of: int, before: int = place) -> None:
                if progress is not None:
                    progress(before * of + done, len(materials) * of)

            member = self.members[material]
            judged = member.model_copy(update={"limits": judged_limits(self.declared, self.objectives)})
            cases = sweep_cases(judged, over, quantities=names, progress=counted).cases
            found += [self._candidate(material, case, refined=refined) for case in cases]
        return found

    def _candidate(self, material: str, case: Case, *, refined: bool) -> PlateCandidate:
        rows = rows_of(
            functools.partial(self.scenario, material, case.at),
            self.members[material].perception,
            case.diagnostics,
            self.declared,
            level=case.values[FELT] if self.perceived else None,
        )
        by_quantity = {row.quantity: row for row in rows}
        values = {}
        for each in self.objectives:
            if each.kind == PARAMETER:
                values[each.name] = case.at[each.name]
            elif each.kind == LARGEST:
                value = by_quantity[each.name].value
                values[each.name] = math.nan if value is None else value
            else:
                values[each.name] = case.values[each.name]
        judged = {row.quantity for row in rows} | {name.replace("_", " ") for name in LIMITED.values()}
        cautions = tuple(
            each
            for each in case.diagnostics
            if each.state == "warning"
            and each.name not in judged
            and each.name.removesuffix(" at switch-on") not in judged
        )
        return PlateCandidate(
            material=material,
            at=dict(case.at),
            values=values,
            rows=rows,
            diagnostics=cautions,
            refined=refined,
        )

    def scenario(self, material: str, at: Mapping[str, float]) -> Scenario:
        """Return the scenario of a candidate, with its own limits."""
        return self.members[material].replace(dict(at))
