"""What is in sight on every tab: the key figures, each in one line, and the drawing of the layers."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import STATES
from electrovib.studies.check.result import FAIL, OUTCOMES, UNCERTAIN, UNKNOWN, nearest_limit
from electrovib.studies.widths import TOGETHER
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


_HEIGHT: Final = 190.0
"""Height of all layers together, in points of the drawing."""
_STRIP: Final = 18.0
_TRUE, _ENLARGED = (4.0, 34.0), (78.0, 60.0)
"""Left edge and width of the layers to scale, and of those that are enlarged."""
_TEXT: Final = 148.0
_TOTAL: Final = 346.0


def drawing(shown: Computed) -> str:
    """Draw the layers between plate and finger as SVG.

    Left, the layers to scale. Right, with heights that grow with the logarithm of the thickness, joined by
    lines to the left; beside each layer its thickness and the largest field and voltage of the run.
    """
    thicknesses = {name: layer.thickness for name, layer in shown.scenario.stack.layers.items()}
    heights = drawn_heights(thicknesses)
    unit, total = _HEIGHT / sum(heights.values()), sum(thicknesses.values())
    colours = layer_colours(list(thicknesses))
    bottom = _STRIP + _HEIGHT
    parts = [*_strip(0.0, "finger", "#cdb9a8", "#222222"), *_strip(bottom, "plate", "#5d5d5d", "#ffffff")]
    true_low = low = bottom
    for name, thickness in thicknesses.items():
        true_high, high = true_low - _HEIGHT * thickness / total, low - unit * heights[name]
        parts += _layer(colours[name], (true_low, true_high), (low, high))
        parts += _words(name, thickness, shown, (low + high) / 2)
        true_low, low = true_high, high
    foot = _HEIGHT + 2 * _STRIP
    parts += [
        _text(_TRUE[0], foot + 11, 9, "to scale"),
        _text(_ENLARGED[0], foot + 11, 9, "enlarged where thin"),
    ]
    described = ", ".join(
        f"{name.replace('_', ' ')} {pretty_quantity(each, 'm')}" for name, each in thicknesses.items()
    )
    label = escape(f"Layers from the plate to the finger: {described}", quote=True)
    return (
        f'<svg role="img" aria-label="{label}" viewBox="0 0 {_TOTAL:g} {foot + 14:g}" width="100%" fill="currentColor"'
        f' font-family="sans-serif">{"".join(parts)}</svg>'
    )


def _strip(top: float, words: str, colour: str, ink: str) -> list[str]:
    boxes = [_box(column, top, _STRIP, colour) for column in (_TRUE, _ENLARGED)]
    middle = _ENLARGED[0] + _ENLARGED[1] / 2
    return [*boxes, _text(middle, top + _STRIP - 6, 9, words, f' text-anchor="middle" fill="{ink}"')]


def _layer(colour: str, true: tuple[float, float], drawn: tuple[float, float]) -> list[str]:
    look = ' fill-opacity="0.75" stroke="#ffffff" stroke-width="0.4"'
    boxes = [
        _box(column, high, max(low - high, 0.3), colour, look)
        for column, (low, high) in ((_TRUE, true), (_ENLARGED, drawn))
    ]
    joint = (
        f'<line x1="{sum(_TRUE):g}" y1="{true[1]:.3f}" x2="{_ENLARGED[0]:g}" y2="{drawn[1]:.3f}"'
        ' stroke="currentColor" stroke-width="0.5" stroke-dasharray="2 2"/>'
    )
    return [*boxes, joint]


def _words(name: str, thickness: float, shown: Computed, middle: float) -> list[str]:
    first = f"{name.replace('_', ' ')}, {pretty_quantity(thickness, 'm', digits=4)}"
    lines = [_text(_TEXT, middle - 2, 11, first, ' font-weight="bold"')]
    field = shown.found.largest_fields.get(name)
    if field is not None:
        strength = pretty_quantity(field, "V/m", digits=3)
        voltage = pretty_quantity(field * thickness, "V", digits=3)
        lines.append(_text(_TEXT, middle + 11, 10, f"at most {strength}, {voltage} across it"))
    return lines


def _box(column: tuple[float, float], top: float, height: float, colour: str, look: str = "") -> str:
    left, width = column
    size = f'x="{left:g}" y="{top:.3f}" width="{width:g}" height="{height:.3f}"'
    return f'<rect {size} fill="{colour}"{look}/>'


def _text(left: float, low: float, size: int, words: str, look: str = "") -> str:
    return f'<text x="{left:g}" y="{low:.1f}" font-size="{size}"{look}>{escape(words)}</text>'
