"""The signal and the drive of a record that are evaluated."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError, nearest
from electrovib.core.signals import SIGNALS

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.readback import Readback


@dataclass(frozen=True, kw_only=True)
class Columns:
    """A signal in its unit over increasing times, and the drive at the same times, or the signal that was chosen for it."""

    signal: str
    unit: str
    time: Real
    values: Real
    drive: Real | None


def columns_of(
    record: xarray.Dataset | str | Path,
    *,
    signal: str | None,
    by: str | None = None,
    readback: Readback | None = None,
) -> Columns:
    """Return the signal, the only one besides `by` if None, and the drive of a record, without missing samples."""
    if isinstance(record, (str, Path)):
        from electrovib.data.traces import open_trace

        record = open_trace(record)
    signal = _named(record, signal, by)
    if readback is not None and by is None:
        raise InputError("readback: states how a signal relates to the drive; name that signal with by")
    time = np.asarray(record["time"].values, dtype=float)
    values = np.asarray(record[signal].values, dtype=float)
    drive = None if by is None else np.asarray(record[by].values, dtype=float)
    whole = np.isfinite(values) & (True if drive is None else np.isfinite(drive))
    time, values = time[whole], values[whole]
    if time.size < 40:
        raise InputError(f"signal = {signal}: it has {time.size} samples; 40 are needed")
    if not (np.diff(time) > 0).all():
        raise InputError("time: the times do not increase; import the record with stamps = 'keep_increasing'")
    if drive is not None:
        drive = _driving(time, drive[whole], readback, by)
    unit = SIGNALS[signal].unit if signal in SIGNALS else str(record[signal].attrs.get("units", ""))
    return Columns(signal=signal, unit=unit, time=time, values=values, drive=drive)


def _named(record: xarray.Dataset, signal: str | None, by: str | None) -> str:
    """Refuse signals that the record does not hold, and return the one to measure."""
    over_time = [str(name) for name, values in record.data_vars.items() if values.dims == ("time",)]
    if signal is None:
        left = [name for name in over_time if name != by]
        if len(left) != 1:
            raise InputError(
                f"signal: the record has {len(left)} signals over time ({', '.join(left) or 'none'}); name the one to measure"
            )
        signal = left[0]
    for option, name in (("signal", signal), ("by", by)):
        if name is not None and name not in over_time:
            raise InputError(
                f"{option} = {name}: the record has no such signal over time; it has {', '.join(over_time) or 'none'}."
                f"{nearest(name, over_time)}"
            )
    return signal


def _driving(time: Real, values: Real, readback: Readback | None, by: str | None) -> Real:
    """Return the drive of which a signal was read back."""
    if readback is None:
        return values
    try:
        return readback.driving(time - time[0], values)
    except ValueError as error:
        raise InputError(f"by = {by}: {error}") from None
