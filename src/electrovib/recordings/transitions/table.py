"""The numbers of measured times and rings as rows of a table, and sentences on what limits them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.recordings.interval import Interval, NumberRow
from electrovib.recordings.transitions.relaxation import INSTANTANEOUS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.transitions.relaxation import Sensor
    from electrovib.recordings.transitions.ring import MeasuredRing, MeasuredRings
    from electrovib.recordings.transitions.times import DirectionTimes, MeasuredTimes

UNITS: Final = {
    "delay": "s",
    "time constant": "s",
    "level time constant": "s",
    "frequency": "Hz",
    "early frequency": "Hz",
    "drift": "Hz/s",
}
"""Units of parameters; those that are absent are dimensionless."""


def time_rows(found: MeasuredTimes | None, rings: MeasuredRings | None = None) -> list[NumberRow]:
    """List the numbers of a measurement."""
    rows: list[NumberRow] = []
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


def _of_ring(ring: MeasuredRing) -> list[NumberRow]:
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


def _of_direction(found: DirectionTimes, levels: str, *, sensor: bool) -> list[NumberRow]:
    interpolated = any(each.record.passages.interpolated for each in found.edges)
    few = "interpolated between two samples" if interpolated else ""
    drifts = (
        "the signal drifts before an edge" if any(each.record.levels.drift for each in found.edges) else ""
    )
    warning = "; ".join(filter(None, [_misfit(found.misfit), drifts]))
    without = "without the sensor" if sensor else "of the fitted form"
    rows = [
        NumberRow(
            group=found.direction, name=f"{levels} % time as recorded", unit="s", number=found.recorded,
            note="; ".join(filter(None, [few, drifts])),
        ),
        NumberRow(
            group=found.direction, name=f"{levels} % time {without} ({found.form})", unit="s",
            number=found.without_sensor, note=warning,
        ),
    ]  # fmt: skip
    if not math.isnan(found.sensor_limit):
        rows.append(
            NumberRow(
                group=found.direction,
                name=f"{levels} % time of an instantaneous change through the sensor",
                unit="s",
                number=Interval(value=found.sensor_limit, method="closed form of the sensor"),
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


def _parameter(group: str, name: str, number: Interval, form: str, note: str) -> NumberRow:
    words = name.replace("_", " ")
    unit = next((unit for key, unit in UNITS.items() if words.startswith(key)), "1")
    return NumberRow(group=group, name=f"{words} ({form})", unit=unit, number=number, note=note)


def _misfit(misfit: float) -> str:
    if math.isinf(misfit):
        return "error not known: the record has no noise without signal"
    return f"error beyond the interval: residual {misfit:.2g} times the noise" if misfit > MISFIT else ""


MISFIT: Final = 1.5
"""Rms residual over the noise above which a form does not reproduce an edge."""
_SUPPORT: Final = 10.0
"""Difference of the criterion above which a form has essentially no support (Burnham and Anderson 2002)."""
_FEW: Final = 3


def in_few(reasons: Sequence[str]) -> list[str]:
    """Return at most three reasons, the last with the number of those left out."""
    left = len(reasons) - _FEW
    return [*reasons[: _FEW - 1], f"{reasons[_FEW - 1]} (and {left} more)"] if left > 0 else list(reasons)


def statements(found: DirectionTimes, *, sensor: Sensor | None, estimated: bool) -> tuple[str, ...]:
    """Write what limits the times of one direction, warnings first."""
    which = found.direction.capitalize()
    warnings = {
        "the record does not determine a time between the levels: its interval reaches 0. Choose the window after an edge so"
        " that the signal reaches both levels, or measure the other edges alone.": not found.recorded.lower
        > 0,
        "the record has no noise before an edge, as a computed one, so no error of the fitted form"
        f" ({found.form}) is known; the intervals state none.": math.isinf(found.misfit),
        f"the best form ({found.form}) leaves a residual of {found.misfit:.2g} times the noise before the edge, so the time"
        " from the fit has an error beyond its interval.": MISFIT < found.misfit < math.inf,
        "the signal drifts before an edge; both levels are taken as constant, which shifts the times.": any(
            each.record.levels.drift for each in found.edges
        ),
        "fewer than five samples lie near a level, so that the time as recorded is interpolated between two samples and may"
        " be wrong by up to a sampling interval.": any(
            each.record.passages.interpolated for each in found.edges
        ),
    }
    said = [f"Warning: {which} edges: {text}" for text, holds in warnings.items() if holds]
    said += _of_sensor(found, which, sensor=sensor, estimated=estimated)
    close = [
        name
        for name, above in found.criteria.items()
        if name != found.form and above < _SUPPORT + found.criteria[found.form]
    ]
    if close:
        ranked = ", ".join(
            f"{name} (AICc {found.criteria[name] - found.criteria[found.form]:+.1f})" for name in close
        )
        said.append(f"{which} edges: the record does not exclude other forms than {found.form}: {ranked}.")
    if len(found.edges) == 1:
        said.append(
            f"{which} edges: there is one; its interval is due to noise alone and does not contain the scatter between edges."
        )
    return tuple(said)


def _of_sensor(found: DirectionTimes, which: str, *, sensor: Sensor | None, estimated: bool) -> list[str]:
    if math.isnan(found.sensor_limit):
        return [
            f"{which} edges: no sensor was taken out; a resonance or bandwidth of the sensor is part of these times."
        ]
    limit = f"an instantaneous change would show {found.sensor_limit * 1e3:.3g} ms through this sensor"
    said = []
    if found.form == INSTANTANEOUS.name:
        said.append(
            f"{which} edges: an instantaneous change through the sensor reproduces the record as well as a relaxation does"
            f" ({limit}); only an upper end of the time is known."
        )
        if "delay" in found.parameters:
            fall = found.exponential["time_constant"].upper
            shorter = f"up to {fall * 1e3:.2g} ms earlier" if math.isfinite(fall) else "earlier"
            said.append(
                f"{which} edges: the delay is that of an instantaneous change; if the force relaxes exponentially, it begins to"
                f" change {shorter}."
            )
    else:
        said.append(f"{which} edges: {limit}.")
    if estimated:
        said.append(
            f"{which} edges: the sensor was estimated from the same edges, with one resonance. Delay, time constant and"
            " resonance then share what the record determines."
        )
    elif sensor is not None and not (sensor.frequency_error or sensor.quality_error):
        said.append(f"{which} edges: the declared sensor is taken as exact.")
    return said
