"""Content of a file: columns with names and units as written, chosen and converted to SI; and what a reader declares."""

from __future__ import annotations

import dataclasses
import enum
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError, InputError, NoColumnError, NoHeadingsError, suggestion
from electrovib.core.units import KINDS
from electrovib.data.guarded import packed
from electrovib.data.unit_words import as_unit, kind_and_factor, name_and_known_unit, name_and_unit

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


MOST_COLUMNS: Final = 1024
"""Columns of a file of text or of an array."""
_MOST_LISTED: Final = 20
_NUMBERED: Final = re.compile(r"column \d+")
"""Name of a column without a heading."""


def called(name: str) -> str:
    """Return what a column is called in a message."""
    return name if _NUMBERED.fullmatch(name) else f"column '{name}'"


@dataclass(frozen=True, kw_only=True)
class DataColumn:
    """One column of a file, with name and unit as written in it; `values` are in that unit, NaN where a field is empty.

    For messages, `place` names a row, or is the word for one.
    """

    name: str
    unit: str
    values: Real
    place: str | Callable[[int], str] = "row"

    def in_si(self, path: Path, asked: str, *, missing: bool = False) -> Real:
        """Return the numbers converted to SI; numbers that are not finite are refused unless `missing` allows them."""
        if len(self.values) < 2:
            count = "only one row" if len(self.values) else "no rows"
            raise DataFileError(f"{called(self.name)} has {count}; at least two are needed.", path=path)
        gone, _ = missing_numbers(self.values)
        bad = np.flatnonzero(gone | ~np.isfinite(self.values))
        if len(bad) and not missing:
            more = f", nor are {len(bad) - 1} more below" if len(bad) > 1 else ""
            where, value = self._where(int(bad[0])), self.values[bad[0]]
            why = "stands for no reading" if np.isfinite(value) else "is not a finite number"
            raise DataFileError(f"{where}, {called(self.name)}: {value:.6g} {why}{more}.", path=path)
        factor = self._factor(path, asked)
        inverse = round(1 / factor) if factor < 1 else 0
        # dividing by a whole number gives the float nearest to the decimal number, multiplying does not
        with np.errstate(all="ignore"):
            values = np.where(gone, np.nan, self.values) if len(bad) else self.values
            found = values / inverse if inverse and 1 / inverse == factor else values * factor
        if not missing and not np.all(np.isfinite(found)):
            row = int(np.argmin(np.isfinite(found)))
            raise DataFileError(
                f"{self._where(row)}, {called(self.name)}: {self.values[row]:g} {self.unit or asked} is too large a number.",
                path=path,
            )
        return found

    def _where(self, row: int) -> str:
        return f"{self.place} {row} (first is 0)" if isinstance(self.place, str) else self.place(row)

    def _factor(self, path: Path, asked: str) -> float:
        expected, own = kind_and_factor(asked), kind_and_factor(self.unit or asked)
        if expected is None or own is None:
            unknown = self.unit if expected else asked
            known = ", ".join(kind for kind in KINDS if kind != "1")
            why = f"{called(self.name)}: '{unknown}' is not a known unit; known, also with prefixes: {known}."
            raise DataFileError(why, path=path)
        if own[0] != expected[0]:
            kind = KINDS[expected[0]][0]
            why = f"{called(self.name)} is in '{self.unit}', but {kind} is needed, such as '{asked}'."
            raise DataFileError(why, path=path)
        return own[1]


@dataclass(frozen=True, kw_only=True)
class NotRead:
    """A column, a block, or rows of a file that are not read, as the file calls them, and why."""

    name: str
    why: str


@dataclass(frozen=True, kw_only=True)
class ChannelClock:
    """When the samples of a channel were taken: in the channel `time`, or from `start` [s] in steps of `step` [s]."""

    time: str = ""
    step: float | None = None
    start: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """The content of one file: what is read of it, and what is not.

    All `channels` have one length. `time` names the one that is the time; it is empty if the time follows
    from `step` [s] and `start` [s], the time of the first sample, or is not known. `clocks` are those of
    channels that have one of their own, by name. `attributes` are statements of the preamble: make, model,
    date, settings. `not_read` accounts for everything else that the file has.
    """

    channels: tuple[DataColumn, ...]
    time: str = ""
    step: float | None = None
    start: float = 0.0
    attributes: Mapping[str, str] = field(default_factory=dict)
    not_read: tuple[NotRead, ...] = ()
    clocks: Mapping[str, ChannelClock] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of samples of each channel."""
        return self.channels[0].values.size if self.channels else 0

    def times(self) -> Real | None:
        """Return the time of each sample, shape (n,), in the unit of its channel, or in s by the step; None if it is unknown."""
        if self.time:
            return next(each.values for each in self.channels if each.name == self.time)
        if self.step is None:
            return None
        return np.asarray(self.start + self.step * np.arange(self.size))


_NO_READING: Final = (9.9e37, 9.91e37, 199.999e99)
"""Magnitudes by which instruments say infinity or no number (SCPI 1999, 7.2.1.4 and 7.2.1.5)."""
_FAR_BELOW: Final = 1e30
_ROUNDING: Final = 1e-6
"""Relative error of these magnitudes in single precision."""
_FILLS: Final = (1e20, 1e30, 1e36, 9.96920996838687e36, 3.4028234663852886e38, 1.7976931348623157e308)
"""Magnitudes that programs write where there is no number, among others that are far below: of netCDF, and the largest floats."""
_NINES: Final = (-999.0, -9999.0, -99999.0, -999.25, -999.9, -999.99, -1e6)
"""Numbers that stand for no reading where they repeat far below the others; the last one is written by catman."""


def missing_numbers(values: Real) -> tuple[np.ndarray[Any, np.dtype[np.bool_]], dict[float, int]]:
    """Find the numbers of a column by which instruments say that there is no reading, and how often each occurs.

    These are magnitudes from 9.9e37 to 199.999e99 among others that are far below, and -999, -9999 and the like where
    they repeat, are not most of all, and lie below all others by more than the range of these.
    """
    gone = np.zeros(values.shape, dtype=bool)
    low, high = (float(each.reduce(values, initial=np.nan)) for each in (np.fmin, np.fmax))
    if max(-low, high) >= _NO_READING[0] * (1 - _ROUNDING):
        size = np.abs(np.where(np.isfinite(values), values, 0.0))
        gone = (size >= _NO_READING[0] * (1 - _ROUNDING)) & (size <= _NO_READING[-1] * (1 + _ROUNDING))
        if gone.all() or size[~gone].max() > _FAR_BELOW:
            gone &= np.any([np.isclose(size, each, rtol=_ROUNDING) for each in _NO_READING], axis=0)
    for fill in _FILLS if max(-low, high) >= min(_FILLS) else ():
        with np.errstate(over="ignore"):
            at = np.isclose(np.abs(values), fill, rtol=_ROUNDING)
        rest = np.abs(values[np.isfinite(values) & ~gone & ~at])
        if (
            0 < np.count_nonzero(at) < values.size
            and rest.max(initial=0.0) < fill * _FAR_BELOW / _NO_READING[0]
        ):
            gone |= at
    for nines in _NINES if low <= max(_NINES) else ():
        at = values == nines
        rest = values[np.isfinite(values) & ~gone & ~at]
        if (
            1 < np.count_nonzero(at) <= values.size / 2
            and rest.size
            and nines < rest.min() - np.ptp(rest) < rest.min()
        ):
            gone |= at
    numbers, counts = np.unique(values[gone], return_counts=True)
    return gone, dict(zip(numbers.tolist(), counts.tolist(), strict=True))


def without_missing_numbers(recorded: Recorded) -> Recorded:
    """Return the content of a file with NaN for the numbers that stand for no reading, each named with its count."""
    channels, named = [], []
    for each in recorded.channels:
        gone, found = missing_numbers(each.values)
        channels.append(
            dataclasses.replace(each, values=np.where(gone, np.nan, each.values)) if found else each
        )
        if found:
            words = ", ".join(f"{count} times {number:.6g}" for number, count in found.items())
            name = f"{sum(found.values())} of {recorded.size} samples of '{each.name}'"
            named.append(NotRead(name=name, why=f"missing: {words}, which stands for no reading"))
    return dataclasses.replace(recorded, channels=tuple(channels), not_read=(*recorded.not_read, *named))


def choose(
    names: Sequence[str], column: str | int, numbered: Sequence[int], headings: Sequence[str] = ()
) -> tuple[int, str]:
    """Return the place of a column, and the unit behind the name that is asked for.

    It is found by its number among the `numbered` places, by its heading, if that holds more, or by its name.
    """
    listed = ", ".join([name[:60] for name in names if name][:_MOST_LISTED]) or "nothing"
    listed += ", ..." if len(names) > _MOST_LISTED else ""
    if isinstance(column, int):
        if not 0 <= column < len(numbered):
            how = f"they are numbered 0 to {len(numbered) - 1}" if numbered else "ask by name"
            raise DataFileError(f"there is no column {column}; {how}. It has: {listed}.")
        return numbered[column], ""
    wanted, unit = name_and_known_unit(column)
    for known, name, stated in ((headings, column, ""), (names, column, ""), (names, wanted, unit)):
        if list(known).count(name) > 1:
            raise DataFileError(f"more than one column is called '{name}'; give its number, or rename one.")
        if name in known and not stated.isdigit():
            return list(known).index(name), stated
    if names and all(map(_NUMBERED.fullmatch, names)):
        why = f"has no headings; ask for column '{column}' by its number, 0 first."
        raise NoHeadingsError(why, column=column)
    why = f"there is no column '{column}'.{suggestion(column, names)} It has: {listed}."
    raise NoColumnError(why, column=column)


def agreed_unit(name: str, own: str, asked: str) -> str:
    """Return the unit of a column, that of the file or else the one behind the name that is asked for; two are refused."""
    if own and asked and kind_and_factor(own) != kind_and_factor(asked):
        raise DataFileError(f"{called(name)} is in '{own}', not in '{asked}'.")
    return own or asked


def column_of(recorded: Recorded, stated: str, *, option: str) -> DataColumn:
    """Find a column by its heading, with or without its unit, or by its number from 0: ``"Ch2"``, ``"Ch2 (N)"``, ``"2"``."""
    by_name = {each.name: each for each in recorded.channels}
    if stated in by_name:
        return by_name[stated]
    name, unit = name_and_unit(stated)
    if name not in by_name:
        whole = [each for each in recorded.channels if f"{each.name} ({each.unit})" == stated]
        if name.isdigit() and int(name) < len(recorded.channels):
            whole = [recorded.channels[int(name)]]
        if not whole:
            listed = ", ".join(f"'{each}'" for each in list(by_name)[:20])
            left = next((f" Not read: {each.why}." for each in recorded.not_read if each.name == name), "")
            raise InputError(
                f"{option} = {stated}: the file has no such column.{suggestion(name, by_name)} It has {listed}.{left}"
            )
        name = whole[0].name
    found = by_name[name]
    if not unit or not found.unit:
        return dataclasses.replace(found, unit=found.unit or unit)
    if kind_and_factor(unit) != kind_and_factor(found.unit):
        raise InputError(
            f"{option} = {stated}: the file states the unit '{found.unit}' for '{found.name}', not '{unit}'; for a sensor state"
            f" its sensitivity with scale, such as '1.5 {unit}/{found.unit}'."
        )
    return found


def one_part(
    parts: Mapping[str, int], part: str, otherwise: str, what: str = "table"
) -> tuple[str, tuple[NotRead, ...]]:
    """Return the part of a file that is asked for, or another one, and the parts that are not read, by their numbers of rows."""
    chosen = part or otherwise
    if chosen not in parts:
        listed = ", ".join(list(parts)[:_MOST_LISTED])
        raise DataFileError(
            f"part = {part}: there is no such {what}.{suggestion(part, parts)} It has {listed}."
        )
    why = "another part of {} rows; choose it with part (--set part=NAME)"
    return chosen, tuple(
        NotRead(name=name, why=why.format(rows)) for name, rows in parts.items() if name != chosen
    )


def check_declared(path: Path, count: int) -> None:
    """Refuse a file that declares more numbers than a file of its size may hold."""
    size = path.stat().st_size
    if count * 8 > content_allowed(size):
        what = f"{megabytes(size)} are too small for the {count} numbers that it declares"
        raise packed(path, what, "")


def recorded_of(
    columns: Sequence[tuple[str, str, Real]],
    *,
    step: float | None = None,
    start: float = 0.0,
    attributes: Mapping[str, str] | None = None,
    part: str = "",
    not_read: Iterable[NotRead] = (),
) -> Recorded:
    """Return columns as the content of a file; of columns of several lengths those like `part`, or that hold most numbers."""
    by_length: dict[int, list[tuple[str, str, Real]]] = defaultdict(list)
    for each in columns:
        by_length[each[2].size].append(each)
    lengths = [size for size in by_length if size >= 2]
    if not lengths:
        raise DataFileError("holds no column of two or more numbers.")
    named = {name: values.size for name, _, values in columns if values.size >= 2}
    if part and part not in named:
        listed = ", ".join(f"{name} ({size})" for name, size in list(named.items())[:_MOST_LISTED])
        raise DataFileError(
            f"part = {part}: there is no such array.{suggestion(part, named)} It has {listed}."
        )
    chosen = named[part] if part else max(lengths, key=lambda size: (size * len(by_length[size]), size))
    others = tuple(
        NotRead(name=name, why=_other_length(values.size, chosen, len(lengths)))
        for name, _, values in columns
        if values.size != chosen
    )
    channels: list[DataColumn] = []
    for name, unit, values in by_length[chosen]:
        unit = unit.partition(" since ")[0]  # noqa: PLW2901  # as netCDF writes times
        known = as_unit(unit)
        channels.append(
            DataColumn(
                name=unique(name, channels),
                unit=unit if known is None else known,
                values=np.asarray(values, dtype=float),
            )
        )
    time = "" if step is not None else next((each.name for each in channels if is_named_time(each)), "")
    return Recorded(
        channels=tuple(channels),
        time=time,
        step=step,
        start=start,
        attributes=attributes or {},
        not_read=(*others, *not_read),
    )


def _other_length(size: int, chosen: int, lengths: int) -> str:
    """Say why a column of another length is not read."""
    choice = "; choose it with part (--set part=NAME)" if size >= 2 and lengths > 1 else ""
    return f"it has {size} {'row' if size == 1 else 'rows'}, those that are read {chosen}{choice}"


def unique(name: str, channels: Iterable[DataColumn]) -> str:
    """Return a name that no channel has, with primes behind it where one has."""
    taken = {each.name for each in channels}
    while name in taken:
        name = f"{name}'"
    return name


def is_unit_of_time(unit: str) -> bool:
    """Return whether a unit is one of time."""
    return (kind_and_factor(unit) or ("",))[0] == "s"


def is_named_time(channel: DataColumn) -> bool:
    """Return whether a column is the time by its name or its unit, and increases."""
    named = re.split(r"[/.]", channel.name)[-1].lower() in ("time", "t", "zeit")
    if not (is_unit_of_time(channel.unit) or (named and not channel.unit)):
        return False
    return bool(np.isfinite(channel.values).all() and (np.diff(channel.values) >= 0).all())


def text_of(value: Any) -> str:
    """Return a property of a foreign file as a short text."""
    return str(value)[:200]


ColumnReader: TypeAlias = Callable[[Path, Sequence[str | int], bool], dict[str | int, DataColumn]]
"""Of path, columns by heading or number, and whether fields may be empty."""


class CanRead(enum.Enum):
    """Whether a reader takes a file."""

    NO = 0
    PERHAPS = 1
    YES = 2


@dataclass(frozen=True, kw_only=True)
class FileFormat:
    """One format of files.

    - `name`: of the reader in options.
    - `can_read`: judges by the first bytes and the suffix.
    - `read`: reads whatever a file holds.
    - `columns`: reads the chosen columns and refuses what is no number in them; by default those of `read`.
    - `options`: what `read` takes besides the path.
    - `package`: has to be installed for it, empty if none has to be; `otherwise`: what else helps.
    - `is_last`: asked after all others.
    """

    name: str
    description: str
    can_read: Callable[[bytes, str], CanRead]
    read: Callable[..., Recorded]
    columns: ColumnReader | None = None
    options: tuple[str, ...] = ()
    package: str = ""
    otherwise: str = ""
    is_last: bool = False


def begins(pattern: bytes, *suffixes: str) -> Callable[[bytes, str], CanRead]:
    """Return a function that recognises a format by a pattern of its first bytes, or perhaps by its suffix."""
    form = re.compile(pattern, re.DOTALL)

    def can_read(head: bytes, suffix: str) -> CanRead:
        if form.match(head):
            return CanRead.YES
        return CanRead.PERHAPS if suffix in suffixes else CanRead.NO

    return can_read
