"""Objectives of the design of a plate: quantities of a run, largest values that limits are compared with, or parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError, Problem
from electrovib.core.paths import quantity_at
from electrovib.physics.limits import WORDS, unit_of_limit
from electrovib.study.check.rows import limited_quantity
from electrovib.study.sweep import read_quantities

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.scenario import Scenario

QUANTITY, LARGEST, PARAMETER = "quantity", "largest value", "parameter"


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


LIMITED: Final = {limited_quantity(name): name for name in WORDS}
"""Quantity to the name of its limit."""


def read_objectives(
    scenario: Scenario, paths: Sequence[str], maximise: Sequence[str], minimise: Sequence[str]
) -> tuple[Objective, ...]:
    """Read the names of objectives, those to be maximised first: quantities, those of `LIMITED`, or swept paths."""
    found: dict[str, Objective] = {}
    problems: list[str | Problem] = []
    for option, sign, names in (("maximise", -1, maximise), ("minimise", 1, minimise)):
        for text in [names] if isinstance(names, str) else names:
            try:
                objective = _objective(scenario, paths, " ".join(text.split()), sign)
            except InputError as error:
                problems += [f"{option}: {problem}" for problem in error.problems]
                continue
            if objective.name in found:
                problems.append(f"{option}: '{objective.name}' is an objective already; name it once")
            found[objective.name] = objective
    if problems:
        raise InputError(problems)
    if not found:
        raise InputError("name at least one objective, for instance maximise = 'mean electrostatic_force'")
    return tuple(found.values())


def _objective(scenario: Scenario, paths: Sequence[str], name: str, sign: int) -> Objective:
    if name in LIMITED:
        return Objective(name=name, unit=unit_of_limit(LIMITED[name]), sign=sign, kind=LARGEST)
    if name in paths:
        return Objective(name=name, unit=quantity_at(scenario, name).unit, sign=sign, kind=PARAMETER)
    if "." in name:
        raise InputError(
            f"'{name}' is not varied; the parameters that are varied are {', '.join(paths) or 'none'}"
        )
    ((named, (unit, _)),) = read_quantities(scenario, [name]).units.items()
    return Objective(name=named, unit=unit, sign=sign, kind=QUANTITY)
