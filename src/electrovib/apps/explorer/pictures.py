"""Plots of a page, as the tables that Plotly draws: curves in one prefixed unit, axes with words, scale and ticks."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.runner import SHOWN_SAMPLES
from electrovib.core.signals import SIGNALS
from electrovib.studies.widths import TYPICAL_FACTORS
from electrovib.view.lines import envelope
from electrovib.view.style import (
    COLOURS,
    FURTHER_COLOURS,
    MOST,
    NEUTRAL,
    layer_colours,
    prefix_for,
    pretty_quantity,
    pretty_unit,
)

if TYPE_CHECKING:
    import xarray
    from numpy.typing import ArrayLike, NDArray

    from electrovib.apps.explorer.computed import Computed, MeasuredForce
    from electrovib.apps.explorer.session import Earlier

_LAYER_DASHES: Final = ("solid", "dash", "dot", "dashdot")
"""Dashes of the curves of layers, from the plate on: one that coincides with another one hides nothing."""
_DIGITS: Final = 5
"""Significant digits of the numbers that are sent."""
_POWERS: Final = np.array([float(f"1e{power}") for power in range(301)])
"""Powers of ten, exact where a number can be, so that few digits are written."""
_LEGEND: Final = 520.0
"""Width of a row of the legend, in points; a letter takes about 6.2, a line 48."""
_FAINT: Final = 0.45
"""Opacity of the curves before the last change."""
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
    lowest: float = 1e-6


TIME: Final = Axis("time", "s")
FREQUENCY: Final = Axis("frequency", "Hz", is_logarithmic=True)
_FORCE, _LOGARITHMIC_FORCE = Axis("force", "N"), Axis("force", "N", is_logarithmic=True)
_FORCE_OF_LAWS: Final = Axis("force", "N", is_logarithmic=True, lowest=1e-5)  # which differ by decades
_VOLTAGE: Final = Axis("voltage", "V")


@dataclass(frozen=True)
class PlottedCurve:
    """A line of a plot, with `x` and `y` (n,) in SI.

    Curves of the same `name` share an entry of the legend; the text on hover always has it. `colour` is
    ``#rrggbb``, `dash` as Plotly calls it. `fill_from` (n,) is the lower edge of a band whose upper edge is
    `y`; the band is filled and has no line. A `is_faint` line lies behind, and neither legend nor hover names it.
    """

    x: ArrayLike
    y: ArrayLike
    name: str
    colour: str = COLOURS[0]
    dash: str = "solid"
    fill_from: ArrayLike | None = None
    width: float = 1.8
    is_faint: bool = False


def figure(title: str, x: Axis, y: Axis, curves: Sequence[PlottedCurve]) -> dict[str, Any]:
    """Make the tables ``data``, ``layout`` and ``config`` of a plot for Plotly, without colours of the page.

    The title is also the accessible name of the plot.
    """
    across = _finite([each.x for each in curves])
    up = _finite([height for each in curves for height in (each.y, each.fill_from) if height is not None])
    (x_table, x_scale, _), (y_table, y_scale, unit) = _axis(x, across), _axis(y, up)
    data: list[dict[str, Any]] = []
    named: set[str] = set()
    for each in curves:
        data += _lines(each, x_scale, y_scale, unit, show=not each.is_faint and each.name not in named)
        if not each.is_faint:
            named.add(each.name)
    rows = math.ceil(sum(48 + 6.2 * len(name) for name in named) / _LEGEND)
    return {
        "data": data,
        "layout": {
            "title": {"text": title, "x": 0.02, "y": 0.98, "yanchor": "top", "font": {"size": 14}},
            "xaxis": x_table,
            "yaxis": y_table | _range(y, up, y_scale),
            "margin": {"l": 62, "r": 12, "t": 30, "b": 44 + (18 * rows if len(named) > 1 else 0)},
            "legend": {
                "orientation": "h", "x": 0, "xanchor": "left", "y": 0, "yref": "container", "yanchor": "bottom",
                "bgcolor": "rgba(0,0,0,0)", "font": {"size": 11},
            },
            "showlegend": len(named) > 1,
            "uirevision": title,
            "hovermode": "x",
        },
        "config": {"displaylogo": False, "responsive": True, "displayModeBar": False},
    }  # fmt: skip


def thinned(x: NDArray[Any], y: NDArray[Any], most: int = SHOWN_SAMPLES) -> tuple[NDArray[Any], NDArray[Any]]:
    """Keep the lowest and the highest point of each stretch of a curve, some points at most, and both ends."""
    return envelope(x, y, longest=most, stretches=most // 2 - 1)


def _lines(
    curve: PlottedCurve, x_scale: float, y_scale: float, unit: str, *, show: bool
) -> list[dict[str, Any]]:
    def line(x: NDArray[Any], y: NDArray[Any], **more: Any) -> dict[str, Any]:
        points = {"x": rounded(x / x_scale), "y": rounded(y / y_scale)}
        named = {"name": curve.name, "legendgroup": curve.name, "showlegend": show}
        return {"type": "scatter", "mode": "lines", **points, **named, **more}

    x, y = np.asarray(curve.x, dtype=float), np.asarray(curve.y, dtype=float)
    if curve.fill_from is None:
        look = {"color": curve.colour, "dash": curve.dash, "width": curve.width, "simplify": False}
        if curve.is_faint:
            behind: dict[str, Any] = {"opacity": _FAINT, "hoverinfo": "skip", "zorder": -1}
            return [line(*thinned(x, y, SHOWN_SAMPLES // 2), line=look, **behind)]
        return [line(*thinned(x, y), line=look, hovertemplate=hover(unit, curve.name))]
    red, green, blue = bytes.fromhex(curve.colour[1:])
    edge: dict[str, Any] = {"line": {"width": 0}, "hoverinfo": "skip"}
    lower = line(x, np.asarray(curve.fill_from, dtype=float), **edge)
    fill = {"fill": "tonexty", "fillcolor": f"rgba({red},{green},{blue},0.22)"}
    return [lower | {"showlegend": False}, line(x, y, **edge, **fill)]


def hover(unit: str, name: str) -> str:
    """Return what a curve says under the pointer: its value with unit, and its name."""
    return f"%{{y:.4~g}} {unit}<extra>{name}</extra>"


def rounded(values: NDArray[Any]) -> tuple[float | None, ...]:
    """Round to a few digits, so that little is sent; numbers that are not finite become gaps.

    The framework watches every item of a list for changes, which takes longer than the simulation; a tuple is sent as it is.
    """
    finite = np.isfinite(values)
    known = np.where(finite, values, 0.0)
    sizes = np.abs(known)
    if span := float(np.ptp(values[finite])) if finite.any() else 0.0:
        sizes = np.minimum(sizes, span)  # a small change of a large value stays smooth
    places = _DIGITS - 1 - np.floor(np.log10(np.where(sizes > 0, sizes, 1.0))).astype(int)
    up, down = _POWERS[np.clip(places, 0, 300)], _POWERS[np.clip(-places, 0, 300)]
    rounded = (np.round(known * up / down) / up * down).tolist()
    return tuple(value if kept else None for value, kept in zip(rounded, finite.tolist(), strict=True))


def _finite(data: Sequence[ArrayLike]) -> NDArray[Any]:
    """Return all finite numbers along an axis."""
    values = np.concatenate([np.ravel(np.asarray(each, dtype=float)) for each in data] or [np.zeros(0)])
    finite: NDArray[Any] = values[np.isfinite(values)]
    return finite


def _axis(axis: Axis, values: NDArray[Any]) -> tuple[dict[str, Any], float, str]:
    """Return the table of an axis for Plotly, the size of its unit in SI, by which data are divided, and the unit.

    One prefix holds for the whole axis, none where it has powers of ten; the unit of a pure number is empty.
    """
    sizes = np.abs(values[values != 0])
    low, high = (float(sizes.min()), float(sizes.max())) if sizes.size else (math.inf, 0.0)
    covers = axis.is_logarithmic and low < high
    decades = math.log10(high / max(low, axis.lowest * high)) if covers else 0.0
    has_powers = axis.is_logarithmic and (axis.unit == "Hz" or decades > _FEW_DECADES)
    prefix, scale = ("", 1.0) if has_powers else prefix_for(high, axis.unit)
    unit = pretty_unit(f"{prefix}{axis.unit}" if axis.unit != "1" else "1")
    table: dict[str, Any] = {
        "title": {"text": f"{axis.words} [{unit}]" if unit else axis.words, "standoff": 6},
        "zeroline": False, "ticks": "outside", "automargin": True, "hoverformat": ".4~g",
    }  # fmt: skip
    if axis.is_logarithmic:
        table |= {"type": "log", "exponentformat": "power"}
    if has_powers:
        table["dtick"] = math.ceil(decades / 8) or 1
    elif decades > 1:  # a decade or less is left to Plotly, which then has linear steps
        digits = (1, 2, 5) if decades <= 2 else (1,)
        ticks = [digit * 10.0**power for power in range(-4, 5) for digit in digits]
        table |= {"tickvals": ticks, "ticktext": [f"{each:g}" for each in ticks]}
    return table, scale, unit


def _range(axis: Axis, values: NDArray[Any], scale: float) -> dict[str, Any]:
    """Keep a logarithmic axis from decades of values that are almost zero, and a linear one from showing rounding."""
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    size = max(abs(low), abs(high))
    if axis.is_logarithmic and high > 0:
        floor = max(float(values[values > 0].min()), axis.lowest * high)
        return {"range": [math.log10(floor / scale) - 0.1, math.log10(high / scale) + 0.15]}
    if axis.is_logarithmic or not values.size or high - low > 1e-6 * size:
        return {}
    return {"range": [(low - 0.2 * (size or 1.0)) / scale, (high + 0.2 * (size or 1.0)) / scale]}


_OVER_TIME: Final = (
    (
        "Voltage",
        _VOLTAGE,
        {
            "drive_voltage": "drive",
            "effective_voltage": "effective",
            "plate_voltage": "plate, behind the amplifier",
        },
    ),
    ("Drive current", Axis("current", "A"), {"drive_current": "drive"}),
    ("Electrostatic force", _FORCE, {"electrostatic_force": "attraction"}),
    (
        "Lateral force",
        _FORCE,
        {"lateral_force": "friction", "lateral_force_measured": "friction as the tribometer reads it"},
    ),
)
"""Title, axis and signals of each plot over time."""
_COMPARABLE: Final = 20.0
"""Ratio of the largest voltages of two layers up to which both can be read on one axis."""


def over_time(shown: Computed, earlier: Earlier | None = None) -> list[dict[str, Any]]:
    """Plot voltages, attraction, friction and fields over time; an earlier result in colours of its own if kept, else faintly."""
    plots = [_signals(title, TIME, y, names, shown, earlier) for title, y, names in _OVER_TIME]
    return _with_curves([*plots, _layer_voltages(shown, earlier)])[:4]


def unknown_signals(shown: Computed) -> list[str]:
    """Return the names, in words, of the signals over time that have no value at all."""
    names = [name for _, _, names in _OVER_TIME for name in names]
    return [name.replace("_", " ") for name in names if shown.has(name) and not _is_known(shown, name, TIME)]


def over_frequency(
    shown: Computed, earlier: Earlier | None = None, *, band: Mapping[str, NDArray[Any]] | None = None
) -> list[dict[str, Any]]:
    """Plot the mean force, the time constant of each layer, its share of the voltage, and the impedance.

    `band` has ``frequency`` [Hz], ``low`` and ``high`` [N] of fingers, each of shape (n,).
    """
    fingers = []
    if band is not None and shown.has("mean_force"):
        name, colour = "5 to 95 % of fingers", COLOURS[5]
        fingers = [PlottedCurve(band["frequency"], band["high"], name, colour, fill_from=band["low"])]
    force, magnitude = {"mean_force": "mean force of the scenario"}, {"impedance": "magnitude"}
    ohms = Axis("impedance", "ohm", is_logarithmic=True, lowest=1e-12)
    share, seconds = (
        Axis(*each, is_logarithmic=True) for each in (("share of the voltage", "1"), ("time constant", "s"))
    )
    times, shares = _TIME_CONSTANTS, "Share of the voltage across each layer"
    gains = functools.partial(_of_layers, signal="field_gain")
    return _with_curves([
        _signals("Mean force under a sine", FREQUENCY, _LOGARITHMIC_FORCE, force, shown, earlier, fingers),
        _layers(times, FREQUENCY, seconds, shown, earlier, _time_constants),
        _layers(shares, FREQUENCY, share, shown, earlier, gains),
        _signals("Magnitude of the impedance", FREQUENCY, ohms, magnitude, shown, earlier),
    ])  # fmt: skip


def laws(
    shown: Computed, others: Mapping[str, Computed], measured: MeasuredForce | None = None
) -> list[dict[str, Any]]:
    """Plot the force of the law of the page, and of those that miss measured forces the least, over time and over frequency.

    The law of the page has a thick solid line; what was `measured` is a band over time.
    """
    cases = {f"{type(shown.scenario.force).__name__} (this scenario)": shown}
    cases |= {
        name: others[name]
        for name in sorted(others, key=lambda each: TYPICAL_FACTORS.get(each, math.inf))[: MOST - 1]
    }
    looks = [
        (colour, "dash" if place else "solid", None, 1.8 if place else 3.2)
        for place, colour in enumerate(COLOURS)
    ]
    plots = []
    for title, signal, x, y in (
        ("Electrostatic force of each law", "electrostatic_force", TIME, _FORCE_OF_LAWS),
        ("Mean force of each law under a sine", "mean_force", FREQUENCY, _LOGARITHMIC_FORCE),
    ):
        curves = [
            PlottedCurve(case.values(x.words), case.values(signal), name, *look)
            for (name, case), look in zip(cases.items(), looks, strict=False)
            if case.has(signal)
        ]
        if measured is not None and x is TIME:
            ends, colour, (low, high) = shown.values("time")[[0, -1]], FURTHER_COLOURS[0], measured.interval
            curves.append(PlottedCurve(ends, [math.sqrt(low * high)] * 2, measured.name, colour, "dot"))
            curves.append(PlottedCurve(ends, [high] * 2, measured.name, colour, fill_from=[low] * 2))
        plots.append(figure(title, x, y, curves))
    return _with_curves(plots)


EXAMPLE: Final = "example (simulated"
"""How the title of a recording begins that nobody has measured."""


def recorded(shown: Computed, measured: xarray.Dataset) -> list[dict[str, Any]]:
    """Plot each signal of a recording with the same signal of the page; the modulus of complex ones."""
    plots = []
    for name in map(str, measured.data_vars):
        dims = measured[name].dims
        if name not in SIGNALS or dims not in (("time",), ("frequency",)):
            continue
        x = TIME if dims == ("time",) else FREQUENCY
        is_example = str(measured.attrs.get("title", "")).startswith(EXAMPLE)
        words = f"{EXAMPLE})" if is_example else "recorded"
        cases = [(words, measured, NEUTRAL, 4.0), ("computed", shown.trace, COLOURS[0], 1.8)]
        curves = [
            PlottedCurve(each[x.words].values, _real(each[name].values), words, colour, width=width)
            for words, each, colour, width in cases
            if name in each and each[name].dims == dims
        ]
        declared = SIGNALS[name]
        y = Axis(declared.doc.partition(",")[0], declared.unit, is_logarithmic=x.is_logarithmic)
        plots.append(figure(name.replace("_", " "), x, y, curves))
    return plots


def _with_curves(plots: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    return [plot for plot in plots if plot["data"]]


def _signals(
    title: str,
    x: Axis,
    y: Axis,
    names: Mapping[str, str],
    shown: Computed,
    earlier: Earlier | None,
    first: Sequence[PlottedCurve] = (),
) -> dict[str, Any]:
    """Plot signals, the modulus of complex ones, of the present result and of an earlier one."""

    def of(each: Computed, which: str, colours: Sequence[str], **look: Any) -> list[PlottedCurve]:
        return [
            PlottedCurve(each.values(x.words), _real(each.values(signal)), f"{words}{which}", colour, **look)
            for colour, (signal, words) in zip(colours, names.items(), strict=False)
            if _is_known(each, signal, x)
        ]

    curves = [*first, *of(shown, "", COLOURS)]
    if earlier is not None and earlier.is_kept:
        curves += of(earlier.computed, ", A", COLOURS[len(_OVER_TIME[0][2]) :], dash="dash")
    elif earlier is not None:
        curves += of(earlier.computed, ", before", COLOURS, is_faint=True)
    present = [words for signal, words in names.items() if _is_known(shown, signal, x)]
    if len(names) > 1 == len(present):  # the legend, which would name the only curve, is omitted
        title = f"{title}: {present[0]}"
    named = [each for each in curves if not each.is_faint][:MOST]
    return figure(title, x, y, [*named, *(each for each in curves if each.is_faint)])


def _real(values: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(np.abs(values) if np.iscomplexobj(values) else values)


def _is_known(shown: Computed, signal: str, x: Axis) -> bool:
    """Return whether a result has a signal along an axis with a finite value."""
    if not shown.has(signal) or shown.dimensions(signal) != (x.words,):
        return False
    return bool(np.isfinite(shown.values(signal)).any())


def _of_layers(shown: Computed, signal: str) -> dict[str, NDArray[Any]]:
    """Return the modulus of a signal in each layer; nothing where there is no such signal."""
    names = shown.scenario.stack.layers if shown.has(signal) else ()
    return {name: _real(shown.values(signal, layer=name)) for name in names}


def _layers(
    title: str,
    x: Axis,
    y: Axis,
    shown: Computed,
    earlier: Earlier | None,
    values_of: Callable[[Computed], Mapping[str, NDArray[Any]]],
    notes: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Plot a curve for each layer that has values, in its colour; those of an earlier result are faint."""
    layers = list(shown.scenario.stack.layers)
    looks = dict(
        zip(layers, zip(layer_colours(layers).values(), itertools.cycle(_LAYER_DASHES)), strict=False)
    )
    curves = [
        PlottedCurve(
            each.values(x.words), values, name.replace("_", " ") + (notes or {}).get(name, ""), *looks[name],
            is_faint=bool(place),
        )
        for place, each in enumerate([shown] if earlier is None else [shown, earlier.computed])
        for name, values in values_of(each).items()
        if name in looks
    ]  # fmt: skip
    return figure(title, x, y, curves)


def _layer_voltages(shown: Computed, earlier: Earlier | None = None) -> dict[str, Any]:
    """Plot the voltage across each layer, its field times its thickness; relative ones where they differ by much."""

    def voltages(each: Computed) -> dict[str, NDArray[Any]]:
        layers = each.scenario.stack.layers
        return {name: field * layers[name].thickness for name, field in _of_layers(each, "field").items()}

    largest = {name: float(np.nanmax(each, initial=0.0)) for name, each in voltages(shown).items()}
    sizes = [each for each in largest.values() if each > 0]
    title = "Voltage across each layer"
    if not sizes or max(sizes) <= _COMPARABLE * min(sizes):
        return _layers(title, TIME, _VOLTAGE, shown, earlier, voltages)

    def relative(each: Computed) -> dict[str, NDArray[Any]]:
        return {name: value / (largest.get(name) or 1.0) for name, value in voltages(each).items()}

    notes = {name: f" (1 is {pretty_quantity(each, 'V', digits=3)})" for name, each in largest.items()}
    axis = Axis("relative voltage", "1")
    return _layers(f"{title} over its largest", TIME, axis, shown, earlier, relative, notes)


_TIME_CONSTANTS: Final = "Time constant of each layer: permittivity / conductivity"


def _time_constants(shown: Computed) -> dict[str, NDArray[Any]]:
    """Return permittivity over conductivity, the time in which a layer loses its charge [s]."""
    found = {}
    for name in shown.scenario.stack.layers:
        value = shown.values("permittivity", layer=name)
        loss = -value.imag * 2 * np.pi * shown.values("frequency")
        if np.any(loss > 0):
            found[name] = np.divide(value.real, loss, out=np.full(loss.shape, np.nan), where=loss > 0)
    return found
