"""A figure of a reproduced paper, from its data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.view.plots.draw import finish
from electrovib.view.style import COLOURS, DASHES, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from electrovib.study.reproduction import Curve, Panel

_SIZE = (6.4, 3.9)
_KINDS: dict[str, dict[str, Any]] = {
    "line": {},
    "dashed": {"linestyle": "--"},
    "points": {"linestyle": "none", "marker": "o", "markersize": 4.0},
}


def panel(panel: Panel, *, ax: Axes | None = None) -> Axes:
    """Draw one figure of a reproduction.

    Parameters
    ----------
    panel : Panel
        Curves, bands and points as data.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI.
    """
    with drawing(ax, _SIZE) as axes:
        if panel.log_x:
            axes.set_xscale("log")
        if panel.log_y:
            axes.set_yscale("log")
        for number, curve in enumerate(panel.curves):
            dash = DASHES[number // len(COLOURS) % len(DASHES)]
            _draw(axes, curve, COLOURS[number % len(COLOURS)], dash)
        finish(axes, x=panel.x, y=panel.y)
        axes.set_title(panel.title)
        return axes


def _draw(ax: Axes, curve: Curve, colour: str, dash: Any) -> None:
    x, y = (np.asarray(values, dtype=float) for values in (curve.x, curve.y))
    if curve.upper is None:
        ax.plot(x, y, color=colour, label=curve.label, **{"linestyle": dash} | _KINDS.get(curve.kind, {}))
        return
    upper = np.asarray(curve.upper, dtype=float)
    ax.fill_between(x, y, upper, color=colour, alpha=0.22, linewidth=0, label=curve.label)
    for edge in (y, upper):
        ax.plot(x, edge, color=colour, linewidth=0.7)
