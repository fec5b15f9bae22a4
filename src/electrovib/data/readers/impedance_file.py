"""Files of impedance analysers and potentiostats, read with the package impedance."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.data.guarded import read_by_library
from electrovib.data.recorded import CanRead, FileFormat, recorded_of

if TYPE_CHECKING:
    from pathlib import Path

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

_PACKAGE: Final = "impedance"
_INSTRUMENTS: Final = {
    "gamry": rb"\A\s*EXPLAIN[\s\S]*(EISPOT|GALVEIS|HYBRIDEIS|ZCURVE)",
    "zplot": rb"\A\s*\"?ZPLOT|End Comments",
    "biologic": rb"\AEC-Lab ASCII FILE|\ABT-Lab ASCII FILE",
    "versastudio": rb"<Application>|<VersaStudio>|<Segment1>",
    "chinstruments": rb"A\.C\. Impedance[\s\S]*Freq/Hz",
}
"""Name of the instrument in the package, to a pattern of the first bytes of its files."""

_TABLES: Final = ("gamry", "biologic", "versastudio", "chinstruments")
"""Instruments whose files are tables, which the reader of text reads unless the reader ``impedance`` is chosen."""


def _instrument_of(head: bytes) -> str:
    """Return the instrument that wrote a file with these first bytes; empty if none is recognised."""
    return next((name for name, form in _INSTRUMENTS.items() if re.search(form, head, re.IGNORECASE)), "")


def read_impedance_file(path: Path) -> Recorded:
    """Read the spectrum of an impedance analyser: frequency [Hz], real and imaginary part of the impedance [ohm]."""
    with path.open("rb") as file:
        instrument = _instrument_of(file.read(65536))
    table = read_by_library(
        lambda: _spectrum(path, instrument or "gamry"), path, "a file of an impedance analyser"
    )
    return recorded_of(table, attributes={"instrument": instrument})


def _spectrum(path: Path, instrument: str) -> list[tuple[str, str, Real]]:
    """Return frequency and parts of the impedance, each with name and unit."""
    from impedance import preprocessing

    frequency, impedance = preprocessing.readFile(str(path), instrument=instrument)
    grid, values = np.asarray(frequency, dtype=float), np.asarray(impedance, dtype=complex)
    if grid.ndim != 1 or values.shape != grid.shape or grid.size < 2:
        raise ValueError("it holds no spectrum of two or more frequencies")
    return [("frequency", "Hz", grid), ("Z'", "ohm", values.real), ("Z''", "ohm", values.imag)]


def _can_read(head: bytes, suffix: str) -> CanRead:
    del suffix
    instrument = "" if b"\0" in head else _instrument_of(head)
    return CanRead.YES if instrument and instrument not in _TABLES else CanRead.NO


FORMAT: Final = FileFormat(
    name="impedance",
    description="ZPlot .z; also impedance of Gamry, BioLogic, VersaStudio, CH Instruments, which text reads too",
    can_read=_can_read,
    read=read_impedance_file,
    package=_PACKAGE,
    otherwise="; with --set reader=text it is read as a plain table",
)
