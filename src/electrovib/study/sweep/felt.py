"""Quantities that need a person: what is felt of a case."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.core.diagnostics import Diagnostic
from electrovib.study.perceive import perceive

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

FELT: Final = {
    "detection level": ("dB", "level above the threshold of the channel that feels it most"),
    "relative level": ("dB", "level above that of a sine of force as large at the best frequency"),
}
"""Name to unit and meaning."""


def felt(name: str, scenario: Scenario) -> tuple[float, list[Diagnostic]]:
    """Take a number from what is felt.

    Parameters
    ----------
    name : str
        One of `FELT`.
    scenario : Scenario
        With its perception.

    Returns
    -------
    value : float
        dB; minus infinity where nothing moves, NaN where the level is not calibrated.
    diagnostics : list of Diagnostic
        That it is not calibrated.
    """
    found = perceive(scenario)
    if name == "relative level":
        return found.relative, []
    if found.sensation is not None or not found.loudest:
        return -math.inf if found.sensation is None else found.sensation, []
    text = "detection level: not calibrated; give perception.threshold, or ask for 'relative level'"
    return math.nan, [Diagnostic("detection level", "unknown", text)]
