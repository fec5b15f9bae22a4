"""What the lines above the numbers state: settings, time step and start, names and units; and which column is the time."""

from __future__ import annotations

import dataclasses
import itertools
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.units import parse_quantity
from electrovib.data.text.layout import Layout, is_number
from electrovib.data.unit_words import as_unit

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn


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
_NAMES: Final = frozenset({"tracename", "channeltitle", "channel title", "channel name", "channel names"})
_UNITS: Final = frozenset({"vertical units", "vunit", "y unit label", "units", "unit", "yunits"})
_ACROSS: Final = ("horizontal units", "hunit", "xunits")
_TIME_HEADINGS: Final = ("", "time", "t", "x_value", "x value")
_CHANNEL: Final = re.compile(r"[A-Za-z]+\s?\d*\s*:\s*")
_COUNTS: Final = frozenset(
    {"sequence", "index", "nr", "no", "pt", "point", "points", "point #", "sample", "samples", "#", "n"}
)
_TIMES: Final = re.compile(
    r"(elapsed |trigger )?time\b.*|t|zeit|x-axis|x[_ ]?value|x|seconds?|source", re.IGNORECASE
)
FREQUENCY: Final = re.compile(r"freq|hz|hertz|omega", re.IGNORECASE)


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


def named_by_preamble(layout: Layout, settings: Mapping[str, str]) -> Layout:
    """Return a layout with the names and units that rows such as ``Vertical Units,V,A`` or ``TraceName,CH1,CH2`` state."""
    names, units = list(layout.names), list(layout.units)
    rows = {_key_of(row[0]): row for row in layout.preamble if row and row[0].strip()}
    for key, row in rows.items():
        for place, column in enumerate(layout.columns):
            cell = row[column].strip() if 0 < column < len(row) else ""
            if key in _NAMES and cell:
                names[place] = cell
            elif key in _UNITS and cell and not units[place]:
                units[place] = as_unit(_CHANNEL.sub("", cell, count=1)) or ""
    stated = {_key_of(name): value.partition(", ")[0] for name, value in settings.items()}
    across = next((as_unit(stated[key]) for key in _ACROSS if key in stated), None)
    if stated.get("x dimension", "").lower() == "time":  # LabVIEW writes seconds
        across = "s"
    if (
        across in ("s", "ms", "us", "ns")
        and len(names) > 1
        and not units[0]
        and names[0].lower() in _TIME_HEADINGS
    ):
        units[0] = across or ""
    if len(names) == 2 and not any(names) and "source" in stated:  # settings stand beside the numbers
        names = ["time", stated["source"]]
    upright = next((as_unit(stated[key]) for key in _UNITS if key in stated), None)
    if len(names) <= 2 and not units[-1] and upright:
        units[-1] = upright
    return dataclasses.replace(layout, names=tuple(names), units=tuple(units))


def _key_of(cell: str) -> str:
    return cell.strip().lstrip("#").rstrip(" :=").replace("_", " ").lower()


def counts(values: Real) -> bool:
    """Return whether a column numbers the samples."""
    return bool(np.array_equal(values, np.arange(values.size) + values[0]) and values[0] in (0, 1))


def is_index(layout: Layout, first: DataColumn) -> bool:
    """Return whether the first column numbers the rows: by its heading, or it counts and it alone has no heading."""
    if {first.name.lower().rstrip("."), first.unit.lower()} & _COUNTS:
        return True
    return counts(first.values) and not layout.names[0] and all(layout.names[1:])


def keeps_step(channel: DataColumn, step: float) -> bool:
    """Return whether a column increases by the time step that the preamble states, within 1 % of it on average."""
    values = channel.values
    even = (values.size - 1) * step
    return bool(np.isfinite(values).all() and abs(values[-1] - values[0] - even) <= 0.01 * abs(even))


def is_time(channel: DataColumn, step: float | None, *, first: bool) -> bool:
    """Return whether a column is the time: by name and unit, and the first column also by its rise."""
    rises = bool(np.isfinite(channel.values).all() and (np.diff(channel.values) >= 0).all())
    named = bool(_TIMES.fullmatch(channel.name))
    if channel.unit in ("s", "ms", "us", "ns"):
        return (rises and (first or named)) or (first and named)
    if not rises or channel.unit or channel.values[0] == channel.values[-1]:
        return False
    if first and step is not None and keeps_step(channel, step):
        return True
    return (
        named and not (channel.name.lower() == "x" and not first)
        if not first
        else (named or channel.name.startswith("column "))
    )
