"""The key figures of a page: forces, and the first sentences of `perceive` and `check`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import STATES
from electrovib.studies.widths import TOGETHER
from electrovib.view.summary import quantities_of_scenario
from electrovib.view.units import pretty_quantity, typeset

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.apps.explorer.computed import Computed, Further
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.studies.check.result import CheckResult
    from electrovib.studies.perceive import Percept

FORCES: Final = {
    "peak electrostatic_force": "Peak attraction",
    "mean electrostatic_force": "Mean attraction",
    "peak lateral_force": "Peak lateral force",
}
"""Quantities of a run, and what the page calls them."""
FELT: Final = "Felt?"
LIMIT: Final = "Limits"
VALIDITY: Final = "Validity"


@dataclass(frozen=True)
class KeyFigure:
    """A value in words, and a line about it; `state` is that of a limit or a diagnostic, such as ``"pass"`` or ``"warning"``."""

    value: str
    note: str = ""
    state: str = ""


def forces(found: Computed, note: str = "") -> dict[str, KeyFigure]:
    """Return the forces of a run at its output times, which are those of its curves; `note` stands below them."""
    return {name: _sampled(found, *quantity.split(), note=note) for quantity, name in FORCES.items()}


def validity(diagnostics: Sequence[Diagnostic]) -> KeyFigure:
    """Name what the result leaves open; the sentences stand below the curves."""
    found = {state: [each.name for each in diagnostics if each.state == state] for state in STATES}
    counts = [f"{len(found[state])} {state}" for state in reversed(STATES) if state != "ok" and found[state]]
    worst = next((state for state in reversed(STATES) if found[state]), "ok")
    names = [] if worst == "ok" else found[worst]
    return KeyFigure(", ".join(counts) or "ok", ", ".join(names).replace("_", " "), worst)


def exact_forces(found: Computed) -> dict[str, KeyFigure]:
    """Return the forces between the output times too; at these alone for a solver that advances in steps, which is stated."""
    known = quantities_of_scenario(found.scenario, tuple(FORCES), quick=True)
    exact = {
        name: KeyFigure(pretty_quantity(known[quantity], "N", digits=3))
        for quantity, name in FORCES.items()
        if quantity in known and np.isfinite(known[quantity])
    }
    return forces(found, "at the output times") | exact


def _sampled(found: Computed, how: str, signal: str, *, note: str) -> KeyFigure:
    """Return the largest or mean value of a signal at the output times."""
    if not found.has(signal):
        return KeyFigure("–", "not part of this scenario")
    values = np.asarray(found.values(signal), dtype=float)
    kept = np.isfinite(values)
    if not kept.any():
        return KeyFigure("–", "the finger rests")
    if how == "peak":
        value = float(np.abs(values[kept]).max())
    else:
        times = np.asarray(found.values("time"), dtype=float)[kept]
        span = float(times[-1] - times[0])
        value = float(np.trapezoid(values[kept], times) / span) if span else float(values[kept][0])
    return KeyFigure(pretty_quantity(value, "N", digits=3), note)


def answers(further: Further) -> dict[str, KeyFigure]:
    """Return what takes longer than the run, as far as it is known: exact forces, what is felt, and the limits."""
    found = dict(further.forces) | {name: KeyFigure("–", why) for name, why in further.unanswered.items()}
    if further.percept is not None:
        found[FELT] = felt(further.percept)
    if further.check is not None:
        found[LIMIT] = limit(further.check)
    return found


def felt(percept: Percept) -> KeyFigure:
    """State the answer of `perceive`: whether a drive is felt, and by how much, with what makes this uncertain."""
    value, _, note = percept.answer.removeprefix("felt or not: ").rpartition(": ")
    together = [each.sentence for each in percept.widths if each.name == TOGETHER]
    return KeyFigure(typeset(value or note), typeset(". ".join([note, *together] if value else together)))


def limit(found: CheckResult) -> KeyFigure:
    """State the verdict of `check`, and the limit that is closest."""
    value, _, names = found.verdict.partition(": ")
    closest = found.closest or "no limit is declared or known"
    return KeyFigure(value, typeset(f"{names}; {closest}" if found.failed else closest), found.state)
