"""Duration and steps in time of a netlist, and the duration of the edge that replaces a step of the drive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import TimeGrid

STEPS = 2000
"""Smallest number of steps in the whole time."""
PER_CYCLE = 300
"""Smallest number of steps in a cycle of the fastest oscillation."""
SHARPNESS = 2e-4
"""Duration of the edge that replaces a step of the drive, over the longest time step."""
FINEST = 1e4
"""Longest time step over the shortest straight piece of the drive; ngspice merges corners 5e-5 of a step apart."""


@dataclass(frozen=True)
class Timing:
    """Duration, longest time step, and duration of the edge that replaces a step of the drive [s]."""

    duration: float
    step: float
    edge: float

    @classmethod
    def of(cls, drive: Drive, grid: TimeGrid) -> Timing:
        """Return the timing of a drive over the time grid of a scenario."""
        duration = float(grid.times(drive)[-1])
        fastest, shortest = drive.highest_frequency, drive.shortest_piece(duration)
        step = duration / max(STEPS, (grid.samples or 0) - 1)
        if fastest > 0:
            step = min(step, 1 / (PER_CYCLE * fastest))
        step = min(step, FINEST * shortest)
        return cls(duration, step, min(SHARPNESS * step, shortest / 4))
