"""A recording of a tribometer, from a file of its instrument or a Trace: calibrated in newtons and metres, and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.files import note_input
from electrovib.core.model import read_model
from electrovib.core.parsing import read_toml_file
from electrovib.data.registry import read_columns
from electrovib.physics.rig import EvenSamples, TimeColumn, TribometerChannels
from electrovib.recordings.rail import at_rail

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.sampled import StampTreatment
    from electrovib.physics.rig import Clock

    Recorded: TypeAlias = "Recording | xarray.Dataset | str | Path"
    Channels: TypeAlias = "TribometerChannels | Mapping[str, Any] | str | Path"


_FEWEST = 100
"""Smallest number of samples of a record."""


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A calibrated recording of a tribometer; the zeros of its forces are still those of the sensors.

    - `position`: position of the carriage, 0 at the first sample, continuous where the encoder wraps `wraps`
      times; None without an encoder.
    - `step`: length of one count of the encoder [m]; 0 without one.
    - `missing`: number of rows that were omitted because they held a NaN.
    - `at_rail`: for ``normal`` and ``lateral``, True where the sensor is at the end of its range.
    """

    time: Real
    normal_force: Real
    lateral_force: Real
    position: Real | None
    step: float
    channels: TribometerChannels
    source: str
    wraps: int
    missing: int
    at_rail: Mapping[str, NDArray[np.bool_]]


def read_recording(path: Path, channels: TribometerChannels) -> Recording:
    """Read and calibrate a recording of a tribometer.

    Parameters
    ----------
    path : Path
        Any file from which `electrovib.data.registry.read_columns` reads columns: ``.mat``, ``.csv``, ``.npy`` ...
    channels : TribometerChannels
        Assignment of the columns, and their calibration.

    Returns
    -------
    Recording
        Calibrated recording, in SI.

    Raises
    ------
    InputError
        If the file or a column cannot be read, or if a column is no record.
    """
    wanted: dict[str, tuple[str | int, str]] = {
        "normal": (channels.normal.column, channels.normal.read_as),
        "lateral": (channels.lateral.column, channels.lateral.read_as),
    }
    if channels.encoder is not None:
        wanted["encoder"] = (channels.encoder.column, "1")
    if isinstance(channels.clock, TimeColumn):
        wanted["time"] = (channels.clock.column, channels.clock.unit)
    return calibrated(read_columns(path, wanted, missing=True), channels, source=str(path))


def calibrated(
    columns: Mapping[str, Real], channels: TribometerChannels, *, source: str = "the recording"
) -> Recording:
    """Compute forces and a position from the columns ``normal``, ``lateral``, ``encoder`` and ``time`` of a tribometer."""
    needed = ["normal", "lateral"]
    needed += ["encoder"] if channels.encoder is not None else []
    needed += ["time"] if isinstance(channels.clock, TimeColumn) else []
    given = {name: np.asarray(columns[name], dtype=np.float64) for name in needed if name in columns}
    problems = [f"{source}: there is no column '{name}'." for name in needed if name not in given]
    problems += [fault for name, values in given.items() for fault in _faults(source, name, values)]
    if len({values.shape for values in given.values()}) > 1:
        sizes = ", ".join(f"{name} {len(values)}" for name, values in given.items())
        problems.append(f"{source}: the columns differ in length: {sizes}.")
    if problems:
        raise InputError(problems)
    whole = without_missing(given, channels.missing_rows, source)
    given, time = _on_time(given, channels.clock, whole, source)
    position, wraps = None, 0
    if channels.encoder is not None:
        position = channels.encoder.position(given["encoder"])
        wraps = int(np.count_nonzero(np.diff(channels.encoder.wraps(given["encoder"]))))
    return Recording(
        time=time,
        normal_force=channels.normal.force(given["normal"]),
        lateral_force=channels.lateral.force(given["lateral"]),
        position=position,
        step=abs(channels.encoder.step) if channels.encoder is not None else 0.0,
        channels=channels,
        source=source,
        wraps=wraps,
        missing=int(np.count_nonzero(~whole)),
        at_rail={name: at_rail(given[name]) for name in ("normal", "lateral")},
    )


def _on_time(
    columns: dict[str, Real], clock: Clock, whole: NDArray[np.bool_], source: str
) -> tuple[dict[str, Real], Real]:
    """Return the rows that are kept and their times; an omitted row leaves a gap in time."""
    rows = np.flatnonzero(whole)
    if isinstance(clock, TimeColumn):
        rows = rows[increasing(columns["time"][rows], clock.stamps, source)]
        time = columns["time"][rows] - columns["time"][rows[0]]
    else:
        assert isinstance(clock, EvenSamples)
        time = rows / clock.rate
    return {name: values[rows] for name, values in columns.items()}, time


def increasing(time: Real, stamps: StampTreatment, source: str) -> NDArray[np.bool_]:
    """Return which samples of a record to keep so that time stamps increase, or refuse the record; 100 have to be left."""
    try:
        kept = stamps.keep(time)
    except ValueError as error:
        fault = str(error).partition(". To drop")[0]
        raise InputError(
            f"{fault}. With stamps KeepIncreasing such samples are dropped.", path=source
        ) from None
    if np.count_nonzero(kept) < _FEWEST:
        raise InputError(
            f"only {np.count_nonzero(kept)} samples with increasing time stamps are left.", path=source
        )
    return kept


def without_missing(columns: Mapping[str, Real], allowed: int, source: str) -> NDArray[np.bool_]:
    """Find the rows of a record in which every value is a finite number; refuse if more than `allowed` are not."""
    kept = np.all([np.isfinite(values) for values in columns.values()], axis=0)
    missing = int(np.count_nonzero(~kept))
    if missing <= allowed:
        return np.asarray(kept)
    faults = []
    for name, values in columns.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            faults.append(f"column '{name}', sample {bad[0]}: {values[bad[0]]} is not a finite number")
    may = f"missing_rows = {missing} omits them" if allowed == 0 else f"missing_rows = {allowed} allows fewer"
    rows = "1 row" if missing == 1 else f"{missing} rows"
    raise InputError(f"{'; '.join(faults)}. This concerns {rows} of {len(kept)}; {may}.", path=source)


def _faults(source: str, name: str, values: Real) -> list[str]:
    if values.ndim != 1 or len(values) < _FEWEST:
        return [
            f"{source}: column '{name}' has shape {values.shape}; a row of at least {_FEWEST} samples is needed."
        ]
    if name in {"normal", "lateral"} and np.all(values == values[0]):
        return [f"{source}: column '{name}' holds {values[0]:g} throughout; is it the right column?"]
    return []


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
