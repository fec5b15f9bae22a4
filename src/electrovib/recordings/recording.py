"""A recording of a tribometer, read from a file, calibrated in newtons and metres, and checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.data.columns import read_columns
from electrovib.physics.rig_channels import EvenSamples, TimeColumn
from electrovib.recordings.rail import at_rail

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from electrovib.physics.drive.sampled import StampTreatment
    from electrovib.physics.rig_channels import Clock, TribometerChannels

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

    time: NDArray[np.float64]
    normal_force: NDArray[np.float64]
    lateral_force: NDArray[np.float64]
    position: NDArray[np.float64] | None
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
        Any file from which `electrovib.data.columns.read_columns` reads columns: ``.mat``, ``.csv``, ``.npy`` ...
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
    columns: Mapping[str, NDArray[np.float64]], channels: TribometerChannels, *, source: str = "the recording"
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
    columns: dict[str, NDArray[np.float64]], clock: Clock, whole: NDArray[np.bool_], source: str
) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.float64]]:
    """Return the rows that are kept and their times; an omitted row leaves a gap in time."""
    rows = np.flatnonzero(whole)
    if isinstance(clock, TimeColumn):
        rows = rows[increasing(columns["time"][rows], clock.stamps, source)]
        time = columns["time"][rows] - columns["time"][rows[0]]
    else:
        assert isinstance(clock, EvenSamples)
        time = rows / clock.rate
    return {name: values[rows] for name, values in columns.items()}, time


def increasing(time: NDArray[np.float64], stamps: StampTreatment, source: str) -> NDArray[np.bool_]:
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


def without_missing(
    columns: Mapping[str, NDArray[np.float64]], allowed: int, source: str
) -> NDArray[np.bool_]:
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


def _faults(source: str, name: str, values: NDArray[np.float64]) -> list[str]:
    if values.ndim != 1 or len(values) < _FEWEST:
        return [
            f"{source}: column '{name}' has shape {values.shape}; a row of at least {_FEWEST} samples is needed."
        ]
    if name in {"normal", "lateral"} and np.all(values == values[0]):
        return [f"{source}: column '{name}' holds {values[0]:g} throughout; is it the right column?"]
    return []
