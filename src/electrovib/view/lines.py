"""Which lines a plot of Traces has: one a Trace, one a value of a sweep, one a layer."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.view.style import COLOURS, DASHES, layer_colours, sequence
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

Traces: TypeAlias = "xarray.Dataset | Sequence[xarray.Dataset] | Mapping[str, xarray.Dataset]"
"""What every plot takes: one Trace, several, or several with labels."""
MOST_LINES: Final = 12
"""Of a sweep; a longer one shows evenly chosen values, the first and the last among them."""
_AXES: Final = frozenset({"time", "frequency", "layer"})


@dataclass(frozen=True)
class Line:
    """One line of a plot.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        SI; y may be complex.
    label : str
        For the legend; empty where there is nothing to tell apart.
    colour : str
        Hexadecimal.
    dash : str or tuple
        As matplotlib takes it.
    """

    x: NDArray[np.float64]
    y: NDArray[Any]
    label: str
    colour: str
    dash: Any


def labelled(traces: Traces) -> dict[str, xarray.Dataset]:
    """Give each Trace a label of its own: the caller's, its title, or its number.

    Raises
    ------
    InputError
        If there is none, or if something is not a Trace.
    """
    import xarray

    if isinstance(traces, xarray.Dataset):
        traces = [traces]
    if isinstance(traces, Mapping):
        found = {str(label): trace for label, trace in traces.items()}
    else:
        found = {}
        for number, trace in enumerate(traces, start=1):
            wanted = str(getattr(trace, "attrs", {}).get("title") or f"Trace {number}")
            found[wanted if wanted not in found else f"{wanted} ({number})"] = trace
    wrong = [label for label, trace in found.items() if not isinstance(trace, xarray.Dataset)]
    if wrong:
        kinds = {label: type(found[label]).__name__ for label in wrong}
        raise InputError(f"{label}: expected a Trace, not {kind}" for label, kind in kinds.items())
    if not found:
        raise InputError("there is no Trace to draw: give at least one")
    return found


def has(traces: Traces, name: str) -> bool:
    """Tell whether any of these Traces has the signal."""
    return any(name in trace for trace in labelled(traces).values())


def lines(traces: Traces, name: str, along: str) -> list[Line]:
    """Find the lines of one signal.

    Parameters
    ----------
    traces : Trace, sequence or mapping of Traces
        Those without the signal are left out.
    name : str
        Signal.
    along : str
        ``"time"`` or ``"frequency"``.

    Returns
    -------
    list of Line
        Colour tells Traces apart, else the values of a sweep, else layers; dashes tell the rest.

    Raises
    ------
    InputError
        If none of the Traces has the signal.
    """
    known = labelled(traces)
    arrays = {label: trace[name] for label, trace in known.items() if name in trace}
    if not arrays:
        have = sorted({str(found) for trace in known.values() for found in trace.data_vars})
        raise InputError(f"no Trace has the signal '{name}'. There are: {', '.join(have) or 'none'}.")
    return lines_of(arrays, along, units={label: swept_units(known[label]) for label in arrays})


def lines_of(
    arrays: Mapping[str, xarray.DataArray], along: str, *, units: Mapping[str, Mapping[str, str]]
) -> list[Line]:
    """Find the lines of labelled arrays, as `lines` does for a signal.

    Parameters
    ----------
    arrays : mapping of str to DataArray
        Label to values over `along`, and over layers and swept paths where there are any.
    along : str
        Dimension of the horizontal axis.
    units : mapping of str to mapping
        Label to unit of each swept path.

    Returns
    -------
    list of Line
        In the order of the arrays.
    """
    found: list[Line] = []
    for number, (label, array) in enumerate(arrays.items()):
        alone = len(arrays) == 1
        paths = [str(dim) for dim in array.dims if dim not in _AXES]
        layered = "layer" in array.dims
        names = [str(value) for value in array["layer"].values] if layered else [""]
        ordered = array.transpose(*paths, *(["layer"] if layered else []), along)
        x = np.asarray(ordered[along].values, dtype=float)
        chosen = _chosen([ordered.sizes[path] for path in paths], most=MOST_LINES // len(names))
        for order, pick in enumerate(chosen):
            words = [] if alone else [label]
            words += [_words(ordered, path, place, units[label]) for path, place in zip(paths, pick, strict=True)]
            for layer, name in enumerate(names):
                y = np.asarray(ordered.values[(*pick, layer) if layered else pick])
                place = _Place(None if alone else number, order if paths else None, len(chosen), layer, names)
                parts = [*words, _readable(name)] if layered else words
                found.append(Line(x, y, ", ".join(parts), *_look(place)))
    return found


def _chosen(sizes: list[int], *, most: int) -> list[tuple[int, ...]]:
    """Choose evenly among all combinations of swept values."""
    combinations = list(itertools.product(*(range(size) for size in sizes)))
    even = np.linspace(0, len(combinations) - 1, min(max(2, most), len(combinations))).round().astype(int)
    return [combinations[place] for place in np.unique(even)]


@dataclass(frozen=True)
class _Place:
    """Where a line stands among the others: which Trace, which swept value of how many, which layer."""

    trace: int | None
    value: int | None
    values: int
    layer: int
    layers: list[str]


def _look(place: _Place) -> tuple[str, Any]:
    """Choose colour and dash."""
    if place.trace is not None:
        inner = place.layer if place.value is None else place.value
        return COLOURS[place.trace % len(COLOURS)], DASHES[inner % len(DASHES)]
    if place.value is not None:
        return sequence(place.values)[place.value], DASHES[place.layer % len(DASHES)]
    if place.layers != [""]:
        return layer_colours(place.layers)[place.layers[place.layer]], "-"
    return COLOURS[0], "-"


def _words(array: xarray.DataArray, path: str, place: int, units: Mapping[str, str]) -> str:
    """Write one value of a swept path."""
    value = array[path].values[place] if path in array.coords else place
    number = isinstance(value, (int, float, np.integer, np.floating))
    return f"{path} = {pretty_quantity(float(value), units.get(path, ''), digits=4) if number else value}"


def _readable(name: str) -> str:
    return name.replace("_", " ")


def swept_paths(trace: xarray.Dataset) -> list[str]:
    """List the dotted paths over which a Trace was swept."""
    return [str(dim) for dim in trace.dims if dim not in _AXES]


def swept_units(trace: xarray.Dataset) -> dict[str, str]:
    """Find the unit of each swept path: written at the coordinate, or declared by the scenario."""
    swept = swept_paths(trace)
    found = {path: str(trace[path].attrs["units"]) for path in swept if "units" in trace[path].attrs}
    if len(found) < len(swept) and "scenario" in trace.attrs:
        from electrovib.solve.scenario import scenario_of

        try:
            declared = {path: quantity.unit for path, _, quantity in scenario_of(trace).parameters()}
        except (InputError, ValueError):
            declared = {}
        found = {path: declared[path] for path in swept if path in declared} | found
    return found


def total_lines(traces: Traces, name: str) -> int:
    """Count the lines there would be if every value of a sweep were drawn."""
    arrays = [trace[name] for trace in labelled(traces).values() if name in trace]
    return sum(math.prod(size for dim, size in array.sizes.items() if dim not in {"time", "frequency"}) for array in arrays)
