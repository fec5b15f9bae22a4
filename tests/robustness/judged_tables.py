"""What a reader makes of a written table: equal in every column, refused, named as not read, or wrong."""

import dataclasses
from collections import Counter
from typing import NamedTuple

import numpy as np
from random_dialects import Dialect, consistent, drawn
from random_tables import UNITS, Table, Written, plain_name, write

from electrovib.core.errors import InputError
from electrovib.data.registry import read_recorded

NANOSECOND = 1.1e-9
PLAIN = Dialect()


class Outcome(NamedTuple):
    """``equal``, ``asked`` (the time is not stated), ``not read``, ``refused``, or ``wrong``, and what was said or is wrong."""

    what: str
    why: str = ""


def outcome_of(table: Table, path) -> Outcome:
    """Read a table and compare it with what was written."""
    path.write_bytes(table.raw)
    try:
        recorded = read_recorded(path)
    except InputError as error:
        return Outcome("refused", str(error))
    except Exception as error:  # noqa: BLE001  # no other exception may reach a user
        return Outcome("wrong", f"raises {type(error).__name__}: {error}")
    found = [_of_segment(recorded, columns, table.dialect) for columns in table.segments]
    best = min(found, key=lambda each: ("equal", "asked", "not read", "refused", "wrong").index(each.what))
    if best.what != "wrong" and len(found) > 1 and not recorded.not_read:
        return Outcome("wrong", "lost: the other segments are not named")
    return best


def _of_segment(recorded, columns: list[Written], dialect: Dialect) -> Outcome:
    """Compare what was read with one segment."""
    named = " | ".join(f"{each.name} {each.why}" for each in recorded.not_read)
    for check in (_rows_differ, _clocks_differ, _times_differ, _columns_differ):
        if why := check(recorded, columns, dialect, named):
            return Outcome("wrong", why)
    read = [_channel_of(recorded.channels, column, place, dialect) for place, column in enumerate(columns)]
    if any(
        channel is None and column.role in ("number", "time")
        for channel, column in zip(read, columns, strict=True)
    ):
        return Outcome("not read", named)
    is_asked = recorded.times() is None and dialect.time != "none"
    return Outcome("asked" if is_asked else "equal")


def _rows_differ(recorded, columns: list[Written], dialect: Dialect, named: str) -> str:
    """Return what became of the rows; rows of statistics are left out and named."""
    if recorded.size != dialect.rows:
        return f"rows: {recorded.size} were read of {dialect.rows}"
    word = dialect.statistics[0].strip(":").lower() if dialect.statistics else ""
    return "" if word in named.lower() else "lost: the rows of statistics are not named"


def _columns_differ(recorded, columns: list[Written], dialect: Dialect, named: str) -> str:
    """Return what became of the columns: each is a channel, or is named as not read."""
    left = list(recorded.channels)
    for place, column in enumerate(columns):
        channel = _channel_of(left, column, place, dialect)
        if channel is not None:
            left.remove(channel)
            if why := _differs(channel, column):
                return f"{why}: '{column.name}'"
            continue
        is_named = plain_name(column.name) in plain_name(named) or f"column {place}" in named
        if not is_named and not (column.role == "stamps" and recorded.time):
            return f"lost: {column.role} '{column.name}' is neither read nor named"
    return next((f"invented: '{each.name}'" for each in left if each.name != recorded.time), "")


def _channel_of(channels, column: Written, place: int, dialect: Dialect):
    """Return the first channel with the name of a column, or its number where there are no headings."""
    if dialect.headings == "none":
        return next((each for each in channels if each.name == f"column {place}"), None)
    wanted = plain_name(column.name)
    named = [each for each in channels if plain_name(each.name) == wanted]
    # the second of its name
    named += [each for each in channels if plain_name(each.name.rstrip("'")) == wanted]
    return named[0] if named else None


def _differs(channel, column: Written) -> str:
    """Return what is wrong in a channel; empty if it is the column."""
    if column.role == "words":
        return "invented numbers"
    if column.role == "stamps":
        return ""  # compared as the times of the rows
    known = UNITS.get(channel.unit.replace("µ", "u").replace("μ", "u"))
    if known is None:
        return f"unit: '{channel.unit}' was read"
    if known[0] != column.unit:
        return f"unit: '{channel.unit}' was read in place of '{column.unit}'"
    return "" if _same(channel.values * known[1], column.values) else "values"


def _same(found, expected, tolerance: float = 0.0) -> bool:
    if not np.array_equal(np.isnan(found), np.isnan(expected)):
        return False
    known = ~np.isnan(expected)
    return bool(np.all(np.abs(found - expected)[known] <= 1e-14 * np.abs(expected[known]) + tolerance))


def _clocks_differ(recorded, columns: list[Written], dialect: Dialect, named: str) -> str:
    """Return which column is read against the time of another one, or against what is no time."""
    if recorded.time and dialect.headings != "none":
        name = plain_name(recorded.time)
        times = [plain_name(each.name) for each in columns if each.role in ("time", "stamps")]
        if not times or not (name.startswith(("time", "date")) or name in times):
            return f"time: '{recorded.time}' is none"
    clocks = {plain_name(each.name): recorded.clocks.get(each.name) for each in recorded.channels}
    for column in columns:
        name = plain_name(column.name)
        if column.clock and name in clocks and recorded.times() is not None:
            own = clocks[name]
            if own is None or plain_name(own.time) != plain_name(column.clock):
                return f"clock: '{column.name}' belongs to '{column.clock}'"
    return ""


def _times_differ(recorded, columns: list[Written], dialect: Dialect, named: str) -> str:
    """Return what differs between the times of the rows and those that the file states."""
    found, stated = (
        recorded.times(),
        next((each for each in columns if each.role in ("time", "stamps")), None),
    )
    if found is None or (recorded.time and stated is None):
        return ""  # without headings a column that rises may be the time
    if stated is None and dialect.time == "none" and dialect.preamble in ("none", "sep="):
        return "time: none is stated"
    if recorded.time:
        unit = next(each.unit for each in recorded.channels if each.name == recorded.time)
        found = found * UNITS.get(unit.replace("µ", "u"), ("", np.nan))[1]
    expected = [np.arange(dialect.rows) * dialect.step if stated is None else stated.values]
    if stated is not None and stated.role == "stamps":
        found = found - found[0]
        expected += [np.floor(expected[0] + NANOSECOND)] if dialect.time == "whole seconds" else []
    return "" if any(_same(found, each, NANOSECOND) for each in expected) else "time: other values"


def judged(seed: int, path) -> tuple[Outcome, Dialect]:
    """Draw, write and judge one table."""
    dialect = drawn(np.random.default_rng(seed))
    return outcome_of(write(dialect, seed), path), dialect


def shrunken(dialect: Dialect, seed: int, path) -> tuple[Dialect, Outcome]:
    """Return the plainest dialect that fails in the same way as this one."""
    first = outcome_of(write(dialect, seed), path)
    kind = first.why.partition(":")[0]
    for field in dataclasses.fields(Dialect):
        options = [2, 5, 12] if field.name == "rows" else [getattr(PLAIN, field.name)]
        for option in options:
            plainer = consistent(dataclasses.replace(dialect, **{field.name: option}))
            found = outcome_of(write(plainer, seed), path) if plainer != dialect else Outcome("equal")
            if found.what == "wrong" and found.why.partition(":")[0] == kind:
                dialect, first = plainer, found
                break
    return dialect, first


def is_plain(dialect: Dialect) -> bool:
    """Return whether a dialect is one that leaves nothing to guess."""
    plain = ("minus", "thousands", "mark", "statistics", "segments", "words", "same_name", "shorter")
    return (
        all(getattr(dialect, name) == getattr(PLAIN, name) for name in plain)
        and dialect.rows >= 5
        and dialect.headings in ("words", "several")
        and dialect.units in ("brackets", "parentheses", "row", "slash", "none")
        and dialect.time in ("seconds", "ms", "us", "none")
        and dialect.missing in (None, "", "NaN", "nan", "N/A")
        and dialect.number != "fortran"
        and (dialect.decimal == "." or dialect.digits != 3)
    )


def differences(dialect: Dialect) -> str:
    """Name what is not plain in a dialect."""
    return ", ".join(
        f"{field.name}={getattr(dialect, field.name)!r}"
        for field in dataclasses.fields(Dialect)
        if getattr(dialect, field.name) != getattr(PLAIN, field.name)
    )


def counted(seeds, path) -> tuple[Counter, Counter, list[tuple[int, Outcome]]]:
    """Judge many tables: the outcomes of all, those of the plain ones, and what is wrong."""
    every, plain, wrong = Counter(), Counter(), []
    for seed in seeds:
        found, dialect = judged(seed, path)
        every[found.what] += 1
        plain[found.what] += is_plain(dialect)
        if found.what == "wrong":
            wrong.append((seed, found))
    return every, plain, wrong
