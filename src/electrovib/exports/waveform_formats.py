"""File formats of waveforms: how each holds the samples, and what a player makes of them."""

from __future__ import annotations

import io
import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity, number_in
from electrovib.data.atomic import Form, unsigned

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.studies.waveform import Waveform


@dataclass(frozen=True, kw_only=True)
class Scaling:
    """Relation of the voltage of the drive to what a file or an instrument holds.

    Parameters
    ----------
    full_scale : float, optional
        Voltage of the drive at full scale, of ``.wav`` and of an instrument [V]; by default its largest voltage. With one value
        several files need one setting of the amplifier.
    gain : float
        Voltage of the drive over that of the instrument [1].
    """

    full_scale: float | str | None = None
    gain: float | str = 1.0


def _ratio(scaling: Scaling) -> float:
    """Return the voltage of the drive over that of the instrument."""
    return number_in("1", "gain", scaling.gain)


def _full(scaling: Scaling, otherwise: float) -> float:
    """Return the voltage at full scale, or refuse one that is none."""
    full = otherwise if scaling.full_scale is None else number_in("V", "full_scale", scaling.full_scale)
    if not (math.isfinite(full) and full > 0):
        raise InputError("must be a voltage above 0 V", path="full_scale", value=str(full))
    return full


@dataclass(frozen=True, kw_only=True)
class Encoded:
    """Samples as a format can hold them: voltages after rounding, and their whole numbers where it has such codes."""

    waveform: Waveform
    voltages: Real
    codes: Real | None = None
    full_scale: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def columns(self) -> list[list[float]]:
        """Times and voltages, with the codes of an instrument."""
        codes = [] if self.codes is None else [self.codes.astype(int).tolist()]
        return [self.waveform.times.tolist(), self.voltages.tolist(), *codes]


def _exact(waveform: Waveform, scaling: Scaling) -> Encoded:
    """Return the samples themselves, which double precision holds exactly; a scaling is refused."""
    if scaling != Scaling():
        raise InputError(
            "this format holds volts of the drive; omit the full scale and the gain", path="scaling"
        )
    return Encoded(waveform=waveform, voltages=waveform.voltages)


def _as_csv(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write columns of time, voltage at 17 digits and code, after the notes as comments."""
    heading = "time [s],voltage [V]" + ("" if encoded.codes is None else ",code")
    lines = [f"# {unsigned(Form.WAVEFORM)}", *(f"# {note}" for note in notes), heading]
    lines += [",".join(map(repr, row)) for row in zip(*encoded.columns, strict=True)]
    return ("\n".join(lines) + "\n").encode()


def _as_npy(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write a structured array with the fields ``time`` [s] and ``voltage`` [V]; the format has no place for the notes."""
    del notes
    array = np.empty(len(encoded.voltages), dtype=[("time", "<f8"), ("voltage", "<f8")])
    array["time"], array["voltage"] = encoded.waveform.times, encoded.voltages
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return file.getvalue()


_MATLAB_HEADER: Final = 116
"""Bytes of text that a MATLAB file begins with."""


def _as_mat(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write the columns ``time`` [s] and ``voltage`` [V], the number ``rate`` [Hz] and the text ``notes``."""
    import scipy.io

    wave, file = encoded.waveform, io.BytesIO()
    content = {"time": wave.times, "voltage": encoded.voltages, "rate": wave.rate, "notes": "\n".join(notes)}
    scipy.io.savemat(file, content, oned_as="column")
    header = f"MATLAB 5.0 MAT-file, {unsigned(Form.WAVEFORM)}"
    file.getbuffer()[:_MATLAB_HEADER] = header.ljust(_MATLAB_HEADER).encode()
    return file.getvalue()


def _as_pwl(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write a voltage source ``Vdrive`` from node ``drive`` to ground, to be included in a netlist."""
    lines = [f"* {unsigned(Form.WAVEFORM)}", *(f"* {note}" for note in notes), "Vdrive drive 0 PWL("]
    lines += [f"+ {time!r} {voltage!r}" for time, voltage in zip(*encoded.columns, strict=True)]
    return ("\n".join([*lines, "+ )"]) + "\n").encode()


_BITS: Final = 24
_FULL: Final = 1 << (_BITS - 1)
"""Code of full scale of a WAV file; the largest that it holds is one less."""
_COUPLING: Final = (
    "audio outputs are usually AC-coupled: a constant voltage and slow parts of the drive are lost, so a drive with an offset or"
    " a long hold needs a DC-coupled output"
)


def _as_shares(waveform: Waveform, scaling: Scaling) -> Encoded:
    """Return the samples as shares of full scale in 24 bits, rounded towards 0 so that none is enlarged."""
    if _ratio(scaling) != 1.0:
        why = "belongs to an --instrument; a WAV file has a full scale"
        raise InputError(why, path="gain", value=f"{_ratio(scaling):g}")
    full = _full(scaling, (waveform.peak or 1.0) * _FULL / (_FULL - 1))
    codes = np.trunc(waveform.voltages / full * _FULL)
    if np.any(np.abs(codes) > _FULL - 1):
        largest = float(np.max(np.abs(waveform.voltages)))
        why = f"the drive reaches {largest:g} V, and a WAV file holds less than its full scale; nothing was written"
        raise InputError(why, path="full_scale", value=f"{full:g} V")
    notes = (
        f"full scale is {full!r} V of the drive: adjust output and amplifier so that a sample at full scale gives"
        f" {format_quantity(full, 'V', digits=6)} there, and secure it against a higher volume",
        _COUPLING,
        "the converter of an audio output smooths between the samples and may overshoot them; measure the output before use",
    )
    voltages = codes / _FULL * full
    return Encoded(waveform=waveform, voltages=voltages, codes=codes, full_scale=full, notes=notes)


def _as_wav(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write one channel of 24-bit samples, with the notes in the comment of the file."""
    assert encoded.codes is not None
    rate = round(encoded.waveform.rate)
    data = encoded.codes.astype("<i4").view("u1").reshape(-1, 4)[:, :3].tobytes()
    comment = "; ".join([unsigned(Form.WAVEFORM), *notes]).encode()
    info = b"INFO" + _chunk(b"ICMT", comment + b"\0")
    form = struct.pack("<HHIIHH", 1, 1, rate, rate * _BITS // 8, _BITS // 8, _BITS)
    body = b"WAVE" + _chunk(b"fmt ", form) + _chunk(b"LIST", info) + _chunk(b"data", data)
    return b"RIFF" + struct.pack("<I", len(body)) + body


def _chunk(name: bytes, content: bytes) -> bytes:
    return name + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)


HP_MOST_POINTS: Final = 16_000
"""Most points of an arbitrary waveform of the HP 33120A."""
HP_FEWEST_POINTS: Final = 8
"""Fewest points; cited from memory, unverified."""
HP_LARGEST_CODE: Final = 2047
"""Code of half of the peak-to-peak amplitude; -2047 is its negative."""
HP_LARGEST_VOLTAGE: Final = 10.0
"""Largest voltage into a high impedance [V]; cited from memory, unverified."""
HP_SMALLEST_AMPLITUDE: Final = 0.1
"""Smallest peak-to-peak voltage into a high impedance [V]; cited from memory, unverified."""


def _as_codes(waveform: Waveform, scaling: Scaling) -> Encoded:
    """Return the samples as codes of 12 bits, in which 2047 is the largest voltage unless a full scale is given."""
    gain = _ratio(scaling)
    if not (math.isfinite(gain) and gain > 0):
        raise InputError("must be a number above 0", path="gain", value=str(gain))
    full = _full(scaling, waveform.peak or gain)
    if full > HP_LARGEST_VOLTAGE * gain * (1 + 1e-12):
        raise InputError(
            f"the full scale is {full:g} V of the drive, and the generator puts out at most {HP_LARGEST_VOLTAGE:g} V (a value"
            " cited from memory, unverified): give the voltage of the drive over that of the generator, at least"
            f" {full / HP_LARGEST_VOLTAGE:g}, with --gain; nothing was written",
            path="gain",
            value=f"{gain:g}",
        )
    if 2 * full / gain < HP_SMALLEST_AMPLITUDE:
        raise InputError(
            f"the generator would have to put out {2 * full / gain:g} V peak to peak, and it puts out at least"
            f" {HP_SMALLEST_AMPLITUDE:g} V (a value cited from memory, unverified); a setting that it refuses leaves the one"
            " before. Give the gain of the amplifier that is used, or a larger full scale; nothing was written",
            path="gain",
            value=f"{gain:g}",
        )
    codes, notes = codes_of(waveform.voltages, full), _settings(waveform, full / gain, full)
    voltages = voltages_of(codes, full)
    return Encoded(waveform=waveform, voltages=voltages, codes=codes, full_scale=full, notes=notes)


def codes_of(voltages: Real, full: float) -> Real:
    """Return the codes of voltages, in which 0 is 0 V and 2047 the voltage `full`; none is clipped."""
    codes: Real = np.rint(voltages / full * HP_LARGEST_CODE)
    if not np.all(np.abs(codes) <= HP_LARGEST_CODE):
        why = f"the drive reaches {float(np.max(np.abs(voltages))):g} V, more than the full scale; nothing was written"
        raise InputError(why, path="full_scale", value=f"{full:g} V")
    return codes


def voltages_of(codes: Real, full: float) -> Real:
    """Return the voltages of the drive [V] that codes stand for, with the voltage at code 2047 [V]."""
    return codes / HP_LARGEST_CODE * full


def _settings(waveform: Waveform, output: float, full: float) -> tuple[str, ...]:
    """Return the settings with which the generator plays the codes as these voltages."""
    frequency = waveform.rate / len(waveform.times)
    return (
        f"code {HP_LARGEST_CODE} is {full!r} V of the drive and {output!r} V at the output of the generator",
        f"one burst of one cycle (BM:NCYC 1) at FREQ {frequency!r} Hz: {len(waveform.times)} points at {waveform.rate!r} Hz",
        f"amplitude {format_quantity(2 * output, 'V', digits=8)} peak to peak (VOLT {2 * output!r} VPP), VOLT:OFFS 0, into a high"
        " impedance: OUTP:LOAD INF; with its default of 50 ohm the voltage would be twice as large",
    )


@dataclass(frozen=True, kw_only=True)
class WaveformFormat:
    """One format of files of waveforms.

    `encode` gives what the file can hold of samples and scaling, and `content` its bytes with notes. A format
    without a place for a mark has no `form`. With `held` a player holds each sample until the next; what is
    `played` by an instrument has to begin and end at 0 V. Any rate will do if `rates` is empty, else those
    that players offer [Hz].
    """

    name: str
    content: Callable[[Encoded, Sequence[str]], bytes]
    encode: Callable[[Waveform, Scaling], Encoded] = _exact
    form: Form | None = Form.WAVEFORM
    held: bool = False
    played: bool = True
    most_points: int | None = None
    fewest_points: int = 2
    rates: tuple[float, ...] = ()
    whole_rate: bool = False


RATES: Final = (44_100.0, 48_000.0, 96_000.0, 192_000.0)
"""Rates of audio outputs [Hz]."""
WAVEFORM_FORMATS: Final = {
    ".csv": WaveformFormat(name="CSV", content=_as_csv),
    ".npy": WaveformFormat(name="NumPy array", content=_as_npy, form=None),
    ".mat": WaveformFormat(name="MATLAB file", content=_as_mat),
    ".wav": WaveformFormat(name="WAV", content=_as_wav, encode=_as_shares, rates=RATES, whole_rate=True),
    ".pwl": WaveformFormat(name="SPICE source", content=_as_pwl, played=False),
}
"""Suffix to format."""
INSTRUMENTS: Final = {
    "hp_33120a": WaveformFormat(
        name="HP 33120A arbitrary waveform", content=_as_csv, encode=_as_codes, held=True,
        most_points=HP_MOST_POINTS, fewest_points=HP_FEWEST_POINTS,
    )
}  # fmt: skip
"""Name of an instrument to its format."""
