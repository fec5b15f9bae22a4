"""The signals of a drive that enter the recursion in each step: its values, or its rises."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.recursion.hold import weights_of

if TYPE_CHECKING:
    from electrovib.core.arrays import Numbers, Real
    from electrovib.solve.recursion.record import StraightDrive


class Inputs(NamedTuple):
    """One number of each signal per step, and its weights in the recursion.

    Parameters
    ----------
    signals : tuple of ndarray, (pieces,)
        Values of the drive or its rises, and its drops at the beginning of each piece if it is discontinuous.
    now, later : ndarray, (signals, poles)
        Weight of a sample in the recursion's state at once, and one step later.
    shift : ndarray, (poles,)
        Share of the drive that is added to the recursion's state to obtain the mode.
    at_end : ndarray, (signals,)
        Value of each signal at the last point.

    Notes
    -----
    With values, the recursion's state is ``w = x - last v``, ``w' = decay w + (decay last + first) v``: a continuous
    drive enters once, and not as starts and ends. With rises it is ``x - v`` itself, which becomes
    ``decay (x - v) - (1 - last) rise``: the small lag of a mode that follows the drive closely is then not the
    difference of two large numbers.
    """

    signals: tuple[Real, ...]
    now: Numbers
    later: Numbers
    shift: Numbers
    at_end: Real


def of_values(drive: StraightDrive, z: Numbers) -> Inputs:
    """Return the values of a drive as the signals of the recursion.

    `z` (poles,) [-].
    """
    decay, first, last = weights_of(z)
    jumps = drive.jumps()
    signals = (drive.starts,) if jumps is None else (drive.starts, jumps)
    count = len(signals)
    now, later = np.stack([np.zeros_like(z), last]), np.stack([decay * last + first, decay * last])
    return Inputs(signals, now[:count], later[:count], last, np.array([drive.ends[-1], 0.0])[:count])


def of_rises(drive: StraightDrive, z: Numbers) -> Inputs:
    """Return the rises of a drive as the signals of the recursion, whose states are lags behind the drive.

    `z` (poles,) [-].
    """
    decay, _, last = weights_of(z)
    jumps, rises = drive.jumps(), drive.ends - drive.starts
    signals = (rises,) if jumps is None else (rises, jumps)
    count = len(signals)
    now, later = np.stack([np.zeros_like(z), np.ones_like(z)]), np.stack([last - 1.0, decay])
    return Inputs(signals, now[:count], later[:count], np.zeros_like(z), np.zeros(count))
