"""Binary files of oscilloscopes (.wfm, .bin, .trc), read with RigolWFM."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.data.columns.faults import check_file
from electrovib.data.guarded import Reader, read_guarded
from electrovib.data.readers.foreign import check_declared, check_package, recorded_of, text_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.data.readers.recorded import Recorded

DESCRIPTION: Final = "Tektronix and Rigol .wfm, Keysight, Rigol and Siglent .bin, LeCroy .trc"
PACKAGE: Final = "RigolWFM"
_UNITS: Final = {"v": "V", "a": "A", "w": "W"}


def is_oscilloscope_binary(head: bytes) -> bool:
    """Return whether the first bytes are those of a known binary file of an oscilloscope."""
    return (
        re.match(rb"[\x0f\xf0]{2}:WFM#", head) is not None
        or re.match(rb"(#9\d{9})?WAVEDESC", head) is not None
        or re.match(rb"(AG|RG)(0[13]|10)", head) is not None
    )


def read_oscilloscope_binary(path: Path) -> Recorded:
    """Read the analogue channels of a binary file of an oscilloscope.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    Recorded
        One channel for each that was recorded, with the time step that the file states.

    Raises
    ------
    DataFileError
        If RigolWFM is not installed, the file is damaged, or its format is not known.
    """
    check_file(path)
    check_package(path, PACKAGE, "a binary file of an oscilloscope")
    found = read_guarded(
        Reader(f"{__name__}:channels", (f"{PACKAGE}.wfm", "numpy"), "a binary file of an oscilloscope"), path
    )
    step, start, model = found["about"]
    table = [(*found[f"about {at}"], found[f"values {at}"]) for at in range((len(found) - 1) // 2)]
    return recorded_of(path, table, step=step, start=start, attributes={"model": model})


def channels(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield time step, start and model, then name, unit and values of each channel; called in a guarded process."""
    from RigolWFM import wfm

    try:
        found = wfm.Wfm.from_file(str(path))
    except Exception as error:  # noqa: BLE001  # the package has many kinds, of which none derives from a common one
        raise ValueError(text_of(error).partition("\n")[0] or type(error).__name__) from None
    recorded = [channel for channel in found.channels if channel.volts is not None and len(channel.volts) > 1]
    if not recorded:
        raise ValueError("it holds no channel")
    check_declared(path, sum(len(channel.volts) for channel in recorded))
    times = np.asarray(recorded[0].times, dtype=float)
    step = float(times[-1] - times[0]) / (times.size - 1)
    if not np.isfinite(step) or step <= 0 or not np.isfinite(times[0]):
        raise ValueError("it states no time step")
    yield "about", [step, float(times[0]), text_of(getattr(found, "header_name", ""))]
    for at, channel in enumerate(recorded):
        unit = str(getattr(channel.unit, "name", "")).lower()
        yield f"about {at}", [str(channel.name), _UNITS.get(unit, "")]
        yield f"values {at}", np.asarray(channel.volts, dtype=float)
