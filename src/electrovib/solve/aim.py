"""What an amplifier aims at, in straight pieces."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.parts import Linear

if TYPE_CHECKING:
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive


@dataclass(frozen=True)
class Piece:
    """A straight piece of what an amplifier aims at.

    Parameters
    ----------
    start, stop : float
        s.
    level, slope : float
        V at the beginning, V/s.
    """

    start: float
    stop: float
    level: float
    slope: float


def aim_pieces(drive: Drive, end: float, amplifier: Amplifier, frequency: float) -> list[Piece]:
    """Cut the voltage that an amplifier aims at into straight pieces.

    Parameters
    ----------
    drive : Drive
        A voltage, off before time 0.
    end : float
        Last time [s].
    amplifier : Amplifier
        Its gain and its largest voltage.
    frequency : float
        How often what is not straight in the drive is cut [Hz].

    Returns
    -------
    list of Piece
        Up to the end, and one that begins there as the drive goes on.
    """
    times = [np.array([0.0, end])]
    for part in drive.parts():
        if isinstance(part, Linear):
            times.append(part.until(end).times)
        else:
            times.append(np.array([part.start, part.stop]))
            times.append(np.linspace(0.0, end, 1 + int(np.ceil(end * frequency))))
    marks = np.unique(np.concatenate(times))
    marks = marks[(marks >= 0) & (marks <= end)]
    marks = marks[np.append(True, np.diff(marks) > 1e-14 * end)]
    found: list[Piece] = []
    for start, stop in pairwise(marks.tolist()):
        near = (stop - start) * 1e-6
        inside = amplifier.gain * drive.voltage(np.array([start + near, stop - near]))
        slope = float(inside[1] - inside[0]) / (stop - start - 2 * near)
        found += _clipped(start, stop, float(inside[0]) - slope * near, slope, amplifier.saturation)
    voltage, rise = float(drive.voltage(np.array(end))), amplifier.gain * float(drive.slope(np.array(end)))
    level = float(amplifier.aim(voltage))
    found.append(Piece(end, np.inf, level, rise if level == amplifier.gain * voltage else 0.0))
    return found


def _clipped(start: float, stop: float, level: float, slope: float, limit: float | None) -> list[Piece]:
    if limit is None:
        return [Piece(start, stop, level, slope)]
    crossings = [start + (side * limit - level) / slope for side in (-1, 1)] if slope else []
    cuts = [start, *sorted(each for each in crossings if start < each < stop), stop]
    found = []
    for first, last in pairwise(cuts):
        middle = level + slope * ((first + last) / 2 - start)
        free = abs(middle) <= limit
        begin = level + slope * (first - start) if free else np.sign(middle) * limit
        found.append(Piece(first, last, float(begin), slope if free else 0.0))
    return found
