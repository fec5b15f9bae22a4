"""Computing times and amounts of memory as text."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Final

from electrovib.core.errors import InputError
from electrovib.core.units import parse_quantity

_MEMORY: Final = re.compile(r"\s*(\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)\s*(B|kB|MB|GB|TB)\s*")
_BYTES: Final = {"B": 1.0, "kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
_DURATIONS: Final = (("days", 86400.0, 3), ("h", 3600.0, 2), ("min", 60.0, 2), ("s", 1.0, 0))
_MORE: Final = 1.5
"""Factor on the estimate that a refusal recommends: an estimate is right within a factor of about two."""


def duration(seconds: float) -> str:
    """Write a computing time [s] in s, min, h or days, with two significant digits."""
    unit, length = next((unit, length) for unit, length, fewest in _DURATIONS if seconds >= fewest * length)
    return f"{float(f'{seconds / length:.2g}'):g} {unit}"


def _positive(name: str, value: float | str, read: Callable[[str], float]) -> float:
    number = read(value) if isinstance(value, str) else float(value)
    if not (math.isfinite(number) and number > 0):
        raise InputError(
            f"{name} = {value}: expected a time above 0 such as '30 min', or a memory such as '8 GB'"
        )
    return number


def _seconds(text: str) -> float:
    try:
        return parse_quantity(text, "s")
    except ValueError:
        return math.nan


def _bytes(text: str) -> float:
    found = _MEMORY.fullmatch(text)
    return float(found[1]) * _BYTES[found[2]] if found else math.nan


def amount_of_memory(name: str, value: float | str) -> float:
    """Read an amount of memory [bytes], given as a number above 0 or as a text such as ``"8 GB"``."""
    number = _bytes(value) if isinstance(value, str) else float(value)
    if not (math.isfinite(number) and number > 0):
        raise InputError(f"{name} = {value}: expected an amount of memory above 0, for instance '1 GB'")
    return number
