"""Signals over frequency, and a quantity of a sweep over what was swept: a curve over one parameter, a map over two."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, nearest
from electrovib.core.paths import words_at
from electrovib.core.signals import signal
from electrovib.view.lines import (
    WIDE,
    Line,
    Traces,
    draw,
    finish,
    has,
    left_out,
    lines,
    logarithmic_if_wide,
    scenario_or_none,
    swept_units,
)
from electrovib.view.style import AMOUNTS, COLOURS, drawing, label_axis, pretty_quantity
from electrovib.view.summary import is_sweep, quantities_of

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

_FREQUENCY = ("frequency $f$", "Hz")


def frequency_response(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the mean attraction under one sine of the drive's peak voltage, over its frequency.

    Parameters
    ----------
    traces : Trace, sequence of Trace or mapping of str to Trace
        One or several; a swept Trace draws one curve for each value, at most five.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in Hz and N; vertical axis logarithmic where the force spans more than a factor of 30.

    Raises
    ------
    InputError
        If no Trace has the signal.

    Examples
    --------
    >>> ev.plot.frequency_response(ev.simulate("vezzoli_2014/fig6")).get_xlabel()
    'frequency $f$ [Hz]'
    """
    return _over_frequency(traces, "mean_force", np.real, _words("mean_force"), "N", ax)


def gain(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the effective voltage per volt of the drive, over frequency.

    Parameters
    ----------
    traces, ax
        As for `frequency_response`. Where no law has an effective voltage, the voltage across every layer is drawn.

    Returns
    -------
    Axes
        Magnitude, a pure number.

    Raises
    ------
    InputError
        If no Trace has either signal.

    Examples
    --------
    >>> ev.plot.gain(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'effective voltage gain $|v_e/v|$'
    """
    name = _gain(traces)
    return _over_frequency(traces, name, np.abs, _words(name, "|{}|"), "1", ax)


def gain_phase(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the phase by which the effective voltage leads the drive, over frequency.

    Parameters
    ----------
    traces, ax
        As for `gain`.

    Returns
    -------
    Axes
        Phase in degrees, -180 to 180.

    Raises
    ------
    InputError
        If no Trace has either signal.

    Examples
    --------
    >>> ev.plot.gain_phase(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'phase of the effective voltage gain $v_e/v$ [°]'
    """
    name = _gain(traces)
    return _over_frequency(traces, name, _degrees, f"phase of the {_words(name)}", "°", ax)


def impedance(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the magnitude of the impedance at the drive, over frequency.

    Parameters
    ----------
    traces, ax
        As for `frequency_response`.

    Returns
    -------
    Axes
        Data in ohm.

    Raises
    ------
    InputError
        If no Trace has the signal.

    Examples
    --------
    >>> ev.plot.impedance(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'impedance $|Z|$ [Ω]'
    """
    return _over_frequency(traces, "impedance", np.abs, "impedance $|Z|$", "ohm", ax)


def impedance_phase(traces: Traces, *, ax: Axes | None = None) -> Axes:
    """Draw the phase of the impedance at the drive, -90 degrees for a capacitor.

    Parameters
    ----------
    traces, ax
        As for `frequency_response`.

    Returns
    -------
    Axes
        Data in degrees, -180 to 180.

    Raises
    ------
    InputError
        If no Trace has the signal.

    Examples
    --------
    >>> ev.plot.impedance_phase(ev.simulate("vezzoli_2014/fig6")).get_ylabel()
    'phase of the impedance $Z$ [°]'
    """
    return _over_frequency(traces, "impedance", _degrees, "phase of the impedance $Z$", "°", ax)


def _gain(traces: Traces) -> str:
    return "effective_voltage_gain" if has(traces, "effective_voltage_gain") else "field_gain"


def _words(name: str, form: str = "{}") -> str:
    """Name a signal with its symbol; ``"|{}|"`` for the magnitude of a complex one."""
    words = {"effective_voltage_gain": "effective voltage gain", "field_gain": "layer voltage gain"}
    return f"{words.get(name, name.replace('_', ' '))} ${form.format(signal(name).symbol)}$"


def _degrees(values: Any) -> Any:
    return np.angle(values, deg=True)


def _over_frequency(
    traces: Traces, name: str, part: Callable[[Any], Any], words: str, unit: str, ax: Axes | None
) -> Axes:
    complex_lines = lines(traces, name, "frequency")
    drawn: list[Line] = [dataclasses.replace(line, y=part(line.y)) for line in complex_lines]
    with drawing(ax) as axes:
        axes.set_xscale("log")
        draw(axes, drawn)
        logarithmic_if_wide(axes)
        finish(axes, x=_FREQUENCY, y=(words, unit), drawn=drawn, note=left_out(traces, name))
        return axes


_MARKED: Final = 60
"""Up to so many values, each is marked."""
_LEVELS: Final = 8
_EVEN: Final = 1e-6
_SHORTEST: Final = 0.06
"""Of a line with a label, over the width of the plot."""
_FINE: Final = 120
"""Values along an axis between which contour lines are drawn straight."""


def quantity(trace: xarray.Dataset, name: str, *, ax: Axes | None = None) -> Axes:
    """Draw a quantity over the parameters that were swept.

    Parameters
    ----------
    trace : xarray.Dataset
        From `electrovib.sweep`; with more than two parameters, choose values of the others with ``trace.isel(...)``.
    name : str
        Of the quantity: ``"mean electrostatic_force"``.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI. Over one parameter a curve, over two a map with labelled contour lines; logarithmic where the values
        of a parameter are evenly spaced in the logarithm, or the quantity spans more than a factor of 30.

    Raises
    ------
    InputError
        If the sweep has no such quantity, or depends on none or more than two parameters.

    Examples
    --------
    >>> swept = ev.sweep("bau_2010/sine", {"drive.amplitude": [40.0, 80.0]})
    >>> ev.plot.quantity(swept, "mean electrostatic_force").get_xlabel()
    'drive voltage [V]'
    """
    known = quantities_of(trace) if is_sweep(trace) else []
    if name not in known:
        raise InputError(f"quantity '{name}': this sweep does not contain it.{nearest(name, known)}")
    values = trace[name].squeeze()
    if values.ndim not in (1, 2):
        several = ", ".join(map(str, values.dims)) or "nothing"
        raise InputError(
            f"quantity '{name}': depends on {several}; a plot has one or two parameters. Choose values of the others with isel"
        )
    with drawing(ax) as axes:
        if values.ndim == 1:
            _curve(axes, trace, values)
        else:
            _map(axes, trace, values)
        return axes


def _curve(ax: Axes, trace: xarray.Dataset, values: xarray.DataArray) -> None:
    path = str(values.dims[0])
    at, numbers = (np.asarray(part, dtype=float) for part in (values[path].values, values.values))
    ax.plot(at, numbers, color=COLOURS[0], marker="o" if len(at) <= _MARKED else "", markersize=3)
    if _geometric(at):
        ax.set_xscale("log")
    finite = numbers[np.isfinite(numbers)]
    if not len(finite):
        ax.text(0.5, 0.5, "no numbers to draw", transform=ax.transAxes, ha="center", va="center")
    elif finite.min() > 0 and finite.max() > WIDE * finite.min():
        ax.set_yscale("log")
    label_axis(ax.xaxis, words_at(scenario_or_none(trace), path), swept_units(trace).get(path, ""))
    label_axis(ax.yaxis, words_at(None, str(values.name)), str(values.attrs.get("units", "")))


def _map(ax: Axes, trace: xarray.Dataset, values: xarray.DataArray) -> None:
    """Draw filled contours with labelled lines between them; the first parameter runs upwards."""
    up, along = (str(dim) for dim in values.dims)
    y, x = (np.asarray(values[path].values, dtype=float) for path in (up, along))
    unit, units = str(values.attrs.get("units", "")), swept_units(trace)
    numbers = np.ma.masked_invalid(np.asarray(values.values, dtype=float))
    for path, axis, scale in ((along, x, ax.set_xscale), (up, y, ax.set_yscale)):
        if _geometric(axis):
            scale("log")
        elif len(axis) < 2:
            raise InputError(f"'{path}': a map needs at least two values")
    ax.grid(visible=False)
    levels = _levels(numbers)
    if levels is None:
        text = (
            "no numbers to draw"
            if not numbers.count()
            else f"{pretty_quantity(float(numbers.mean()), unit, digits=4)} everywhere"
        )
        ax.text(0.5, 0.5, text, transform=ax.transAxes, ha="center", va="center")
        ax.set_xlim(x.min(), x.max())
        ax.set_ylim(y.min(), y.max())
    else:
        _contours(ax, (x, y, numbers), levels, unit)
    ax.dataLim.update_from_data_xy(np.column_stack([[x.min(), x.max()], [y.min(), y.max()]]))
    for path, line in ((along, ax.xaxis), (up, ax.yaxis)):
        label_axis(line, words_at(scenario_or_none(trace), path), units.get(path, ""))
    ax.set_title(words_at(None, str(values.name)) + ("; white: unknown" if np.ma.is_masked(numbers) else ""))


def _contours(ax: Axes, points: tuple[Any, Any, Any], levels: NDArray[np.float64], unit: str) -> None:
    from matplotlib.colors import LogNorm, Normalize

    low, high = float(points[2].min()), float(points[2].max())
    wide = _is_wide(low, high)
    x, y, z = _finer(points, wide=wide)
    filled = np.unique(np.concatenate([[low], levels, [high]]))
    norm = LogNorm(low, high) if wide else Normalize(low, high)
    ax.contourf(x, y, z, levels=filled, norm=norm, cmap=AMOUNTS, alpha=0.55, extend="both")
    drawn = ax.contour(x, y, z, levels=levels, colors="#222222", linewidths=0.8)
    places = [place for lines in drawn.allsegs if lines and (place := _middle(ax, lines)) is not None]
    fmt = {level: pretty_quantity(float(level), unit, digits=3) for level in drawn.levels}
    ax.clabel(drawn, fmt=fmt, fontsize=7.5, manual=places)


def _finer(points: tuple[Any, Any, Any], *, wide: bool) -> tuple[Any, Any, Any]:
    """Interpolate between the computed values, along straight lines on the scales of the drawing."""
    x, y, z = points
    (along, finer_x), (up, finer_y) = (_between(axis) for axis in (x, y))
    known = np.ma.log(z) if wide else z
    rows = np.array([np.interp(finer_x, along, row) for row in known.filled(np.nan)])
    values = np.array([np.interp(finer_y, up, column) for column in rows.T]).T
    drawn_x, drawn_y = (
        np.exp(finer) if _geometric(axis) else finer for axis, finer in ((x, finer_x), (y, finer_y))
    )
    return drawn_x, drawn_y, np.ma.masked_invalid(np.exp(values) if wide else values)


def _between(axis: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the values of an axis on the scale of the drawing, and the finer ones between them."""
    drawn = np.log(axis) if _geometric(axis) else axis
    steps = max(1, -(-_FINE // len(axis)))
    finer = np.interp(np.arange((len(axis) - 1) * steps + 1) / steps, np.arange(len(axis)), drawn)
    return drawn, finer


def _middle(ax: Axes, lines: Any) -> Any:
    """Return the middle, in the drawing, of the longest line of a level; None where it is too short for a label."""
    seen = [ax.transData.transform(line) for line in lines]
    lengths = [np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T))) for line in seen]
    longest = int(np.argmax([length[-1] for length in lengths]))
    if lengths[longest][-1] < _SHORTEST * ax.bbox.width:
        return None
    place = int(np.searchsorted(lengths[longest], lengths[longest][-1] / 2))
    return tuple(lines[longest][min(place, len(lines[longest]) - 1)])


def _levels(numbers: Any) -> NDArray[np.float64] | None:
    """Choose round values for contour lines; None where all values are equal."""
    from matplotlib.ticker import LogLocator, MaxNLocator

    if not numbers.count():
        return None
    low, high = float(numbers.min()), float(numbers.max())
    if high - low <= _EVEN * max(abs(low), abs(high)):
        return None
    if _is_wide(low, high):
        found = np.asarray(LogLocator(numticks=_LEVELS).tick_values(low, high))
        if np.count_nonzero((found > low) & (found < high)) < 4:
            found = np.asarray(LogLocator(subs=(1.0, 2.0, 5.0), numticks=_LEVELS).tick_values(low, high))
    else:
        found = np.asarray(MaxNLocator(_LEVELS).tick_values(low, high))
    inside = found[(found > low) & (found < high)]
    return inside if len(inside) else np.array([(low + high) / 2])


def _is_wide(low: float, high: float) -> bool:
    return low > 0 and high > WIDE * low


def _geometric(values: NDArray[np.float64]) -> bool:
    if len(values) < 3 or np.min(values) <= 0:
        return False
    ratios = np.diff(np.log(values))
    return bool(np.ptp(ratios) < _EVEN * abs(ratios[0]) and abs(ratios[0]) > _EVEN)
