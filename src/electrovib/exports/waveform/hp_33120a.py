"""Arbitrary waveforms of the function generator HP 33120A, as a table of its codes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.data.marks import Form, unsigned
from electrovib.exports.waveform.encoded import Encoded, Scaling

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.studies.waveform import Waveform

MOST_POINTS: Final = 16_000
"""Most points of an arbitrary waveform."""
FEWEST_POINTS: Final = 8
"""Fewest points; cited from memory, unverified."""
LARGEST_CODE: Final = 2047
"""Code of half of the peak-to-peak amplitude; -2047 is its negative."""
LARGEST_VOLTAGE: Final = 10.0
"""Largest voltage into a high impedance [V]; cited from memory, unverified."""
SMALLEST_AMPLITUDE: Final = 0.1
"""Smallest peak-to-peak voltage into a high impedance [V]; cited from memory, unverified."""


def encode(waveform: Waveform, scaling: Scaling) -> Encoded:
    """Return the samples as codes of 12 bits, in which 2047 is the largest voltage unless a full scale is given."""
    gain = scaling.gain
    if not (math.isfinite(gain) and gain > 0):
        raise InputError("must be a number above 0", path="gain", value=str(gain))
    full = scaling.full_scale if scaling.full_scale is not None else (waveform.peak or gain)
    if not (math.isfinite(full) and full > 0):
        raise InputError("must be a voltage above 0 V", path="full_scale", value=str(full))
    if full > LARGEST_VOLTAGE * gain * (1 + 1e-12):
        raise InputError(
            f"the full scale is {full:g} V of the drive, and the generator puts out at most {LARGEST_VOLTAGE:g} V (a value cited"
            " from memory, unverified): give the voltage of the drive over that of the generator, at least"
            f" {full / LARGEST_VOLTAGE:g}, with --gain; nothing was written",
            path="gain",
            value=f"{gain:g}",
        )
    if 2 * full / gain < SMALLEST_AMPLITUDE:
        raise InputError(
            f"the generator would have to put out {2 * full / gain:g} V peak to peak, and it puts out at least"
            f" {SMALLEST_AMPLITUDE:g} V (a value cited from memory, unverified); a setting that it refuses leaves the one before."
            " Give the gain of the amplifier that is used, or a larger full scale; nothing was written",
            path="gain",
            value=f"{gain:g}",
        )
    codes = codes_of(waveform.voltages, full)
    return Encoded(
        waveform=waveform,
        voltages=voltages_of(codes, full),
        codes=codes,
        full_scale=full,
        notes=_settings(waveform, full / gain, full),
    )


def codes_of(voltages: Real, full: float) -> Real:
    """Return the codes of voltages, in which 0 is 0 V and 2047 the voltage `full`; none is clipped."""
    codes: Real = np.rint(voltages / full * LARGEST_CODE)
    if not np.all(np.abs(codes) <= LARGEST_CODE):
        why = f"the drive reaches {float(np.max(np.abs(voltages))):g} V, more than the full scale; nothing was written"
        raise InputError(why, path="full_scale", value=f"{full:g} V")
    return codes


def voltages_of(codes: Real, full: float) -> Real:
    """Return the voltages of the drive [V] that codes stand for, with the voltage at code 2047 [V]."""
    return codes / LARGEST_CODE * full


def _settings(waveform: Waveform, output: float, full: float) -> tuple[str, ...]:
    """Return the settings with which the generator plays the codes as these voltages."""
    frequency = waveform.rate / len(waveform.times)
    return (
        f"code {LARGEST_CODE} is {full!r} V of the drive and {output!r} V at the output of the generator",
        f"one burst of one cycle (BM:NCYC 1) at FREQ {frequency!r} Hz: {len(waveform.times)} points at {waveform.rate!r} Hz",
        f"amplitude {format_quantity(2 * output, 'V', digits=8)} peak to peak (VOLT {2 * output!r} VPP), VOLT:OFFS 0, into a high"
        " impedance: OUTP:LOAD INF; with its default of 50 ohm the voltage would be twice as large",
    )


def as_csv(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write columns of time, voltage of the drive and code, after the settings as comments."""
    assert encoded.codes is not None
    lines = [f"# {unsigned(Form.WAVEFORM)}", *(f"# {note}" for note in notes), "time [s],voltage [V],code"]
    columns = (encoded.waveform.times.tolist(), encoded.voltages.tolist(), encoded.codes.astype(int).tolist())
    lines += [f"{time!r},{voltage!r},{code}" for time, voltage, code in zip(*columns, strict=True)]
    return ("\n".join(lines) + "\n").encode()
