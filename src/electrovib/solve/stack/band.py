"""Over which frequencies a run needs its materials: from how long it is, and how short its shortest event."""

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
"""How far beyond 1/(2 pi time) the band goes: a relaxation of a time t acts on all times around t."""
SAME = 1e-9
"""Times nearer than this to a corner, over the last time, count as at it."""


def run_band(scenario: Scenario, times: Real) -> tuple[float, float]:
    """Find the frequencies that the answer of a run depends on.

    Parameters
    ----------
    scenario : Scenario
        Drive, initial state and frequency grid.
    times : ndarray, shape (n,)
        Output times, increasing, >= 0 [s].

    Returns
    -------
    tuple of float
        Lowest and highest frequency [Hz], those of the frequency grid among them.

    Notes
    -----
    From rest the lowest is 1/(2 pi t) of the last output time t, less a margin of 10; in the periodic state
    the lowest frequency of the drive, less the same. The highest is ten times 1/(2 pi t) of the shortest
    straight piece and of the shortest time between a corner and the next output, and ten times the highest
    frequency of a sine.
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
    """Return the shortest straight piece of the drive or time between a corner and the next output [s].

    Parameters
    ----------
    scenario : Scenario
        Its drive.
    times : ndarray, shape (n,)
        Output times [s].

    Returns
    -------
    float
        s; infinite if the drive has no corner before an output.
    """
    end, drive = float(times[-1]), scenario.drive
    if any(isinstance(part, Linear) and part.begins_with(times) for part in drive.parts()):
        return drive.shortest_piece(end)  # every output is at a corner
    begins = [] if isinstance(scenario.time.initial_state, PeriodicState) else [0.0]
    corners = np.concatenate([[-math.inf], begins, drive.corners(end)[0]])
    since = times - corners[np.searchsorted(corners, times * (1 + SAME), side="right") - 1]
    after = since[since > SAME * end]
    return min(drive.shortest_piece(end), float(np.min(after, initial=math.inf)))


def lowest_frequency(scenario: Scenario) -> float:
    """Return the lowest frequency in a drive that repeats [Hz]; 0 for its mean, only where a measured layer blocks."""
    materials = [layer.material for layer in scenario.stack.layers.values()]
    blocked = any(math.isfinite(each.band[1]) and each.conductivity == 0 for each in materials)
    frequencies, amplitudes = spectrum(scenario.drive, harmonics=1)
    sizes = np.abs(amplitudes)
    there = (sizes > SAME * np.max(sizes, initial=0.0)) & (blocked | (frequencies > 0))
    return float(np.min(frequencies[there], initial=math.inf))


def _slowest(part: Part) -> list[float]:
    if isinstance(part, Tones):
        moving = part.frequencies[(part.frequencies > 0) & (part.amplitudes != 0)]
        return [float(np.min(moving))] if len(moving) else []
    return [1 / part.period] if isinstance(part, Linear) and part.period else []
