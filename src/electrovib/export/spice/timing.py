"""How long, in which steps, and how steep an edge that has no length of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.parts import Linear, Smooth, Tones

if TYPE_CHECKING:
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.drive.parts import Part
    from electrovib.solve.scenario import TimeGrid

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
        parts = drive.parts()
        fastest = max(_highest_frequency(part) for part in parts)
        shortest = min(_shortest_piece(part, duration) for part in parts)
        step = duration / max(STEPS, (grid.samples or 0) - 1)
        if fastest > 0:
            step = min(step, 1 / (PER_CYCLE * fastest))
        step = min(step, FINEST * shortest)
        return cls(duration, step, min(SHARPNESS * step, shortest / 4))


def _highest_frequency(part: Part) -> float:
    if isinstance(part, Tones):
        return float(np.max(part.frequencies[part.amplitudes != 0], initial=0.0))
    return part.highest_frequency if isinstance(part, Smooth) else 0.0


def _shortest_piece(part: Part, duration: float) -> float:
    if isinstance(part, Linear):
        return float(np.min(np.diff(part.times), initial=np.inf))
    on = min(part.stop, duration) - max(part.start, 0.0)
    return on if on > 0 else np.inf
