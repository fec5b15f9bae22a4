"""What of a drive pushes the modes in each step: its values, or how much it rises."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.recursion.hold import weights_of

if TYPE_CHECKING:
    from electrovib.core.arrays import Numbers, Real
    from electrovib.solve.recursion.record import StraightDrive


class Inputs(NamedTuple):
    """One number of each signal a step, and what the modes take of it.

    Parameters
    ----------
    signals : tuple of ndarray, (pieces,)
        Values of the drive or its rises, and its drops at the beginning of each piece if it jumps.
    now, later : ndarray, (signals, poles)
        What a number adds to the modes at once, and what one step later.
    shift : ndarray, (poles,)
        Share of the drive that stands in a mode beside the followed number.
    at_end : ndarray, (signals,)
        The number of each signal at the last point.

    Notes
    -----
    Of values ``w = x - last v`` is followed, ``w' = decay w + (decay last + first) v``: a drive without jumps enters
    once, and not as starts and ends. Of rises ``x - v`` itself, which becomes ``decay (x - v) - (1 - last) rise``: what
    is left of a drive that a mode follows closely is then no difference of two large numbers.
    """

    signals: tuple[Real, ...]
    now: Numbers
    later: Numbers
    shift: Numbers
    at_end: Real


def of_values(drive: StraightDrive, z: Numbers) -> Inputs:
    """Let the values of a drive push the modes.

    Parameters
    ----------
    drive : StraightDrive
        Pieces with one duration for all.
    z : ndarray, (poles,)
        Poles times step [-].

    Returns
    -------
    Inputs
        The drive, and its drops if it jumps.
    """
    decay, first, last = weights_of(z)
    jumps = drive.jumps()
    signals = (drive.starts,) if jumps is None else (drive.starts, jumps)
    count = len(signals)
    now, later = np.stack([np.zeros_like(z), last]), np.stack([decay * last + first, decay * last])
    return Inputs(signals, now[:count], later[:count], last, np.array([drive.ends[-1], 0.0])[:count])


def of_rises(drive: StraightDrive, z: Numbers) -> Inputs:
    """Let the rises of a drive push what modes lag behind it.

    Parameters
    ----------
    drive : StraightDrive
        Pieces with one duration for all.
    z : ndarray, (poles,)
        Poles times step [-].

    Returns
    -------
    Inputs
        Rises in each piece, and drops between them if it jumps.
    """
    decay, _, last = weights_of(z)
    jumps, rises = drive.jumps(), drive.ends - drive.starts
    signals = (rises,) if jumps is None else (rises, jumps)
    count = len(signals)
    now, later = np.stack([np.zeros_like(z), np.ones_like(z)]), np.stack([last - 1.0, decay])
    return Inputs(signals, now[:count], later[:count], np.zeros_like(z), np.zeros(count))
