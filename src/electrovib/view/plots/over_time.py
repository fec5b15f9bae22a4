"""Signals over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.signals import signal
from electrovib.physics.time_profile import Steady
from electrovib.scenario import scenario_of
from electrovib.view.lines import (
    Line,
    Traces,
    draw,
    finish,
    labelled,
    left_out,
    lines,
    lines_of,
    scenario_or_none,
)
from electrovib.view.style import NEUTRAL, drawing, pretty_quantity
from electrovib.view.summary import not_known

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray
    from matplotlib.axes import Axes

_TIME = ("time $t$", "s")
_OF_SLIDING = ("lateral_force", "lateral_force_measured")
"""Signals that are NaN where they stand on a friction at rest."""


def drive(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the voltage of the drive over time.

    Parameters
    ----------
    traces : Trace, sequence of Trace or mapping of str to Trace
        One or several, computed or measured; a swept Trace draws one curve for each value, at most five.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI; the unit in the label of an axis has a prefix.

    Raises
    ------
    InputError
        If no Trace has the signal.

    Examples
    --------
    >>> ev.plot.drive(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'drive voltage $v$ [kV]'
    """
    return _over_time(traces, "drive_voltage", ax)


def effective_voltage(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the effective voltage, the part of the voltage that attracts the finger, for laws that have one.

    Parameters
    ----------
    traces, ax
        As for `drive`.

    Returns
    -------
    Axes
        Data in V.

    Raises
    ------
    InputError
        If no Trace has the signal; `layer_voltages` can be drawn for every law.

    Examples
    --------
    >>> ev.plot.effective_voltage(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'effective voltage $v_e$ [V]'
    """
    return _over_time(traces, "effective_voltage", ax)


def force(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the electrostatic attraction over time.

    Parameters
    ----------
    traces, ax
        As for `drive`.

    Returns
    -------
    Axes
        Data in N.

    Raises
    ------
    InputError
        If no Trace has the signal.

    Examples
    --------
    >>> ev.plot.force(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'electrostatic force $f_e$ [mN]'
    """
    return _over_time(traces, "electrostatic_force", ax)


def lateral_force(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the friction force over time, so that its change can be compared with the whole.

    Parameters
    ----------
    traces, ax
        As for `drive`.

    Returns
    -------
    Axes
        Data in N. A force that changes by a fifth of itself or more is drawn from 0, with the friction of the load as a
        dashed line. A smaller change is drawn above its smallest value, with a second axis in percent of that value.

    Raises
    ------
    InputError
        If no Trace has the signal.

    Examples
    --------
    >>> ev.plot.lateral_force(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'lateral force $f_t$ above 250 mN [mN]'
    """
    return _over_time(traces, "lateral_force", ax)


def field(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the electric field of every layer over time.

    Parameters
    ----------
    traces, ax
        As for `drive`; one line a layer.

    Returns
    -------
    Axes
        Data in V/m.

    Raises
    ------
    InputError
        If no Trace has the signal.

    Examples
    --------
    >>> ev.plot.field(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'field $E$ [MV/m]'
    """
    return _over_time(traces, "field", ax)


def current(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the current into the contact over time, displacement current included.

    Parameters
    ----------
    traces, ax
        As for `drive`.

    Returns
    -------
    Axes
        Data in A.

    Raises
    ------
    InputError
        If no Trace has the signal.

    Examples
    --------
    >>> ev.plot.current(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'current $i$ [nA]'
    """
    return _over_time(traces, "current", ax)


def over_time(traces: Traces, name: str, *, ax: Axes | None = None) -> Axes:
    """Draw any signal over time: gap, measured forces, skin displacement, current of the amplifier.

    Parameters
    ----------
    traces : Trace, sequence of Trace or mapping of str to Trace
        As for `drive`.
    name : str
        Of the signal.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI.

    Raises
    ------
    ElectrovibError
        If there is no signal of this name, or no Trace has it.

    Examples
    --------
    >>> ev.plot.over_time(ev.simulate("vezzoli_2014/fig6"), "current").get_ylabel()
    'current $i$ [nA]'
    """
    return _over_time(traces, name, ax)


def layer_voltages(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the voltage across each layer: its field times its thickness.

    Parameters
    ----------
    traces, ax
        As for `drive`; Traces without a field, or without a scenario that gives the thicknesses, are omitted.

    Returns
    -------
    Axes
        Data in V.

    Raises
    ------
    InputError
        If no Trace has both.

    Examples
    --------
    >>> ev.plot.layer_voltages(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'layer voltage [kV]'
    """
    known = labelled(traces)
    arrays = {label: _voltages(trace) for label, trace in known.items() if has_layer_voltages(trace)}
    if not arrays:
        raise InputError(
            "no Trace has both the signal 'field' and a scenario with the thicknesses of its layers"
        )
    drawn = lines_of(arrays, "time", known)
    return _draw(drawn, "layer voltage", "V", ax, note=left_out(traces, "field"))


def has_layer_voltages(trace: xarray.Dataset) -> bool:
    """Return whether a Trace has fields and a scenario with all their layers."""
    scenario = scenario_or_none(trace)
    if "field" not in trace or scenario is None:
        return False
    return all(str(name) in scenario.stack.layers for name in trace["layer"].values)


def _voltages(trace: xarray.Dataset) -> xarray.DataArray:
    """Multiply the field of each layer by its thickness, swept or fixed."""
    import xarray

    layers = scenario_of(trace).stack.layers
    parts = []
    for name in trace["layer"].values:
        path = f"stack.{name}.thickness"
        thickness = trace[path] if path in trace.dims else layers[str(name)].thickness
        if name == "gap" and "gap" in trace:
            thickness = trace["gap"]  # it moves
        parts.append(trace["field"].sel(layer=name) * thickness)
    joined = xarray.concat(parts, dim="layer", coords="minimal", compat="override")
    return joined.assign_coords(layer=trace["layer"])


def _over_time(traces: Traces, name: str, ax: Axes | None) -> Axes:
    drawn = lines(traces, name, "time")
    known = signal(name)
    words = f"{name.replace('_', ' ')} ${known.symbol}$"
    note = left_out(traces, name)
    if name not in _OF_SLIDING:
        return _draw(drawn, words, known.unit, ax, note=note)
    found = [trace for trace in labelled(traces).values() if name in trace]
    axes = _draw(
        drawn, words, known.unit, ax, note=note, loads=[friction_of_the_load(each) for each in found]
    )
    if any(not_known(trace, name) for trace in found):
        axes.text(
            0.5, 0.98, "not known where the finger rests", transform=axes.transAxes, ha="center", va="top"
        )
    return axes


def _draw(
    drawn: list[Line],
    words: str,
    unit: str,
    ax: Axes | None,
    *,
    note: str = "",
    loads: Sequence[float | None] | None = None,
) -> Axes:
    with drawing(ax) as axes:
        draw(axes, drawn)
        base = 0.0 if loads is None else against_the_whole(axes, loads)
        above = f" above {pretty_quantity(base, unit, digits=4)}" if base else ""
        finish(axes, x=_TIME, y=(f"{words}{above}", unit), base=base, drawn=drawn, note=note)
        return axes


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
            _mark(ax, load, "of the load")
        return 0.0
    of_the_load = load is not None and abs(load - low) <= _SAME * change
    ax.set_ylim(low - 0.12 * change, low + 1.15 * change, auto=None)
    ax.yaxis.set_major_locator(_from(low))
    _mark(ax, low, "of the load" if of_the_load else "smallest value")
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
