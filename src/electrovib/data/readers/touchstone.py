"""Touchstone files (.s1p) of a one-port: reflection, impedance or admittance over frequency."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import CanRead, DataColumn, FileFormat, Recorded

if TYPE_CHECKING:
    from pathlib import Path

    from electrovib.core.arrays import Complex, Real

_OPTIONS: Final = re.compile(rb"^\s*#\s*([^\n\r!]{0,80})", re.MULTILINE)
_FREQUENCY: Final = {"HZ": 1.0, "KHZ": 1e3, "MHZ": 1e6, "GHZ": 1e9}
_LONGEST_LINE: Final = 1000


def read_touchstone(path: Path) -> Recorded:
    """Read the impedance of a one-port.

    Z = R (1 + S) / (1 - S) with the reference resistance R of the file. Parameters Z and Y of version 1 are
    normalised to R. Without an option line the format prescribes GHz, S, MA and 50 ohm.
    """
    raw = path.read_bytes()
    unit, kind, form, reference = _options(path, raw)
    lines = (line.partition(b"!")[0].strip() for line in raw.splitlines())
    rows = [line[:_LONGEST_LINE].split() for line in lines if line and not line.startswith((b"#", b"["))]
    if any(len(row) != 3 for row in rows) or len(rows) < 2:
        raise DataFileError(
            "is no Touchstone file of a one-port: its rows do not have three numbers.", path=path
        )
    try:
        frequency, first, second = np.array(rows, dtype=float).T
    except ValueError:
        raise DataFileError("holds a row that is not made of numbers.", path=path) from None
    values = _complex(first, second, form)
    with np.errstate(all="ignore"):  # a reflection of 1 is an open end
        impedance = {"S": (1 + values) / (1 - values), "Z": values, "Y": 1 / values}[kind] * reference
    return Recorded(
        channels=(
            DataColumn(name="frequency", unit="Hz", values=frequency * _FREQUENCY[unit]),
            DataColumn(name="Z'", unit="ohm", values=impedance.real),
            DataColumn(name="Z''", unit="ohm", values=impedance.imag),
        ),
        attributes={"parameters": f"{kind} {form}, reference {reference:g} ohm"},
    )


def _options(path: Path, raw: bytes) -> tuple[str, str, str, float]:
    """Return unit of frequency, kind of parameters, form of complex numbers and reference resistance [ohm]."""
    match = _OPTIONS.search(raw)
    words = match[1].decode("latin-1").upper().split() if match else []
    unit = next((word for word in words if word in _FREQUENCY), "GHZ")
    kind = next((word for word in words if word in ("S", "Z", "Y", "G", "H")), "S")
    form = next((word for word in words if word in ("MA", "DB", "RI")), "MA")
    try:
        reference = float(words[words.index("R") + 1]) if "R" in words else 50.0
    except (ValueError, IndexError):
        reference = 0.0
    if kind not in ("S", "Z", "Y") or not 0 < reference < np.inf:
        raise DataFileError(
            f"states the parameters {kind} with the reference {reference:g} ohm; known are S, Z and Y.",
            path=path,
        )
    return unit, kind, form, reference


def _complex(first: Real, second: Real, form: str) -> Complex:
    """Combine real and imaginary part, or magnitude (also in dB) and angle in degrees."""
    if form == "RI":
        return np.asarray(first + 1j * second)
    with np.errstate(all="ignore"):  # a damaged file may overflow
        size = 10 ** (first / 20) if form == "DB" else first
        return np.asarray(size * np.exp(1j * np.deg2rad(second)))


def _can_read(head: bytes, suffix: str) -> CanRead:
    return CanRead.YES if suffix == ".s1p" and b"\0" not in head else CanRead.NO


FORMAT: Final = FileFormat(
    name="touchstone",
    description="Touchstone files of a one-port (.s1p): S, Z or Y as an impedance",
    can_read=_can_read,
    read=read_touchstone,
)
