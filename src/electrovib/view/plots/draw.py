"""From lines to Axes: the one place where a curve is drawn, labelled and explained by a legend."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.view.lines import envelope
from electrovib.view.plots.legends import legend_beside_no_curve
from electrovib.view.units import label_axis

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from electrovib.view.lines import Line

_LONG_LABEL = 44
_MOST_POINTS = 4000
"""Points of a recording; of a longer one every nth sample."""
_POINTS: Any = {"linestyle": "none", "marker": ".", "markersize": 3.5, "markeredgewidth": 0, "alpha": 0.6}
"""Look of a recording under a model."""
_PATH = re.compile(r"(?:^|, )([^\s,=]+) = ")
_WIDE = 30.0
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
    if low > 0 and high > _WIDE * low:
        ax.set_yscale("log")
    else:
        ax.set_ylim(0, 1.06 * high)
