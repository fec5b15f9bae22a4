"""Names under which instruments state settings above the numbers, and which line is a setting."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence


STEP: Final = frozenset({
    "increment", "sample interval", "sampleinterval", "sampling interval", "xincr", "x increment", "xincrement", "dt",
    "tinc", "t inc", "time step", "timestep", "sampling period", "sample period", "xinc", "horizontal interval",
    "time interval", "resolution", "interval", "delta x", "hresolution", "clock",
})  # fmt: skip
RATE: Final = frozenset(
    {"sample rate", "samplerate", "sampling rate", "sampling frequency", "sample frequency", "fs"}
)
START: Final = frozenset(
    {"start", "xzero", "x zero", "xorg", "xorigin", "t0", "x0", "start time", "first sample", "hoffset"}
)
VAGUE: Final = frozenset({"resolution", "interval", "clock"})
"""Names of which only a value with a unit is a time step."""
TIMING: Final = STEP | START
_MEASURED: Final = frozenset({"frequency", "period", "amplitude", "memory depth", "probe", "vertical scale"})
"""Further names, which are settings where a number with a unit stands beside them."""
_VALUE: Final = re.compile(
    r"(?:\w{1,8}\s?[=:]\s?)?[+-]?[\d.,]+(?:[eE][+-]?\d+)?\s?(?P<unit>[\w/%µμΩ°]{0,12})"
)


def key_of(cell: str) -> str:
    """Return the name of a setting without its unit and its signs, in small letters."""
    bare = re.sub(r"[\[(].*?[\])]", "", cell)
    return bare.strip().lstrip("#").rstrip(" :=").replace("_", " ").lower()


def is_setting(row: Sequence[str]) -> bool:
    """Return whether a line such as ``Sampling rate,10.0kS/s`` states one setting: a known name with its values beside it."""
    filled = [cell.strip() for cell in row if cell.strip()]
    values = [_VALUE.fullmatch(cell) for cell in filled[1:]]
    key = key_of(filled[0]) if values and all(values) else ""
    return key in TIMING | RATE or (key in _MEASURED and all(each and each["unit"] for each in values))
