"""Signals over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.errors import InputError
from electrovib.core.signals import signal
from electrovib.view.lines import Line, Traces, labelled, lines, lines_of, signals, total_lines
from electrovib.view.plots.draw import draw, finish
from electrovib.view.style import drawing

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

_TIME = ("time $t$", "s")


def drive(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the voltage of the drive over time.

    Parameters
    ----------
    traces : Trace, sequence of Trace or mapping of str to Trace
        One or several, computed or measured; a swept Trace draws one line a value, at most 12.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI; the numbers at the axes have a prefix.

    Raises
    ------
    InputError
        If no Trace has the signal.
    """
    return _over_time(traces, "drive_voltage", ax)


def effective_voltage(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the part of the voltage that pulls the finger, for laws that have one.

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
        If no Trace has the signal: `layer_voltages` shows what every law has.
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
    """
    return _over_time(traces, "electrostatic_force", ax)


def lateral_force(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the friction force over time.

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
    """
    return _over_time(traces, "current", ax)


def layer_voltages(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw how the voltage divides over the layers: field times thickness of each.

    Parameters
    ----------
    traces, ax
        As for `drive`; Traces without field or without a scenario, which knows the thicknesses, are left out.

    Returns
    -------
    Axes
        Data in V.

    Raises
    ------
    InputError
        If no Trace has both.
    """
    known = labelled(traces)
    arrays = {label: found for label, trace in known.items() if (found := _voltages(trace)) is not None}
    if not arrays:
        raise InputError("no Trace has both the signal 'field' and a scenario with the thicknesses of its layers")
    drawn = lines_of(arrays, "time", known)
    hidden = total_lines(arrays.values()) - len(drawn)
    return _draw(drawn, "layer voltage", "V", ax, hidden=hidden)


def _voltages(trace: xarray.Dataset) -> xarray.DataArray | None:
    """Multiply the field of each layer by its thickness, swept or fixed."""
    if "field" not in trace or "scenario" not in trace.attrs:
        return None
    import xarray

    from electrovib.solve.scenario import scenario_of

    layers = scenario_of(trace).stack.layers
    parts = []
    for name in trace["layer"].values:
        path = f"stack.{name}.thickness"
        thickness = trace[path] if path in trace.dims else layers[str(name)].thickness
        parts.append(trace["field"].sel(layer=name) * thickness)
    return xarray.concat(parts, dim="layer", coords="minimal", compat="override").assign_coords(layer=trace["layer"])


def _over_time(traces: Traces, name: str, ax: Axes | None) -> Axes:
    drawn = lines(traces, name, "time")
    known = signal(name)
    words = f"{name.replace('_', ' ')} ${known.symbol}$"
    hidden = total_lines(signals(traces, name)) - len(drawn)
    return _draw(drawn, words, known.unit, ax, hidden=hidden)


def _draw(drawn: list[Line], words: str, unit: str, ax: Axes | None, *, hidden: int = 0) -> Axes:
    with drawing(ax) as axes:
        draw(axes, drawn)
        finish(axes, x=_TIME, y=(words, unit), drawn=drawn, hidden=hidden)
        return axes
