"""What the lines above the numbers state: settings, time step and start, names and units; and which column is the time."""

from __future__ import annotations

import dataclasses
import itertools
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.units import format_quantity, parse_quantity
from electrovib.data.recorded import ChannelClock, DataColumn, NotRead, Recorded, is_unit_of_time
from electrovib.data.text.layout import Layout
from electrovib.data.unit_words import Notation, as_unit, kind_and_factor, name_and_unit

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real


_STEP: Final = frozenset({
    "increment", "sample interval", "sampleinterval", "sampling interval", "xincr", "x increment", "xincrement", "dt",
    "tinc", "t inc", "time step", "timestep", "sampling period", "sample period", "xinc", "horizontal interval",
    "time interval", "resolution", "interval", "delta x", "hresolution", "clock", "abtastintervall", "zeitschritt",
})  # fmt: skip
_RATE: Final = frozenset({
    "sample rate", "samplerate", "sampling rate", "sampling frequency", "sample frequency", "fs", "abtastrate",
    "abtastfrequenz", "messrate",
})  # fmt: skip
_START: Final = frozenset(
    {"start", "xzero", "x zero", "xorg", "xorigin", "t0", "x0", "start time", "first sample", "hoffset"}
)
_VAGUE: Final = frozenset({"resolution", "interval", "clock"})
"""Names of which only a value with a unit is a time step."""
_TIMING: Final = _STEP | _START
_THINNED: Final = re.compile(r"(decimation|down ?sampling|sub ?sampling)( ?(factor|ratio|by))?")
"""Names of settings of which samples were left out, by a factor."""
_SECONDS: Final = re.compile(r"(?<=[\d. munµp])([munµp]?)S\b")
"""A second that is written as S, as some oscilloscopes do."""
_PER_SECOND: Final = re.compile(r"(S(a|amples?)?|samples?|s)(/s(ec)?|ps)(?=, |$)")
"""Samples per second, with a prefix before them, as of a rate."""
_LONGEST_SETTING: Final = 200
_MOST_SETTINGS: Final = 200
_NAMES: Final = frozenset({"tracename", "channeltitle", "channel title", "channel name", "channel names"})
_UNITS: Final = frozenset({"vertical units", "vunit", "y unit label", "units", "unit", "yunits", "unitname"})
_ACROSS: Final = ("horizontal units", "hunit", "xunits")
_TIME_HEADINGS: Final = ("", "time", "t", "x_value", "x value")
_CHANNEL: Final = re.compile(r"[A-Za-z]+\s?\d*\s*:\s*")
_COUNTS: Final = frozenset(
    {"sequence", "index", "nr", "no", "pt", "point", "points", "point #", "sample", "samples", "#", "n"}
)
_TIMES: Final = re.compile(
    r"(?i)(elapsed |trigger )?time(?![a-z]).*|t|zeit|temps|x-axis|x[_ ]?value'*|x|(milli|micro|nano)?seconds?\b.*|source"
)
_OF_A_STEP: Final = 0.01
"""Difference of two columns of the same times, in steps."""
_BY_CHANCE: Final = 8
"""Changes that may all be upward in a column that is no time."""
_OF_TIME: Final = re.compile(r"""["'(\[<{][mnuµ]s(ec)?["')\]>}]""")
"""Unit of time within a heading of a form that is not known."""
_SINCE: Final = re.compile(r"(\w+) since \d", re.IGNORECASE)
FREQUENCY: Final = re.compile(r"freq|hz|hertz|omega", re.IGNORECASE)


def settings_of(layout: Layout) -> dict[str, str]:
    """Collect the settings of the preamble: a key with its value beside it, or below it in headings."""
    found: dict[str, str] = {}
    for row in layout.preamble[:_MOST_SETTINGS]:
        filled = [cell.strip().lstrip("#").strip() for cell in row if cell.strip()]
        if len(filled) == 1 and (sign := next((sign for sign in ":=" if sign in filled[0]), "")):
            filled = [part.strip() for part in filled[0].split(sign, 1)]
        if len(filled) >= 2 and not filled[0][:1].isdigit() and not _looks_like_number(filled[0]):
            found.setdefault(
                filled[0].rstrip(" :=")[:_LONGEST_SETTING], ", ".join(filled[1:])[:_LONGEST_SETTING]
            )
    inside = re.findall(r"(?:^|,)\s*([^,=]+?) ?= ?([^,=]+)", ",".join(itertools.chain(*layout.preamble)))
    found = {key: value for key, value in inside if _key_of(key) in _TIMING} | found
    for above, below in itertools.pairwise(layout.preamble):
        pairs = zip(above, below, strict=False)
        found |= {
            name.rstrip(": "): value
            for name, value in pairs
            if _key_of(name) in _TIMING and value[:1].strip() and _looks_like_number(value)
        }
    return found


def _looks_like_number(text: str) -> bool:
    return any(Notation(decimal=sign).is_number(text) for sign in ".,")


def timing(layout: Layout, settings: Mapping[str, str]) -> tuple[dict[str, float], float]:
    """Find the time steps [s] that the preamble states, by name, and the first time [s], 0 if it is not stated."""
    steps: dict[str, float] = {}
    start = 0.0
    for key, value in settings.items():
        name = _key_of(key)
        unit = (re.search(r"[\[(](.*?)[\])]", key) or [None, ""])[1] or ""
        if name in _STEP and (unit or name not in _VAGUE or not _looks_like_number(value)):
            steps |= {key: step} if (step := _seconds(value, unit, layout)) else {}
        elif name in _RATE and (rate := _hertz(value, unit, layout)):
            steps[key] = 1 / rate
        elif name in _START:
            start = _seconds(value, unit, layout) or start
    return steps, start


def _contradiction(steps: Mapping[str, float]) -> tuple[NotRead, ...]:
    """Name time steps of which one is not another, within 1 %."""
    if not steps or max(steps.values()) <= (1 + _OF_A_STEP) * min(steps.values()):
        return ()
    stated = ", ".join(f"{format_quantity(step, 's', digits=4)} by '{key}'" for key, step in steps.items())
    return (NotRead(name="the time step", why=f"the file states {stated}; state the right one with step"),)


def _thinned(settings: Mapping[str, str], layout: Layout) -> tuple[float, str]:
    """Return the factor by which samples were left out, and the setting that states it; 1 if there is none."""
    for key, value in settings.items():
        number = (
            layout.notation.number(value.partition(", ")[0]) if _THINNED.fullmatch(_key_of(key)) else None
        )
        if number is not None and number > 1:
            return number, f"{key} = {value}"
    return 1.0, ""


def _seconds(value: str, unit: str, layout: Layout) -> float | None:
    return _quantity(_SECONDS.sub(r"\1s", value.removeprefix("Analog:")), unit, "s", layout)


def _hertz(value: str, unit: str, layout: Layout) -> float | None:
    return _quantity(_PER_SECOND.sub("Hz", value), unit, "Hz", layout)


def _quantity(value: str, unit: str, kind: str, layout: Layout) -> float | None:
    """Read '1.0E-6', '2,0 us', or '1 us' with its unit in the key or in the next field; None if it is no such quantity."""
    text, _, beside = (part.strip() for part in value.partition(", "))
    if layout.decimal_comma:
        text = text.replace(",", ".")
    beside = as_unit(beside.partition(", ")[0]) or beside
    unit = unit or (beside if (kind_and_factor(beside) or ("",))[0] == kind else "")
    for candidate in (f"{text} {unit}" if unit else text, f"{text} {kind}", text):
        try:
            found = parse_quantity(candidate, kind)
        except ValueError:
            continue
        return float(found)
    return None


def named_by_preamble(layout: Layout, settings: Mapping[str, str]) -> Layout:
    """Return a layout with the names and units that rows such as ``Vertical Units,V,A`` or ``TraceName,CH1,CH2`` state."""
    names, units = list(layout.names), list(layout.units)
    rows = {_key_of(row[0]): row for row in layout.preamble if row and row[0].strip()}
    for key, row in rows.items():
        for place, column in enumerate(layout.columns):
            cell = row[column].strip() if 0 < column < len(row) else ""
            if key in _NAMES and cell:
                names[place] = cell
            elif key in _UNITS and cell and not units[place]:
                units[place] = as_unit(_CHANNEL.sub("", cell, count=1)) or ""
    stated = {_key_of(name): value.partition(", ")[0] for name, value in settings.items()}
    across = next((as_unit(stated[key]) for key in _ACROSS if key in stated), None)
    if stated.get("x dimension", "").lower() == "time":  # LabVIEW writes seconds
        across = "s"
    if (
        across in ("s", "ms", "us", "ns")
        and len(names) > 1
        and not units[0]
        and names[0].lower() in _TIME_HEADINGS
    ):
        units[0] = across or ""
    if len(names) == 2 and not any(names) and "source" in stated:  # settings stand beside the numbers
        names = ["time", stated["source"]]
    upright = next((as_unit(stated[key]) for key in _UNITS if key in stated), None)
    if len(names) <= 2 and not units[-1] and upright:
        units[-1] = upright
    return dataclasses.replace(layout, names=tuple(names), units=tuple(units))


def with_clocks(layout: Layout, columns: Sequence[DataColumn], settings: Mapping[str, str]) -> Recorded:
    """Return columns with the clock that one of them or the preamble states, and those of columns behind another time.

    Where the preamble states another step than the column of times has, both are in the record.
    """
    steps, start = timing(layout, settings)
    doubt = _contradiction(steps)
    step = None if doubt or not steps else min(steps.values())
    channels = [_in_unit_of_time(each) for each in columns]
    thinned, words = _thinned(settings, layout)
    if step is not None and words:
        about = f"the time step: whether '{next(iter(steps))}' is that before or behind '{words}', the file does not say"
        settings = {**settings, "unsure": about}
    recorded = Recorded(channels=tuple(channels), step=step, start=start, attributes=settings, not_read=doubt)
    numbers_rows = is_index(layout, channels[0])
    if len(channels) > 1 and not any(FREQUENCY.match(each.name) for each in channels):
        times = _pairs(layout, channels) or [
            each for at, each in enumerate(channels[numbers_rows:]) if is_time(each, step, first=not at)
        ]
        known = {each.name for each in times}
        times += [each for each in channels if known and each.name not in known and _is_further_time(each)]
    else:
        times = []
    if step is not None and (numbers_rows or (counts(channels[0].values) and not channels[0].unit)):
        if times and times[0] is channels[0] and not keeps_step(channels[0], step):
            times = times[1:]
        if not times and len(channels) > 1:
            return without(recorded, channels[0], "it numbers the rows")
    if not times:
        return recorded
    first = times[0]
    if not first.unit and (layout.has_unused_headings or _states_a_time(layout)):
        return recorded  # whose unit is asked for: some heading was not understood
    recorded = _by_column(recorded, first, thinned)
    return _with_further_times(recorded, times)


def without_doubt(recorded: Recorded) -> dict[str, str]:
    """Return the statements of a preamble without a doubt about its time step, where the rows have times of their own."""
    return {name: each for name, each in recorded.attributes.items() if name != "unsure"}


def _by_column(recorded: Recorded, times: DataColumn, thinned: float) -> Recorded:
    """Return a record with the times of a column, and with a step of the preamble only where the column has another one."""
    found = dataclasses.replace(recorded, time=times.name, attributes=without_doubt(recorded))
    step = recorded.step
    if step is None or not (keeps_step(times, step) or keeps_step(times, step * thinned)):
        return found
    seconds = _seconds_of(times)
    if (np.diff(seconds) != 0).all() or not keeps_step(times, step):
        return dataclasses.replace(found, step=None)
    rounded = dataclasses.replace(recorded, start=recorded.start or float(seconds[0]))
    return without(rounded, times, "it is rounded; the times follow from the step that the file states")


def _states_a_time(layout: Layout) -> bool:
    """Return whether a field above the numbers names a unit of time other than the second."""
    cells = [cell for row in layout.preamble for cell in row if not cell[:1].isdigit()]
    units = {as_unit(cell.strip("[]()")) or name_and_unit(cell)[1] for cell in cells}
    return any(map(_OF_TIME.search, cells)) or any(unit != "s" and is_unit_of_time(unit) for unit in units)


def _is_further_time(channel: DataColumn) -> bool:
    """Return whether a column behind one of times is such a one too, by its unit and its rise, whatever its heading is."""
    if not is_unit_of_time(channel.unit):
        return False
    changes = np.diff(_seconds_of(channel))
    return changes.size > _BY_CHANCE and bool((changes > 0).all())


def _with_further_times(recorded: Recorded, times: Sequence[DataColumn]) -> Recorded:
    """Give the columns behind a further column of times, which differs from the first one, this time as their clock."""
    first, clocks, own = times[0], dict[str, ChannelClock](), ""
    same = {each.name for each in times[1:] if _are_equal(each, first)}
    unused: list[NotRead] = []
    for before, channel in itertools.pairwise([first, *recorded.channels]):
        if any(channel is each for each in times):
            own = "" if channel is first or _keeps_pace(channel, first) else channel.name
            if not own and not any(before is each for each in times):
                unused += _of_another_zero(channel, first)
        elif own:
            clocks[channel.name] = ChannelClock(time=own)
    recorded = dataclasses.replace(recorded, clocks=clocks, not_read=(*recorded.not_read, *unused))
    for each in times[1:]:
        if each.name in same:
            recorded = without(recorded, each, f"it repeats the times of column '{first.name}'")
    return recorded


def _are_equal(one: DataColumn, other: DataColumn) -> bool:
    same = one.unit == other.unit and np.array_equal(one.values, other.values, equal_nan=True)
    return same and bool(np.ptp(_seconds_of(one)) > 0)


def _of_another_zero(channel: DataColumn, first: DataColumn) -> list[NotRead]:
    """Say by how much the times behind a signal differ from those of the first column, if they do; which is right is open."""
    later = float(np.mean(_seconds_of(channel) - _seconds_of(first)))
    is_none = abs(later) <= _OF_A_STEP * np.ptp(_seconds_of(first)) / first.values.size
    words = f"{format_quantity(abs(later), 's', digits=4)} {'later' if later > 0 else 'earlier'}"
    why = f"they are {words} than those of '{first.name}', which are taken; else state time='{channel.name}'"
    return [] if is_none else [NotRead(name=f"times of '{channel.name}'", why=why)]


def _keeps_pace(one: DataColumn, other: DataColumn) -> bool:
    """Return whether two columns of times differ by a constant alone."""
    a, b = (each.values * _factor(each) for each in (one, other))
    if not np.array_equal(np.isfinite(a), np.isfinite(b)) or np.ptp(_seconds_of(other)) == 0:
        return False
    difference = (a - b)[np.isfinite(a)]
    return bool(np.ptp(difference) <= _OF_A_STEP * abs(np.ptp(_seconds_of(other))) / difference.size)


def _pairs(layout: Layout, channels: Sequence[DataColumn]) -> list[DataColumn]:
    """Return the times of a text without headings in which each column stands behind its times, as ngspice writes them."""
    times = list(channels[::2])
    if any(layout.names) or len(channels) < 4 or len(channels) % 2:
        return []
    ends = np.array([[_seconds_of(each)[0], _seconds_of(each)[-1]] for each in times])
    alike = np.abs(ends - ends[0]).max() <= 0.01 * np.ptp(ends[0])
    return times if alike and all(_rises(each) for each in times) else []


def without(recorded: Recorded, channel: DataColumn, why: str) -> Recorded:
    """Name a column as not read."""
    kept = tuple(each for each in recorded.channels if each is not channel)
    return dataclasses.replace(
        recorded, channels=kept, not_read=(*recorded.not_read, NotRead(name=channel.name, why=why))
    )


def _in_unit_of_time(channel: DataColumn) -> DataColumn:
    """Return a column whose heading counts from a date, such as ``milliseconds since 2026-11-28``, with its unit alone."""
    match = _SINCE.search(channel.unit or channel.name)
    known = kind_and_factor(match[1].lower()) if match else None
    return (
        dataclasses.replace(channel, unit=match[1].lower())
        if match and known and known[0] == "s"
        else channel
    )


def _factor(channel: DataColumn) -> float:
    known = kind_and_factor(channel.unit)
    return known[1] if known is not None and known[0] == "s" else 1.0


def _seconds_of(channel: DataColumn) -> Real:
    """Return the times of a column that are known [s]; a shorter record ends before the others."""
    return np.asarray(channel.values[np.isfinite(channel.values)] * _factor(channel))


def _key_of(cell: str) -> str:
    """Return the name of a setting without its unit and its signs, in small letters."""
    bare = re.sub(
        r"[\[(][^\])]{0,200}[\])]", "", cell
    )  # unbounded, the time would be the square of the length
    return bare.strip().lstrip("#").rstrip(" :=").replace("_", " ").lower()


def counts(values: Real) -> bool:
    """Return whether a column numbers the samples."""
    return bool(np.array_equal(values, np.arange(values.size) + values[0]) and values[0] in (0, 1))


def is_index(layout: Layout, first: DataColumn) -> bool:
    """Return whether the first column numbers the rows: by its heading, or it counts and it alone has no heading."""
    unit = "" if first.unit == "N" else first.unit.lower()
    if {first.name.lower().rstrip("."), unit} & _COUNTS and (np.diff(first.values) > 0).all():
        return True
    return counts(first.values) and not layout.names[0] and all(layout.names[1:])


def keeps_step(channel: DataColumn, step: float) -> bool:
    """Return whether a column increases by the time step [s] that the preamble states, within 1 % and the rounding of both."""
    known = _seconds_of(channel)
    even, change = (known.size - 1) * step, np.diff(known)
    rounding = float(change.max(initial=0.0)) if (change == 0).any() else 0.0
    return known.size > 1 and bool(abs(known[-1] - known[0] - even) <= 0.01 * abs(even) + rounding)


def _rises(channel: DataColumn, *, in_segments: bool = False) -> bool:
    known = _seconds_of(channel)
    parts = segments_of(known) if in_segments else [np.s_[:]]
    return known.size > 1 and all(bool((np.diff(known[part]) >= 0).all()) for part in parts)


_NEAR: Final = 0.05
"""Difference of the beginnings of two segments over the length of the first."""
_MOST_SEGMENTS: Final = 1000
_FEWEST: Final = 2
"""Fewest rows of a segment."""


def segments_of(times: Real) -> list[slice]:
    """Return the rows of each segment of times that turn back to near their beginning; one if they do not."""
    turns = np.flatnonzero(np.diff(times) < 0) + 1
    ends = [0, *turns.tolist(), times.size]
    spans = [slice(start, stop) for start, stop in itertools.pairwise(ends)]
    first = times[spans[0]]
    near = _NEAR * np.ptp(first) if first.size else 0.0
    whole = len(spans) <= _MOST_SEGMENTS and all(
        each.stop - each.start >= _FEWEST and abs(times[each.start] - times[0]) <= near for each in spans
    )
    return spans if whole else [slice(0, times.size)]


def is_time(channel: DataColumn, step: float | None, *, first: bool) -> bool:
    """Return whether a column is the time: by name and unit, and the first column also by its rise."""
    named = bool(_TIMES.fullmatch(channel.name))
    known = kind_and_factor(channel.unit) if channel.unit else None
    if known is not None and known[0] == "s":
        named = named or channel.name.lower().startswith("timestamp")  # without a unit it is asked for
        rises = _rises(channel, in_segments=True) and np.ptp(_seconds_of(channel)) > 0
        return (first and named) or bool((first or named) and rises)
    if channel.unit or not _rises(channel, in_segments=named) or np.ptp(_seconds_of(channel)) == 0:
        return False
    if first and step is not None and keeps_step(channel, step):
        return True
    is_named = named and channel.name.lower() != "x"
    return is_named or (first and (named or channel.name.startswith("column ")))
