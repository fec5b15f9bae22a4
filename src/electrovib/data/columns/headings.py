"""Selection of columns by heading, with or without its unit, or by number."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.errors import DataFileError, NoColumnError, suggestion
from electrovib.data.columns.column import kind_and_factor

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

_CLOSING = "])"


def name_and_unit(heading: str) -> tuple[str, str]:
    """Split a heading such as ``time [us]``; round brackets, or brackets without a blank, may belong to the name."""
    start = max(heading.rfind("["), heading.rfind("("))
    if start < 1 or heading[-1:] not in _CLOSING:
        return heading, ""
    name, unit = heading[:start].rstrip(), heading[start + 1 : -1]
    if not name or not unit.strip() or "]" in unit or ")" in unit:
        return heading, ""
    is_unit = len(name) < start and heading[start] == "["
    return (name, unit.strip()) if is_unit or kind_and_factor(unit.strip()) else (heading, "")


def choose(path: Path, headings: Sequence[str], column: str | int, width: int) -> int:
    """Return the number of a column, found by number, by heading, or by heading without the unit."""
    if isinstance(column, int):
        if not 0 <= column < width:
            raise DataFileError(
                f"there is no column {column}; they are numbered 0 to {width - 1}.", path=path
            )
        return column
    if not headings:
        raise DataFileError(f"has no headings; ask for column '{column}' by its number, 0 first.", path=path)
    names = [name_and_unit(heading)[0] for heading in headings]
    for known in (list(headings), names):
        if known.count(column) > 1:
            raise DataFileError(f"more than one column is called '{column}'; give its number.", path=path)
        if column in known:
            return known.index(column)
    listed = ", ".join([name[:60] for name in names if name][:20]) + (", ..." if len(names) > 20 else "")
    why = f"there is no column '{column}'.{suggestion(column, names)} It has: {listed}."
    raise NoColumnError(why, path=path, column=column)
