"""The numbers of measured times and rings as rows of a table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.units import KINDS, digits_of_interval, format_quantity
from electrovib.recordings.transitions.estimate import none
from electrovib.recordings.transitions.statements import MISFIT

if TYPE_CHECKING:
    from electrovib.recordings.transitions.estimate import Interval
    from electrovib.recordings.transitions.result import DirectionTimes, MeasuredTimes
    from electrovib.recordings.transitions.ring_result import MeasuredRing, MeasuredRings

UNITS: Final = {
    "delay": "s",
    "time constant": "s",
    "level time constant": "s",
    "frequency": "Hz",
    "early frequency": "Hz",
    "drift": "Hz/s",
}
"""Units of parameters; those that are absent are dimensionless."""


@dataclass(frozen=True, kw_only=True)
class TimeRow:
    """One number of a measurement, in its SI unit, and why it may be wrong."""

    group: str
    name: str
    unit: str
    number: Interval
    note: str = ""


def with_interval(row: TimeRow) -> str:
    """Write a number with its 95 % interval, the method, and what may be wrong with it."""
    number = row.number
    if not math.isfinite(number.value):
        return f"{row.name}: none, {number.method}"
    digits = digits_of_interval(number.value, number.lower, number.upper)
    value, lower, upper = (
        _shown(each, row.unit, digits) for each in (number.value, number.lower, number.upper)
    )
    text = f"{row.name}: {value}"
    if math.isfinite(number.upper):
        text += f", 95 % interval {lower} to {upper} ({number.method})"
        if math.isfinite(number.scatter):
            text += f", scatter {_shown(number.scatter, row.unit)}"
    else:
        text += f", no interval: {number.method}"
    return f"{text}; {row.note}" if row.note else text


def _shown(value: float, unit: str, digits: int = 4) -> str:
    return format_quantity(value, unit, digits=digits) if unit in KINDS else f"{value:.{digits}g} {unit}"


def time_rows(found: MeasuredTimes | None, rings: MeasuredRings | None = None) -> list[TimeRow]:
    """List the numbers of a measurement."""
    rows: list[TimeRow] = []
    if found is not None:
        shown = "-".join(f"{100 * each:g}" for each in found.levels)
        for each in found.directions:
            rows += _of_direction(each, shown, sensor=found.sensor != "none")
    if rings is None:
        return rows
    if len(rings.rings) == 1:
        return [*rows, *_of_ring(rings.rings[0])]
    for name, number in (("frequency", rings.frequency), ("quality", rings.quality)):
        rows.append(_parameter("ring", name, number, f"mean of {number.count} impacts", ""))
    for ring in rings.rings:
        group = f"impact at {ring.reference:.6g} s"
        rows += [
            _parameter(group, name, each, ring.form, _misfit(ring.misfit))
            for name, each in ring.parameters.items()
        ]
    return rows


def _of_ring(ring: MeasuredRing) -> list[TimeRow]:
    rows = [
        _parameter("ring", name, each, ring.form, _misfit(ring.misfit))
        for name, each in ring.parameters.items()
    ]
    if "drift" not in ring.parameters:
        rows.append(_parameter("ring", "drift", ring.drift, "one drifting mode", f"{ring.form} fits better"))
    for each in ring.sections:
        start = f"one mode from {each.start * 1e3:.3g} ms on"
        rows += [
            _parameter("ring", "frequency", each.frequency, start, ""),
            _parameter("ring", "quality", each.quality, start, ""),
        ]
    return rows


def _of_direction(found: DirectionTimes, levels: str, *, sensor: bool) -> list[TimeRow]:
    interpolated = any(each.record.passages.interpolated for each in found.edges)
    few = "interpolated between two samples" if interpolated else ""
    drifts = (
        "the signal drifts before an edge" if any(each.record.levels.drift for each in found.edges) else ""
    )
    warning = "; ".join(filter(None, [_misfit(found.misfit), drifts]))
    without = "without the sensor" if sensor else "of the fitted form"
    rows = [
        TimeRow(
            group=found.direction, name=f"{levels} % time as recorded", unit="s", number=found.recorded,
            note="; ".join(filter(None, [few, drifts])),
        ),
        TimeRow(
            group=found.direction, name=f"{levels} % time {without} ({found.form})", unit="s",
            number=found.without_sensor, note=warning,
        ),
    ]  # fmt: skip
    if not math.isnan(found.sensor_limit):
        rows.append(
            TimeRow(
                group=found.direction,
                name=f"{levels} % time of an instantaneous change through the sensor",
                unit="s",
                number=none(found.sensor_limit, "closed form of the sensor"),
            )
        )
    rows += [
        _parameter(found.direction, name, each, found.form, warning)
        for name, each in found.parameters.items()
    ]
    if found.form != "exponential":
        rows += [
            _parameter(found.direction, name, each, "exponential", f"{found.form} fits better")
            for name, each in found.exponential.items()
        ]
    return rows


def _parameter(group: str, name: str, number: Interval, form: str, note: str) -> TimeRow:
    words = name.replace("_", " ")
    unit = next((unit for key, unit in UNITS.items() if words.startswith(key)), "1")
    return TimeRow(group=group, name=f"{words} ({form})", unit=unit, number=number, note=note)


def _misfit(misfit: float) -> str:
    if math.isinf(misfit):
        return "error not known: the record has no noise without signal"
    return f"error beyond the interval: residual {misfit:.2g} times the noise" if misfit > MISFIT else ""
