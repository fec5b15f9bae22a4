"""Reduction of materials to Debye terms over the band that a run needs, with the error of the reduction.

The band follows from the duration of a run and from its shortest event.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.parts import Tones
from electrovib.physics.tabulated import FEWEST
from electrovib.solve.stack.harmonics import spectrum
from electrovib.solve.stack.prony import DENSE, fit_debye, fit_debye_table

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.drive.parts import Part
    from electrovib.physics.material import Material
    from electrovib.scenario import Scenario

LOWEST, HIGHEST = 1.0, 1e6
"""Smallest band of a reduction [Hz]."""
TERMS_PER_DECADE = 3
"""Relaxations for each decade of the band: an error of some 1e-5 for laws that are not sums of Debye terms."""
FEWEST_TERMS = 14
STEPS_PER_DECADE = 2
"""Ends of a band lie at whole 1/STEPS_PER_DECADE decades, so that runs that differ little share their reductions."""
MARGIN = 10.0
"""Factor by which the band extends beyond 1/(2 pi time): a relaxation of a time t acts on all times around t."""
SAME = 1e-12
"""Relative difference of two times or frequencies that counts as rounding: such a time is at a corner, not after it."""
ABSENT = 1e-9
"""Share of the largest amplitude below which a frequency is not part of a drive."""


@dataclass(frozen=True)
class Reduction:
    """Bound permittivity of a material as Debye terms.

    Parameters
    ----------
    debye : DebyeSum
        The terms.
    largest_error : float
        Largest |reduced/declared - 1| of the bound permittivity in the band [1]; 0 where no reduction was needed. For a
        measured table relative to its rows, with their noise.
    """

    debye: DebyeSum
    largest_error: float


def reduction_band(*, low: float, high: float) -> tuple[float, float]:
    """Return a band widened to at least `LOWEST` to `HIGHEST`, and outwards to half decades."""
    lowest, highest = math.log10(min(low, LOWEST)), math.log10(max(high, HIGHEST))
    slack = 1e-9  # the logarithm of a whole decade may miss it by rounding
    first, last = (
        math.floor(STEPS_PER_DECADE * lowest + slack) / STEPS_PER_DECADE,
        math.ceil(STEPS_PER_DECADE * highest - slack) / STEPS_PER_DECADE,
    )
    return float(10.0**first), float(10.0**last)


def reduce_material(
    material: Material, *, low: float = LOWEST, high: float = HIGHEST, terms: int | None = None
) -> Reduction:
    """Return the Debye terms of a material."""
    exact = material.debye()
    if exact is not None:
        return Reduction(exact, 0.0)
    return _reduced(material, *reduction_band(low=low, high=high), terms)


@functools.lru_cache(maxsize=256)
def _reduced(material: Material, low: float, high: float, terms: int | None) -> Reduction:
    rows, slowest = material.table(), material.slowest_relaxation
    if rows is None:
        count = terms or min(DENSE, math.ceil(TERMS_PER_DECADE * math.log10(high / low)) + 2)
        fit = fit_debye(material.bound_permittivity, low=low, high=high, terms=count, slowest=slowest)
    else:
        near = (rows[0] >= low) & (rows[0] <= high)
        wanted = near if np.count_nonzero(near) >= FEWEST else np.ones_like(near)
        fit = fit_debye_table(*(row[wanted] for row in rows), terms=terms or FEWEST_TERMS, slowest=slowest)
    return Reduction(fit.debye, fit.largest_error)


def band_of_run(scenario: Scenario, times: Real) -> tuple[float, float]:
    """Return the band over which the materials of a run are reduced [Hz]; runs that differ little share it."""
    low, high = run_band(scenario, times)
    return reduction_band(low=low, high=high)


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
    if scenario.time.settled:
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
    if any(part.begins_with(times) for part in drive.parts()):
        return drive.shortest_piece(end)  # every output is at a corner
    begins = [] if scenario.time.settled else [0.0]
    corners = np.concatenate([[-math.inf], begins, drive.corners(end)[0]])
    if len(corners) == 1:
        return drive.shortest_piece(end)
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
    return [1 / part.period] if part.period else []
