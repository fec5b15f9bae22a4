"""Candidates of a plate: every combination of materials and parameters, solved and compared with every limit."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.citation import UNVERIFIED
from electrovib.core.quantity import quantity_of
from electrovib.physics.limits import SWITCH_ON, WORDS, Limits
from electrovib.physics.safety import AIR
from electrovib.studies.check import CheckRow, checked
from electrovib.studies.check.result import (
    FAIL,
    ONLY_DECLARED,
    PASS,
    UNKNOWN,
    breakdown_row,
    limit_row,
    limited_quantity,
)
from electrovib.studies.perceive import verdict
from electrovib.studies.sweep import sweep_cases

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.check import DeclaredLimit
    from electrovib.studies.sweep import Case

FILM: Final = "film strength"
"""Beginning of the name of the diagnostic of a layer's breakdown."""
FELT: Final = "detection level"
PERCEIVED: Final = "threshold over felt amplitude"
"""Quantity of the row of perception: 1 at the threshold."""
LIMITED: Final = {limited_quantity(name): name for name in WORDS}
"""Quantity to the name of its limit."""
QUANTITY, LARGEST, PARAMETER = "quantity", "largest value", "parameter"
_FELT_STATES: Final = {"detectable": PASS, "not detectable": FAIL}


@dataclass(frozen=True, kw_only=True)
class Objective:
    """What is maximised or minimised: ``"mean electrostatic_force"``, ``"peak voltage"`` or a dotted path.

    `sign` is -1 if the largest value is the best, 1 if the smallest is. `kind` is `QUANTITY` of a sweep,
    `LARGEST` value that a limit is compared with, or swept `PARAMETER`.
    """

    name: str
    unit: str
    sign: int
    kind: str

    @property
    def goal(self) -> str:
        """The word ``largest`` or ``smallest``."""
        return "largest" if self.sign < 0 else "smallest"

    def cost(self, candidate: PlateCandidate) -> float:
        """Return the value of a candidate, negative where the largest is the best; NaN where it is not known."""
        return self.sign * candidate.values[self.name]


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
        films = [row for row in self.rows if row.quantity.startswith(FILM)]
        return tuple(row.text for row in films if row.state == UNKNOWN or UNVERIFIED in row.text)


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
        names = [each.name for each in self.objectives if each.kind == QUANTITY]
        names += [FELT] if self.perceived and FELT not in names else []
        names = names or ["mean electrostatic_force"]  # a run is needed for the limits
        for place, material in enumerate(materials):

            def counted(done: int, of: int, before: int = place) -> None:
                if progress is not None:
                    progress(before * of + done, len(materials) * of)

            judged = self.members[material].model_copy(update={"limits": self._judged_limits()})
            cases = sweep_cases(judged, over, quantities=names, progress=counted).cases
            found += [self._candidate(material, case, refined=refined) for case in cases]
        return found

    def scenario(self, material: str, at: Mapping[str, float]) -> Scenario:
        """Return the scenario of a candidate, with its own limits."""
        return self.members[material].replace(dict(at))

    def _judged_limits(self) -> Limits:
        """Return limits with which a run judges every quantity that a row shows, the largest possible where none is declared.

        Root mean squares and the rate of change, which take a run of their own, need a limit or an objective.
        """
        asked = {LIMITED[each.name] for each in self.objectives if each.kind == LARGEST}
        values = {}
        for name in WORDS:
            quantity = quantity_of(Limits, name)
            assert quantity is not None
            if name in self.declared:
                values[name] = self.declared[name].value
            elif name in asked or name not in ONLY_DECLARED:
                values[name] = quantity.high
        return Limits(**values)

    def _candidate(self, material: str, case: Case, *, refined: bool) -> PlateCandidate:
        rows = self._rows(material, case)
        by_quantity = {row.quantity: row.value for row in rows}
        known = dict(case.at) | dict(case.values) | by_quantity
        values = {each.name: known[each.name] for each in self.objectives}
        judged = set(by_quantity) | {name.replace("_", " ") for name in WORDS}
        return PlateCandidate(
            material=material,
            at=dict(case.at),
            values={name: math.nan if value is None else value for name, value in values.items()},
            rows=rows,
            diagnostics=tuple(
                each
                for each in case.diagnostics
                if each.state == "warning" and each.name.removesuffix(SWITCH_ON) not in judged
            ),
            refined=refined,
        )

    def _rows(self, material: str, case: Case) -> tuple[CheckRow, ...]:
        """Compare a case with declared limits, breakdown and perception; a row in the state ``"fail"`` forbids it.

        An unverified strength of a film forbids too, and its row states the status.
        """
        declared, largest, diagnostics = self.declared, _largest(case.diagnostics), case.diagnostics
        names = [name for name in WORDS if name in largest or name in declared or name not in ONLY_DECLARED]
        elsewhere = {}
        if declared.keys() - largest.keys():  # limits that a run does not judge
            limits = Limits(**{name: each.value for name, each in declared.items()})
            result = checked(self.scenario(material, case.at), limits=[limits])
            elsewhere = {row.quantity: row for row in result.rows}
        rows = [
            elsewhere[limited_quantity(name)]
            if name in declared and name not in largest
            else limit_row(name, largest.get(name), declared.get(name))
            for name in names
        ]
        rows += [breakdown_row(each, strict=True) for each in diagnostics if each.name.startswith(FILM)]
        rows += [breakdown_row(each) for each in diagnostics if each.name in AIR]
        if self.perceived:
            person = self.members[material].perception
            assert person is not None
            rows.append(_felt_row(case.values[FELT], person.threshold_uncertainty))
        return tuple(rows)


def _largest(diagnostics: Sequence[Diagnostic]) -> dict[str, float | None]:
    """Return the largest value of each limited quantity that was judged; infinite without a bound, None if unknown."""
    by_title = {name.replace("_", " "): name for name in WORDS}
    found: dict[str, float | None] = {}
    for each in diagnostics:
        name = by_title.get(each.name.removesuffix(SWITCH_ON))
        if name is None:
            continue
        value = math.inf if each.value is None and each.state == "warning" else each.value
        held = found.get(name)
        if name not in found or held is None or (value is not None and value > held):
            found[name] = value
    return found


def _felt_row(level: float, uncertainty: float | None) -> CheckRow:
    """Return the row of perception: a change of friction below the detection threshold forbids the candidate."""
    is_known = not math.isnan(level)
    found = verdict(sensation=level if is_known else None, uncertainty=uncertainty)
    return CheckRow(
        quantity=PERCEIVED,
        value=float(10 ** (-level / 20)) if is_known else None,
        limit=1.0,
        unit="1",
        source="perception.threshold of the scenario",
        state=_FELT_STATES.get(found, UNKNOWN),
        text=f"the change of friction is {level:.3g} dB above the detection threshold: {found}",
    )
