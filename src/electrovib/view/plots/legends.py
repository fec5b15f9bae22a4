"""Legends: inside the plot, where no curve runs."""

from __future__ import annotations

from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from matplotlib.axes import Axes
    from matplotlib.legend import Legend
    from matplotlib.transforms import Bbox

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
