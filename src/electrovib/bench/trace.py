"""What a run on a bench has recorded, as a Trace with its provenance."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.trace import make_trace
from electrovib.solve.simulate import provenance

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.bench.plan import BenchPlan
    from electrovib.bench.sequence import RunRecord

_TIMES: Final = 1001
"""Times at which the plan is written where nothing was recorded."""


def trace_of(
    plan: BenchPlan, record: RunRecord, *, about: Mapping[str, str | int | float], stopped: str = ""
) -> xarray.Dataset:
    """Make a Trace of a run from the trigger on, complete or, for the reason `stopped`, not.

    It has the planned ``drive_voltage``, and what was read back. The voltage before the trigger is stated in
    the attribute ``comparisons``.
    """
    after = record.time >= 0
    if after.any() and record.channels:
        times, fraction = record.time[after], plan.fraction if record.burst.startswith("low") else 1.0
        channels = {name: values[after] for name, values in record.channels.items()}
    else:
        times, fraction, channels = np.linspace(0.0, plan.duration, _TIMES), 1.0, {}
    names = _signals(plan)
    variables: dict[str, Any] = {"drive_voltage": (("time",), fraction * plan.voltage(times))}
    variables |= {names[name]: (("time",), values) for name, values in channels.items()}
    trace = make_trace(variables, {"time": times}, _attributes(plan, record, stopped) | dict(about))
    if "voltage" in channels:
        trace["plate_voltage"].attrs["calibration"] = (
            f"ratio {plan.settings.oscilloscope.voltage.ratio:g} V/V"
        )
    for name, force in (("lateral", plan.settings.forces.lateral), ("normal", plan.settings.forces.normal)):
        if force is not None and name in channels:
            trace[names[name]].attrs["calibration"] = f"{force.sensitivity:g} N/V, zero {force.zero:g} V"
    return trace


def _signals(plan: BenchPlan) -> dict[str, str]:
    """Return the name of the signal of each channel: with a rig the scenario predicts the readings of its sensors."""
    reading = "_measured" if plan.scenario.rig is not None else ""
    return {
        "voltage": "plate_voltage",
        "current": "amplifier_current",
        "lateral": f"lateral_force{reading}",
        "normal": f"normal_force{reading}",
    }


def _attributes(plan: BenchPlan, record: RunRecord, stopped: str) -> dict[str, Any]:
    limiter = plan.settings.current_limiter
    stated = provenance(plan.scenario)
    return {
        "title": f"Bench: {plan.scenario.title}",
        "electrovib": stated["electrovib"],
        "planned_scenario": stated["scenario"],
        "planned_scenario_hash": stated["scenario_hash"],
        "bench": json.dumps(plan.settings.to_dict()),
        "limits": json.dumps(plan.limits.to_dict()),
        "check": json.dumps(plan.check.to_dict()),
        "validity": json.dumps([each.to_dict() for each in plan.diagnostics]),
        "current_limiter": f"{limiter.name}, {limiter.current:g} A (declared, hardware)",
        "instruments": json.dumps(record.instruments),
        "settings": json.dumps(record.settings),
        "steps": json.dumps(record.steps),
        "burst": record.burst,
        "comparisons": json.dumps(record.statements),
        "resampling_error": plan.resampling_error,
        "complete": int(not stopped),
        "stopped": stopped,
    }
