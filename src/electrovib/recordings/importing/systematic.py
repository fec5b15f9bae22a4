"""Systematic uncertainty of a calibrated signal: that of its zero and its scale, common to all samples."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.files import note_input
from electrovib.core.signals import SIGNALS
from electrovib.data.columns.column import kind_and_factor
from electrovib.data.readers.registry import read_recorded
from electrovib.recordings.importing.calibration import SensorCalibration, calibrate

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    import xarray

    from electrovib.core.arrays import Real

ATTRIBUTE: Final = "calibration_covariance"
"""Attribute of a Trace that states the systematic uncertainty of its signals."""


def read_calibration(signal: str, path: str | Path) -> SensorCalibration:
    """Fit the calibration line of a sensor to a file of readings at known values.

    Parameters
    ----------
    signal : str
        Signal that the sensor measures.
    path : str or Path
        Table of two columns: the reading with its unit, and the known value in a unit of the signal, in this order.

    Returns
    -------
    SensorCalibration
        In SI.

    Raises
    ------
    InputError
        If the file is no such table.
    """
    place = Path(path)
    note_input(place)
    recorded = read_recorded(place)
    if len(recorded.channels) != 2:
        listed = ", ".join(f"'{each.name}'" for each in recorded.channels[:20])
        raise DataFileError(
            f"calibration.{signal}: expected two columns, the reading and the known value; the file has {listed}.",
            path=place,
        )
    known: list[Real] = []
    for each, target in zip(recorded.channels, ("", SIGNALS[signal].unit), strict=True):
        found = kind_and_factor(each.unit) if each.unit else None
        if found is None or (target and found[0] != target):
            what = f"a unit of {target}" if target else "a unit that is known"
            raise DataFileError(
                f"calibration.{signal}: column '{each.name}' needs {what} in its heading, such as 'F [{target or 'V'}]'; it has"
                f" '{each.unit}'.",
                path=place,
            )
        known.append(np.asarray(each.values * found[1]))
    try:
        return calibrate(known[0], known[1])
    except InputError as error:
        raise DataFileError(str(error.problems[0].reason), path=place) from None


def zero_and_scale(line: SensorCalibration, *, zero_known: bool) -> dict[str, float]:
    """Return the uncertainty of zero and scale of a signal that a calibration line has converted.

    Parameters
    ----------
    line : SensorCalibration
        Calibration line.
    zero_known : bool
        Whether a mean or a trend of the signal has been subtracted, which removes the uncertainty of its zero.

    Returns
    -------
    dict of str to float
        ``zero``, the standard deviation of the zero [unit of the signal]; ``scale``, that of the scale, relative to it;
        ``covariance`` of both [unit of the signal].

    Notes
    -----
    With value v = a + b r of the reading r, deviations da and db change v by dz + s v, where s = db / b and
    dz = da - (a / b) db.
    """
    (aa, ab), (_, bb) = line.covariance
    ratio = line.intercept / line.sensitivity
    zero = 0.0 if zero_known else math.sqrt(max(aa - 2 * ratio * ab + ratio**2 * bb, 0.0))
    covariance = 0.0 if zero_known else (ab - ratio * bb) / line.sensitivity
    return {
        "zero": zero,
        "scale": math.sqrt(bb) / abs(line.sensitivity),
        "covariance": float(covariance),
    }


def systematic_attribute(lines: Mapping[str, SensorCalibration], zeroed: Collection[str]) -> dict[str, str]:
    """Return the attribute of a Trace that states the systematic uncertainty of its calibrated signals.

    Parameters
    ----------
    lines : mapping of str to SensorCalibration
        Signal to its calibration line.
    zeroed : collection of str
        Signals of which a mean or a trend has been subtracted.

    Returns
    -------
    dict of str to str
        The attribute with its JSON text; empty without a calibration.
    """
    if not lines:
        return {}
    found = {signal: zero_and_scale(line, zero_known=signal in zeroed) for signal, line in lines.items()}
    return {ATTRIBUTE: json.dumps(found)}


def systematic_uncertainty(trace: xarray.Dataset) -> dict[str, dict[str, float]]:
    """Return the systematic uncertainty of the calibrated signals of a Trace.

    Parameters
    ----------
    trace : xarray.Dataset
        An imported Trace.

    Returns
    -------
    dict of str to dict of str to float
        Signal to ``zero``, the standard deviation of its zero in its unit, ``scale``, that of its scale relative to it, and
        ``covariance`` of both in its unit; empty if no signal was calibrated with a covariance.
    """
    found: dict[str, dict[str, float]] = json.loads(trace.attrs.get(ATTRIBUTE, "{}"))
    return found
