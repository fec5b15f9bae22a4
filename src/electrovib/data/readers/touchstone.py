"""Touchstone files (.s1p, .ts) of a one-port: reflection, impedance or admittance over frequency."""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import CanRead, FileFormat, NotRead, recorded_of

if TYPE_CHECKING:
    from pathlib import Path

    from electrovib.core.arrays import Complex, Real
    from electrovib.data.recorded import Recorded

_FREQUENCY: Final = {"HZ": 1.0, "KHZ": 1e3, "MHZ": 1e6, "GHZ": 1e9}
_KEYWORD: Final = re.compile(r"^\s*\[([^\]\n]*)\]", re.MULTILINE)
_SUFFIX: Final = re.compile(r"\.s(\d{1,2})p")
_LONGEST_LINE: Final = 1000


def read_touchstone(path: Path) -> Recorded:
    """Read the impedance of a one-port.

    Z = R (1 + S) / (1 - S) with the reference resistance R of the file. Parameters Z and Y are normalised to R
    in version 1, and in ohm and siemens from version 2 on, where ``[Reference]`` states R. Without an option
    line the format prescribes GHz, S, MA and 50 ohm.
    """
    raw = path.read_bytes().decode("latin-1")
    text = "\n".join(line.partition("!")[0][:_LONGEST_LINE] for line in raw.splitlines())
    words = _KEYWORD.split(text)
    sections = {key.strip().lower(): body for key, body in zip(words[1::2], words[2::2], strict=True)}
    is_first = float(_stated(sections, "version", "1")) < 2
    option_line = re.search(r"^\s*#(.*)", text, re.MULTILINE)
    options = option_line[1].upper().split() if option_line else []
    unit = next((word for word in options if word in _FREQUENCY), "GHZ")
    kind = next((word for word in options if word in ("S", "Z", "Y", "G", "H")), "S")
    form = next((word for word in options if word in ("MA", "DB", "RI")), "MA")
    resistance = next((after for word, after in itertools.pairwise([*options, ""]) if word == "R"), "50")
    reference = float(_stated(sections, "reference", resistance))
    name = _SUFFIX.fullmatch(path.suffix.lower())
    ports = _stated(sections, "number of ports", name[1] if name else "1")
    body = text if is_first else sections.get("network data", "")
    rows = [line.split() for line in body.splitlines() if line.strip() and line.lstrip()[0] not in "#["]
    if kind not in ("S", "Z", "Y"):
        raise DataFileError(f"states the parameters {kind}; known are S, Z and Y.")
    if float(ports) != 1 or any(len(row) != 3 for row in rows) or len(rows) < 2:
        raise DataFileError(
            f"is no Touchstone file of a one-port: it states {ports} ports, or its rows do not have three numbers. Save the"
            " impedance of the sample, or one reflection such as S11, as .s1p."
        )
    if len(rows) != int(float(stated := _stated(sections, "number of frequencies", str(len(rows))))):
        raise DataFileError(f"states {stated} frequencies and holds {len(rows)}: it is cut off.")
    try:
        frequency, first, second = np.array(rows, dtype=float).T
    except ValueError:
        raise DataFileError("holds a row that is not made of numbers.") from None
    with np.errstate(all="ignore"):  # a reflection of 1 is an open end, and a damaged file may overflow
        values = _complex(first, second, form)
        normalised = {"S": (1 + values) / (1 - values), "Z": values, "Y": 1 / values}[kind]
        impedance = normalised * (reference if is_first or kind == "S" else 1.0)
    columns = [
        ("frequency", "Hz", frequency * _FREQUENCY[unit]), ("Z'", "ohm", impedance.real), ("Z''", "ohm", impedance.imag),
    ]  # fmt: skip
    about = {"parameters": f"{kind} {form}, reference {reference:g} ohm"}
    noise = [NotRead(name=key, why="only network data are read") for key in sections if key == "noise data"]
    return recorded_of(columns, attributes=about, not_read=noise)


def _stated(sections: dict[str, str], key: str, otherwise: str) -> str:
    """Return the number above 0 that stands behind a keyword, on its line or below it."""
    found = (sections.get(key, otherwise).split() or [""])[0]
    try:
        if 0 < float(found) < np.inf:
            return found
    except ValueError:
        pass
    raise DataFileError(f"states '{found}' for [{key.title()}], where a number above 0 is expected.")


def _complex(first: Real, second: Real, form: str) -> Complex:
    """Combine real and imaginary part, or magnitude (also in dB) and angle in degrees."""
    if form == "RI":
        return np.asarray(first + 1j * second)
    size = 10 ** (first / 20) if form == "DB" else first
    return np.asarray(size * np.exp(1j * np.deg2rad(second)))


def _can_read(head: bytes, suffix: str) -> CanRead:
    is_named = _SUFFIX.fullmatch(suffix) or (
        suffix == ".ts" and re.search(rb"^\s*\[Version\]", head, re.IGNORECASE | re.MULTILINE)
    )
    return CanRead.YES if is_named and b"\0" not in head else CanRead.NO


FORMAT: Final = FileFormat(
    name="touchstone",
    description="Touchstone files of a one-port (.s1p, .ts): S, Z or Y as an impedance",
    can_read=_can_read,
    read=read_touchstone,
)
