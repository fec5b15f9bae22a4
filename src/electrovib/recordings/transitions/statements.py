"""Sentences about measured times: what they mean, and what limits them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.recordings.transitions.forms import INSTANTANEOUS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.transitions.result import DirectionTimes
    from electrovib.recordings.transitions.sensor import Sensor

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
    said = []
    if not found.recorded.lower > 0:
        said.append(
            f"Warning: {which} edges: the record does not determine a time between the levels: its interval reaches 0. Choose the"
            " window after an edge so that the signal reaches both levels, or measure the other edges alone."
        )
    if math.isinf(found.misfit):
        said.append(
            f"Warning: {which} edges: the record has no noise before an edge, as a computed one, so no error of the fitted form"
            f" ({found.form}) is known; the intervals state none."
        )
    elif found.misfit > MISFIT:
        said.append(
            f"Warning: {which} edges: the best form ({found.form}) leaves a residual of {found.misfit:.2g} times the noise before"
            " the edge, so the time from the fit has an error beyond its interval."
        )
    if any(each.record.levels.drift for each in found.edges):
        said.append(
            f"Warning: {which} edges: the signal drifts before an edge; both levels are taken as constant, which shifts the"
            " times."
        )
    if any(each.record.passages.interpolated for each in found.edges):
        said.append(
            f"Warning: {which} edges: fewer than five samples lie near a level, so that the time as recorded is interpolated"
            " between two samples and may be wrong by up to a sampling interval."
        )
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
