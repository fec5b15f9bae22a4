"""From lines to Axes: the one place where a curve is drawn, labelled, and explained by a legend where no curve runs."""

from __future__ import annotations

import re
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.view.lines import envelope
from electrovib.view.units import label_axis

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from matplotlib.axes import Axes
    from matplotlib.legend import Legend
    from matplotlib.transforms import Bbox

    from electrovib.view.lines import Line


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
        if legend.get_window_extent().width <= ax.bbox.width:
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
