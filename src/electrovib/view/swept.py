"""A sweep in words: the range of each quantity and where it occurs, the values of each swept path."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.parsing import read_json
from electrovib.core.units import KINDS, format_quantity
from electrovib.view.lines import shown_value, swept_paths, swept_units

if TYPE_CHECKING:
    import xarray


def is_sweep(trace: xarray.Dataset) -> bool:
    """Return whether a Dataset holds numbers for each case of a sweep."""
    return "quantities" in trace.attrs


def quantities_of(trace: xarray.Dataset) -> list[str]:
    """List the quantities of a sweep, in the order asked for."""
    try:
        return [str(name) for name in read_json(trace.attrs.get("quantities", "[]"))]
    except (TypeError, ValueError):
        return []


def quantity_ranges(trace: xarray.Dataset, *, plain: bool = False, named: bool = True) -> dict[str, str]:
    """Write smallest and largest value of each quantity of a sweep and where they occur; `plain` writes ``uA``."""
    units, found = swept_units(trace), {}
    for name in quantities_of(trace):
        unit = str(trace[name].attrs.get("units", ""))
        values = np.asarray(trace[name].values, dtype=float)
        known = np.isfinite(values)
        if not known.any():
            found[name] = "not known" if np.isnan(values).all() else str(values.flat[0])
            continue
        ends = []
        for place in (
            int(np.argmin(np.where(known, values, np.inf))),
            int(np.argmax(np.where(known, values, -np.inf))),
        ):
            at = np.unravel_index(place, values.shape)
            where = ", ".join(
                (f"{path} = " if named else "")
                + swept_value(trace[path].values[i], units.get(str(path), ""), plain=plain)
                for path, i in zip(trace[name].dims, at, strict=True)
            )
            number = swept_value(values.flat[place], unit, plain=plain)
            ends.append(f"{number} (at {where})" if where else number)
        text = ends[0] if values.size == 1 else " to ".join(ends)
        lost = int(np.count_nonzero(~known))
        found[name] = text + (f"; not known in {lost} of {values.size} cases" if lost else "")
    return found


def swept_value(value: object, unit: str, *, plain: bool) -> str:
    """Write a number with its unit, or a word; with plain units in letters that every terminal has."""
    if plain and unit in KINDS and not isinstance(value, str):
        return format_quantity(float(value), unit, digits=4)  # type: ignore[arg-type]
    return shown_value(value, unit)


def swept_texts(trace: xarray.Dataset) -> dict[str, str]:
    """Return for each swept path its first and last value and their number."""
    units = swept_units(trace)
    texts = {}
    for path in swept_paths(trace):
        values = trace[path].values
        first, last = (shown_value(value, units.get(path, "")) for value in (values[0], values[-1]))
        texts[path] = f"{first} … {last} ({len(values)} values)"
    return texts
