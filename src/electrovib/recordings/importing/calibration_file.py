"""Calibration of a sensor from a file of readings at known values."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.files import note_input
from electrovib.core.signals import SIGNALS
from electrovib.data.registry import read_recorded
from electrovib.data.unit_words import kind_and_factor
from electrovib.recordings.importing.calibration import calibrate

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.importing.calibration import SensorCalibration


def read_calibration(signal: str, path: str | Path) -> SensorCalibration:
    """Fit the calibration line of a sensor to a table of readings with their unit and known values, in this order."""
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
