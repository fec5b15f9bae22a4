"""A figure of a reproduced paper, drawn from its data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.core.answer import REFERENCE
from electrovib.view.plots.draw import finish
from electrovib.view.style import COLOURS, FURTHER_COLOURS, NEUTRAL, drawing
from electrovib.view.units import typeset

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.typing import LineStyleType

    from electrovib.core.answer import Curve, Panel

    _Dashes: TypeAlias = tuple[LineStyleType, LineStyleType]

_SIZE = (6.4, 3.9)
PALETTE = COLOURS + FURTHER_COLOURS
_SOLID: _Dashes = ("-", "-.")
_MANY_POINTS: Final = 60
_BROKEN: _Dashes = ("--", ":")
_DOTTED: _Dashes = (":", (0, (1, 3)))


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
        Data in SI. Curves that are not to be drawn are omitted.
    """
    with drawing(ax, _SIZE) as axes:
        if panel.log_x:
            axes.set_xscale("log")
        if panel.log_y:
            axes.set_yscale("log")
        shown = [curve for curve in panel.curves if curve.drawn]
        for curve, (colour, dash) in zip(shown, _looks(shown), strict=True):
            _draw(axes, curve, colour, dash, floor=panel.floor)
        finish(axes, x=panel.x, y=panel.y)
        axes.set_title(typeset(panel.title))
        return axes


def _looks(curves: Sequence[Curve]) -> list[tuple[str, LineStyleType]]:
    """Return colour and dash of every curve: that of its look, or else the next of the palette."""
    found = []
    for number, curve in enumerate(curves):
        dashes = {"dashed": _BROKEN, "dotted": _DOTTED}.get(curve.kind, _SOLID)
        turn, place = divmod(number if curve.look is None else curve.look, len(PALETTE))
        reference = curve.look == REFERENCE
        found.append((NEUTRAL, dashes[0]) if reference else (PALETTE[place], dashes[turn % len(dashes)]))
    return found


def _draw(ax: Axes, curve: Curve, colour: str, dash: LineStyleType, *, floor: float | None) -> None:
    x, y = (np.asarray(values, dtype=float) for values in (curve.x, curve.y))
    if floor is not None:
        y = np.where(y >= floor, y, np.nan)
    label = typeset(curve.label)
    if curve.upper is not None:
        upper = np.asarray(curve.upper, dtype=float)
        ax.fill_between(x, y, upper, color=colour, alpha=0.22, linewidth=0, label=label)
        for edge in (y, upper):
            ax.plot(x, edge, color=colour, linewidth=0.7)
    elif curve.kind == "points":
        many = (
            x.size > _MANY_POINTS
        )  # samples of a recording: faint, so that the line of a model shows on them
        size, strength = (2.5, 0.35) if many else (4.0, 1.0)
        ax.plot(
            x, y, color=colour, label=label, linestyle="none", marker="o", markersize=size, alpha=strength
        )
    else:
        ax.plot(x, y, color=colour, label=label, linestyle=dash)
