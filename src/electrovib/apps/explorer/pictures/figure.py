"""A plot as a table for Plotly: curves in one prefixed unit, axes with words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.limits import SHOWN_SAMPLES
from electrovib.view.style import COLOURS
from electrovib.view.units import prefix_for, pretty_unit

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

PINNED: Final = ("dash", "dot", "dashdot", "longdash")
"""Dashes of the curves that are kept for comparison."""
DIGITS: Final = 5
"""Significant digits of the numbers that are sent."""
_LOWEST: Final = 1e-4
"""Part of the largest value below which a logarithmic axis does not begin by itself."""


@dataclass(frozen=True)
class PlottedCurve:
    """A line of a plot.

    Parameters
    ----------
    x, y : array_like, shape (n,)
        In SI.
    name : str
        In the legend; curves of the same name share an entry.
    colour : str
        As ``#rrggbb``.
    dash : str
        As Plotly calls it.
    fill_from : array_like, shape (n,), optional
        Lower edge of a band whose upper edge is `y`; the band is filled and has no line.
    """

    x: ArrayLike
    y: ArrayLike
    name: str
    colour: str = COLOURS[0]
    dash: str = "solid"
    fill_from: ArrayLike | None = None


@dataclass(frozen=True)
class Axis:
    """Words, unit and scale of an axis.

    Parameters
    ----------
    words, unit : str
        What it shows, and the SI unit of the data.
    is_logarithmic : bool
        Scale.
    """

    words: str
    unit: str
    is_logarithmic: bool = False


def figure(title: str, x: Axis, y: Axis, curves: Sequence[PlottedCurve]) -> dict[str, Any]:
    """Make the table of a plot.

    Parameters
    ----------
    title : str
        Heading, also the accessible name of the plot.
    x, y : Axis
        Axes.
    curves : sequence of PlottedCurve
        Lines and bands, in SI.

    Returns
    -------
    dict
        Tables ``data``, ``layout`` and ``config`` for Plotly, without colours of the page.
    """
    x_unit, x_scale = _unit(x, [each.x for each in curves])
    y_unit, y_scale = _unit(y, [each.y for each in curves])
    data: list[dict[str, Any]] = []
    named: set[str] = set()
    for each in curves:
        data += _lines(each, x_scale, y_scale, show=each.name not in named)
        named.add(each.name)
    return {
        "data": data,
        "layout": {
            "title": {"text": title, "x": 0.02, "font": {"size": 14}},
            "xaxis": _axis(x, x_unit),
            "yaxis": _axis(y, y_unit) | _range(y, curves, y_scale),
            "margin": {"l": 62, "r": 12, "t": 34, "b": 44},
            "legend": {
                "orientation": "h",
                "x": 1,
                "xanchor": "right",
                "y": 1.0,
                "yanchor": "bottom",
                "bgcolor": "rgba(0,0,0,0)",
                "font": {"size": 11},
            },
            "showlegend": len(named) > 1,
            "uirevision": title,
            "hovermode": "x",
        },
        "config": {"displaylogo": False, "responsive": True, "displayModeBar": False},
    }


def thinned(x: NDArray[Any], y: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Keep the lowest and the highest point of each stretch of a curve, `SHOWN_SAMPLES` at most, and both ends."""
    if len(x) <= SHOWN_SAMPLES:
        return x, y
    size = -(-len(y) // (SHOWN_SAMPLES // 2 - 1))
    rows = np.concatenate([y, np.full(-len(y) % size, y[-1])]).reshape(-1, size)
    start = np.arange(len(rows)) * size
    places = np.concatenate(
        [[0, len(x) - 1], start + np.argmin(rows, axis=1), start + np.argmax(rows, axis=1)]
    )
    places = np.unique(places[places < len(x)])
    return x[places], y[places]


def _lines(curve: PlottedCurve, x_scale: float, y_scale: float, *, show: bool) -> list[dict[str, Any]]:
    x, y = thinned(np.asarray(curve.x, dtype=float), np.asarray(curve.y, dtype=float))
    line = {
        "type": "scatter",
        "mode": "lines",
        "x": _numbers(x / x_scale),
        "y": _numbers(y / y_scale),
        "name": curve.name,
        "legendgroup": curve.name,
        "showlegend": show,
        "line": {"color": curve.colour, "dash": curve.dash, "width": 1.8},
    }
    if curve.fill_from is None:
        return [line]
    edge = {
        **line,
        "x": _numbers(np.asarray(curve.x, dtype=float) / x_scale),
        "showlegend": False,
        "line": {"width": 0},
    }
    lower = {**edge, "y": _numbers(np.asarray(curve.fill_from, dtype=float) / y_scale), "hoverinfo": "skip"}
    upper = {
        **edge,
        "y": _numbers(np.asarray(curve.y, dtype=float) / y_scale),
        "fill": "tonexty",
        "fillcolor": _faint(curve.colour),
        "showlegend": show,
        "hoverinfo": "skip",
    }
    return [lower, upper]


def _numbers(values: NDArray[Any]) -> tuple[float | None, ...]:
    """Round to a few digits, so that little is sent; numbers that are not finite become gaps.

    The framework watches every item of a list for changes, which takes longer than the simulation; a tuple is sent as it is.
    """
    finite = np.isfinite(values)
    sizes = np.abs(np.where(finite & (values != 0), values, 1.0))
    places = DIGITS - 1 - np.floor(np.log10(sizes))
    up, down = (
        10.0 ** np.clip(places, 0, 300),
        10.0 ** np.clip(-places, 0, 300),
    )  # exact, so that few digits are written
    rounded = np.round(np.where(finite, values, 0.0) * up / down) / up * down
    if finite.all():
        return tuple(rounded.tolist())
    return tuple(
        value if kept else None for value, kept in zip(rounded.tolist(), finite.tolist(), strict=True)
    )


def _unit(axis: Axis, data: Sequence[ArrayLike]) -> tuple[str, float]:
    """Return the unit of the label and its size: one prefix for the whole axis, none on a logarithmic one."""
    sizes = [float(np.nanmax(np.abs(each), initial=0.0)) for each in map(np.asarray, data) if each.size]
    largest = max((each for each in sizes if math.isfinite(each)), default=0.0)
    prefix, scale = ("", 1.0) if axis.is_logarithmic else prefix_for(largest, axis.unit)
    return pretty_unit(f"{prefix}{axis.unit}" if axis.unit != "1" else "1"), scale


def _axis(axis: Axis, unit: str) -> dict[str, Any]:
    shown: dict[str, Any] = {
        "title": {"text": f"{axis.words} [{unit}]" if unit else axis.words, "standoff": 6},
        "zeroline": False,
        "ticks": "outside",
        "automargin": True,
    }
    if axis.is_logarithmic:
        shown |= {"type": "log", "exponentformat": "power", "dtick": 1 if axis.unit == "Hz" else None}
    return shown


def _range(axis: Axis, curves: Sequence[PlottedCurve], scale: float) -> dict[str, Any]:
    """Keep a logarithmic axis from decades of values that are almost zero, and a linear one from showing rounding."""
    values = np.concatenate([np.ravel(np.asarray(each.y, dtype=float)) for each in curves] or [np.zeros(1)])
    values = values[np.isfinite(values)]
    if not values.size:
        return {}
    low, high = float(values.min()), float(values.max())
    if axis.is_logarithmic:
        if high <= 0:
            return {}
        floor = max(float(values[values > 0].min()), _LOWEST * high)
        return {"range": [math.log10(floor) - 0.1, math.log10(high) + 0.15]}
    if high - low > 1e-6 * max(abs(low), abs(high)):
        return {}
    size = max(abs(low), abs(high)) or 1.0
    return {"range": [(low - 0.2 * size) / scale, (high + 0.2 * size) / scale]}


def _faint(colour: str) -> str:
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    return f"rgba({red},{green},{blue},0.22)"
