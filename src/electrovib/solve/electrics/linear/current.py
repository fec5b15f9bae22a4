"""The voltage of a prescribed current, and what such a drive does not tell."""

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
    """Voltage that the amplifier has to give for its current.

    Parameters
    ----------
    stack_voltage : ndarray, shape (n,)
        Across the layers [V].
    drive : Drive
        A current [A].
    time : ndarray, shape (n,)
        s.
    element : SeriesElement
        Source and return path.
    second : float
        First contact area over that of a second, equal stack; 0 for none.
    settled : bool
        As for `transient`.
    charge : float
        On the body's capacitor at time 0 [C].

    Returns
    -------
    ndarray, shape (n,)
        V.
    """
    rates, gains, free = np.zeros(0), np.zeros(0), np.zeros(0)
    if element.elastance > 0:
        rates = np.array([element.rate or INTEGRATING, element.rate])
        gains = np.array([element.elastance / rates[0], 0.0])
        free = np.array([0.0, element.elastance * charge])
    around = {"voltage": Transfer(rates=rates, gains=gains, direct=element.resistance, slope=0.0, free=free)}
    return stack_voltage * (1 + second) + transient(around, drive, time, settled=settled)["voltage"]


def caveat() -> Diagnostic:
    """Say what a prescribed current does not tell."""
    text = (
        "the whole current of the drive is taken to cross this contact area: the force goes as 1/area, and what"
        " passes through stray capacitance or leaks beside the gap does not pull; neither is known here"
    )
    return Diagnostic("current drive", "unknown", text)
