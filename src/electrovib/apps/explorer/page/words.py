"""Tables and sentences of the tabs, as HTML in which every text is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.apps.explorer.pictures import PINNED
from electrovib.core.diagnostics import STATES, Diagnostic
from electrovib.view.summary import quantities_of_scenario
from electrovib.view.units import pretty_quantity, typeset

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.further import Further
    from electrovib.studies.check.result import CheckResult
    from electrovib.studies.perceive import Percept
    from electrovib.view.fitted import FitResult

_DASHES: Final = {"dash": "8 5", "dot": "2 4", "dashdot": "8 4 2 4", "longdash": "13 5"}
"""Dashes of Plotly as SVG writes them."""
CLASSES: Final = {
    "ok": "ev-ok",
    "pass": "ev-ok",
    "unknown": "ev-unknown",
    "warning": "ev-warning",
    "fail": "ev-warning",
}
"""Classes of the style sheet for each state; the state is written as a word as well, never as a colour alone."""


def judged_words(diagnostics: Sequence[Diagnostic]) -> str:
    """List what limits the validity of a result, the worst first, and count what is in order."""
    worst_first = sorted(diagnostics, key=lambda each: -STATES.index(each.state))
    rows = [
        f"<li>{_state(each.state)} <b>{escape(_plain(each.name))}</b>: {escape(typeset(each.text))}</li>"
        for each in worst_first
        if each.state != "ok"
    ]
    fine = [_plain(each.name) for each in diagnostics if each.state == "ok"]
    if fine:
        rows.append(f"<li>{_state('ok')} {escape('; '.join(fine))}</li>")
    return f'<ul class="ev-list">{"".join(rows)}</ul>'


def law_words(found: Computed, further: Further) -> str:
    """Tabulate the largest force of each law over that of the law of the page."""
    own = _peak(found)
    rows = []
    for name, case in {type(found.scenario.force).__name__: found, **further.laws}.items():
        peak = _peak(case)
        ratio = f"{peak / own:.3g}" if own > 0 and np.isfinite(peak) else "–"
        law = case.scenario.force
        rows.append(
            (name, _plain(law.evaluation_surface), law.status, pretty_quantity(peak, "N", digits=3), ratio)
        )
    rows += [(name, "", "", "cannot run here", why) for name, why in further.left_out.items()]
    headings = (
        "law",
        "stress evaluated in",
        "source status",
        "largest force",
        "relative to this law",
    )
    return _table(headings, rows)


def verdict_words(percept: Percept) -> str:
    """State whether it is felt, what that rests on, and where nothing varies."""
    head, comma, rest = percept.answer.partition(",")
    words = f"<p><b>{escape(head)}</b>{escape(comma + rest)}</p>"
    if percept.to_measure:
        words += f"<p>{escape(percept.to_measure)}</p>"
    if not percept.loudest:
        words += "<p>The force does not vary between 1 Hz and 2 kHz, so there is no spectrum to show.</p>"
    return words


def felt_words(percept: Percept) -> str:
    """Tabulate the level of each channel, and list what the levels are based on."""
    rows = [
        (each.channel, _decibels(each.level, f" re 1 {percept.unit}"), _decibels(each.relative), each.status)
        for each in percept.channels
    ]
    headings = (
        "channel",
        "level",
        "relative to a sine of equal force at the best frequency",
        "source status",
    )
    notes = "".join(f"<li>{escape(typeset(text))}</li>" for text in percept.calibrated_on)
    return f'{_table(headings, rows)}<ul class="ev-list">{notes}</ul>'


def kept_words(names: Sequence[str]) -> str:
    """List the results that are kept, each with the dash of its curves."""
    rows = [
        f'<li><svg width="36" height="8" aria-hidden="true"><line x1="0" y1="4" x2="36" y2="4" stroke="currentColor"'
        f' stroke-width="2" stroke-dasharray="{_DASHES[dash]}"/></svg> kept {place}: {escape(name)}</li>'
        for place, (name, dash) in enumerate(zip(names, PINNED, strict=False), 1)
    ]
    return f'<ul class="ev-kept">{"".join(rows)}</ul>' if rows else ""


def safety_words(check: CheckResult) -> str:
    """Tabulate limits and breakdown, and state what was assumed."""
    rows = [
        (
            row.state,
            row.quantity,
            pretty_quantity(row.value, row.unit, digits=4),
            pretty_quantity(row.limit, row.unit, digits=4),
            typeset(row.source),
        )
        for row in (*check.rows, *check.comparisons)
    ]
    notes = "".join(f"<li>{escape(typeset(text))}</li>" for text in check.notes)
    table = _table(("state", "quantity", "value", "limit", "source of the limit"), rows, states=True)
    return (
        f"<p>A comparison with limits protects nobody: hardware has to limit the current.</p>{table}"
        f'<ul class="ev-list">{notes}</ul>'
    )


def fit_words(result: FitResult) -> str:
    """Tabulate the estimates of a fit with their 95 % intervals, or the reason why there is none."""
    rows = [
        (row.name, value, ends or "–", row.note or row.state)
        for row in result.rows
        for value, ends in [row.shown(pretty_quantity)]
    ]
    return _table(("parameter", "estimate", "95 % interval", "note"), rows)


def _peak(found: Computed) -> float:
    """Return the largest attraction of a run; at the output times alone for a solver that advances in steps."""
    if not found.has("electrostatic_force"):
        return float("nan")
    name = "peak electrostatic_force"
    largest = float(np.nanmax(np.abs(found.values("electrostatic_force"))))
    return quantities_of_scenario(found.scenario, (name,), quick=True).get(name, largest)


def _decibels(value: float, unit: str = "") -> str:
    """Write a level; minus infinity, the level of nothing, as a dash."""
    return f"{value:.1f} dB{unit}".replace("-", "\N{MINUS SIGN}") if np.isfinite(value) else "–"


def _plain(name: str) -> str:
    """Write a name of the program in words."""
    return name.replace("_", " ")


def _state(state: str) -> str:
    return f'<span class="{CLASSES[state]}">{escape(state)}</span>'


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]], *, states: bool = False) -> str:
    head = "".join(f"<th scope=col>{escape(each)}</th>" for each in headings)
    body = "".join(
        "<tr>"
        + "".join(
            f"<td>{_state(cell) if states and place == 0 else escape(cell)}</td>"
            for place, cell in enumerate(row)
        )
        + "</tr>"
        for row in rows
    )
    return f'<table class="ev-table"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
