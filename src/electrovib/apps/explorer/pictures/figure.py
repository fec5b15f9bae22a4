"""A plot as a table for Plotly: curves in one prefixed unit, axes with words, scale and ticks."""

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

    from electrovib.apps.explorer.computed import Computed


PINNED: Final = ("dash", "dot", "dashdot", "longdash")
"""Dashes of the curves that are kept for comparison."""
LAYER_DASHES: Final = ("solid", "dash", "dot", "dashdot")
"""Dashes of the curves of layers, from the plate on: one that coincides with another one hides nothing."""
DIGITS: Final = 5
"""Significant digits of the numbers that are sent."""
_POWERS: Final = np.array([float(f"1e{power}") for power in range(301)])
"""Powers of ten, exact where a number can be, so that few digits are written."""
_LEGEND: Final = 520.0
"""Width of a row of the legend, in points; a letter takes about 6.2, a line 48."""


@dataclass(frozen=True)
class PlottedCurve:
    """A line of a plot, with `x` and `y` (n,) in SI.

    Curves of the same `name` share an entry of the legend; the text on hover always has it. `colour` is
    ``#rrggbb``, `dash` as Plotly calls it. `fill_from` (n,) is the lower edge of a band whose upper edge is
    `y`; the band is filled and has no line.
    """

    x: ArrayLike
    y: ArrayLike
    name: str
    colour: str = COLOURS[0]
    dash: str = "solid"
    fill_from: ArrayLike | None = None
    width: float = 1.8
    in_legend: bool = True


def figure(title: str, x: Axis, y: Axis, curves: Sequence[PlottedCurve]) -> dict[str, Any]:
    """Make the tables ``data``, ``layout`` and ``config`` of a plot for Plotly, without colours of the page.

    The title is also the accessible name of the plot.
    """
    x_unit, x_scale = unit_of(x, [each.x for each in curves])
    y_unit, y_scale = unit_of(y, _heights(curves))
    data: list[dict[str, Any]] = []
    named: set[str] = set()
    for each in curves:
        data += _lines(each, x_scale, y_scale, y_unit, show=each.in_legend and each.name not in named)
        if each.in_legend:
            named.add(each.name)
    return {
        "data": data,
        "layout": {
            "title": {"text": title, "x": 0.02, "y": 0.98, "yanchor": "top", "font": {"size": 14}},
            "xaxis": axis_table(x, x_unit, span(x, [each.x for each in curves])),
            "yaxis": axis_table(y, y_unit, span(y, _heights(curves))) | _range(y, curves, y_scale),
            "margin": {"l": 62, "r": 12, "t": 30, "b": 44 + (18 * _rows(named) if len(named) > 1 else 0)},
            "legend": {
                "orientation": "h",
                "x": 0,
                "xanchor": "left",
                "y": 0,
                "yref": "container",
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


def with_kept(shown: Computed, pinned: Sequence[Computed]) -> list[tuple[Computed, str, str]]:
    """Return the present result and those that are kept, each with its dash and with what follows the name of its curves."""
    kept = [
        (each, dash, f", kept {place}")
        for place, (each, dash) in enumerate(zip(pinned, PINNED, strict=False), 1)
    ]
    return [(shown, "solid", ""), *kept]


def _heights(curves: Sequence[PlottedCurve]) -> list[ArrayLike]:
    """Return what the vertical axis covers: all curves, and the lower edges of bands."""
    return [y for each in curves for y in (each.y, each.fill_from) if y is not None]


def _rows(names: set[str]) -> int:
    """Estimate the rows of a legend."""
    return math.ceil(sum(48 + 6.2 * len(name) for name in names) / _LEGEND)


def thinned(x: NDArray[Any], y: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Keep the lowest and the highest point of each stretch of a curve, `SHOWN_SAMPLES` at most, and both ends."""
    if len(x) <= SHOWN_SAMPLES:
        return x, y
    size = -(-len(y) // (SHOWN_SAMPLES // 2 - 1))
    rows = np.concatenate([y, np.full(-len(y) % size, y[-1])]).reshape(-1, size)
    start = np.arange(len(rows)) * size
    ends = np.sort([start + np.argmin(rows, axis=1), start + np.argmax(rows, axis=1)], axis=0)
    places = np.minimum(np.concatenate([[0], ends.T.ravel(), [len(x) - 1]]), len(x) - 1)
    places = places[np.append(True, places[1:] > places[:-1])]
    return x[places], y[places]


def _lines(
    curve: PlottedCurve, x_scale: float, y_scale: float, unit: str, *, show: bool
) -> list[dict[str, Any]]:
    x, y = thinned(np.asarray(curve.x, dtype=float), np.asarray(curve.y, dtype=float))
    line = {
        "type": "scatter",
        "mode": "lines",
        "x": _numbers(x / x_scale),
        "y": _numbers(y / y_scale),
        "name": curve.name,
        "legendgroup": curve.name,
        "showlegend": show,
        "line": {"color": curve.colour, "dash": curve.dash, "width": curve.width, "simplify": False},
        "hovertemplate": f"%{{y:.4~g}} {unit}<extra>{curve.name}</extra>",
    }
    if curve.fill_from is None:
        return [line]
    edge = {
        **line,
        "x": _numbers(np.asarray(curve.x, dtype=float) / x_scale),
        "showlegend": False,
        "line": {"width": 0},
        "hovertemplate": None,
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
    is_whole = bool(finite.all())
    known = values if is_whole else np.where(finite, values, 0.0)
    sizes = np.abs(known)
    span = float(np.ptp(known if is_whole else values[finite])) if finite.any() else 0.0
    if span:
        sizes = np.minimum(sizes, span)  # a small change of a large value stays smooth
    places = DIGITS - 1 - np.floor(np.log10(np.where(sizes > 0, sizes, 1.0))).astype(int)
    up, down = _POWERS[np.clip(places, 0, 300)], _POWERS[np.clip(-places, 0, 300)]
    rounded = np.round(known * up / down) / up * down
    if is_whole:
        return tuple(rounded.tolist())
    return tuple(
        value if kept else None for value, kept in zip(rounded.tolist(), finite.tolist(), strict=True)
    )


def _range(axis: Axis, curves: Sequence[PlottedCurve], scale: float) -> dict[str, Any]:
    """Keep a logarithmic axis from decades of values that are almost zero, and a linear one from showing rounding."""
    drawn = [np.asarray(each, dtype=float).ravel() for each in _heights(curves)]
    values = np.concatenate(drawn or [np.zeros(1)])
    values = values[np.isfinite(values)]
    if not values.size:
        return {}
    low, high = float(values.min()), float(values.max())
    if axis.is_logarithmic:
        if high <= 0:
            return {}
        floor = max(float(values[values > 0].min()), axis.lowest * high)
        return {"range": [math.log10(floor / scale) - 0.1, math.log10(high / scale) + 0.15]}
    if high - low > 1e-6 * max(abs(low), abs(high)):
        return {}
    size = max(abs(low), abs(high)) or 1.0
    return {"range": [(low - 0.2 * size) / scale, (high + 0.2 * size) / scale]}


def _faint(colour: str) -> str:
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    return f"rgba({red},{green},{blue},0.22)"


_LOWEST: Final = 1e-6
"""Part of the largest value below which a logarithmic axis does not begin by itself."""
_FEW_DECADES: Final = 3.0
"""Decades up to which a logarithmic axis has plain numbers in a prefixed unit, and above which it has powers of ten."""


@dataclass(frozen=True)
class Axis:
    """Words, SI unit and scale of an axis.

    `lowest` is the part of the largest value below which a logarithmic axis does not begin.
    """

    words: str
    unit: str
    is_logarithmic: bool = False
    lowest: float = _LOWEST


def unit_of(axis: Axis, data: Sequence[ArrayLike]) -> tuple[str, float]:
    """Return the unit of a label, with its prefix, and its size in SI, by which data are divided.

    One prefix holds for the whole axis, none where it has powers of ten; the unit of a pure number is empty.
    """
    largest = max((high for low, high in map(_ends, data)), default=0.0)
    has_powers = axis.is_logarithmic and (axis.unit == "Hz" or span(axis, data) > _FEW_DECADES)
    prefix, scale = ("", 1.0) if has_powers else prefix_for(largest, axis.unit)
    return pretty_unit(f"{prefix}{axis.unit}" if axis.unit != "1" else "1"), scale


def _ends(values: ArrayLike) -> tuple[float, float]:
    """Return the smallest and the largest finite magnitude above 0; infinity and 0 where there is none."""
    sizes = np.abs(np.asarray(values, dtype=float))
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    return (float(sizes.min()), float(sizes.max())) if sizes.size else (math.inf, 0.0)


def span(axis: Axis, data: Sequence[ArrayLike]) -> float:
    """Return the decades that a logarithmic axis covers, largest over smallest magnitude; 0 for a linear axis."""
    if not axis.is_logarithmic:
        return 0.0
    ends = [_ends(each) for each in data]
    low, high = min((low for low, _ in ends), default=math.inf), max((high for _, high in ends), default=0.0)
    return math.log10(high / max(low, axis.lowest * high)) if 0 < low < high else 0.0


def axis_table(axis: Axis, unit: str, decades: float) -> dict[str, Any]:
    """Make the table of an axis for Plotly, without colours and range, from a unit and the decades it covers."""
    shown: dict[str, Any] = {
        "title": {"text": f"{axis.words} [{unit}]" if unit else axis.words, "standoff": 6},
        "zeroline": False,
        "ticks": "outside",
        "automargin": True,
        "hoverformat": ".4~g",
    }
    if axis.is_logarithmic:
        shown |= {"type": "log", "exponentformat": "power"}
        if decades > _FEW_DECADES or axis.unit == "Hz":
            shown["dtick"] = math.ceil(decades / 8) or 1
        elif decades > 1:  # a decade or less is left to Plotly, which then has linear steps
            digits = (1, 2, 5) if decades <= 2 else (1,)
            ticks = [digit * 10.0**power for power in range(-4, 5) for digit in digits]
            shown |= {"tickvals": ticks, "ticktext": [f"{each:g}" for each in ticks]}
    return shown
