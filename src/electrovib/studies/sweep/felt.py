"""Quantities of perception of a case."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.core.diagnostics import Diagnostic
from electrovib.studies.perceive import perceive

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

FELT: Final = {
    "detection level": ("dB", "level of the most excited channel above its threshold"),
    "relative level": ("dB", "level relative to a sine of equal force at the best frequency"),
}
"""Unit and meaning of each quantity, by name."""


def felt(name: str, scenario: Scenario) -> tuple[float, list[Diagnostic]]:
    """Compute a quantity of perception [dB]: minus infinity where nothing moves, NaN where no threshold is known."""
    found = perceive(scenario)
    if name == "relative level":
        return found.relative, []
    if not found.loudest:
        return -math.inf, []
    value = math.nan if found.sensation is None else found.sensation
    text = f"{found.answer}; {found.to_measure}" if found.to_measure else ""
    return value, [Diagnostic("detection level", "unknown", text)] if text else []
