"""Diagnostics of the limit of a vanishing gap, and of a negative attraction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

SMALLEST_GAP: Final = 1e-9
"""Smallest real gap considered [m]: about the roughness of the smoothest plates; a choice."""
LARGEST_SHARE: Final = 0.01
"""Share of the voltage across that gap above which the limit does not describe it; a choice."""
_ROUNDING = 1e-9
"""Negative attraction over the largest absolute one, below which it is rounding."""


def vanishing_gap(scenario: Scenario, times: Real, variables: dict[str, Any]) -> list[Diagnostic]:
    """Return whether the limit of a vanishing gap describes the smallest real gap.

    `times` (n,) [s].

    A gap g has the voltage E g across it. While that is a small share of the whole voltage, a smaller gap has the same
    field; over a conducting plate E grows as long as the voltage is held.
    """
    if scenario.stack.gap_name is not None or scenario.force.evaluation_surface != "gap":
        return []
    name, gap = "vanishing gap", format_quantity(SMALLEST_GAP, "m")
    add = "add a layer with role = 'gap' to the stack, for instance stack.gap.thickness = '1 um'"
    if "interface_field" not in variables:
        text = f"the field of a vanishing gap is not known, so the limit was not compared with a gap of {gap}: {add}"
        return [Diagnostic(name, "unknown", text)]
    field, voltage = (np.abs(variables[each][1]) for each in ("interface_field", "stack_voltage"))
    reached = np.maximum.accumulate(voltage)
    share = np.divide(field * SMALLEST_GAP, reached, out=np.zeros_like(field), where=reached > 0)
    worst = float(np.max(share, initial=0.0))
    beyond = np.flatnonzero(share > LARGEST_SHARE)
    said = f"a gap of {gap} would have {100 * worst:.3g} % of the voltage across it"
    if len(beyond):
        since = format_quantity(float(times[beyond[0]]), "s", digits=3)
        text = (
            f"{said}, and more than {100 * LARGEST_SHARE:g} % from {since} on: from then on the force is larger than that of"
            f" any real gap; {add}"
        )
        return [Diagnostic(name, "warning", text, worst, LARGEST_SHARE, "1")]
    text = f"the stack has no gap: the force is the limit of a vanishing gap; {said} at most"
    return [Diagnostic(name, "ok", text, worst, LARGEST_SHARE, "1")]


def negative_attraction(scenario: Scenario, variables: dict[str, Any]) -> list[Diagnostic]:
    """Return a warning where the attraction is negative, with the reason that the force law declares."""
    force = variables["electrostatic_force"][1]
    lowest, largest = float(np.min(force)), float(np.max(np.abs(force)))
    if not lowest < -_ROUNDING * largest:
        return []
    law = scenario.force
    why = law.negative or f"{type(law).__name__} does not declare why its pressure may be negative"
    text = f"the attraction falls to {format_quantity(lowest, 'N', digits=3)}: {why}"
    return [Diagnostic("negative attraction", "warning", text, -lowest, 0.0, "N")]
