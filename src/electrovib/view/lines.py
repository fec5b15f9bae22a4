"""The lines of a plot of Traces: one for each Trace, value of a sweep and layer."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.paths import quantity_at
from electrovib.view.style import COLOURS, DASHES, between, label_axis, layer_colours, pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray
    from matplotlib.axes import Axes
    from matplotlib.legend import Legend
    from matplotlib.transforms import Bbox
    from numpy.typing import NDArray

    from electrovib.scenario import Scenario

LONG: Final = 20_000
"""Records with more points are drawn as their envelope."""
BINS: Final = 2_000


def envelope(
    x: NDArray[np.float64], y: NDArray[np.float64], *, longest: int = LONG, stretches: int = BINS
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Keep ends, lowest and highest point of each stretch of a record above the longest; one without a number stays a gap."""
    if len(y) <= longest:
        return x, y
    size = -(-len(y) // stretches)
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


_LONG_LABEL = 44
_MOST_POINTS = 4000
"""Points of a recording; of a longer one every nth sample."""
_POINTS: Any = {"linestyle": "none", "marker": ".", "markersize": 3.5, "markeredgewidth": 0, "alpha": 0.6}
"""Look of a recording under a model."""
_PATH = re.compile(r"(?:^|, )([^\s,=]+) = ")
WIDE = 30.0
"""Ratio of largest to smallest value from which an axis is logarithmic."""


def draw(ax: Axes, drawn: Sequence[Line]) -> None:
    """Draw lines, long ones as the envelope of their points, and recordings as points under them."""
    alone = all(line.measured for line in drawn)
    for line in drawn:
        label = plain(", ".join(part for part in (line.label, line.kind) if part)) or "_nolegend_"
        y = np.asarray(line.y, dtype=float)
        if line.measured and not alone:
            every = -(-y.size // _MOST_POINTS)
            ax.plot(line.x[::every], y[::every], color=line.colour, label=label, zorder=1.5, **_POINTS)
        else:
            ax.plot(*envelope(line.x, y), color=line.colour, linestyle=line.dash, label=label)


def finish(
    ax: Axes,
    *,
    x: tuple[str, str],
    y: tuple[str, str],
    base: float = 0.0,
    drawn: Sequence[Line] = (),
    note: str = "",
) -> None:
    """Label the axes in words and units, and explain the lines; the vertical axis counts from `base`."""
    label_axis(ax.xaxis, *x)
    label_axis(ax.yaxis, *y, base=base)
    if not np.all(np.isfinite(ax.dataLim.intervaly)):
        ax.text(0.5, 0.5, "no numbers to draw", transform=ax.transAxes, ha="center", va="center")
    elif ax.get_xscale() == "linear":
        ax.margins(x=0.01)
    handles, labels = _colours_and_dashes(drawn) or ax.get_legend_handles_labels()
    if labels:
        _legend(ax, handles, labels, note)


def _colours_and_dashes(drawn: Sequence[Line]) -> tuple[list[Any], list[str]] | None:
    """Return entries for colours, then for dashes, instead of one for each pair; None where only one of them has a meaning."""
    from matplotlib.lines import Line2D

    colours = {line.label: line for line in drawn if line.label}
    dashes = {line.kind: line.dash for line in drawn if line.kind}
    if not (colours and dashes):
        return None
    points = not all(line.measured for line in drawn)
    handles = [
        Line2D([], [], color=line.colour, **(_POINTS if line.measured and points else {}))
        for line in colours.values()
    ]
    handles += [Line2D([], [], color="#555555", linestyle=dash) for dash in dashes.values()]
    return handles, [plain(label) for label in (*colours, *dashes)]


def plain(label: str) -> str:
    """Escape in a label what matplotlib would read as a formula, or as a label not to be shown."""
    shown = label.replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def _legend(ax: Axes, handles: Sequence[Any], labels: list[str], note: str) -> None:
    common, short = shared_words(labels)
    title = "\n".join(part for part in (common, note) if part)
    legend_beside_no_curve(ax, handles, [_cut(label) for label in short], title)


def _cut(label: str) -> str:
    """Omit the middle of a label that is wider than a legend may be."""
    return "\n".join(
        line if len(line) <= _LONG_LABEL else f"{line[:28].rstrip()} … {line[-12:].lstrip()}"
        for line in label.split("\n")
    )


def shared_words(labels: list[str]) -> tuple[str, list[str]]:
    """Split labels such as ``drive.rise = 5 ms`` that all name the same paths, which become the title of the legend."""
    parts = {label: _PATH.split(label) for label in labels if " = " in label}
    named = {(before, *rest[::2]) for before, *rest in parts.values()}
    if len(labels) > 1 and len(named) == 1 and (paths := named.pop())[0] == "" and len(paths) > 1:
        return ", ".join(paths[1:]), [
            ", ".join(parts[label][2::2]) if label in parts else label for label in labels
        ]
    return "", labels


def logarithmic_if_wide(ax: Axes) -> None:
    """Set a logarithmic vertical axis for positive values over more than a factor of 30, else one from 0."""
    low, high = (float(bound) for bound in ax.yaxis.get_data_interval())
    if not (np.isfinite(low) and np.isfinite(high)) or low < 0 or high == 0:
        return
    if low > 0 and high > WIDE * low:
        ax.set_yscale("log")
    else:
        ax.set_ylim(0, 1.06 * high)


_PLACES: Final = (
    "upper right",
    "upper left",
    "lower right",
    "lower left",
    "center right",
    "center left",
    "upper center",
    "lower center",
)
_CLEAR: Final = 4.0
"""Distance that a legend keeps from every curve [point]."""
_HIGHEST: Final = 0.4
"""Share of the plot's height that a legend may take above the curves; a higher one stands beside the plot."""
_settled: ContextVar[bool] = ContextVar("settled", default=True)


@contextmanager
def legends_collected() -> Iterator[None]:
    """Leave every legend where it is made, for a figure that collects them into one of its own."""
    token = _settled.set(False)
    try:
        yield
    finally:
        _settled.reset(token)


def legend_beside_no_curve(ax: Axes, handles: Sequence[Any], labels: Sequence[str], title: str) -> None:
    """Add a legend inside the plot that covers no curve, in the first free corner, side or end.

    Where none is free, the vertical axis is extended and the legend stands above the curves, in as many
    columns as fit; one too high for that stands at the right of the plot.
    """
    words = {"title": title or None, "alignment": "left", "labelspacing": 0.3}
    legend = ax.legend(handles, labels, loc="upper right", **words)
    if not _settled.get():
        return
    figure = ax.get_figure(root=True)
    assert figure is not None
    legend.set_in_layout(False)
    figure.draw_without_rendering()
    for place in _PLACES:
        legend.set_loc(place)
        if _is_free(ax, legend):
            return
    legend = _widest(ax, handles, labels, words)
    share = (legend.get_window_extent().height + _pixels(ax, 3 * _CLEAR)) / ax.bbox.height
    if share <= _HIGHEST:
        _raise_top(ax, share)
    else:
        ax.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, **words)


def _widest(ax: Axes, handles: Sequence[Any], labels: Sequence[str], words: dict[str, Any]) -> Legend:
    """Add the legend with as many columns as fit into the width of the plot."""
    for columns in range(len(labels), 0, -1):
        legend = ax.legend(handles, labels, loc="upper left", ncols=columns, **words)
        legend.set_in_layout(False)
        if legend.get_window_extent().width + _pixels(ax, 3 * _CLEAR) <= ax.bbox.width:
            break
    return legend


def _raise_top(ax: Axes, share: float) -> None:
    """Extend the vertical axis, so that everything drawn so far ends below its upper part."""
    low, high = ax.transScale.transform([(0.5, bound) for bound in ax.get_ylim()])[:, 1]
    top = low + (high - low) / (1 - share)
    ax.set_ylim(top=ax.transScale.inverted().transform((0.5, top))[1], auto=None)


def _is_free(ax: Axes, legend: Legend) -> bool:
    """Return whether no line, area or text of the plot comes near the legend."""
    clear = _pixels(ax, _CLEAR)
    box = legend.get_window_extent().padded(clear)
    return not (
        any(_crosses(line, box) for line in ax.lines)
        or any(_covers(area, box) for area in (*ax.collections, *ax.patches))
        or any(text.get_window_extent().overlaps(box) for text in ax.texts)
    )


def _pixels(ax: Axes, points: float) -> float:
    figure = ax.get_figure(root=True)
    assert figure is not None
    return points * figure.dpi / 72


def _crosses(line: Any, box: Bbox) -> bool:
    """Return whether a line, or a marker of it, lies in a box of the display."""
    path = line.get_path().transformed(line.get_transform())
    if line.get_linestyle() == "None":
        return any(box.contains(x, y) for x, y in path.vertices)
    return bool(path.intersects_bbox(box, filled=False))


def _covers(area: Any, box: Bbox) -> bool:
    """Return whether an area, or a set of lines, meets a box of the display."""
    from matplotlib.collections import LineCollection

    paths = area.get_paths() if hasattr(area, "get_paths") else [area.get_path()]
    filled = not isinstance(area, LineCollection)
    return any(path.transformed(area.get_transform()).intersects_bbox(box, filled=filled) for path in paths)
