"""Listing of a file: its columns, its clocks, what is wrong with its samples, and the options that import them."""

from __future__ import annotations

import shlex
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.data.registry import format_of, read_recorded
from electrovib.data.spectrum import spectrum_of, split_part
from electrovib.recordings.importing.choice import (
    ProposedColumn,
    may_be_voltage,
    possible_times,
    proposed_columns,
    proposed_time,
)
from electrovib.recordings.importing.clock import (
    clock_words,
    clocks_of,
    contradicted,
    needs_unit,
    overlap,
    sample_times,
)
from electrovib.recordings.importing.notices import MOST_COLUMNS, about_sensors, account_lines

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.data.recorded import DataColumn, Recorded


_ABOUT: Final = {"table": "read", "arrangement": "arrangement", "unsure": "not sure"}
"""What a reader states of its file, and how that is called."""


def list_columns(
    path: str | Path,
    *,
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    part: str | None = None,
) -> list[str]:
    """List the columns of a file, with their units, and an example of the options that import them."""
    table, wanted = split_part(part)
    recorded = read_recorded(
        Path(path), reader=reader, delimiter=delimiter, decimal_comma=decimal_comma, part=table
    )
    lines = [_heading(Path(path), recorded, reader), *account_lines(recorded)]
    about = recorded.attributes
    lines += [f"  {words}: {about[name]}" for name, words in _ABOUT.items() if name in about]
    try:
        spectrum = spectrum_of(recorded, spectrum=wanted)
    except InputError as error:
        if any(each.name.lower().startswith("freq") for each in recorded.channels):
            return [*lines, f"not yet a spectrum: {error.problems[0].reason}"]
        typed = {"reader": reader, "delimiter": delimiter, "decimal_comma": decimal_comma, "part": part}
        return [*lines, *_example(recorded, "".join(_set(name, value) for name, value in typed.items()))]
    return [
        *lines,
        f"a spectrum of {'impedance' if spectrum.impedance is not None else 'permittivity'}: {spectrum.read_as}",
        *([spectrum.among] if spectrum.among else []),
        "to import it: -o spectrum.nc, or --as material -o material.toml",
    ]


def list_account(path: str | Path, *, reader: str = "", part: str | None = None, **options: Any) -> list[str]:
    """List every column of a file that is read, and everything that is not, whole."""
    recorded = read_recorded(Path(path), reader=reader, part=split_part(part)[0], **options)
    return [_heading(Path(path), recorded, reader), *account_lines(recorded, whole=True)]


def _heading(path: Path, recorded: Recorded, reader: str) -> str:
    count, name = len(recorded.channels), reader or format_of(path).name
    return f"{path.name}: reader '{name}', {count} columns of {recorded.size} samples"


def _example(recorded: Recorded, typed: str) -> list[str]:
    """State the clocks and the faults of the columns, and the options that import those whose heading or unit tells a signal."""
    time = None if recorded.time or recorded.step is not None else proposed_time(recorded)
    times = {recorded.time, time.name if time else "", *(each.time for each in recorded.clocks.values())}
    columns = [each for each in recorded.channels if each.name not in times]
    proposed = proposed_columns(recorded, columns) or tuple(
        ProposedColumn(column=each.name, signal="drive_voltage", unit="V")
        for each in [each for each in columns if may_be_voltage(each)][:1]
    )
    clocks = clocks_of(recorded, [each.column for each in proposed] or [each.name for each in columns])
    words, stated = _time(recorded, time)
    lines = [words, *_faults(recorded, columns, next(iter(clocks.values())))]
    if not proposed:
        why = "no heading and no unit tells a signal"
        return [*lines, f"{why}; to import a column: --column SIGNAL=COLUMN{typed} -o trace.nc"]
    options = {
        clock: _options([each for each in proposed if each.column in names]) + typed
        for clock, names in clocks.items()
    }
    first, *others = clocks
    lines.append(f"to import it: {options[first]}{stated} -o trace.nc")
    earlier = "trace.nc"
    for number, clock in enumerate(others, 2):
        named = f"{', '.join(map(repr, clocks[clock]))}: another clock, {clock_words(recorded, clock)}"
        how, onto, target = "to import it by itself", "", f"trace_{number}.nc"
        if overlap(recorded, first, clock):
            how, onto = "to put it onto the one before", _set("with", earlier) + _set("clock_shift", "0 s")
            earlier = target
        lines.append(f"{named}; {how}: {options[clock]}{onto} -o {target}")
    return lines + _remarks(proposed, stated)


def _options(proposed: Sequence[ProposedColumn]) -> str:
    columns = (f"--column {each.signal}={_quoted(each.stated)}" for each in proposed)
    return " ".join(columns) + "".join(_set(f"scale.{each.signal}", each.scale) for each in proposed)


def _set(key: str, value: str | bool | None) -> str:
    """Return an entry of the recipe as it is typed; nothing for one that is not given."""
    return (
        "" if value is None or (value == "" and key != "delimiter") else f" --set {key}={_quoted(str(value))}"
    )


def _quoted(text: str) -> str:
    return shlex.quote(text) if set(text) & set('"$`\\!') else f'"{text}"'


def _time(recorded: Recorded, proposed: DataColumn | None) -> tuple[str, str]:
    """State the clock of the file, or what is missing of it, and return the option that states it then."""
    if not recorded.time and recorded.step is not None:
        start, every = (format_quantity(each, "s") for each in (recorded.start, recorded.step))
        return f"time: a step of {every}, first sample at {start}, as the file states", ""
    column = proposed or next((each for each in recorded.channels if each.name == recorded.time), None)
    if column is None:
        return 'time: not stated; add --set time="COLUMN [s]" or --set step="10 us"', _set("step", "10 us")
    option = _set("time", column.name if column.unit else f"{column.name} [s]")
    if column is proposed:
        found = [each.name for each in possible_times(recorded) if each.unit] or [column.name]
        several = "may be it: import the signals of each by themselves"
        words = several if len(found) > 1 else "increases and may be it"
        return f"time: not stated; {', '.join(map(repr, found))} {words}", option
    words = f"time: column '{column.name}'"
    if recorded.step is not None and contradicted(recorded):
        every = format_quantity(recorded.step, "s")
        return f"{words}, but the file also states a step of {every}: state which one is right", option
    if column.unit:
        return words, ""
    assumed = "it has to be stated" if needs_unit(column) else "s are assumed"
    return (
        f'{words}, for which the file states no unit: {assumed}; write --set time="{column.name} [ms]" if it is ms',
        option,
    )


def _faults(recorded: Recorded, columns: Sequence[DataColumn], together: Sequence[str]) -> list[str]:
    """State whether the rows are changes alone, and the faults of the columns, a line for each."""
    found: list[Diagnostic] = []
    with suppress(InputError):  # of a file without times, and of times that are refused when it is imported
        clock = sample_times(recorded, together)
        found += [each for each in clock.diagnostics if clock.held or each.state == "warning"]
    readings = {each.name: each.values for each in columns[:MOST_COLUMNS]}
    found += [each for each in about_sensors(readings) if each.state == "warning"]
    return [f"{'warning' if each.state == 'warning' else 'time'}: {each.text}" for each in found]


def _remarks(proposed: Sequence[ProposedColumn], stated: str) -> list[str]:
    """Say what of the proposal is an example, or not sure."""
    lines = []
    if unsure := ", ".join(f"'{each.column}'" for each in proposed if each.unit):
        lines.append(f"the file states no unit for {unsure}: write the right one into the brackets")
    if stated:
        lines.append(f"{stated.removeprefix(' --set ')} is an example: write what is right")
    if scaled := ", ".join(each.scale for each in proposed if "/" in each.scale):
        lines.append(f"{scaled} stands for the sensitivity of the sensor: write that of yours")
    if unnamed := [each.column for each in proposed if each.signal == "drive_voltage" and not each.is_named]:
        sensor = "is the output of a sensor, take the signal that it measures, with --set scale.SIGNAL=..."
        lines.append(f"if '{unnamed[0]}' {sensor} SIGNAL=\"1.5 N/V\"")
    if turned := next((each.column for each in proposed if each.scale == "-1"), ""):
        lines.append(f"'{turned}' is negative; as normal_force a load is positive")
    lines += [
        f"not sure: '{each.column}' is the lateral force if the finger slides along y; it may be another axis"
        for each in proposed
        if not each.is_sure
    ]
    if any(each.signal.endswith("_force") for each in proposed):
        lines.append("of a scenario with a [rig]: lateral_force_measured, normal_force_measured")
    return lines
