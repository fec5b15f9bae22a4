"""Slew rate and discontinuities of the voltage that a drive asks for."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.slew import slew_of
from electrovib.scenario import PeriodicState

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

ROUNDED = 1e-9
"""Height of a discontinuity over the largest value of the drive, below which it is rounding."""


def slew_rate(scenario: Scenario, end: float) -> float:
    """Return the largest rate of change of the drive times the gain, from time 0 to an end."""
    drive, amplifier = scenario.drive, scenario.circuit.amplifier
    if drive.quantity == "current":
        return math.nan
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    until = max(end, drive.period or 0.0) if settled else end
    return abs(1.0 if amplifier is None else amplifier.gain) * slew_of(drive, until, from_rest=not settled)


def discontinuities(scenario: Scenario, *, end: float) -> tuple[float, float]:
    """Return the heights of the discontinuities of the voltage that reach the stack."""
    drive, amplifier = scenario.drive, scenario.circuit.amplifier
    if drive.quantity == "current" or (
        amplifier is not None
        and (amplifier.bandwidth is not None or np.isfinite(amplifier.current_limits[1]))
    ):
        return 0.0, 0.0
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    smallest = ROUNDED * sum(part.bound() for part in drive.parts())
    until = max(end, drive.period or 0.0) if settled else end
    times, heights = drive.corners(until)
    if amplifier is not None and amplifier.saturation is not None:
        after = drive.voltage(times)
        passed = np.abs(amplifier.aim(after) - amplifier.aim(after - heights))
        heights = np.where(passed > ROUNDED * amplifier.saturation, heights, 0.0)
    later = float(np.max(np.abs(heights), initial=0.0))
    first = 0.0 if settled else abs(float(drive.voltage(0.0)))
    return first * (first > smallest), later * (later > smallest)
