"""Raw files of ngspice and LTspice (.raw), binary and ASCII: every plot, and every run of a stepped one, is a part."""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import FileFormat, begins, one_part, recorded_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

Column: TypeAlias = "tuple[str, str, Real]"
"""Name, unit and numbers."""
_DATA: Final = re.compile(rb"^(Binary|Values):\r?\n", re.MULTILINE)
_KEY: Final = re.compile(r"^([A-Z][a-z. A-Z]*):[ \t]*(.*?)\r?$", re.MULTILINE)
_VARIABLE: Final = re.compile(r"^(?:Variables:)?\s*\d+\t(\S+)\t([\w-]+)", re.MULTILINE)
_UNITS: Final = {
    "time": "s", "frequency": "Hz", "voltage": "V", "current": "A", "device_current": "A", "subckt_current": "A",
    "impedance": "ohm", "admittance": "S", "power": "W", "charge": "C", "capacitance": "F",
}  # fmt: skip


def read_spice_raw(path: Path, *, part: str = "") -> Recorded:
    """Read one run of a simulation, the first of two or more points by default, and name the others as not read.

    A complex vector is two channels, ``Re(v(out))`` and ``Im(v(out))``.
    """
    return chosen_run(dict(_runs(_narrow(path.read_bytes()))), part)


def chosen_run(runs: dict[str, list[Column]], part: str) -> Recorded:
    """Return the run that is asked for, else the first of two or more points."""
    sizes = {name: table[0][2].size for name, table in runs.items()}
    first = max(runs, key=lambda each: sizes[each] > 1)
    name, others = one_part(sizes, part, first, "plot or run")
    return recorded_of(runs[name], attributes={"table": name}, not_read=others)


def columns_of(named: Sequence[tuple[str, str]], vectors: Sequence[NDArray[Any]]) -> list[Column]:
    """Return vectors as columns, two of a complex one; the first is what the others are over, and real."""
    (name, unit), first = named[0], vectors[0].real
    # a negative time stands before points left out
    table = [(name, unit, np.abs(first) if unit == "s" else first)]
    for (name, unit), values in zip(named[1:], vectors[1:], strict=True):
        parts = {"Re({})": values.real, "Im({})": values.imag} if np.iscomplexobj(values) else {"{}": values}
        table += [(form.format(name), unit, numbers) for form, numbers in parts.items()]
    return table


def _narrow(raw: bytes) -> bytes:
    """Return a file whose header LTspice wrote in UTF-16 with one byte for each character."""
    if raw[1:2] != b"\0":
        return raw
    head, mark, data = raw.partition("Binary:\n".encode("utf-16-le"))
    return b"LTspice\n" + (head + mark).decode("utf-16-le", "replace").encode("latin-1", "replace") + data


def _runs(raw: bytes) -> Iterator[tuple[str, list[Column]]]:
    """Iterate over the columns of each run by name: a run ends where the time, frequency or sweep begins again."""
    at, names = 0, []
    while (data := _DATA.search(raw, at)) is not None:
        header = raw[at : data.start()].decode("latin-1")
        keys = {key.lower(): value for key, value in _KEY.findall(header)}
        variables, points = _VARIABLE.findall(header), keys.get("no. points", "")
        if not variables or keys.get("no. variables") != str(len(variables)) or not points.isdecimal():
            raise DataFileError("has a header without the number of its variables and points.")
        flags = keys.get("flags", "").lower().split()
        types = [np.dtype("<c16" if "complex" in flags else "<f8")] * len(variables)
        if re.search("LTspice|Linear Technology", header) and not {"double", "complex"} & {*flags}:
            types[1:] = [np.dtype("<f4")] * (len(types) - 1)
        try:
            if data[1] == b"Values":
                vectors, at = _written_out(raw, data.end(), int(points), types)
            else:
                vectors, at = _binary(raw, data.end(), int(points), types, by_column="fastaccess" in flags)
        except (ValueError, TypeError, OverflowError):
            why = f"does not hold the {points} points of {len(types)} numbers that it states: it is cut off or damaged."
            raise DataFileError(why) from None
        table = columns_of([(name, _UNITS.get(kind, "")) for name, kind in variables], vectors)
        names.append(plot := keys.get("plotname", "plot"))
        label = f"{plot} {names.count(plot)}" if names.count(plot) > 1 else plot
        first = table[0][2]
        again = np.diff(first) < 0 if variables[0][1] in ("time", "frequency") else first[1:] == first[:1]
        bounds = [0, *(np.flatnonzero(again) + 1), first.size]
        for number, (begin, end) in enumerate(itertools.pairwise(bounds), 1):
            run = f"{label}, run {number}" if len(bounds) > 2 else label
            yield run, [(name, unit, values[begin:end]) for name, unit, values in table]
    if raw[at:].strip() or not names:
        raise DataFileError("has a header without values behind it: it is cut off.")


def _written_out(
    raw: bytes, begin: int, points: int, types: Sequence[np.dtype[Any]]
) -> tuple[list[NDArray[Any]], int]:
    """Return the vectors of a plot in ASCII, where each point has its number before it, and where the next plot begins."""
    end = raw.find(b"Title:", begin) % (len(raw) + 1)
    width = 1 + len(types) * types[0].itemsize // 8
    found = np.array(raw[begin:end].replace(b",", b" ").split(), dtype=float).reshape(points, width)
    return list(np.ascontiguousarray(found[:, 1:]).view(types[0]).T), end


def _binary(
    raw: bytes, begin: int, points: int, types: Sequence[np.dtype[Any]], *, by_column: bool
) -> tuple[list[NDArray[Any]], int]:
    """Return the vectors of a plot, one after the other or point by point, and where the next one begins."""
    *places, row = np.cumsum([0, *(each.itemsize for each in types)]).tolist()
    return [
        np.ndarray(
            points, each, raw, begin + (points * at if by_column else at), each.itemsize if by_column else row
        )
        for each, at in zip(types, places, strict=True)
    ], begin + points * row


FORMAT: Final = FileFormat(
    name="spice",
    description="raw files of ngspice and LTspice (.raw), binary and ASCII",
    can_read=begins(rb"(T\0?i\0?t\0?l\0?e\0?:)(?=.*P\0?l\0?o\0?t\0?n\0?a\0?m\0?e\0?:)"),
    read=read_spice_raw,
    options=("part",),
)
