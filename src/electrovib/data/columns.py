"""Columns of a measured file of any format as SI arrays."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import Column, choose
from electrovib.data.registry import format_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded


def read_columns(
    path: Path, wanted: Mapping[str, tuple[str | int, str]], *, missing: bool = False
) -> dict[str, Real]:
    """Read the wanted columns of a measured file, converted to SI.

    `wanted` maps a name to heading, or number from 0, and unit; a unit in the file has priority over it, and
    must be of the same kind. With `missing`, NaN, infinities and empty fields of text (as NaN) are accepted.
    Text has lines of ``#`` as comments; of a ``.mat`` file ``"name[3]"`` is column 3 of the array ``name``,
    and ``"trial.force"`` a field of a struct.
    """
    chosen = format_of(path)
    asked = [column for column, _ in wanted.values()]
    read = chosen.columns or functools.partial(_of_recorded, chosen.read)
    found = read(path, asked, missing)
    if len({len(column.values) for column in found.values()}) > 1:
        sizes = ", ".join(f"{column.label} {len(column.values)}" for column in found.values())
        raise DataFileError(f"the columns differ in length: {sizes}.", path=path)
    return {name: found[column].in_si(path, unit, missing=missing) for name, (column, unit) in wanted.items()}


def _of_recorded(
    read: Callable[[Path], Recorded], path: Path, asked: Sequence[str | int], missing: bool
) -> dict[str | int, Column]:
    """Choose columns of a format that has no other access to them."""
    del missing
    recorded = read(path)
    names = [channel.name for channel in recorded.channels]
    found: dict[str | int, Column] = {}
    for column in asked:
        channel = recorded.channels[choose(path, names, column, len(names))]
        found[column] = Column(
            label=f"column '{channel.name}'", unit=channel.unit, values=channel.values, place="row"
        )
    return found
