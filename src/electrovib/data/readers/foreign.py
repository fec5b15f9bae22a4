"""Common parts of readers that need another package or run in a guarded process."""

from __future__ import annotations

import importlib.util
from collections import defaultdict
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError, suggestion
from electrovib.data.readers.recorded import DataColumn, Recorded
from electrovib.data.readers.unit_words import as_unit

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from electrovib.core.arrays import Real

EXTRA: Final = "formats"
"""Name of the optional dependencies that the readers of foreign formats need."""
_MOST_OMITTED: Final = 20
_TIME_UNITS: Final = ("s", "ms", "us", "ns")


def check_package(path: Path, module: str, what: str, otherwise: str = "") -> None:
    """Refuse to read a file without the package that reads it."""
    if importlib.util.find_spec(module) is None:
        raise DataFileError(
            f"{what} is read with the package {module}, which is not installed: pip install 'electrovib[{EXTRA}]'{otherwise}",
            path=path,
        )


def check_declared(path: Path, count: int) -> None:
    """Refuse a file that declares more numbers than a file of its size may hold."""
    size = path.stat().st_size
    if count * 8 > content_allowed(size):
        raise DataFileError(
            f"is damaged, or packed too tightly: {megabytes(size)} are too small for the {count} numbers that it declares.",
            path=path,
        )


def recorded_of(
    path: Path,
    columns: Sequence[tuple[str, str, Real]],
    *,
    step: float | None = None,
    start: float = 0.0,
    attributes: Mapping[str, str] | None = None,
    part: str = "",
) -> Recorded:
    """Return columns as the content of a file; of columns of several lengths those like `part`, or that hold most numbers."""
    by_length: dict[int, list[tuple[str, str, Real]]] = defaultdict(list)
    for each in columns:
        by_length[each[2].size].append(each)
    lengths = [size for size in by_length if size >= 2]
    if not lengths:
        raise DataFileError("holds no column of two or more numbers.", path=path)
    named = {name: values.size for name, _, values in columns if values.size >= 2}
    if part and part not in named:
        listed = ", ".join(f"{name} ({size})" for name, size in list(named.items())[:_MOST_OMITTED])
        raise DataFileError(
            f"part = {part}: there is no such array.{suggestion(part, named)} It has {listed}.", path=path
        )
    chosen = named[part] if part else max(lengths, key=lambda size: (size * len(by_length[size]), size))
    stated = dict(attributes or {})
    others = [f"{name} ({values.size})" for name, _, values in columns if values.size != chosen]
    if others:
        more = f" and {len(others) - _MOST_OMITTED} more" if len(others) > _MOST_OMITTED else ""
        stated["omitted"] = ", ".join(others[:_MOST_OMITTED]) + more
    channels: list[DataColumn] = []
    names: set[str] = set()
    for name, unit, values in by_length[chosen]:
        unique = name
        while unique in names:
            unique += "'"
        names.add(unique)
        known = as_unit(unit)
        channels.append(
            DataColumn(
                name=unique, unit=unit if known is None else known, values=np.asarray(values, dtype=float)
            )
        )
    time = "" if step is not None else next((each.name for each in channels if is_named_time(each)), "")
    return Recorded(channels=tuple(channels), time=time, step=step, start=start, attributes=stated)


def is_named_time(channel: DataColumn) -> bool:
    """Return whether a column is the time by its name or its unit, and increases."""
    named = channel.name.rpartition("/")[2].lower() in ("time", "t", "timestamp", "zeit")
    if not (channel.unit in _TIME_UNITS or (named and not channel.unit)):
        return False
    return bool(np.isfinite(channel.values).all() and (np.diff(channel.values) >= 0).all())


def columns_of_array(name: str, unit: str, values: Real, most: int = 64) -> Iterator[tuple[str, str, Real]]:
    """Iterate over the columns, ``"name[3]"`` for column 3, of an array of one or two dimensions; other arrays have none."""
    if values.ndim == 1 or (values.ndim == 2 and 1 in values.shape):
        yield name, unit, values.ravel()
    elif values.ndim == 2:
        turned = values.T if values.shape[1] > most >= values.shape[0] else values
        if turned.shape[1] <= most:
            for number in range(turned.shape[1]):
                yield f"{name}[{number}]", unit, turned[:, number]


def text_of(value: Any) -> str:
    """Return a property of a foreign file as a short text."""
    return str(value)[:200]
