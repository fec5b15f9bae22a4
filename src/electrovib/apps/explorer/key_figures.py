"""The key figures of a page: forces, whether they are felt, and the nearest limit, each in one line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import STATES
from electrovib.studies.check.result import FAIL, OUTCOMES, UNCERTAIN, UNKNOWN, nearest_limit
from electrovib.studies.widths import TOGETHER
from electrovib.view.summary import quantities_of_scenario
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.apps.explorer.computed import Computed, Further
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.studies.check.result import CheckRow
    from electrovib.studies.perceive import Percept

FORCES: Final = {
    "peak electrostatic_force": "Peak attraction",
    "mean electrostatic_force": "Mean attraction",
    "peak lateral_force": "Peak lateral force",
}
"""Quantities of a run, and what the page calls them."""
FELT: Final = "Felt?"
LIMIT: Final = "Nearest limit"
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
    """Return what takes longer than the run, as far as it is known: exact forces, what is felt, and the nearest limit."""
    found = dict(further.forces) | {name: KeyFigure("–", why) for name, why in further.unanswered.items()}
    if further.percept is not None:
        found[FELT] = felt(further.percept)
    if further.check is not None:
        found[LIMIT] = limit(nearest_limit(further.check.rows), further.check.state)
    return found


_VERDICTS: Final = {"detectable": "yes", "not detectable": "no", "within the uncertainty": "undecided"}


def felt(percept: Percept) -> KeyFigure:
    """State whether a drive is felt, and by how many decibels it is above the threshold."""
    if not percept.loudest:
        return KeyFigure("no", "nothing moves the skin")
    middle, spread = percept.sensation, percept.uncertainty
    if middle is None or spread is None:
        return KeyFigure("unknown", "no threshold is known")
    whose = "published thresholds" if percept.left else "the threshold"
    ends = f"{_level(middle - spread)} to {_level(middle + spread)} dB relative to {whose}"
    law = next((each.interval for each in percept.widths if each.name == TOGETHER), None)
    more = f"{_level(law[0])} to {_level(law[1])} dB with" if law else "without"
    return KeyFigure(
        f"{_VERDICTS[percept.verdict]}, {_level(middle)} dB", f"{ends}; {more} the spread of the force law"
    )


def _level(value: float) -> str:
    return f"{np.round(value) + 0.0:+.0f}".replace("-", "\N{MINUS SIGN}").replace("+0", "0")


def limit(row: CheckRow | None, state: str) -> KeyFigure:
    """State how much of the nearest limit is reached, and the outcome of the whole check, whose `state` is given."""
    outcome = OUTCOMES[state]
    if row is None or row.value is None or row.limit is None:
        return KeyFigure("none", f"no limit is declared or known: {outcome}", state)
    sizes = " of ".join(pretty_quantity(each, row.unit, digits=3) for each in (row.value, row.limit))
    doubt = f", {UNCERTAIN}" if row.state == UNKNOWN else ""
    reached = outcome if state == FAIL else f"{100 * row.value / row.limit:.2g} % reached"
    rest = "" if state == FAIL else f"; {outcome}"
    return KeyFigure(reached, f"{row.named}: {sizes}{doubt}{rest}", state)
