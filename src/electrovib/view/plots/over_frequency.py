"""Signals over frequency."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.signals import signal
from electrovib.view.lines import Line, Traces, has, left_out, lines
from electrovib.view.plots.draw import draw, finish, logarithmic_if_wide
from electrovib.view.style import drawing

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes

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
