"""Files of instruments as Traces, and listings of what such a file holds and which options import it."""

from __future__ import annotations

import hashlib
import json
import shlex
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.deprecation import former_value
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError, gathered, nearest, refuse
from electrovib.core.files import note_input
from electrovib.core.mistakes import shown
from electrovib.core.signals import make_trace
from electrovib.core.units import format_quantity
from electrovib.data.guarded import check_file
from electrovib.data.recorded import column_of
from electrovib.data.registry import format_of, read_recorded
from electrovib.data.spectrum import spectrum_of, split_part
from electrovib.recordings.importing.choice import (
    ProposedColumn,
    calibrated_column,
    check_names,
    may_be_voltage,
    possible_times,
    proposed_columns,
    proposed_time,
    read_calibration,
)
from electrovib.recordings.importing.clock import (
    SampleTimes,
    clock_words,
    clocks_of,
    contradicted,
    held,
    needs_unit,
    overlap,
    sample_times,
)
from electrovib.recordings.importing.notices import (
    MOST_COLUMNS,
    about_file,
    about_parts,
    about_reactance,
    about_samples,
    about_sensors,
    account_lines,
    account_of,
    not_read_words,
    told,
)
from electrovib.recordings.importing.own_material import phase_offset
from electrovib.recordings.importing.reduction import ReductionSteps, reduced
from electrovib.recordings.recording import SensorCalibration

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn, Recorded

_LONGEST_SETTINGS: Final = 4000


def import_file(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    *,
    time: str = "",
    step: str | float | None = None,
    stamps: str = "refuse",
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    part: str | None = None,
    **reduction: Any,
) -> xarray.Dataset:
    """Import a file of an instrument: its columns become signals of a Trace, in SI, with their history.

    Parameters
    ----------
    path : str or Path
        Any file that a reader takes.
    columns : mapping of str to str, optional
        Signal of the nomenclature to the heading of its column, with a unit where the file states none:
        ``{"lateral_force_measured": "Ch2 (N)"}``. Of an impedance spectrum: ``frequency``, ``modulus``, ``phase``, ``real``,
        ``imaginary`` and other meanings to the headings, or nothing.
    time : str
        Column of the time stamps, with a unit where the file states none; found if empty.
    step : str or float, optional
        Time between samples [s], if there are no time stamps.
    stamps : str
        Treatment of time stamps that do not increase: ``"refuse"`` or ``"keep_increasing"``.
    reader : str
        Name of the reader; found from the first bytes if empty.
    delimiter : str, optional
        Of text: one character, or empty for blanks; found if not given.
    decimal_comma : bool, optional
        Of text: whether decimals are written with a comma; found if not given.
    part : str, optional
        Sheet of a spreadsheet, table of a Gamry file, or array whose length is chosen where a file holds several.
    **reduction
        ``calibration`` has the signal and a table of two columns with units, the reading of its sensor and the known value; the
        line fitted to it is used as the scale, and its error goes with the signal, as a fit reads it. ``scale``, ``offset``,
        ``shift``, ``trigger``, ``baseline``, ``detrend``, ``crop``, ``average`` and ``resample``, as described for
        `electrovib.recordings.importing.reduction.ReductionSteps`, are applied in this order.

    Returns
    -------
    xarray.Dataset
        Trace with the signals over ``time`` [s], or with ``impedance`` [ohm] over ``frequency`` [Hz]. Attributes ``file``,
        ``file_sha256``, ``reader``, ``options`` and ``history`` state its origin, ``columns_of_file`` every column that was
        read and everything that was not, with the reason, ``validity`` the diagnostics.

    Raises
    ------
    InputError
        If the file cannot be read, a column or unit is unknown, or an option does not fit; all mistakes of a kind at once.
    """
    place = Path(path)
    check_file(place)
    note_input(place)
    table, spectrum = split_part(part)
    calibration = _calibrations(reduction.pop("calibration", None))
    options = {"delimiter": delimiter, "decimal_comma": decimal_comma, "part": table}
    with ThreadPoolExecutor(1) as beside:
        checksum = beside.submit(_checksum, place)
        recorded = read_recorded(place, reader=reader, **options)
    stated: dict[str, Any] = {
        name: value for name, value in (options | {"part": part}).items() if value is not None
    }
    stated |= {"columns": dict(columns or {}), "time": time, "step": step, "stamps": stamps}
    stated |= {"calibration": {name: str(each) for name, each in calibration.items()}} if calibration else {}
    origin = {
        "title": former_value("title", "") or place.stem,
        "electrovib": version("electrovib"),
        "file": place.name,
        "file_sha256": checksum.result(),
        "reader": reader or format_of(place).name,
        "options": json.dumps(stated | reduction, default=repr),
        "columns_of_file": json.dumps(account_of(recorded)),
        "file_preamble": json.dumps(dict(recorded.attributes))[:_LONGEST_SETTINGS],
    }
    wanted = dict(columns or {})
    if is_spectrum(wanted):
        scale = _reduction(reduction).scale
        trace = spectrum_trace(recorded, wanted, origin, spectrum=spectrum, scale=scale)  # type: ignore[arg-type]  # no calibrations yet
        given = reduction | {"time": time, "step": step, "calibration": calibration}
        given |= {"scale": None, "stamps": stamps != "refuse"}
        refuse([f"{name}: has no effect on a spectrum; omit it" for name, value in given.items() if value])
        return trace
    steps = _reduction(reduction | _with_calibrations(calibration, wanted, reduction.get("scale") or {}))
    if problems := _wrong_names(wanted, steps):
        raise InputError(problems)
    if spectrum:
        raise InputError(f"part = {part}: the columns are signals over time, not a spectrum")
    chosen = _chosen(recorded, wanted)
    names = [each.name for each in chosen.values()]
    clock = sample_times(recorded, names, time=time, step=step, stamps=stamps)
    return _over_time(recorded, chosen, clock, steps, origin)


def _calibrations(given: Any) -> dict[str, str | Path]:
    """Read the file of the calibration of each signal."""
    if not isinstance(given or {}, dict) or not all(
        isinstance(each, (str, Path)) for each in (given or {}).values()
    ):
        raise InputError(
            "expected the name of a file for each signal", path="calibration", value=shown(given)
        )
    return dict(given or {})


def _checksum(path: Path) -> str:
    """Return the SHA-256 of a file, which is taken beside its reading."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _chosen(recorded: Recorded, wanted: Mapping[str, str]) -> dict[str, DataColumn]:
    """Return the column of each signal, or refuse all names that no column has."""
    chosen: dict[str, DataColumn] = {}
    problems: list[str] = []
    for signal, column in wanted.items():
        with gathered(problems):
            chosen[signal] = column_of(recorded, column, option=f"columns.{signal}")
    refuse(problems)
    return chosen


def _wrong_names(wanted: Mapping[str, str], steps: ReductionSteps) -> list[str]:
    """List the names that are no signals over time, or that no column was chosen for."""
    named = {option: getattr(steps, option) for option in ("scale", "offset", "shift", "baseline")}
    named |= {"detrend": steps.detrend, "trigger": [steps.trigger], "average": [steps.average]}
    problems = check_names("columns", wanted)
    for option, names in named.items():
        problems += check_names(option, [name for name in names if name], wanted)
    return problems


def _with_calibrations(
    files: Mapping[str, str | Path], columns: Mapping[str, str], scale: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the scales with the calibration lines of files."""
    problems = check_names("calibration", files, columns)
    problems += [
        f"calibration.{name}: a scale is given too; omit one of the two" for name in files if name in scale
    ]
    refuse(problems)
    lines = {name: read_calibration(name, place) for name, place in files.items()}
    return {"scale": dict(scale) | lines} if lines else {}


def is_spectrum(columns: Mapping[str, str]) -> bool:
    """Return whether the chosen columns are those of a spectrum, or none are chosen."""
    return not columns or "frequency" in columns or "angular_frequency" in columns


def _reduction(given: Mapping[str, Any]) -> ReductionSteps:
    known = ReductionSteps.__dataclass_fields__
    problems = [
        f"{name}: is not an option of import_file.{nearest(name, known)}"
        for name in given
        if name not in known
    ]
    refuse(problems)
    fitting = {name: value for name, value in given.items() if value is not None}
    if "detrend" in fitting:
        trends = fitting["detrend"]
        fitting["detrend"] = (trends,) if isinstance(trends, str) else tuple(trends)
    return ReductionSteps(**fitting)


def _over_time(
    recorded: Recorded,
    columns: Mapping[str, DataColumn],
    clock: SampleTimes,
    steps: ReductionSteps,
    origin: dict[str, str],
) -> xarray.Dataset:
    read = f"{origin['file']} read by reader '{origin['reader']}'"
    history = [read, *not_read_words(recorded), *clock.steps]
    signals: dict[str, Real] = {}
    readings: dict[str, Real] = {}
    problems: list[str] = []
    for signal, column in columns.items():
        with gathered(problems):
            values, words = calibrated_column(
                column, signal, scale=steps.scale.get(signal), offset=steps.offset.get(signal)
            )
            signals[signal], readings[signal] = values[clock.rows], column.values[clock.rows]
            history += words
    refuse(problems)
    judged = about_samples(clock.time, readings, held=clock.held)
    diagnostics = [*about_file(recorded), *clock.diagnostics, *judged]
    time, signals = held(clock.time, signals) if clock.held else (clock.time, signals)
    found, signals, words = reduced(time, signals, steps)
    trace = make_trace(
        {name: (("time",), values) for name, values in signals.items()},
        {"time": found},
        origin | told(history + words, diagnostics),
    )
    for name, scale in steps.scale.items():
        if isinstance(scale, SensorCalibration):
            zero_known = name in {*steps.baseline, *steps.detrend}
            trace[name].attrs |= scale.error(zero_known=zero_known).attributes()
    return trace


def spectrum_trace(
    recorded: Recorded,
    columns: Mapping[str, str],
    origin: Mapping[str, str],
    *,
    spectrum: int = 0,
    scale: Mapping[str, str | float] | None = None,
) -> xarray.Dataset:
    """Return a measured impedance over frequency, or a permittivity over ``frequency`` and one ``layer``, as a Trace."""
    try:
        found = spectrum_of(recorded, columns=columns, spectrum=spectrum, scale=scale)
    except InputError as error:
        if columns:
            raise
        listed = ", ".join(f"'{each.name}'" for each in recorded.channels[:20])
        raise InputError(
            f"columns: name a column for each signal, such as lateral_force_measured = '{recorded.channels[-1].name}'; the file"
            f" has {listed}. It is not recognised as a spectrum either: {error.problems[0].reason}",
            path=origin["file"],
        ) from None
    if found.times_area:
        raise InputError(
            "columns: the impedance is one times an area; its permittivity is imported with --as material, --set area=... and"
            " thickness=...",
            path=origin["file"],
        )
    diagnostics = about_parts(recorded, found)
    if found.lossless:
        text = "the table states a permittivity without loss; the loss was assumed to be 0"
        diagnostics.append(Diagnostic("loss", "unknown", text))
    if found.impedance is not None:
        diagnostics += about_reactance(found.impedance)
    if found.impedance is not None and (offset := phase_offset(found.frequency, found.impedance)):
        text = f"{offset.sentence()}: the instrument is badly calibrated"
        diagnostics.append(Diagnostic("calibration of the instrument", "warning", text))
    read = f"{origin['file']} read by reader '{origin['reader']}'"
    attributes = {**origin, **told([read, f"spectrum: {found.read_as}; sorted by frequency"], diagnostics)}
    axes: dict[str, Any] = {"frequency": found.frequency}
    if found.impedance is not None:
        return make_trace({"impedance": (("frequency",), found.impedance)}, axes, attributes)
    assert found.permittivity is not None
    layered = {"permittivity": (("layer", "frequency"), found.permittivity[None])}
    return make_trace(layered, axes | {"layer": ["sample"]}, attributes)


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
