"""A friction force whose change is seen against the whole of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.physics.time_profile import Steady
from electrovib.view.lines import scenario_or_none
from electrovib.view.style import NEUTRAL
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray
    from matplotlib.axes import Axes

SMALL: Final = 0.2
"""Share of the whole below which a change has an axis of its own, with a second one in percent of the whole."""
_SAME: Final = 0.01
_CONSTANT: Final = 1e-6


def friction_of_the_load(trace: xarray.Dataset) -> float | None:
    """Return the friction of the steady load without any attraction [N]; None where it is not a single number."""
    scenario = scenario_or_none(trace)
    if scenario is None or not isinstance(scenario.load.time_profile, Steady):
        return None
    law = scenario.friction.without_memory()
    if law.needs_real_area or any(str(path).startswith(("friction.", "load.")) for path in trace.dims):
        return None
    pressed, nothing = np.array([scenario.load.normal_force]), np.zeros(1)
    return float(law.lateral_force(pressed, nothing, nothing)[0])


def against_the_whole(ax: Axes, loads: Sequence[float | None]) -> float:
    """Set the vertical axis of a friction force, and return the value from which it counts [N].

    A force that changes by a fifth of itself or more is drawn from 0, with the friction of the load as a
    dashed line. A smaller change is drawn above its smallest value, and a second axis states it in percent of
    that value. A force of both signs is drawn as it is.
    """
    low, high = (float(bound) for bound in ax.yaxis.get_data_interval())
    if not (np.isfinite(low) and np.isfinite(high)) or low < 0 or high <= 0:
        return 0.0
    known = set(loads)
    load = known.pop() if len(known) == 1 else None
    change = high - low
    if change < _CONSTANT * high or change >= SMALL * high:
        ax.set_ylim(0.0, 1.1 * high, auto=None)
        if load:
            _mark(ax, load, "friction of the load")
        return 0.0
    of_the_load = load is not None and abs(load - low) <= _SAME * change
    ax.set_ylim(low - 0.12 * change, low + 1.15 * change, auto=None)
    ax.yaxis.set_major_locator(_from(low))
    _mark(ax, low, "friction of the load" if of_the_load else "smallest value")
    _in_percent(ax, low)
    return low


def _mark(ax: Axes, force: float, words: str) -> None:
    """Mark a force by a dashed line with its name."""
    ax.axhline(force, color=NEUTRAL, linestyle=(0, (4, 3)), linewidth=0.9, zorder=1.5)
    ax.annotate(
        f"{words}, {pretty_quantity(force, 'N', digits=4)}",
        (1.0, force),
        xycoords=("axes fraction", "data"),
        xytext=(-2, -2),
        textcoords="offset points",
        ha="right",
        va="top",
        fontsize=7.0,
        color="#5a5a5a",
    )


def _in_percent(ax: Axes, whole: float) -> None:
    """Add a second vertical axis, in percent of the whole."""

    def share(force: Any) -> Any:
        return 100 * (force / whole - 1)

    def force(share: Any) -> Any:
        return whole * (1 + share / 100)

    axis = ax.secondary_yaxis("right", functions=(share, force))
    axis.set_ylabel(f"in % of {pretty_quantity(whole, 'N', digits=4)}")
    axis.spines["right"].set_visible(True)


def _from(base: float) -> Any:
    """Return a locator of round numbers counted from a base."""
    from matplotlib.ticker import MaxNLocator

    class FromBase(MaxNLocator):
        def tick_values(self, vmin: float, vmax: float) -> Any:
            return np.asarray(super().tick_values(vmin - base, vmax - base)) + base

    return FromBase(nbins=6, steps=[1, 2, 2.5, 5, 10])
