"""Waveforms as floating-point numbers: CSV, NumPy, MATLAB and a source of a SPICE netlist."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.data.marks import Form, unsigned
from electrovib.exports.waveform.encoded import Encoded, Scaling

if TYPE_CHECKING:
    from electrovib.studies.waveform import Waveform

_HEADER = 116  # bytes of text that a MATLAB file begins with


def encode(waveform: Waveform, scaling: Scaling) -> Encoded:
    """Return the samples themselves, which double precision holds exactly; a scaling is refused."""
    if scaling != Scaling():
        raise InputError(
            "this format holds volts of the drive; omit the full scale and the gain", path="scaling"
        )
    return Encoded(waveform=waveform, voltages=waveform.voltages)


def as_csv(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write columns of time and voltage at 17 digits, after the notes as comments."""
    lines = [f"# {unsigned(Form.WAVEFORM)}", *(f"# {note}" for note in notes), "time [s],voltage [V]"]
    pairs = zip(encoded.waveform.times.tolist(), encoded.voltages.tolist(), strict=True)
    lines += [f"{time!r},{voltage!r}" for time, voltage in pairs]
    return ("\n".join(lines) + "\n").encode()


def as_npy(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write a structured array with the fields ``time`` [s] and ``voltage`` [V]; the format has no place for the notes."""
    del notes
    array = np.empty(len(encoded.voltages), dtype=[("time", "<f8"), ("voltage", "<f8")])
    array["time"], array["voltage"] = encoded.waveform.times, encoded.voltages
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return file.getvalue()


def as_mat(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write the columns ``time`` [s] and ``voltage`` [V], the number ``rate`` [Hz] and the text ``notes``."""
    import scipy.io

    content = {
        "time": encoded.waveform.times,
        "voltage": encoded.voltages,
        "rate": encoded.waveform.rate,
        "notes": "\n".join(notes),
    }
    file = io.BytesIO()
    scipy.io.savemat(file, content, oned_as="column")
    header = f"MATLAB 5.0 MAT-file, {unsigned(Form.WAVEFORM)}"
    file.getbuffer()[:_HEADER] = header.ljust(_HEADER).encode()
    return file.getvalue()


def as_pwl(encoded: Encoded, notes: Sequence[str]) -> bytes:
    """Write a voltage source ``Vdrive`` from node ``drive`` to ground, to be included in a netlist."""
    lines = [f"* {unsigned(Form.WAVEFORM)}", *(f"* {note}" for note in notes), "Vdrive drive 0 PWL("]
    pairs = zip(encoded.waveform.times.tolist(), encoded.voltages.tolist(), strict=True)
    lines += [f"+ {time!r} {voltage!r}" for time, voltage in pairs]
    return ("\n".join([*lines, "+ )"]) + "\n").encode()
