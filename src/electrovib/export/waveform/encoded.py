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

    `full_scale` is the voltage of the drive at full scale [V], None for its largest voltage; `gain` the
    voltage of the drive over that of the instrument.
    """

    full_scale: float | None = None
    gain: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Encoded:
    """Samples as a format can hold them.

    `voltages` are those of the drive that the file represents after rounding [V], `codes` its whole numbers,
    None for floating-point numbers; the `notes` state how to play the file so that it gives these voltages.
    """

    waveform: Waveform
    voltages: Real
    codes: Real | None = None
    full_scale: float | None = None
    notes: tuple[str, ...] = ()
