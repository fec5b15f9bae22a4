"""Samples as a format can hold them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.studies.waveform import Waveform


@dataclass(frozen=True, kw_only=True)
class Scaling:
    """Relation of the voltage of the drive to what a file or an instrument holds.

    It has the voltage at full scale, None for the largest one, and the voltage over that of the instrument.
    """

    full_scale: float | None = None
    gain: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Encoded:
    """Samples as a format can hold them: voltages after rounding, and their whole numbers where it has such codes."""

    waveform: Waveform
    voltages: Real
    codes: Real | None = None
    full_scale: float | None = None
    notes: tuple[str, ...] = ()
