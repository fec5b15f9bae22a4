"""Scenario with another drive: a file, a table or a Drive in the place of its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import DataFileError, InputError, NoColumnError
from electrovib.core.files import note_input
from electrovib.core.model import read_model
from electrovib.core.samples import Samples
from electrovib.data.columns import read_columns
from electrovib.data.recorded import Recorded
from electrovib.data.registry import read_recorded
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.sampled import Sampled
from electrovib.scenario import Scenario, TimeGrid, read_part

DriveSource: TypeAlias = "str | Path | Mapping[str, Any] | Drive | None"
"""A file of samples, a table of a drive, a Drive, or None for the drive of the scenario."""
COLUMNS = (("time", "voltage"), ("time", "drive_voltage"))
"""Headings of time and voltage that are tried in a file, in this order."""
_READ_DIRECTLY = (".csv", ".txt", ".tsv", ".npy", ".nc", ".mat")


def with_drive(scenario: Scenario, drive: DriveSource) -> Scenario:
    """Put another drive into a scenario, from rest and over its whole duration; None leaves the scenario as it is."""
    if drive is None:
        return scenario
    return scenario.model_copy(update={"drive": read_drive(drive), "time": TimeGrid()})


def read_drive(source: str | Path | Mapping[str, Any] | Drive) -> Drive:
    """Read a drive from a file, a table or itself; a file has columns of time [s] and voltage [V], without NaN."""
    if isinstance(source, Drive):
        return source
    if isinstance(source, Mapping):
        return read_part(Drive, dict(source))  # type: ignore[type-abstract]
    if not isinstance(source, str | Path):
        raise InputError(f"expected a file, a table or a Drive, not a {type(source).__name__}", path="drive")
    path = Path(source)
    note_input(path)
    time, voltage = _columns(path) if path.suffix.lower() in _READ_DIRECTLY else _channels(path)
    return sampled(time, voltage, path=path)


def sampled(time: Real, voltage: Real, *, path: str | Path = "") -> Drive:
    """Return a drive of straight lines between samples [s, V]; `path` names the file in messages."""
    try:
        return read_model(Sampled, {"time_samples": Samples(time), "voltage_samples": Samples(voltage)})
    except InputError as error:
        if not path:
            raise
        raise (
            InputError((each.reason for each in error.problems), path=path)
            if len(error.problems) == 1
            else error
        ) from None


def _columns(path: Path) -> tuple[Real, Real]:
    """Return times and voltages from the first pair of known headings; without headings, from the first two columns."""
    faults: list[DataFileError] = []
    for time, voltage in COLUMNS:
        try:
            found = read_columns(path, {"time": (time, "s"), "voltage": (voltage, "V")})
        except DataFileError as error:
            if "has no headings" in str(error):
                found = read_columns(path, {"time": (0, "s"), "voltage": (1, "V")})
                return found["time"], found["voltage"]
            if not isinstance(error, NoColumnError):
                raise
            faults.append(error)
        else:
            return found["time"], found["voltage"]
    raise faults[0]


def _channels(path: Path) -> tuple[Real, Real]:
    """Return times and voltages of a record of an instrument that has one channel in volts."""
    recorded: Recorded = read_recorded(path)
    time = recorded.times()
    if time is None:
        raise InputError(
            "states no times of its samples; write it as CSV with the columns time and voltage", path=path
        )
    stamped = [each.unit.strip().lower() for each in recorded.channels if each.name == recorded.time]
    if any(unit not in {"", "s", "sec", "second", "seconds"} for unit in stamped):
        raise InputError(
            f"has times in '{stamped[0]}'; write it as CSV with the columns time and voltage", path=path
        )
    channels = [each for each in recorded.channels if each.name != recorded.time]
    volts = [each for each in channels if each.unit.strip().lower() in {"v", "volt", "volts"}]
    if len(volts) != 1:
        listed = ", ".join(f"'{each.name}' [{each.unit or 'no unit'}]" for each in channels)
        raise InputError(
            f"a drive is one channel in volts, and the file has {listed}; write the voltage as CSV with the columns time and"
            " voltage",
            path=path,
        )
    return np.asarray(time, dtype=float), np.asarray(volts[0].values, dtype=float)
