"""The columns of a file, the signals that they probably are, and their selection for a Trace, calibrated."""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, Problem, nearest
from electrovib.core.signals import SIGNALS
from electrovib.core.units import KINDS, format_quantity, parse_quantity
from electrovib.data.registry import format_of, read_recorded
from electrovib.data.spectrum import spectrum_of, split_part
from electrovib.data.unit_words import kind_and_factor
from electrovib.recordings.calibration import SensorCalibration
from electrovib.recordings.importing.account import account_lines

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn, Recorded


_FACTOR: Final = re.compile(
    r"\s*([+-]?[\d.]+(?:[eE][+-]?\d{1,3})?(?:\s*/\s*[\d.]+(?:[eE][+-]?\d{1,3})?)?)\s*(.*?)\s*"
)
OVER_TIME: Final = tuple(name for name, known in SIGNALS.items() if known.dims == ("time",))
"""Signals that a column of samples can become."""


def check_names(option: str, names: Collection[str], known: Collection[str] | None = None) -> list[str]:
    """List the names that are no signals over time, or that no column was chosen for."""
    allowed = OVER_TIME if known is None else tuple(known)
    what = "a signal over time" if known is None else "a signal that has a column"
    return [
        Problem(f"'{name}' is not {what}.{_remedy(name, allowed)}", path=f"{option}.{name}")
        for name in names
        if name not in allowed
    ]


def _remedy(name: str, allowed: Collection[str]) -> str:
    """State what to write in place of a wrong name of a signal."""
    if name == "time":
        return ' The column of the time is chosen with --set time="COLUMN [s]" (time= in Python).'
    return nearest(name, allowed)


def calibrated_column(
    column: DataColumn,
    signal: str,
    *,
    scale: str | float | SensorCalibration | None,
    offset: str | float | None,
) -> tuple[Real, list[str]]:
    """Convert a column to the SI unit of a signal, with one sentence for each step.

    `scale` is a sensitivity such as ``"4/9 N/V"``, a plain factor, or a calibration; `offset`, which is
    subtracted, the reading at which the signal is zero in the unit of the column, or a value in that of the
    signal.
    """
    target = SIGNALS[signal].unit
    if isinstance(scale, SensorCalibration):
        return _by_line(column, signal, scale, offset)
    factor, unit, words = _sensitivity(scale, column, signal)
    if not unit:
        raise InputError(
            f"columns.{signal} = {column.name}: the file states no unit; write it behind the name:"
            f" '{column.name} [{target}]', or state a scale such as '1.5 {target}/V'."
        )
    known = kind_and_factor(unit)
    if known is None:
        raise InputError(
            f"columns.{signal} = {column.name}: '{unit}' is not a unit that is known; known, also with prefixes, are"
            f" {', '.join(kind for kind in KINDS if kind != '1')}."
        )
    if known[0] != target and factor[1] != target:
        raise InputError(
            f"columns.{signal} = {column.name}: it is in '{unit}', but {KINDS[target][0]} is needed; for a sensor state its"
            f" sensitivity with scale, such as '1.5 {target}/{unit}'."
        )
    steps = [f"{signal}: column '{column.name}'" + (f" [{unit}]" if unit else "")]
    before, after = _offset(offset, known[0], target, signal, scaled=bool(words))
    with np.errstate(all="ignore"):  # what overflows is reported as missing
        values = (np.asarray(column.values, dtype=float) * known[1] - before) * factor[0] - after
    steps += [f"{signal}: {offset} subtracted before the scale"] if before else []
    steps += [f"{signal}: multiplied by {words}"] if words else []
    steps += [f"{signal}: {offset} subtracted"] if after else []
    return values, steps


def _by_line(
    column: DataColumn, signal: str, line: SensorCalibration, offset: str | float | None
) -> tuple[Real, list[str]]:
    known = kind_and_factor(column.unit) if column.unit else None
    if known is None or offset is not None:
        why = "the column needs a unit, as in 'Ch1 [V]'"
        raise InputError(f"scale.{signal}: {'offset is part of the calibration; omit it' if known else why}")
    with np.errstate(all="ignore"):  # what overflows is reported as missing
        reading = np.asarray(column.values, dtype=float) * known[1]
        values = line.value(reading)
        largest = float(np.nanmax(line.standard_uncertainty(reading), initial=0.0))
    unit = SIGNALS[signal].unit
    return values, [
        f"{signal}: column '{column.name}' [{column.unit}]",
        f"{signal}: calibration line of {line.sensitivity:.10g} {unit} per {known[0]} from {line.intercept:.10g} {unit}; its"
        f" standard uncertainty is at most {largest:.3g} {unit} and common to all samples",
    ]


def _sensitivity(
    scale: str | float | None, column: DataColumn, signal: str
) -> tuple[tuple[float, str], str, str]:
    """Read a scale: factor in SI with the kind it leads to, unit of the numbers of the column, and the words."""
    if scale is None:
        return (1.0, ""), column.unit, ""
    option = f"scale.{signal} = {scale}"
    match, number = _FACTOR.fullmatch(str(scale)), 0.0
    with contextlib.suppress(TypeError, ValueError, ZeroDivisionError):
        over, _, under = match[1].partition("/")  # type: ignore[index]  # none is refused below
        number = float(Fraction(over.strip()) / Fraction(under.strip() or 1))
    if not number or match is None:
        raise InputError(
            f"{option}: expected a number other than 0 or a ratio, with a unit such as '4/9 N/V'"
        )
    unit, target = match[2], SIGNALS[signal].unit
    if not unit:
        return (number, ""), column.unit, f"{number:.10g}"
    whole = kind_and_factor(unit)
    if whole is not None and whole[0] == target:
        over, under = unit, "1"
    else:
        over, _, under = unit.rpartition("/")
    known, per = kind_and_factor(over), kind_and_factor(under)
    if known is None or per is None or known[0] != target:
        raise InputError(
            f"{option}: expected a factor in {target} per unit of the column, such as '1.5 {target}/V'"
        )
    own = kind_and_factor(column.unit or under)
    if own is None or own[0] != per[0]:
        raise InputError(f"{option}: the column '{column.name}' is in '{column.unit}', not in '{under}'.")
    return (number * known[1] / per[1], target), column.unit or under, f"{scale}"


def _offset(
    offset: str | float | None, own: str, target: str, signal: str, *, scaled: bool
) -> tuple[float, float]:
    """Return the offset before the scale, in SI of the column, and the one after it, in SI of the signal."""
    if offset is None:
        return 0.0, 0.0
    for kind, before in ((own, True), (target, False)):
        try:
            value = parse_quantity(str(offset), kind)
        except ValueError:
            continue
        if isinstance(offset, str) and own != target and offset.strip()[-1:].isdigit():
            break  # a plain number could be either
        return (value, 0.0) if before and scaled else (0.0, value)
    raise InputError(
        f"offset.{signal} = {offset}: expected a value in {own}" + (f" or {target}" if own != target else "")
    )


_ABOUT: Final = {"table": "read", "unsure": "not sure"}
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
    options: dict[str, Any] = {
        "reader": reader,
        "delimiter": delimiter,
        "decimal_comma": decimal_comma,
        "part": table,
    }
    recorded = read_recorded(Path(path), **options)
    lines = [_heading(Path(path), recorded, reader), *account_lines(recorded)]
    about = recorded.attributes
    lines += [f"  {words}: {about[name]}" for name, words in _ABOUT.items() if name in about]
    try:
        spectrum = spectrum_of(recorded, spectrum=wanted)
    except InputError as error:
        if any(each.name.lower().startswith("freq") for each in recorded.channels):
            return [*lines, f"not yet a spectrum: {error.problems[0].reason}"]
        return [*lines, _clock(recorded), *_example(recorded)]
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


def _clock(recorded: Recorded) -> str:
    if recorded.time:
        unit = next(each.unit for each in recorded.channels if each.name == recorded.time)
        unsure = f', for which the file states no unit: s are assumed; add --set time="{recorded.time} [ms]" if it is ms'
        return f"time: column '{recorded.time}'" + ("" if unit else unsure)
    if recorded.step is not None:
        return (
            f"time: a step of {format_quantity(recorded.step, 's')}, first sample at"
            f" {format_quantity(recorded.start, 's')}, as the file states"
        )
    return 'time: not stated; add --set time="COLUMN [s]" or --set step="10 us"'


def _example(recorded: Recorded) -> list[str]:
    """Return the options that import the columns whose unit or heading tells a signal, else the first one as a voltage."""
    columns = [each for each in recorded.channels if each.name != recorded.time]
    if not columns:
        return []
    proposed = proposed_columns(recorded) or (
        ProposedColumn(column=columns[0].name, signal="drive_voltage", unit="" if columns[0].unit else "V"),
    )
    options = [f'--column {each.signal}="{each.stated}"' for each in proposed]
    options += [f'--set scale.{each.signal}="{each.scale}"' for each in proposed if each.scale]
    lines = [f"to import it: {' '.join(options)} -o trace.nc"]
    if unsure := ", ".join(f"'{each.column}'" for each in proposed if each.unit):
        lines.append(f"the file states no unit for {unsure}: write the right one into the brackets")
    if scaled := ", ".join(each.scale for each in proposed if "/" in each.scale):
        lines.append(f"{scaled} stands for the sensitivity of the sensor: write that of yours")
    if unnamed := [each.column for each in proposed if each.signal == "drive_voltage" and not each.is_named]:
        sensor = "is the output of a sensor, take the signal that it measures, with --set scale.SIGNAL=..."
        lines.append(f"if '{unnamed[0]}' {sensor} SIGNAL=\"1.5 N/V\"")
    if turned := next((each.column for each in proposed if each.scale == "-1"), ""):
        lines.append(f"'{turned}' is negative; as normal_force a load is positive")
    if any(each.signal.endswith("_force") for each in proposed):
        lines.append("of a scenario with a [rig]: lateral_force_measured, normal_force_measured")
    return lines


_WORDS: Final[Mapping[str, str]] = {
    "normal_force": r"f ?[nz]|.*\b(normal|vertical|load(?! ?cell)|down ?force|last|normalkraft|press(ing)?|effort normal)\b.*",
    "lateral_force": r"f ?[txyrf]?|.*\b(lateral|tangential\w*|shear|friction|horizontal|reib\w*|querkraft|frottement)\b.*"
    r"|.*(force|kraft|effort|load ?cell).*",
    "current": r"i|.*\b(current|strom|courant|amp(ere)?s?)\b.*",
    "sliding_speed": r".*\b(sliding )?(speed|velocity|geschwindigkeit|vitesse)\b.*",
    "plate_voltage": r".*\b(plate|electrode) (voltage|potential|spannung)\b.*",
    "drive_voltage": r"u|v|hv|.*(volt|spannung|tension|\bdrive\b).*",
    "capacitance": r"cp?|.*\b(capacit(y|ance)|kapazit(ä|ae)t|capacité)\b.*",
    "gap": r".*\b(gap|spalt|entrefer)\b.*",
    "gross_contact_area": r".*\b(area|fl(ä|ae)che|surface)\b.*",
}
"""Signal to the pattern of its headings, in small letters, without separators; the first one that fits is taken."""
_BY_UNIT: Final[Mapping[str, str]] = {
    "N": "lateral_force",
    "V": "drive_voltage",
    "A": "current",
    "m/s": "sliding_speed",
    "m2": "gross_contact_area",
    "F": "capacitance",
}
"""SI unit to the signal that a column in this unit is where its heading says nothing else."""


@dataclass(frozen=True, kw_only=True)
class ProposedColumn:
    """What a column probably is.

    `unit` is the SI unit of the signal, to be confirmed where the file states no unit; else empty. `scale` is
    an example of a sensitivity where the unit is that of a sensor, ``"-1"`` for a load that is negative; else
    empty.
    """

    column: str
    signal: str
    unit: str = ""
    scale: str = ""

    @property
    def stated(self) -> str:
        """The column as an import expects it."""
        return f"{self.column} [{self.unit}]" if self.unit else self.column

    @property
    def is_named(self) -> bool:
        """Whether the heading itself tells the signal, not the unit alone."""
        return _signal(self.column, "") == self.signal


def proposed_columns(recorded: Recorded) -> tuple[ProposedColumn, ...]:
    """Propose a signal, each once, for each column whose unit tells one, or else its heading."""
    found: dict[str, ProposedColumn] = {}
    for channel in recorded.channels:
        if channel.name == recorded.time:
            continue
        kind = (kind_and_factor(channel.unit) or ("",))[0] if channel.unit else ""
        signal = _signal(channel.name, kind)
        if not signal or signal in found or (channel.unit and not kind):
            continue
        target = SIGNALS[signal].unit
        found[signal] = ProposedColumn(
            column=channel.name,
            signal=signal,
            unit="" if kind else target,
            scale=f"1.5 {target}/{channel.unit}"
            if kind not in ("", target)
            else _sign(signal, channel.values),
        )
    return tuple(found.values())


def _sign(signal: str, values: Real) -> str:
    """Return the factor that makes a load positive, where the tribometer writes it as a negative number."""
    pressed = values[np.isfinite(values)]
    return "-1" if signal == "normal_force" and pressed.size and np.median(pressed) < 0 else ""


def _signal(name: str, kind: str) -> str:
    """Return the signal of a column with this heading and SI unit; empty if nothing tells it."""
    heading = re.sub(r"[\s_.:\-]+", " ", name.lower()).strip()
    named = next((signal for signal, form in _WORDS.items() if re.fullmatch(form, heading)), "")
    if not kind or (named and (SIGNALS[named].unit == kind or kind == "V")):
        return named
    return _BY_UNIT.get(kind, "")
