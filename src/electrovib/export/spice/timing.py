"""How long, in which steps, and how steep an edge that has no length of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import TimeGrid

STEPS = 2000
"""Steps of the whole time at least."""
PER_CYCLE = 300
"""Steps in a cycle of the fastest oscillation at least."""
SHARPNESS = 2e-4
"""An edge without length, over the longest step."""
FINEST = 1e4
"""Longest step over the shortest straight piece of the drive: ngspice joins corners 5e-5 of a step apart."""


@dataclass(frozen=True)
class Timing:
    """Duration, longest step, and the length of an edge that should have none [s]."""

    duration: float
    step: float
    edge: float

    @classmethod
    def of(cls, drive: Drive, grid: TimeGrid) -> Timing:
        """Choose the steps of a drive over the times that a scenario asks for."""
        duration = float(grid.times(drive)[-1])
        fastest, shortest = drive.highest_frequency, drive.shortest_piece(duration)
        step = duration / max(STEPS, (grid.samples or 0) - 1)
        if fastest > 0:
            step = min(step, 1 / (PER_CYCLE * fastest))
        step = min(step, FINEST * shortest)
        return cls(duration, step, min(SHARPNESS * step, shortest / 4))
