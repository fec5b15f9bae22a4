"""A column of a measured file: its numbers and unit as in the file, and their conversion to SI."""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.core.units import KINDS, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import NDArray

_ANGLE = re.compile(r"rad|deg|°|turn|rev|rpm|cycle")


@functools.cache
def kind_and_factor(unit: str) -> tuple[str, float] | None:
    """Return the SI unit of the kind to which a unit text belongs, and the conversion factor."""
    if unit in ("1", "-"):
        return "1", 1.0
    if not unit or len(unit) > 24:
        return None
    # likely kinds first, because each miss asks pint; to pint an angle is a plain number and rad/s is Hz
    for kind in sorted(KINDS, key=lambda kind: -len(kind) if unit.endswith(kind) else 0):
        if (kind == "rad") == bool(_ANGLE.search(unit)):
            try:
                return kind, parse_quantity(f"1 {unit}", kind)
            except ValueError:
                continue
    return None


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column with the numbers as they are in the file."""

    label: str
    unit: str
    values: NDArray[np.float64]
    place: Callable[[int], str]

    def in_si(self, path: Path, asked: str, *, missing: bool = False) -> NDArray[np.float64]:
        """Return the numbers converted to SI; numbers that are not finite are refused unless `missing` allows them."""
        if len(self.values) < 2:
            count = "only one row" if len(self.values) else "no rows"
            raise DataFileError(f"{self.label} has {count}; at least two are needed.", path=path)
        bad = np.flatnonzero(~np.isfinite(self.values))
        if len(bad) and not missing:
            more = f", nor are {len(bad) - 1} more below" if len(bad) > 1 else ""
            where, value = self.place(int(bad[0])), self.values[bad[0]]
            raise DataFileError(f"{where}, {self.label}: {value} is not a finite number{more}.", path=path)
        factor = self._factor(path, asked)
        inverse = round(1 / factor) if factor < 1 else 0
        # dividing by a whole number gives the float nearest to the decimal number, multiplying does not
        with np.errstate(all="ignore"):
            found = self.values / inverse if inverse and 1 / inverse == factor else self.values * factor
        if not missing and not np.all(np.isfinite(found)):
            row = int(np.argmin(np.isfinite(found)))
            raise DataFileError(
                f"{self.place(row)}, {self.label}: {self.values[row]:g} {self.unit or asked} is too large a number.",
                path=path,
            )
        return found

    def _factor(self, path: Path, asked: str) -> float:
        expected, own = kind_and_factor(asked), kind_and_factor(self.unit or asked)
        if expected is None or own is None:
            unknown = self.unit if expected else asked
            known = ", ".join(kind for kind in KINDS if kind != "1")
            raise DataFileError(
                f"{self.label}: '{unknown}' is not a known unit; known, also with prefixes: {known}.",
                path=path,
            )
        if own[0] != expected[0]:
            kind = KINDS[expected[0]][0]
            raise DataFileError(
                f"{self.label} is in '{self.unit}', but {kind} is needed, such as '{asked}'.", path=path
            )
        return own[1]


def check_row(path: Path, label: str, dimensions: int, dtype: np.dtype[Any]) -> None:
    """Refuse anything but a one-dimensional array of real numbers."""
    if dimensions != 1 or dtype.kind not in "fiu":
        kind = f"{dimensions} dimensions" if dimensions != 1 else f"'{dtype}'"
        raise DataFileError(f"{label} holds {kind}, but a row of real numbers is needed.", path=path)


def real_numbers(path: Path, label: str, array: NDArray[Any], unit: str, word: str) -> Column:
    """Return an array of a binary file as a column."""
    check_row(path, label, array.ndim, array.dtype)
    with np.errstate(all="ignore"):  # what a damaged file holds may be no number at all
        values = np.asarray(array, dtype=np.float64)
    return Column(label=label, unit=unit, values=values, place=lambda row: f"{word} {row} (first is 0)")
