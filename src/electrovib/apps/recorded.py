"""The recordings of a fit: files and Traces with their noise, zeros and sessions, and the folder of the results."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from electrovib.core.errors import InputError
from electrovib.data.traces import open_trace
from electrovib.recordings.fit import CalibrationError, MeasuredTrace

if TYPE_CHECKING:
    import xarray

    Recorded: TypeAlias = str | Path | MeasuredTrace | xarray.Dataset


def listed(recordings: Sequence[Recorded] | Recorded) -> list[Recorded]:
    """Return one recording, or a sequence of them, as a list."""
    if isinstance(recordings, (str, Path)) or not isinstance(recordings, Sequence):
        return [recordings]
    return list(recordings)


def measured_of(recording: Recorded, number: int) -> MeasuredTrace:
    """Open a recording, and name it by its file or by its place among the recordings."""
    if isinstance(recording, MeasuredTrace):
        return recording
    if isinstance(recording, (str, Path)):
        return MeasuredTrace(trace=open_trace(recording), name=Path(recording).name)
    return MeasuredTrace(trace=recording, name=f"recording {number + 1}")


def with_own_names(measured: Sequence[MeasuredTrace]) -> list[MeasuredTrace]:
    """Number the recordings that have the same name, such as files of different folders."""
    names = [each.name for each in measured]
    return [
        dataclasses.replace(each, name=f"{each.name} ({number})") if names.count(each.name) > 1 else each
        for number, each in enumerate(measured, start=1)
    ]


def described(
    measured: Sequence[MeasuredTrace],
    noise: Mapping[str, float],
    offsets: Sequence[str],
    sessions: Mapping[str, str] | None,
    *,
    varying: bool,
    calibration: Mapping[str, float | CalibrationError] | None = None,
    stated: Mapping[str, Any] | None = None,
) -> list[MeasuredTrace]:
    """Put settings, noise, zeros, sessions and calibration errors into the recordings that have these signals."""
    names = [each.name for each in measured]
    by_name = {Path(file).name: session for file, session in (sessions or {}).items()}
    unknown = [name for name in by_name if name not in names]
    if unknown:
        raise InputError(f"session: '{unknown[0]}' is none of the recordings: {', '.join(names)}")
    held = {str(name) for each in measured for name in each.trace.data_vars}
    errors = {
        name: each if isinstance(each, CalibrationError) else CalibrationError(gain=each)
        for name, each in (calibration or {}).items()
    }
    absent = [name for name in (*noise, *offsets, *errors) if measured and name not in held]
    if absent:
        raise InputError(f"'{absent[0]}': no recording has this signal; they have {', '.join(sorted(held))}")
    found = []
    for each in measured:
        own = set(map(str, each.trace.data_vars))
        given = each.session or (each.name if varying else "")
        found.append(
            dataclasses.replace(
                each,
                changes=dict(stated or {}) | dict(each.changes),
                noise={name: value for name, value in noise.items() if name in own} | dict(each.noise),
                offsets=[
                    *each.offsets,
                    *(name for name in offsets if name in own and name not in each.offsets),
                ],
                session=by_name.get(each.name, given),
                calibration={name: error for name, error in errors.items() if name in own}
                | dict(each.calibration),
            )
        )
    return found
