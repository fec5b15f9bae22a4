"""Columns of a file as signals, calibrated by a sensitivity, an offset or the line of a calibration."""

from __future__ import annotations

import contextlib
import re
from fractions import Fraction
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError, Problem, nearest
from electrovib.core.signals import SIGNALS
from electrovib.core.units import KINDS, parse_quantity
from electrovib.data.unit_words import kind_and_factor
from electrovib.recordings.calibration import SensorCalibration

if TYPE_CHECKING:
    from collections.abc import Collection

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn


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
