"""Columns of a file as signals: what they probably are, and what is chosen, calibrated by a sensitivity or a line."""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError, InputError, Problem, nearest
from electrovib.core.files import note_input
from electrovib.core.signals import SIGNALS
from electrovib.core.units import KINDS, parse_quantity
from electrovib.data.recorded import is_unit_of_time
from electrovib.data.registry import read_recorded
from electrovib.data.unit_words import HAS_POWER, as_unit, kind_and_factor, unit_of_force
from electrovib.recordings.recording import SensorCalibration, calibrate

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn, Recorded

_WORDS: Final[Mapping[str, str]] = {
    "normal_force": r".*\b(f ?[nz]|(force|kraft) ?z|f ?norm(al)?) ?\d*\b.*|.*\bz (force|kraft)\b.*"
    r"|.*\b(normal|vertical|load(?! ?cell)|down ?force|last|normalkraft|press(ing)?|effort normal)\b.*",
    "lateral_force": r"f|.*\bf ?([txyrf] ?\d*|tan(gential)?)\b.*"
    r"|.*\b(lateral|tangential\w*|shear|friction|horizontal|reib\w*|querkraft|frottement)\b.*"
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
_RATIO: Final = re.compile(r".*\b(cof|coeff?(icient)?|mu|µ|μ|ratio|reibwert|reib\w*zahl)\b.*")
"""Headings of a ratio of two forces, which is no force."""
_COUNTER: Final = re.compile(r".*\b(sequence|status|counter|index)\b.*")
"""Headings of what counts or flags the samples."""
_UNSURE: Final = re.compile(r".*\b((f|force|kraft) ?y ?\d*|y (force|kraft))\b.*")
"""Headings of a force along y, which is lateral or normal."""
_TIME: Final = re.compile(r".*\b(time|time ?stamp|t|zeit|temps|x)\b.*")
_COUNT: Final = re.compile(r".*\b(index|nr|no|number|points?|samples?|rows?|steps?|cycles?|segment|#|n)\b.*|")
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

    @property
    def is_sure(self) -> bool:
        """Whether the heading names one direction of a force alone."""
        return not _UNSURE.fullmatch(_words(self.column))


def proposed_time(recorded: Recorded) -> DataColumn | None:
    """Return the column that is probably the time: of those that may be it one that is called so, or the first."""
    found = possible_times(recorded)
    return next((each for each in found if _TIME.fullmatch(_words(each.name))), found[0] if found else None)


def possible_times(recorded: Recorded) -> list[DataColumn]:
    """Return the columns that may be times: they increase, in a unit of time, or without a unit and a signal."""
    return [
        each
        for each in recorded.channels
        if (is_unit_of_time(each.unit) or not (each.unit or _signal(each.name, "")))
        and rises(each.values)
        and (_TIME.fullmatch(_words(each.name)) or not _COUNT.fullmatch(_words(each.name)))
    ]


def may_be_voltage(column: DataColumn) -> bool:
    """Return whether a column without a unit may be an example of a voltage: neither the time by its name, nor rising."""
    return not (column.unit or _TIME.fullmatch(_words(column.name)) or rises(column.values))


def rises(values: Real) -> bool:
    """Return whether each number exceeds the one before."""
    return values.size > 1 and bool((np.diff(values) > 0).all())


def proposed_columns(
    recorded: Recorded, columns: Sequence[DataColumn] | None = None
) -> tuple[ProposedColumn, ...]:
    """Propose a signal, each once, for each of the columns whose unit tells one, or else its heading."""
    if columns is None:
        columns = [each for each in recorded.channels if each.name != recorded.time]
    found: dict[str, ProposedColumn] = {}
    for channel in sorted(columns, key=lambda each: bool(_UNSURE.fullmatch(_words(each.name)))):
        kind = (kind_and_factor(channel.unit) or ("",))[0] if channel.unit else ""
        signal = _signal(channel.name, kind)
        if not signal or signal in found or (channel.unit and not kind):
            continue
        target = SIGNALS[signal].unit
        found[signal] = ProposedColumn(
            column=channel.name,
            signal=signal,
            unit="" if kind else example_unit(channel.name, target),
            scale=f"1.5 {target}/{channel.unit}"
            if kind not in ("", target)
            else _sign(signal, channel.values),
        )
    return tuple(found.values())


def example_unit(name: str, target: str) -> str:
    """Return the unit that a column may be in: the letters at the end of its heading, if they are one of the right kind."""
    if HAS_POWER.search(name) or re.search(r"[\[(]M[VAN][\])]", name):
        return (
            "UNIT"  # whether the numbers have that factor already, or M is milli, the heading does not tell
        )
    own = as_unit(name.rpartition("_")[2]) if "_" in name else None
    own = unit_of_force(name, own or "")
    return own if own and (kind_and_factor(own) or ("",))[0] == target else target


def _sign(signal: str, values: Real) -> str:
    """Return the factor that makes a load positive, where the tribometer writes it as a negative number."""
    pressed = values[np.isfinite(values)]
    return "-1" if signal == "normal_force" and pressed.size and np.median(pressed) < 0 else ""


def _words(name: str) -> str:
    """Return a heading in small letters, with a blank for each separator and before each capital behind a small letter."""
    return re.sub(r"[\s_.:/\-]+|(?<=[a-z])(?=[A-Z])", " ", name).lower().strip()


def _signal(name: str, kind: str) -> str:
    """Return the signal of a column with this heading and SI unit; empty if nothing tells it."""
    heading = _words(name)
    own = SIGNALS.get(heading.replace(" ", "_"))
    if own and own.dims == ("time",) and kind in ("", own.unit):
        return heading.replace(" ", "_")
    if kind in ("", "1") and (_RATIO.fullmatch(heading) or _COUNTER.fullmatch(heading)):
        return ""
    named = next((signal for signal, form in _WORDS.items() if re.fullmatch(form, heading)), "")
    if not kind or (named and (SIGNALS[named].unit == kind or kind == "V")):
        return named
    return _BY_UNIT.get(kind, "")


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
            f" '{column.name} [{example_unit(column.name, target)}]', or state a scale such as '1.5 {target}/V'."
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
    values = np.asarray(column.values, dtype=float)
    with np.errstate(all="ignore"):  # what overflows is reported as missing
        for operation, number, neutral in (
            (np.multiply, known[1], 1.0),
            (np.subtract, before, 0.0),
            (np.multiply, factor[0], 1.0),
            (np.subtract, after, 0.0),
        ):
            values = values if number == neutral else operation(values, number)
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


def read_calibration(signal: str, path: str | Path) -> SensorCalibration:
    """Fit the calibration line of a sensor to a table of readings with their unit and known values, in this order."""
    place = Path(path)
    note_input(place)
    recorded = read_recorded(place)
    if len(recorded.channels) != 2:
        listed = ", ".join(f"'{each.name}'" for each in recorded.channels[:20])
        raise DataFileError(
            f"calibration.{signal}: expected two columns, the reading and the known value; the file has {listed}.",
            path=place,
        )
    known: list[Real] = []
    for each, target in zip(recorded.channels, ("", SIGNALS[signal].unit), strict=True):
        found = kind_and_factor(each.unit) if each.unit else None
        if found is None or (target and found[0] != target):
            what = f"a unit of {target}" if target else "a unit that is known"
            raise DataFileError(
                f"calibration.{signal}: column '{each.name}' needs {what} in its heading, such as 'F [{target or 'V'}]'; it has"
                f" '{each.unit}'.",
                path=place,
            )
        known.append(np.asarray(each.values * found[1]))
    try:
        return calibrate(known[0], known[1])
    except InputError as error:
        raise DataFileError(str(error.problems[0].reason), path=place) from None
