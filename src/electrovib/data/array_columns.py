"""Arrays of a binary file as the columns of one table; what is no column is named with the reason."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError, NoColumnError, NoHeadingsError, suggestion
from electrovib.data.recorded import (
    MOST_COLUMNS,
    ChannelClock,
    DataColumn,
    NotRead,
    called,
    is_named_time,
    recorded_of,
)
from electrovib.data.unit_words import name_and_known_unit

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

    _Column = tuple[str, str, NDArray[Any] | str]

_EXACT: Final = 2**53
"""Whole numbers up to here are floats without loss."""
_MOST_COLUMNS: Final = 64
"""Columns of an array that are signals; one of more is a picture, or has a row for each signal."""
_NUMBERED: Final = re.compile(r"column \d+")
_LISTED: Final = 20
_UNITS_OF_TIME: Final = ("s", "ms", "us", "ns")
_NO_NUMBERS: Final = {"c": "complex numbers", "S": "text", "U": "text", "O": "objects", "V": "plain bytes"}


def table_of_arrays(
    path: Path,
    arrays: Iterable[_Column],
    *,
    part: str = "",
    attributes: Mapping[str, str] | None = None,
    clocks: Mapping[str, str] | None = None,
) -> Recorded:
    """Return named arrays with their units as the content of a file.

    An array of two dimensions is a column for each of its columns (``"name[3]"``), one of records a column
    for each field (``"name.force"``). A text in place of an array is the reason why it is not read. `part`
    is the name of a column, or what the names of those that are meant begin with (``"trial[0]"``). `clocks`
    maps a column to that of its times; without one those in the same group or struct hold.
    """
    columns: list[tuple[str, str, Real]] = []
    not_read: list[NotRead] = []
    origins: dict[str, Any] = {}
    stated, turned = dict(attributes or {}), []
    for whole in arrays:
        if _has_a_row_for_each_signal(whole[2]):
            turned.append(f"{whole[0]}[0] is the first row of {whole[0]}")
        for name, unit, values in _columns_of(*whole, _MOST_COLUMNS):
            found = in_numbers(values, unit, origins)
            if isinstance(found, str):
                not_read.append(NotRead(name=name, why=found))
            else:
                columns.append((name, *found))
    inside = [each for each in columns if each[0].startswith((f"{part}.", f"{part}/", f"{part}["))]
    meant = columns if not inside or part in [name for name, *_ in columns] else inside
    if turned:
        stated["arrangement"] = f"a row per signal: {', '.join(turned)}"
    if origins:
        stated["first_time"] = ", ".join(map(str, origins.values()))
    try:
        recorded = recorded_of(path, meant, attributes=stated, part=part if meant is columns else "")
    except DataFileError as error:
        if part or not not_read:
            raise
        reasons = "; ".join(f"{each.name} ({each.why})" for each in not_read[:_LISTED])
        raise DataFileError(f"{error.problems[0].reason} Not read: {reasons}.", path=path) from None
    taken = {each.name for each in recorded.channels} | {each.name for each in recorded.not_read}
    not_read += [
        NotRead(name=name, why=f"it belongs to another part; read it with part = {name}")
        for name, *_ in columns
        if name not in taken
    ]
    return dataclasses.replace(
        recorded, not_read=(*recorded.not_read, *not_read), clocks=_clocks(recorded, clocks or {})
    )


def chosen_columns(
    path: Path, arrays: Iterable[_Column], columns: Sequence[str | int], *, are_numbered: bool = False
) -> dict[str | int, DataColumn]:
    """Return columns by name, with a unit behind it if the file has none, or by number if they are those of one array."""
    there = list(arrays)
    table = [each for whole in there for each in _columns_of(*whole, MOST_COLUMNS)]
    is_one = are_numbered or sum(not isinstance(values, str) for *_, values in there) == 1
    numbered = table if is_one else []
    origins: dict[str, Any] = {}
    found: dict[str | int, DataColumn] = {}
    for column in columns:
        (name, unit, values), stated = _chosen(path, table, numbered, column)
        read = in_numbers(values, unit, origins)
        if isinstance(read, str):
            raise DataFileError(f"{called(name)} {read}.", path=path)
        found[column] = DataColumn(name=name, unit=stated or read[0], values=read[1])
    return found


def _chosen(
    path: Path, table: Sequence[_Column], numbered: Sequence[_Column], column: str | int
) -> tuple[_Column, str]:
    """Return a column, and the unit that stands behind its name as asked for."""
    names = [name for name, *_ in table]
    listed = ", ".join(names[:_LISTED]) + (", ..." if len(names) > _LISTED else "")
    if isinstance(column, int):
        numbers = [each for each in numbered if not isinstance(each[2], str)]
        if not 0 <= column < len(numbers):
            how = f"they are numbered 0 to {len(numbers) - 1}" if numbers else "ask by name"
            why = f"there is no column {column}; {how}. It has: {listed or 'nothing'}."
            raise DataFileError(why, path=path)
        return numbers[column], ""
    name, unit = (column, "") if column in names else name_and_known_unit(column)
    if unit.isdigit() or name not in names:
        if names and all(_NUMBERED.fullmatch(each) for each in names):
            why = f"has no headings; ask for column '{column}' by its number, 0 first."
            raise NoHeadingsError(why, path=path, column=column)
        near = suggestion(column, names)
        why = f"there is no column '{column}'.{near} It has: {listed or 'nothing'}."
        raise NoColumnError(why, path=path, column=column)
    if names.count(name) > 1:
        raise DataFileError(f"more than one column is called '{name}'; rename one.", path=path)
    return table[names.index(name)], unit


def in_numbers(values: NDArray[Any] | str, unit: str, origins: dict[str, Any]) -> tuple[str, Real] | str:
    """Return unit and numbers of a row, or why it is none; times are counted from the first, kept in `origins`."""
    if isinstance(values, str):
        return values
    kind = values.dtype.kind
    if kind in "mM":
        own = np.datetime_data(values.dtype)[0]
        unit = own if own in _UNITS_OF_TIME else "s"
        times, missing = values.astype(f"{kind}8[{unit}]"), np.isnat(values)
        if missing.all():
            return "holds no time"
        if kind == "M":
            times = times - origins.setdefault("date", times[~missing][0]).astype(times.dtype)
        numbers = times.astype(np.int64).astype(float)
        numbers[missing] = np.nan
        return unit, numbers
    if kind not in "fiub":
        return f"holds {_NO_NUMBERS[kind]}"
    if kind in "iu" and values.itemsize == 8 and max(int(values.max()), -int(values.min())) > _EXACT:
        if (values[1:] < values[:-1]).any():
            return f"holds whole numbers beyond {_EXACT}, which floats do not keep apart"
        values = values - origins.setdefault(f"in {unit}", values[0])
    with np.errstate(all="ignore"):  # what a damaged file holds may be no number at all
        return unit, np.asarray(values, dtype=float)


def _columns_of(name: str, unit: str, values: NDArray[Any] | str, most: int) -> Iterator[_Column]:
    """Iterate over the columns of an array of one or two dimensions or of records, or give the reason why it has none."""
    if isinstance(values, str):
        yield name, unit, values
    elif values.dtype.names:
        for field in values.dtype.names:
            yield from _columns_of(f"{name}.{field}" if name else field, unit, values[field], most)
    elif values.ndim == 0 or values.size == 1:
        yield name, unit, f"is the single value {str(values.ravel()[0])[:40]}"
    elif values.size == 0:
        yield name, unit, "is empty"
    elif values.ndim == 1 or (values.ndim == 2 and 1 in values.shape):
        yield name, unit, values.ravel()
    else:
        turned = values.T if _has_a_row_for_each_signal(values) else values
        shape = " x ".join(map(str, values.shape))
        if turned.ndim > 2:
            yield name, unit, f"has {values.ndim} dimensions ({shape})"
        elif turned.shape[1] > most:
            yield name, unit, f"has {shape} values; at most {most} columns are read"
        else:
            for at in range(turned.shape[1]):
                yield f"{name}[{at}]", unit, turned[:, at]


def _has_a_row_for_each_signal(values: NDArray[Any] | str) -> bool:
    """Return whether an array is so wide that its columns cannot be signals."""
    return (
        not isinstance(values, str)
        and values.ndim == 2
        and values.shape[1] > _MOST_COLUMNS >= values.shape[0] > 1
    )


def _clocks(recorded: Recorded, stated: Mapping[str, str]) -> dict[str, ChannelClock]:
    """Assign channels to the times that are stated for them, or stand in their group, where these are not those of all."""
    times = {each.name for each in recorded.channels if is_named_time(each)}
    by_group = {_group(name): name for name in sorted(times, reverse=True)}
    found = {}
    for each in recorded.channels:
        own = stated.get(each.name, "")
        time = own if own in times else by_group.get(_group(each.name), "")
        if time and time != recorded.time and each.name not in times:
            found[each.name] = ChannelClock(time=time)
    return found


def _group(name: str) -> str:
    """Return the group or struct in which a column stands: ``trial[0]`` of ``trial[0].force``."""
    return name[: max(name.rfind("/"), name.rfind("."), 0)]
