"""Whether any real gap is small enough for the limit of a vanishing one, and why an attraction may be negative."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

SMALLEST_GAP: Final = 1e-9
"""Smallest gap that one may mean [m]: about the roughness of the smoothest plates; a choice."""
LARGEST_SHARE: Final = 0.01
"""Share of the voltage across that gap from which on the limit does not describe it; a choice."""
_ROUNDING = 1e-9
"""Negative attraction over the largest, below which it is rounding."""


def vanishing_gap(scenario: Scenario, times: Real, variables: dict[str, Any]) -> list[Diagnostic]:
    """Judge whether the limit of a vanishing gap stands for the smallest real one.

    Parameters
    ----------
    scenario : Scenario
        Stack and law.
    times : ndarray, shape (n,)
        Output times [s].
    variables : dict
        Dimensions and values of the signals of the Trace.

    Returns
    -------
    list of Diagnostic
        None if the stack has a gap, or the law reads no field at the interface.

    Notes
    -----
    A gap g holds the voltage E g. While that is a small share of the whole voltage, closing the gap further
    changes nothing; over a plate that conducts E grows as long as the voltage is held.
    """
    if scenario.stack.gap_name is not None or scenario.force.evaluation_surface != "gap":
        return []
    name, gap = "vanishing gap", format_quantity(SMALLEST_GAP, "m")
    add = "give the stack a layer with role = 'gap', for instance stack.gap.thickness = '1 um'"
    if "interface_field" not in variables:
        text = f"the field of a vanishing gap is not known, so no gap of {gap} could be judged: {add}"
        return [Diagnostic(name, "unknown", text)]
    field, voltage = (np.abs(variables[each][1]) for each in ("interface_field", "stack_voltage"))
    reached = np.maximum.accumulate(voltage)
    share = np.divide(field * SMALLEST_GAP, reached, out=np.zeros_like(field), where=reached > 0)
    worst = float(np.max(share, initial=0.0))
    beyond = np.flatnonzero(share > LARGEST_SHARE)
    said = f"a gap of {gap} would hold {100 * worst:.3g} % of the voltage"
    if len(beyond):
        since = format_quantity(float(times[beyond[0]]), "s", digits=3)
        text = (
            f"{said}, from {since} on more than {100 * LARGEST_SHARE:g} %: from then on the force is larger than that of any"
            f" real gap; {add}"
        )
        return [Diagnostic(name, "warning", text, worst, LARGEST_SHARE, "1")]
    text = f"the stack has no gap: the force is the limit of a vanishing one; {said} at most"
    return [Diagnostic(name, "ok", text, worst, LARGEST_SHARE, "1")]


def negative_attraction(scenario: Scenario, variables: dict[str, Any]) -> list[Diagnostic]:
    """Say why an attraction is negative, where it is.

    Parameters
    ----------
    scenario : Scenario
        With its law.
    variables : dict
        Dimensions and values of the signals of the Trace.

    Returns
    -------
    list of Diagnostic
        One warning, or none.
    """
    force = variables["electrostatic_force"][1]
    lowest, largest = float(np.min(force)), float(np.max(np.abs(force)))
    if not lowest < -_ROUNDING * largest:
        return []
    law = scenario.force
    why = law.negative or f"{type(law).__name__} does not say why its pressure may be negative"
    text = f"the attraction falls to {format_quantity(lowest, 'N', digits=3)}: {why}"
    return [Diagnostic("negative attraction", "warning", text, -lowest, 0.0, "N")]
