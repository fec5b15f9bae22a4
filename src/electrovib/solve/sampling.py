"""Whether the times at which a result is wanted are close enough to show it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.lamps import Lamp
from electrovib.core.units import format_quantity
from electrovib.physics.drive.parts import Linear, Part

if TYPE_CHECKING:
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.transfer import Real

FEWEST: Final = 8
"""Samples a cycle of the drive below which a curve misleads: the force has two cycles in it."""


def sampling(drive: Drive, times: Real) -> list[Lamp]:
    """Warn where a result is exact at its times but a line through them is not the result.

    Parameters
    ----------
    drive : Drive
        What oscillates.
    times : ndarray, shape (n,)
        When the result is wanted, increasing [s].

    Returns
    -------
    list of Lamp
        One warning with the number of samples that would do, or none.
    """
    fastest = max((_fastest(part) for part in drive.parts()), default=0.0)
    step = float(np.max(np.diff(times))) if len(times) > 1 else 0.0
    if step * fastest * FEWEST <= 1 + 1e-9:
        return []
    needed = math.ceil(FEWEST * fastest * float(times[-1] - times[0])) + 1
    text = (
        f"the times are {format_quantity(step, 's')} apart, but the drive changes with"
        f" {format_quantity(fastest, 'Hz')}: right at each of them, misleading between them;"
        f" time.samples = {needed} would show it"
    )
    return [Lamp("sampling", "warning", text)]


def _fastest(part: Part) -> float:
    """Give the highest frequency of a part [Hz]; of straight pieces, how often the whole of them passes."""
    if not isinstance(part, Linear):
        return part.highest_frequency
    lasts = part.period or float(part.times[-1])
    return 1 / lasts if lasts else 0.0
