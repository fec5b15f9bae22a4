"""What every end of a run does after 0 V: say how the bench was left, keep what was read, and only then make the Trace."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.bench.faults import BenchError
from electrovib.bench.sequence import RunRecord
from electrovib.core.errors import ElectrovibError, printable
from electrovib.core.signals import make_trace
from electrovib.exports.save import save
from electrovib.solve.simulate import provenance

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.bench.plan import BenchPlan
    from electrovib.bench.sequence import RunRecord


def incomplete(path: Path) -> Path:
    """Return the file to which a run that is stopped writes what it has."""
    return path.with_name(f"{path.stem}.incomplete{path.suffix}")


def rehearse(plan: BenchPlan, output: Path | None, about: Mapping[str, str | int | float]) -> None:
    """Save readings of 0, so that all modules of the end are imported, and found to work, before anything is enabled."""
    record = RunRecord(burst="rehearsal", time=np.zeros(2))
    record.channels = {name: np.zeros(2) for name in plan.settings.channels()}
    with tempfile.TemporaryDirectory() as folder:
        place = None if output is None else Path(folder, f"rehearsal{output.suffix}")
        trace, why = saved(plan, record, about, output=place)
    if trace is None:
        raise BenchError(why)


def tell(sentences: list[str]) -> None:
    """Print sentences on the screen, which may be closed by now."""
    for sentence in sentences:
        with suppress(OSError, ValueError):
            print(f"electrovib: {printable(sentence)}", file=sys.stderr, flush=True)


def saved(
    plan: BenchPlan,
    record: RunRecord,
    about: Mapping[str, str | int | float],
    *,
    output: Path | None,
    force: bool = False,
    stopped: str = "",
) -> tuple[xarray.Dataset | None, list[str]]:
    """Keep what was read as it is, until it is saved as a Trace.

    The Trace is returned if it could be made and saved, and in words where the data are, or why not.
    `stopped` is why the run was stopped, empty for a complete one; the file is then that of `incomplete`.
    """
    if output is not None and stopped:
        output = incomplete(output)
    raw, sentences = (None, []) if output is None else _kept(record, output)
    written: list[Path] = []
    try:
        trace = trace_of(plan, record, about=about, stopped=stopped)
        if output is not None:
            written = save(trace, output, force=force)
    except Exception as error:  # noqa: BLE001  # what was read is kept, whatever fails
        return None, [f"the data could not be written as a Trace: {_reason(error)}", *sentences]
    _remove(raw)
    which = "the data so far" if stopped else "the data"
    return trace, [f"{which}: {', '.join(map(str, written))}"] if written else []


def _kept(record: RunRecord, output: Path) -> tuple[Path | None, list[str]]:
    """Write what was read as numbers and texts, beside the output; return the file, and where the data are or why not."""
    raw = None
    try:
        handle, name = tempfile.mkstemp(prefix=f"{output.stem}.raw.", suffix=".json", dir=output.parent)
        raw = Path(name)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(json.dumps(asdict(record), default=np.ndarray.tolist))
    except Exception as error:  # noqa: BLE001  # the Trace is tried in any case
        _remove(raw)
        return None, [f"what was read could not be written either: {_reason(error)}"]
    return raw, [f"what was read is kept as it is: {raw}"]


def _remove(raw: Path | None) -> None:
    if raw is not None:
        with suppress(OSError):
            raw.unlink()


def _reason(error: Exception) -> str:
    return (
        "; ".join(error.problems)
        if isinstance(error, ElectrovibError)
        else f"{type(error).__name__}: {error}"
    )


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
