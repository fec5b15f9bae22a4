"""Largest constant force by a slow voltage and by a carrier, over the frequency of the carrier."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.view.style import COLOURS, drawing
from electrovib.view.units import label_axis, pretty_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from electrovib.study.design.drive import HeldForce

_INSET: Final = 0.02
"""Distance of words from the left edge, over the width of the axes; the curves fall to the right."""
_ROOM: Final = 3.0
"""Largest value of the axis over the largest force."""


def held_force(found: HeldForce, *, ax: Axes | None = None) -> Axes:
    """Draw the largest constant force within limits over the frequency of the carrier, and that of a slow voltage.

    Parameters
    ----------
    found : HeldForce
        Result of `electrovib.study.design.drive.held_force`.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Logarithmic, with a curve for each stray capacitance and a line for the slow voltage.
    """
    with drawing(ax) as axes:
        for colour, (stray, force) in zip(COLOURS, found.forces.items(), strict=False):
            words = f"{pretty_quantity(stray, 'F', digits=3)} stray" if stray else "no stray capacitance"
            axes.loglog(found.carriers, force, color=colour, label=f"carrier, {words}")
        axes.axhline(found.direct, color="#222222", linestyle="--")
        long = pretty_quantity(found.duration, "s", digits=3)
        level = pretty_quantity(found.direct, "N", digits=3)
        axes.text(
            _INSET,
            1.15 * found.direct,
            f"slow voltage, held for {long}: {level}",
            transform=axes.get_yaxis_transform(),
            ha="left",
            va="bottom",
        )
        highest = max(float(np.max(force)) for force in found.forces.values())
        axes.set_ylim(found.direct / _ROOM, _ROOM * highest)
        axes.set_xlim(found.carriers[0], found.carriers[-1])
        volts, amperes = (
            pretty_quantity(found.limits[name], unit, digits=3)
            for name, unit in (("voltage", "V"), ("current", "A"))
        )
        axes.set_title(f"Largest constant force within {volts} and {amperes}")
        label_axis(axes.xaxis, "frequency of the carrier", "Hz")
        label_axis(axes.yaxis, "mean electrostatic force", "N")
        axes.legend(loc=(_INSET, 0.2))
        return axes
