"""Comparison of what was read back with the plan and with the limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.bench.faults import BenchError
from electrovib.bench.settings import ForceInput
from electrovib.core.units import format_quantity
from electrovib.solve.quantities import of_record

if TYPE_CHECKING:
    from electrovib.bench.plan import BenchPlan
    from electrovib.bench.sequence import RunRecord

_UNITS: Final = {"voltage": "V", "current": "A"}
READINGS: Final = 2.0
"""Readings of the oscilloscope by which a value may exceed a limit: its resolution and the noise of the last bit."""


def refuse_beyond(plan: BenchPlan, record: RunRecord, name: str, step: float) -> None:
    """Refuse a ``"voltage"`` of the plate, or a ``"current"``, whose peak or root mean square exceeds its limit.

    `step` is the difference of two readings [V or A].
    """
    unit = _UNITS[name]
    values = record.channels[name]
    during = (record.time >= 0) & (record.time <= plan.duration)
    reached = {
        name: float(np.max(np.abs(values))),
        f"rms_{name}": of_record("rms", record.time[during], values[during]),
    }
    for limited, value in reached.items():
        limit = getattr(plan.limits, limited)
        if limit is not None and not value <= limit + READINGS * step:
            raise BenchError(_beyond(record, limited.replace("_", " "), value, limit, step, unit=unit))


def refuse_scaled(plan: BenchPlan, record: RunRecord, *, fraction: float, step: float) -> None:
    """Refuse a full burst whose voltage would exceed its limit, by the voltage read back in the low-voltage burst.

    `fraction` is the peak of that burst over that of the full one, `step` the difference of two readings [V].
    """
    limit = plan.limits.voltage
    assert limit is not None
    reached, resolution = _scale(plan, record, fraction) * plan.peak, step / fraction
    if not reached <= limit + READINGS * resolution:
        scaled = _beyond(
            record, "voltage", reached, limit, resolution, unit="V", verb="scaled to the full burst reaches"
        )
        raise BenchError(f"{scaled}; the full burst is not played")


def _beyond(
    record: RunRecord, name: str, value: float, limit: float, step: float, *, unit: str, verb: str = "reached"
) -> str:
    return (
        f"in the {record.burst} the {name} read back {verb} {format_quantity(value, unit, digits=4)}, above its limit of"
        f" {format_quantity(limit, unit)} (resolution {format_quantity(step, unit, digits=2)})"
    )


def _scale(plan: BenchPlan, record: RunRecord, fraction: float) -> float:
    """Return the voltage that was read back over that of the plan, by least squares."""
    wanted = fraction * plan.voltage(record.time)
    power = float(np.dot(wanted, wanted))
    return float(np.dot(wanted, record.channels["voltage"])) / power if power > 0 else 0.0


def compare(plan: BenchPlan, record: RunRecord, *, fraction: float, step: float) -> list[str]:
    """Compare the voltage that was read back with the plan, and say what was found.

    A run is stopped if scale, shape, or the voltage before the burst differ by more than the tolerance of the
    bench. `fraction` is the peak of the burst over that of the full one, `step` the difference of two
    readings [V].
    """
    times, found = record.time, record.channels["voltage"]
    wanted, peak = fraction * plan.voltage(times), fraction * plan.peak
    tolerance = plan.settings.burst.tolerance
    rest = float(np.mean(found[times < 0])) if (times < 0).any() else float(found[0])
    scale = _scale(plan, record, fraction)
    error = float(np.sqrt(np.mean((found - wanted) ** 2))) / peak
    seen = f"{scale:.4g} times the plan, rms difference {100 * error:.2g} % of the peak"
    if abs(scale - 1) > tolerance:
        hint = (
            " Twice the plan is that of a generator set for a load of 50 ohm, or of another meaning of its amplitude."
            if abs(scale - 2) < 0.2
            else " Check amplifier.gain and oscilloscope.voltage.ratio."
        )
        raise BenchError(f"in the {record.burst} the voltage read back is {seen}.{hint}")
    if error > tolerance:
        raise BenchError(f"in the {record.burst} the voltage read back has another shape: {seen}")
    if abs(rest) > tolerance * peak + READINGS * step:
        raise BenchError(
            f"before the {record.burst} the plate is at {format_quantity(rest, 'V', digits=3)}, where 0 V was expected"
        )
    return [f"{record.burst}: voltage read back {seen}; {format_quantity(rest, 'V', digits=2)} before it"]


def beyond_range(plan: BenchPlan, record: RunRecord, name: str) -> list[str]:
    """State how many readings of a force channel lie beyond the range that is declared for it."""
    channel = plan.settings.channels()[name]
    if not isinstance(channel, ForceInput):
        return []
    values = record.channels[name]
    count = int(np.count_nonzero((values < channel.low) | (values > channel.high)))
    if not count:
        return []
    ends = " to ".join(format_quantity(end, "N") for end in (channel.low, channel.high))
    return [
        f"warning: {count} of {values.size} readings of the {name} force lie beyond {ends} (forces.{name}); they may be clipped"
    ]
