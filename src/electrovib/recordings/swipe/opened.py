"""Recordings of a tribometer from a Trace, or from a file of an instrument with the calibration of its channels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.files import note_input
from electrovib.core.model import read_model
from electrovib.data.toml_file import read_toml_file
from electrovib.physics.rig_channels import TribometerChannels
from electrovib.recordings.recording import Recording, calibrated, read_recording

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real

    Recorded: TypeAlias = Recording | xarray.Dataset | str | Path
    Channels: TypeAlias = TribometerChannels | Mapping[str, Any] | str | Path

_FORCES = {
    "normal": ("normal_force_measured", "normal_force"),
    "lateral": ("lateral_force_measured", "lateral_force"),
}


def recording_of(
    record: Recorded, *, channels: Channels | None = None, speed: float | str | None = None
) -> Recording:
    """Open a recording of a tribometer; the position of a Trace is the integral of its sliding speed."""
    if channels is not None:
        if not isinstance(record, (str, Path)) or speed is not None:
            raise InputError(
                "channels: belongs to a file of an instrument, and states its speed too"
                if speed is not None
                else "channels: belongs to a file of an instrument; a Trace is calibrated already"
            )
        note_input(Path(record))
        return read_recording(Path(record), _channels(channels))
    if isinstance(record, Recording):
        return record
    source = "the Trace"
    if isinstance(record, (str, Path)):
        from electrovib.data.traces import open_trace

        source, record = str(record), open_trace(record)
    return _of_trace(record, speed, source)


def _channels(channels: Channels) -> TribometerChannels:
    if isinstance(channels, TribometerChannels):
        return channels
    if isinstance(channels, Mapping):
        return read_model(TribometerChannels, channels)
    path = Path(channels)
    advice = "--recipe names the calibration of the columns"
    content = read_toml_file(path, kind="a file of channels", advice=advice)
    try:
        return read_model(TribometerChannels, content)
    except InputError as error:
        raise InputError(f"{path}: {problem}" for problem in error.problems) from None


def _of_trace(trace: xarray.Dataset, speed: float | str | None, source: str) -> Recording:
    names = {
        part: next((each for each in wanted if each in trace and trace[each].dims == ("time",)), "")
        for part, wanted in _FORCES.items()
    }
    if lacking := [part for part, name in names.items() if not name]:
        held = ", ".join(str(name) for name in trace.data_vars) or "none"
        raise InputError(
            f"{source}: a swipe needs a {lacking[0]} force over time; the signals are {held}. Import it with"
            f" --column {_FORCES[lacking[0]][0]}=COLUMN, or name the columns of the file of the instrument with --recipe"
        )
    moved = "sliding_speed" in trace and trace["sliding_speed"].dims == ("time",)
    if moved and speed is not None:
        raise InputError("speed: the Trace has a sliding_speed; omit one of them")
    channels = read_model(
        TribometerChannels,
        {
            **{part: {"column": name, "unit": "N"} for part, name in names.items()},
            "clock": {"model": "TimeColumn", "column": "time"},
            "speed": speed,
        },
    )
    rows = np.all([np.isfinite(trace[name].values) for name in names.values()], axis=0)
    columns: dict[str, Real] = {part: trace[name].values[rows] for part, name in names.items()}
    found = calibrated({**columns, "time": trace["time"].values[rows]}, channels, source=source)
    found = replace(found, missing=int(np.count_nonzero(~rows)))
    if not moved:
        return found
    pace = np.nan_to_num(np.asarray(trace["sliding_speed"].values[rows], dtype=float))
    steps = np.diff(found.time) * (pace[1:] + pace[:-1]) / 2
    return replace(found, position=np.append(0.0, np.cumsum(steps)))
