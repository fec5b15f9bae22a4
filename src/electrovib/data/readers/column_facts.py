"""Names and units of columns that the preamble of a text states in rows of their own."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Final

from electrovib.data.readers.unit_words import as_unit

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.data.readers.layout import Layout

_NAMES: Final = frozenset({"tracename", "channeltitle", "channel title", "channel name", "channel names"})
_UNITS: Final = frozenset({"vertical units", "vunit", "y unit label", "units", "unit", "yunits"})
_ACROSS: Final = ("horizontal units", "hunit", "xunits")
_TIMES: Final = ("", "time", "t", "x_value", "x value")
_CHANNEL: Final = re.compile(r"[A-Za-z]+\s?\d*\s*:\s*")


def named_by_preamble(layout: Layout, settings: Mapping[str, str]) -> Layout:
    """Return a layout with the names and units that rows such as ``Vertical Units,V,A`` or ``TraceName,CH1,CH2`` state."""
    names, units = list(layout.names), list(layout.units)
    rows = {_key(row[0]): row for row in layout.preamble if row and row[0].strip()}
    for key, row in rows.items():
        for place, column in enumerate(layout.columns):
            cell = row[column].strip() if 0 < column < len(row) else ""
            if key in _NAMES and cell:
                names[place] = cell
            elif key in _UNITS and cell and not units[place]:
                units[place] = as_unit(_CHANNEL.sub("", cell, count=1)) or ""
    stated = {_key(name): value.partition(", ")[0] for name, value in settings.items()}
    across = next((as_unit(stated[key]) for key in _ACROSS if key in stated), None)
    if stated.get("x dimension", "").lower() == "time":  # LabVIEW writes seconds
        across = "s"
    if across in ("s", "ms", "us", "ns") and len(names) > 1 and not units[0] and names[0].lower() in _TIMES:
        units[0] = across or ""
    if len(names) == 2 and not any(names) and "source" in stated:  # settings stand beside the numbers
        names = ["time", stated["source"]]
    upright = next((as_unit(stated[key]) for key in _UNITS if key in stated), None)
    if len(names) <= 2 and not units[-1] and upright:
        units[-1] = upright
    return dataclasses.replace(layout, names=tuple(names), units=tuple(units))


def _key(cell: str) -> str:
    return cell.strip().lstrip("#").rstrip(" :=").replace("_", " ").lower()
