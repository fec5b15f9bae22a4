"""The row of a check for one limit, declared or of breakdown."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.core.status import UNVERIFIED
from electrovib.core.units import format_quantity
from electrovib.physics.limits import MEAN_SQUARES, PEAKS, WORDS, unit_of_limit
from electrovib.studies.check.declared import NEEDED, unlimited_words
from electrovib.studies.check.result import FAIL, PASS, UNKNOWN, CheckRow

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.studies.check.declared import DeclaredLimit

ONLY_DECLARED: Final = (*MEAN_SQUARES, "slew_rate")
"""Limits that have no row where nobody declares them."""
_STATES: Final = {"ok": PASS, "warning": FAIL, "unknown": UNKNOWN}


def limited_quantity(name: str) -> str:
    """Return the name by which `electrovib.check` has the quantity of a limit: ``"peak voltage"`` for ``"voltage"``."""
    words = name.replace("_", " ")
    return f"peak {words}" if name in PEAKS else words


def limit_row(name: str, value: float | None, limit: DeclaredLimit | None, *, words: str = "") -> CheckRow:
    """Return the row of a limit; the value is infinite without a bound, NaN or None where it is not known."""
    unit, words = unit_of_limit(name), words or WORDS[name]
    if value is None or math.isnan(value):
        value, reached = None, "is not known"
    elif math.isinf(value):
        where = "a discontinuity" if name == "slew_rate" else "a discontinuity without a series resistance"
        reached = f"has no bound ({where})"
    else:
        reached = f"reaches {format_quantity(value, unit, digits=6)}"
    if limit is None:
        state, text = UNKNOWN, f"{words} {reached}; limits.{name} is not declared"
    else:
        state = UNKNOWN if value is None else PASS if value <= limit.value else FAIL
        word = {UNKNOWN: "not compared with", PASS: "within", FAIL: "above"}[state]
        text = f"{words} {reached}, {word} {format_quantity(limit.value, unit, digits=6)}: {limit.source}"
    return CheckRow(
        quantity=limited_quantity(name),
        value=value,
        limit=None if limit is None else limit.value,
        unit=unit,
        source=unlimited_words(name) if limit is None else limit.source,
        state=state,
        text=text,
    )


def breakdown_row(found: Diagnostic, *, strict: bool = False) -> CheckRow:
    """Return the row of a diagnostic of breakdown.

    A limit that was cited from memory decides nothing, whichever side of it the value is on, unless it is
    `strict`. That of Paschen's law depends on such a value only through the logarithm of a logarithm: a field
    above it fails, one within it is not known to pass.
    """
    state = _STATES[found.state]
    if UNVERIFIED in found.text and not strict and not (state == FAIL and found.name == "Paschen"):
        state = UNKNOWN
    return CheckRow(
        quantity=found.name,
        value=found.value,
        limit=found.limit,
        unit=found.unit,
        source=found.text.partition(": ")[2] or found.text,
        state=state,
        text=found.text,
    )


def not_compared(rows: Iterable[CheckRow]) -> list[str]:
    """Return one sentence that names the needed limits which nobody declares; none where all are declared."""
    open_ones = {row.quantity for row in rows if row.limit is None}
    names = [f"limits.{name}" for name in NEEDED if limited_quantity(name) in open_ones]
    if not names:
        return []
    verbs = ("is", "it was") if len(names) == 1 else ("are", "they were")
    return [f"{' and '.join(names)} {verbs[0]} not declared, so {verbs[1]} not compared."]
