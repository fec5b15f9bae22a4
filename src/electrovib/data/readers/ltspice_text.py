"""Text that LTspice exports: complex numbers in one cell, and the runs of a stepped simulation one below the other."""

from __future__ import annotations

import cmath
import math
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.readers.spice_raw import chosen_run, columns_of
from electrovib.data.recorded import FileFormat, begins

if TYPE_CHECKING:
    from pathlib import Path

    from electrovib.data.recorded import Recorded

_STEP: Final = "Step Information:"
_POLAR: Final = re.compile(r"\(([^,]+)dB,([^,]+?)\u00c2?\u00b0\)")
"""A modulus in dB and an angle in degrees, whose sign is written in several encodings."""
_UNITS: Final = {"time": "s", "frequency": "Hz", "V(": "V", "I": "A"}


def read_ltspice_text(path: Path, *, part: str = "") -> Recorded:
    """Read one run of an exported plot, the first by default, and name the others as not read."""
    heading, *lines = path.read_bytes().decode("latin-1").splitlines()
    runs: dict[str, list[list[str]]] = {}
    name, names = "plot", heading.replace("Freq.", "frequency").split("\t")
    for line in lines:
        if line.startswith(_STEP):
            name = " ".join(line.removeprefix(_STEP).split())
        elif line.strip():
            runs.setdefault(name, []).append(line.split("\t"))
    tables = {}
    for name, rows in runs.items():
        try:
            values = np.array([[_number(cell) for cell in row] for row in rows]).reshape(-1, len(names)).T
        except (ValueError, TypeError, OverflowError):
            raise DataFileError(f"holds a row of {name} that is not made of numbers.") from None
        units = [
            next((unit for begin, unit in _UNITS.items() if each.startswith(begin)), "") for each in names
        ]
        tables[name] = columns_of(list(zip(names, units, strict=True)), list(values))
    return chosen_run(tables, part)


def _number(cell: str) -> complex:
    """Read a number, a real and an imaginary part, or a modulus and an angle."""
    if polar := _POLAR.fullmatch(cell.strip()):
        return cmath.rect(10 ** (float(polar[1]) / 20), math.radians(float(polar[2])))
    parts = [float(each) for each in cell.split(",")]
    return complex(*parts) if len(parts) > 1 else parts[0]


FORMAT: Final = FileFormat(
    name="ltspice",
    description="text of LTspice with complex cells or steps (.txt)",
    can_read=begins(
        rb"(?:Freq\.|time)\t[^\n]*\n(?:Step Information:|[^\t\n]+\t(?:\([^\t\n]+dB,|[-+\d.]+e[-+\d]+,))"
    ),
    read=read_ltspice_text,
    options=("part",),
)
