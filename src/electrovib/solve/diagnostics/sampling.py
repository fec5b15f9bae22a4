"""Diagnostic of output times that are too far apart to show the drive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.physics.drive.shown import FEWEST, ROUNDING, enough, fastest_frequency, shows

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive

MOST: Final = 4_000_000
"""Samples beyond which no number of even times is advised."""


def sampling(drive: Drive, times: Real) -> list[Diagnostic]:
    """Return a warning where output values are exact but a line through them does not follow the result.

    `times` (n,) [s].
    """
    if len(times) < 2 or shows(drive, times):
        return []
    step, fastest = float(np.max(np.diff(times))), fastest_frequency(drive)
    needed = enough(drive, float(times[0]), float(times[-1]), fewest=len(times), most=MOST)
    changes = f"varies at {format_quantity(fastest, 'Hz')}"
    if step * fastest * FEWEST <= 1 + ROUNDING:
        changes = "has pieces that lie between them"
    advice = f"time.samples = {needed} would show it"
    if drive.time_stamps is not None:
        advice = "omit time.samples: the times of the measured drive show it"
    elif needed > MOST:
        advice = f"more than {MOST} samples would be needed: request numbers with --quantity, or a shorter time.duration"
    text = (
        f"the output times are {format_quantity(step, 's')} apart, but the drive {changes}: the values are exact at each"
        f" time, and a line between them is misleading; {advice}"
    )
    return [Diagnostic("sampling", "warning", text, float(needed), float(len(times)), "1")]
