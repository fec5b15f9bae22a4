"""What is in sight on every tab: the key figures, each in one line, and the drawing of the layers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import STATES
from electrovib.studies.check.result import FAIL, OUTCOMES, UNCERTAIN, UNKNOWN, nearest_limit
from electrovib.studies.widths import TOGETHER
from electrovib.view.pages import part
from electrovib.view.plots.layers import drawn_heights
from electrovib.view.style import layer_colours, pretty_quantity
from electrovib.view.summary import quantities_of_scenario

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


_HEIGHT, _STRIP = 190.0, 18.0
"""Height of all layers together, and of plate and finger each, in points of the drawing."""


def drawing(shown: Computed) -> str:
    """Draw the layers between plate and finger as SVG.

    Left, the layers to scale. Right, with heights that grow with the logarithm of the thickness, joined by
    lines to the left; beside each layer its thickness and the largest field and voltage of the run.
    """
    thicknesses = {name: layer.thickness for name, layer in shown.scenario.stack.layers.items()}
    heights, colours = drawn_heights(thicknesses), layer_colours(list(thicknesses))
    sums = np.cumsum([(0.0, 0.0), *((thicknesses[name], heights[name]) for name in thicknesses)], axis=0)
    true, drawn = (_STRIP + _HEIGHT * (1 - sums / sums[-1])).T
    layers = [
        {
            "words": name.replace("_", " "),
            "colour": colours[name],
            "thickness": pretty_quantity(thickness, "m"),
            "exact": pretty_quantity(thickness, "m", digits=4),
            "most": _most(shown.found.largest_fields.get(name), thickness),
            "true": true[place : place + 2],
            "drawn": drawn[place : place + 2],
        }
        for place, (name, thickness) in enumerate(thicknesses.items())
    ]
    return part("explorer.html.jinja", "drawing", layers=layers, height=_HEIGHT, strip=_STRIP)


def _most(field: float | None, thickness: float) -> str:
    if field is None:
        return ""
    strength, voltage = (
        pretty_quantity(field, "V/m", digits=3),
        pretty_quantity(field * thickness, "V", digits=3),
    )
    return f"at most {strength}, {voltage} across it"
