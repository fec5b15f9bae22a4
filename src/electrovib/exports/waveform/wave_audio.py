"""Waveforms as WAV files of 24 bits."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.data.marks import Form, unsigned
from electrovib.exports.waveform.encoded import Encoded, Scaling

if TYPE_CHECKING:
    from electrovib.studies.waveform import Waveform

RATES: Final = (44_100.0, 48_000.0, 96_000.0, 192_000.0)
"""Rates of audio outputs [Hz]."""
_BITS: Final = 24
_FULL: Final = 1 << (_BITS - 1)
"""Code of full scale; the largest that a file holds is one less."""
COUPLING: Final = (
    "audio outputs are usually AC-coupled: a constant voltage and slow parts of the drive are lost, so a drive with an offset or"
    " a long hold needs a DC-coupled output"
)


def encode(waveform: Waveform, scaling: Scaling) -> Encoded:
    """Return the samples as shares of full scale in 24 bits, rounded towards 0 so that none is enlarged."""
    if scaling.gain != 1.0:
        raise InputError(
            "belongs to an instrument (--as); a WAV file has a full scale",
            path="gain",
            value=f"{scaling.gain:g}",
        )
    largest = float(np.max(np.abs(waveform.voltages)))
    full = scaling.full_scale
    if full is None:
        full = (waveform.peak or 1.0) * _FULL / (_FULL - 1)
    if not (math.isfinite(full) and full > 0):
        raise InputError("must be a voltage above 0 V", path="full_scale", value=str(full))
    codes = np.trunc(waveform.voltages / full * _FULL)
    if np.any(np.abs(codes) > _FULL - 1):
        why = f"the drive reaches {largest:g} V, and a WAV file holds less than its full scale; nothing was written"
        raise InputError(why, path="full_scale", value=f"{full:g} V")
    notes = (
        f"full scale is {full!r} V of the drive: adjust output and amplifier so that a sample at full scale gives"
        f" {format_quantity(full, 'V', digits=6)} there, and secure it against a higher volume",
        COUPLING,
        "the converter of an audio output smooths between the samples and may overshoot them; measure the output before use",
    )
    return Encoded(
        waveform=waveform, voltages=codes / _FULL * full, codes=codes, full_scale=full, notes=notes
    )


def as_wav(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write one channel of 24-bit samples, with the notes in the comment of the file."""
    assert encoded.codes is not None
    rate = round(encoded.waveform.rate)
    codes = encoded.codes.astype("<i4")
    data = codes.view("u1").reshape(-1, 4)[:, :3].tobytes()
    comment = "; ".join([unsigned(Form.WAVEFORM), *notes]).encode()
    info = b"INFO" + _chunk(b"ICMT", comment + b"\0")
    form = struct.pack("<HHIIHH", 1, 1, rate, rate * _BITS // 8, _BITS // 8, _BITS)
    body = b"WAVE" + _chunk(b"fmt ", form) + _chunk(b"LIST", info) + _chunk(b"data", data)
    return b"RIFF" + struct.pack("<I", len(body)) + body


def _chunk(name: bytes, content: bytes) -> bytes:
    return name + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)
