"""The lines of a plot of Traces: one for each Trace, value of a sweep and layer."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.paths import quantity_at
from electrovib.view.style import COLOURS, DASHES, between, layer_colours
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.scenario import Scenario


LONG: Final = 20_000
"""Records with more points are drawn as their envelope."""
BINS: Final = 2_000


def envelope(
    x: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Keep the lowest and the highest point of each stretch of a long record; a stretch without a number stays a gap."""
    if len(y) <= LONG:
        return x, y
    size = -(-len(y) // BINS)
    padded = np.concatenate([y, np.full(-len(y) % size, np.nan)]).reshape(-1, size)
    missing = np.isnan(padded)
    lowest = np.argmin(np.where(missing, np.inf, padded), axis=1)
    highest = np.argmax(np.where(missing, -np.inf, padded), axis=1)
    start = np.arange(len(padded)) * size
    kept = np.unique(np.concatenate([[0, len(y) - 1], start + lowest, start + highest]))
    kept = kept[kept < len(y)]
    return x[kept], y[kept]


Traces: TypeAlias = "xarray.Dataset | Sequence[xarray.Dataset] | Mapping[str, xarray.Dataset]"
"""What every plot takes: one Trace, several, or several with labels."""
MOST_LINES: Final = 5
"""Largest number of curves of a sweep; a longer sweep shows evenly chosen values, the first and the last among them."""
_AXES: Final = frozenset({"time", "frequency", "layer", "sample"})


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of a plot, of which `y` may be complex.

    `label` and `kind` are what colour and dash stand for, empty where there is only one; `dash` is as
    matplotlib takes it; a `measured` line is drawn as points under the lines of models.
    """

    x: NDArray[np.float64]
    y: NDArray[Any]
    label: str
    colour: str
    kind: str = ""
    dash: Any = "-"
    measured: bool = False


def labelled(traces: Traces) -> dict[str, xarray.Dataset]:
    """Return the Traces under distinct labels: the caller's, the title, or the number."""
    import xarray

    given: Any = [traces] if isinstance(traces, xarray.Dataset) else traces
    if isinstance(given, Model):
        raise InputError(
            f"expected a Trace, not a {type(given).__name__}; simulate first: trace = ev.simulate(scenario)"
        )
    if isinstance(given, (str, PathLike)):
        raise InputError(f"expected a Trace, not '{given}'; open it first: trace = ev.open_trace(path)")
    found: dict[str, Any] = {}
    if isinstance(given, Mapping):
        found = {str(label): trace for label, trace in given.items()}
    else:
        for number, trace in enumerate(given, start=1):
            wanted = str(getattr(trace, "attrs", {}).get("title") or f"Trace {number}")
            found[wanted if wanted not in found else f"{wanted} ({number})"] = trace
    wrong = {label: type(it).__name__ for label, it in found.items() if not isinstance(it, xarray.Dataset)}
    if wrong:
        raise InputError(f"{label}: expected a Trace, not {kind}" for label, kind in wrong.items())
    if not found:
        raise InputError("there is no Trace to draw; at least one is needed")
    return found


def has(traces: Traces, name: str) -> bool:
    """Return whether any of these Traces has the signal."""
    return any(name in trace for trace in labelled(traces).values())


def lines(traces: Traces, name: str, along: str) -> list[Line]:
    """Find the lines of one signal along ``"time"`` or ``"frequency"``; Traces without it are omitted."""
    known = labelled(traces)
    arrays = {label: trace[name] for label, trace in known.items() if name in trace}
    if not arrays:
        have = sorted({str(found) for trace in known.values() for found in trace.data_vars})
        raise InputError(f"no Trace has the signal '{name}'. There are: {', '.join(have) or 'none'}.")
    return lines_of(arrays, along, known)


def lines_of(
    arrays: Mapping[str, xarray.DataArray], along: str, known: Mapping[str, xarray.Dataset]
) -> list[Line]:
    """Find the lines of labelled arrays, as `lines` does for a signal, with the colours of all Traces in `known`."""
    found: list[Line] = []
    labels = list(known)
    for label, array in arrays.items():
        paths = [str(dim) for dim in array.dims if dim not in _AXES]
        names = [str(value) for value in array["layer"].values] if "layer" in array.dims else []
        runs = "sample" if along == "time" and "sample" in array.dims else along  # each case at its own times
        ordered = array.transpose(*paths, *(["layer"] if names else []), runs)
        stamps = np.asarray(ordered[along].values, dtype=float)
        units = swept_units(known[label])
        every = list(itertools.product(*(range(ordered.sizes[path]) for path in paths)))
        for order, at in enumerate(_even(len(every), _most(array, len(labels)))):
            pick = every[at]
            value = ", ".join(
                _words(ordered, path, place, units) for path, place in zip(paths, pick, strict=True)
            )
            for layer, name in enumerate(names or [""]):
                looks = _looks(
                    trace=(label, labels.index(label)) if len(labels) > 1 else None,
                    value=(value, order, at / max(1, len(every) - 1)) if paths else None,
                    layer=(name, layer, names) if names else None,
                )
                y = np.asarray(ordered.values[(*pick, layer) if names else pick])
                x = stamps[pick] if stamps.ndim > 1 else stamps
                kept = np.isfinite(x)
                found.append(
                    Line(x=x[kept], y=y[kept], measured="scenario" not in known[label].attrs, **looks)
                )
    return found


def _even(count: int, most: int) -> list[int]:
    """Choose evenly among the values of a sweep, the first and the last among them."""
    even = np.linspace(0, count - 1, min(most, count)).round().astype(int)
    return [int(place) for place in np.unique(even)]


def _looks(
    *,
    trace: tuple[str, int] | None,
    value: tuple[str, int, float] | None,
    layer: tuple[str, int, list[str]] | None,
) -> dict[str, Any]:
    """Choose colour and dash of a line: the colour is that of the first of Trace, swept value and layer."""
    keys: list[tuple[str, str, int]] = []
    if trace is not None:
        keys.append((trace[0], COLOURS[trace[1] % len(COLOURS)], trace[1]))
    if value is not None:
        keys.append((value[0], between(value[2]), value[1]))
    if layer is not None:
        keys.append((layer[0].replace("_", " "), layer_colours(layer[2])[layer[0]], layer[1]))
    if not keys:
        return {"label": "", "colour": COLOURS[0]}
    words, colour, _ = keys[0]
    kind = ", ".join(key[0] for key in keys[1:])
    order = sum(key[2] for key in keys[1:])
    return {"label": words, "colour": colour, "kind": kind, "dash": DASHES[order % len(DASHES)]}


def _words(array: xarray.DataArray, path: str, place: int, units: Mapping[str, str]) -> str:
    """Write one value of a swept path."""
    value = array[path].values[place] if path in array.coords else place
    return f"{path} = {shown_value(value, units.get(path, ''))}"


def shown_value(value: object, unit: str) -> str:
    """Write a value of a sweep: a number with its unit, or a word."""
    if isinstance(value, (int, float, np.integer, np.floating)):
        return pretty_quantity(float(value), unit, digits=4)
    return str(value)


def scenario_or_none(trace: xarray.Dataset) -> Scenario | None:
    """Return the scenario of a Trace; None for a measurement, or for a scenario that this version cannot read."""
    from electrovib.scenario import scenario_of

    try:
        return scenario_of(trace)
    except (InputError, ValueError):
        return None


def swept_paths(trace: xarray.Dataset) -> list[str]:
    """List the dotted paths over which a Trace was swept."""
    return [str(dim) for dim in trace.dims if dim not in _AXES]


def swept_units(trace: xarray.Dataset) -> dict[str, str]:
    """Return the unit of each swept path, from its coordinate or from the declaration in the scenario."""
    swept = swept_paths(trace)
    found = {path: str(trace[path].attrs["units"]) for path in swept if "units" in trace[path].attrs}
    if len(found) < len(swept) and (scenario := scenario_or_none(trace)):
        for path in swept:
            with suppress(InputError):
                found.setdefault(path, quantity_at(scenario, path).unit)
    return found


def left_out(traces: Traces, name: str) -> str:
    """State how many values of a sweep a plot of this signal shows; empty where it shows all."""
    known = labelled(traces)
    notes = []
    for trace in known.values():
        if name not in trace:
            continue
        count = math.prod(trace.sizes[path] for path in swept_paths(trace))
        shown = len(_even(count, _most(trace[name], len(known))))
        if shown < count:
            notes.append(f"{shown} of {count} values")
    return ", ".join(dict.fromkeys(notes))


def _most(array: xarray.DataArray, traces: int) -> int:
    """Return how many values of a sweep are drawn: the lines of a plot, shared among Traces and layers, but two at least."""
    return max(2, MOST_LINES // array.sizes.get("layer", 1) // traces)
