"""Statements of the preamble of a text file: settings by name, the time step and the first time."""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING, Final

from electrovib.core.units import parse_quantity
from electrovib.data.readers.number_cells import is_number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.data.readers.layout import Layout

_STEP: Final = frozenset({
    "increment", "sample interval", "sampleinterval", "sampling interval", "xincr", "x increment", "xincrement", "dt",
    "tinc", "t inc", "time step", "timestep", "sampling period", "sample period", "xinc", "horizontal interval",
    "time interval", "resolution", "interval", "delta x", "hresolution", "clock",
})  # fmt: skip
_RATE: Final = frozenset(
    {"sample rate", "samplerate", "sampling rate", "sampling frequency", "sample frequency", "fs"}
)
_START: Final = frozenset(
    {"start", "xzero", "x zero", "xorg", "xorigin", "t0", "x0", "start time", "first sample", "hoffset"}
)
_TIMING: Final = _STEP | _START
_SECONDS: Final = re.compile(r"(?<=[\d. munµp])([munµp]?)S\b")
"""A second that is written as S, as some oscilloscopes do."""
_LONGEST_SETTING: Final = 200
_MOST_SETTINGS: Final = 200


def settings_of(layout: Layout) -> dict[str, str]:
    """Collect the settings of the preamble: a key with its value beside it, or below it in headings."""
    found: dict[str, str] = {}
    for row in layout.preamble[:_MOST_SETTINGS]:
        filled = [cell.strip().lstrip("#").strip() for cell in row if cell.strip()]
        if len(filled) == 1 and (sign := next((sign for sign in ":=" if sign in filled[0]), "")):
            filled = [part.strip() for part in filled[0].split(sign, 1)]
        if len(filled) >= 2 and not _looks_like_number(filled[0]):
            found.setdefault(
                filled[0].rstrip(" :=")[:_LONGEST_SETTING], ", ".join(filled[1:])[:_LONGEST_SETTING]
            )
    for above, below in itertools.pairwise(layout.preamble):
        pairs = zip(above, below, strict=False)
        found |= {
            name: value for name, value in pairs if name.lower() in _TIMING and _looks_like_number(value)
        }
    return found


def _looks_like_number(text: str) -> bool:
    return is_number(text, decimal_comma=False) or is_number(text, decimal_comma=True)


def timing(layout: Layout, settings: Mapping[str, str]) -> tuple[float | None, float]:
    """Find the time step [s], None if it is not stated, and the first time [s], 0 if it is not stated, in the preamble."""
    step: float | None = None
    start = 0.0
    for key, value in settings.items():
        name = re.sub(r"[\[(].*?[\])]", "", key).strip().lower().replace("_", " ")
        unit = (re.search(r"[\[(](.*?)[\])]", key) or [None, ""])[1] or ""
        if name in _STEP:
            step = _seconds(value, unit, layout) or step
        elif name in _RATE and (rate := _hertz(value, unit, layout)):
            step = 1 / rate
        elif name in _START:
            start = _seconds(value, unit, layout) or start
    return step, start


def _seconds(value: str, unit: str, layout: Layout) -> float | None:
    return _quantity(_SECONDS.sub(r"\1s", value.removeprefix("Analog:")), unit, "s", layout)


def _hertz(value: str, unit: str, layout: Layout) -> float | None:
    return _quantity(re.sub(r"S(a|ample)?(/s|ps)$", "Hz", value.partition(", ")[0]), unit, "Hz", layout)


def _quantity(value: str, unit: str, kind: str, layout: Layout) -> float | None:
    """Read '1.0E-6', '2,0 us', or '1 us' with its unit in the key; None if it is no such quantity."""
    text = value.partition(", ")[0].strip()
    if layout.decimal_comma:
        text = text.replace(",", ".")
    for candidate in (f"{text} {unit}" if unit else text, f"{text} {kind}", text):
        try:
            found = parse_quantity(candidate, kind)
        except ValueError:
            continue
        return float(found)
    return None
