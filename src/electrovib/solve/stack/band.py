"""Frequency band over which a run needs its materials, from its duration and its shortest event."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.parts import Tones
from electrovib.physics.drive.pieces import Linear
from electrovib.scenario import PeriodicState
from electrovib.solve.stack.harmonics import spectrum

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.parts import Part
    from electrovib.scenario import Scenario

MARGIN = 10.0
"""Factor by which the band extends beyond 1/(2 pi time): a relaxation of a time t acts on all times around t."""
SAME = 1e-12
"""Relative difference of two times or frequencies that counts as rounding: such a time is at a corner, not after it."""
ABSENT = 1e-9
"""Share of the largest amplitude below which a frequency is not part of a drive."""


def run_band(scenario: Scenario, times: Real) -> tuple[float, float]:
    """Return the band of frequencies that the response of a run depends on.

    `times` (n,) [s].

    From rest the lowest is a tenth of 1/(2 pi t) of the last output time t; in the periodic state a tenth of the
    lowest frequency of the drive. The highest is ten times 1/(2 pi t) of the shortest straight piece and of the
    shortest time between a corner and the next output, and ten times the highest frequency of a sine.
    """
    parts, grid = scenario.drive.parts(), scenario.frequency
    fastest = [scenario.drive.highest_frequency]
    shortest = shortest_time(scenario, times)
    if math.isfinite(shortest):
        fastest.append(1 / (2 * np.pi * shortest))
    if isinstance(scenario.time.initial_state, PeriodicState):
        slowest = [found for part in parts for found in _slowest(part)]
    else:
        slowest = [1 / (2 * np.pi * float(times[-1]))] if times[-1] > 0 else []
    return (
        min([grid.low, *(frequency / MARGIN for frequency in slowest)]),
        max([grid.high, *(frequency * MARGIN for frequency in fastest)]),
    )


def shortest_time(scenario: Scenario, times: Real) -> float:
    """Return the duration of the shortest straight piece of the drive, or of a corner to the next output if shorter.

    `times` (n,) [s].
    """
    end, drive = float(times[-1]), scenario.drive
    if any(isinstance(part, Linear) and part.begins_with(times) for part in drive.parts()):
        return drive.shortest_piece(end)  # every output is at a corner
    begins = [] if isinstance(scenario.time.initial_state, PeriodicState) else [0.0]
    corners = np.concatenate([[-math.inf], begins, drive.corners(end)[0]])
    since = times - corners[np.searchsorted(corners, times * (1 + SAME), side="right") - 1]
    after = since[since > SAME * times]
    return min(drive.shortest_piece(end), float(np.min(after, initial=math.inf)))


def lowest_frequency(scenario: Scenario) -> float:
    """Return the lowest frequency of a periodic drive [Hz]; its mean, 0, counts only if a measured layer does not conduct."""
    materials = [layer.material for layer in scenario.stack.layers.values()]
    blocked = any(math.isfinite(each.band[1]) and each.conductivity == 0 for each in materials)
    frequencies, amplitudes = spectrum(scenario.drive, harmonics=1)
    sizes = np.abs(amplitudes)
    there = (sizes > ABSENT * np.max(sizes, initial=0.0)) & (blocked | (frequencies > 0))
    return float(np.min(frequencies[there], initial=math.inf))


def _slowest(part: Part) -> list[float]:
    if isinstance(part, Tones):
        moving = part.frequencies[(part.frequencies > 0) & (part.amplitudes != 0)]
        return [float(np.min(moving))] if len(moving) else []
    return [1 / part.period] if isinstance(part, Linear) and part.period else []
