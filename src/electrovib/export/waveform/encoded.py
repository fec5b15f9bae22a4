"""Samples as a format can hold them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.study.waveform import Waveform


@dataclass(frozen=True, kw_only=True)
class Scaling:
    """Relation of the voltage of the drive to what a file or an instrument holds.

    Parameters
    ----------
    full_scale : float or None
        Voltage of the drive at full scale of a format with a full scale [V]; its largest voltage if absent.
    gain : float
        Voltage of the drive over that of the instrument [1].
    """

    full_scale: float | None = None
    gain: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Encoded:
    """Samples as a format can hold them.

    Parameters
    ----------
    waveform : Waveform
        What was sampled.
    voltages : ndarray, shape (n,)
        Voltages of the drive that the file represents, after rounding [V].
    codes : ndarray, shape (n,), or None
        Whole numbers in the file; None for a format of floating-point numbers.
    full_scale : float or None
        Voltage of the drive at full scale [V].
    notes : tuple of str
        How to play the file so that it gives these voltages.
    """

    waveform: Waveform
    voltages: Real
    codes: Real | None = None
    full_scale: float | None = None
    notes: tuple[str, ...] = ()
