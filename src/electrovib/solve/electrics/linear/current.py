"""The voltage under a prescribed current, and the limits of that prescription."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.solve.electrics.linear.transient import transient
from electrovib.solve.stack.integrator import INTEGRATING
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.drive.base import Drive


def drive_voltage(
    stack_voltage: Real,
    drive: Drive,
    time: Real,
    *,
    element: SeriesElement,
    second: float,
    settled: bool,
    charge: float = 0.0,
) -> Real:
    """Compute the voltage that the amplifier has to supply for its current.

    `stack_voltage` (n,) [V], `time` (n,) [s]; returns `voltage` (n,) [V].
    """
    rates, gains, free = np.zeros(0), np.zeros(0), np.zeros(0)
    if element.elastance > 0:
        rates = np.array([element.rate or INTEGRATING, element.rate])
        gains = np.array([element.elastance / rates[0], 0.0])
        free = np.array([0.0, element.elastance * charge])
    around = {"voltage": Transfer(rates=rates, gains=gains, direct=element.resistance, slope=0.0, free=free)}
    return stack_voltage * (1 + second) + transient(around, drive, time, settled=settled)["voltage"]


def caveat() -> Diagnostic:
    """Return the diagnostic that the contact area and stray currents of a prescribed current are not known."""
    text = (
        "the whole current of the drive is assumed to cross this contact area, so the force is proportional to 1/area; a"
        " current through stray capacitance or beside the gap does not attract, and its share is not known here"
    )
    return Diagnostic("current drive", "unknown", text)
