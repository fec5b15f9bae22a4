"""Sobol indices as bars with intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.view.style import COLOURS, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from electrovib.study.sensitivity import Sensitivity

_WIDTH: Final = 7.2
_HEIGHT_OF_INPUT: Final = 0.42
"""Height of the two bars of an input [inch]."""
_BAR: Final = 0.36
"""Height of a bar over the distance of the inputs."""


def indices(found: Sensitivity, *, ax: Axes | None = None) -> Axes:
    """Draw the first-order and the total index of every input, with 95 % intervals.

    Parameters
    ----------
    found : Sensitivity
        Result of `electrovib.sensitivity`.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        The largest total index on top.
    """
    with drawing(ax, size_of(found)) as axes:
        places = np.arange(len(found.indices), dtype=float)
        kinds = (
            ("total index", -_BAR / 2, COLOURS[0], [(e.total, e.total_interval) for e in found.indices]),
            ("first-order index", _BAR / 2, COLOURS[4], [(e.first, e.first_interval) for e in found.indices]),
        )
        for label, shift, colour, values in kinds:
            numbers = [value for value, _ in values]
            axes.barh(places + shift, numbers, height=_BAR, color=colour, label=label)
            for place, (_, ends) in zip(places + shift, values, strict=True):
                axes.plot(ends, (place, place), color="#222222", linewidth=1.0)
        axes.set_yticks(places, [each.name for each in found.indices])
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("Sobol index (lines: 95 % intervals)")
        axes.set_xlim(left=min(0.0, axes.get_xlim()[0]))
        axes.legend(loc="lower right")
        axes.set_title(f"Variance of {found.quantity.replace('_', ' ')}")
        return axes


def size_of(found: Sensitivity) -> tuple[float, float]:
    """Return width and height of the figure of `indices` [inch]."""
    return _WIDTH, 1.1 + _HEIGHT_OF_INPUT * len(found.indices)
