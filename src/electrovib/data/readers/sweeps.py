"""Several spectra in one table, one behind the other, and the choice of one of them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_NAME: Final = re.compile(r"(?:(.+), )?spectrum (\d{1,4})")
_FEWEST: Final = 4
"""Fewest rows of a spectrum; a table with shorter ones is in no order of frequencies."""
_MOST_NAMED: Final = 20


def split_part(part: str | None) -> tuple[str | None, int]:
    """Split a part such as ``"Sheet1, spectrum 2"`` into the table and the number of the spectrum, 0 where none is stated."""
    found = _NAME.fullmatch(part or "")
    return (part, 0) if found is None else (found[1], int(found[2]))


def refuse_spectrum(part: str | None, spectrum: int) -> None:
    """Refuse the name of a spectrum for columns over time."""
    if spectrum:
        raise InputError(f"part = {part}: the columns are signals over time, not a spectrum")


def sweeps_of(frequency: Real) -> list[np.ndarray[tuple[int], np.dtype[np.intp]]]:
    """Find the rows of each spectrum in a column of frequencies: a new one begins where the frequency turns back."""
    rows = np.flatnonzero(np.isfinite(frequency) & (frequency > 0))
    changes = np.sign(np.diff(frequency[rows]))
    begins, direction = [0], 0
    for place, change in enumerate(changes, 1):
        if direction and change == -direction:
            begins.append(
                place if changes[place - 2] else place - 1
            )  # both may hold the frequency of the turn
            direction = 0
        elif change:
            direction = int(change)
    found = np.split(rows, begins[1:])
    return found if min(each.size for each in found) >= _FEWEST else [rows]


def chosen_sweep(frequency: Real, spectrum: int) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], str]:
    """Return the rows of one spectrum, and what was chosen among several."""
    found = sweeps_of(frequency)
    if spectrum > len(found):
        raise InputError(
            f"part = spectrum {spectrum}: the table has {len(found)} spectrum"
            if len(found) == 1
            else f"part = spectrum {spectrum}: the table has {len(found)} spectra, spectrum 1 to spectrum {len(found)}"
        )
    if len(found) == 1:
        return found[0], ""
    number = spectrum or 1
    others = ", ".join(f"spectrum {other}" for other in range(1, len(found) + 1) if other != number)
    if len(found) > _MOST_NAMED:
        others = f"{len(found) - 1} others of spectrum 1 to spectrum {len(found)}"
    return found[number - 1], f"read: spectrum {number}; not read: {others}; choose with --set part=..."
