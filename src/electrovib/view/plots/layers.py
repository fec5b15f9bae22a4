"""The stack, drawn to scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.view.style import drawing, layer_colours
from electrovib.view.units import label_axis, pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from electrovib.physics.stack import Layer

_WIDTH = 0.27
"""Of the drawing; the words stand at its right."""
_STRIP = 0.11
"""Height of plate and finger, as a part of the stack's thickness; they are not to scale."""
_LINE = 1.2
"""Thinnest visible line [point]."""
_TEXT_HEIGHT = 27.0
"""Of a label of two lines [point]."""
_BEFORE_LAYOUT, _AFTER_LAYOUT = 0.77, 0.94
"""Share of a figure's height that its only Axes take, before and after the layout is settled."""
_SHOWN_FREQUENCY = 1e3
"""Where the permittivity of a dispersive layer is quoted [Hz], if it lies in the scenario's band."""


def stack(source: Source, *, ax: Axes | None = None) -> Axes:
    """Draw the layers between plate and finger, to scale, with their values.

    Parameters
    ----------
    source : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`; of a sweep, the scenario it started from.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Vertical axis: distance from the plate in m. A layer thinner than a line is drawn as one, and its
        label says so.

    Raises
    ------
    InputError
        If the Trace carries no scenario, as a measurement does.
    """
    scenario = read_scenario(source, before_sweep=True)
    layers = scenario.stack.layers
    with drawing(ax, (7.2, max(2.6, 0.9 + 0.46 * len(layers)))) as axes:
        total = scenario.stack.thickness
        bottom, top = -_STRIP * total, (1 + _STRIP) * total
        axes.set_xlim(0, 1)
        axes.set_ylim(bottom, top)
        _surroundings(axes, scenario, bottom, top)
        _slabs(axes, scenario, _points_per_metre(axes, top - bottom))
        _tidy(axes)
        return axes


def _points_per_metre(ax: Axes, height: float) -> float:
    """Estimate the scale of the drawing; the layout is settled only when the figure is saved."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    inches = float(figure.get_size_inches()[1])
    share = min(1.0, ax.get_position().height / _BEFORE_LAYOUT)
    return 72 * _AFTER_LAYOUT * share * inches / height


def _surroundings(ax: Axes, scenario: Scenario, bottom: float, top: float) -> None:
    """Draw plate and finger as strips, with the return path of the current."""
    from matplotlib.patches import Rectangle

    total = scenario.stack.thickness
    strips = (("plate electrode", bottom, "#7d7d7d", "white"), ("finger", total, "#e6e0da", "#222222"))
    for words, low, colour, text in strips:
        ax.add_patch(Rectangle((0, low), _WIDTH, _STRIP * total, facecolor=colour, edgecolor="none"))
        middle = low + _STRIP * total / 2
        ax.text(_WIDTH / 2, middle, words, ha="center", va="center", color=text, fontsize=8)
    back = scenario.circuit.return_path
    values = [
        f"{path} {pretty_quantity(value, q.unit)}"
        for path, value, q in back.parameters()
        if value is not None
    ]
    words = f"current returns by {type(back).__name__}" + (f": {', '.join(values)}" if values else "")
    ax.text(_WIDTH + 0.03, (top + total) / 2, words, va="center", fontsize=7.5, color="#555555")


def _slabs(ax: Axes, scenario: Scenario, scale: float) -> None:
    """Draw the layers, and their labels at the ends of leader lines."""
    from matplotlib.patches import Rectangle

    layers = scenario.stack.layers
    colours = layer_colours([*layers])
    edges = np.concatenate([[0.0], np.cumsum([layer.thickness for layer in layers.values()])])
    middles = (edges[1:] + edges[:-1]) / 2
    heights = _spread(middles, _TEXT_HEIGHT / scale, float(edges[0]), float(edges[-1]))
    for (name, layer), low, middle, height in zip(layers.items(), edges[:-1], middles, heights, strict=True):
        thin = layer.thickness * scale < _LINE
        colour = colours[name]
        ax.add_patch(
            Rectangle(
                (0, low), _WIDTH, layer.thickness, facecolor=colour, alpha=0.4, edgecolor="none", label=name
            )
        )
        if thin:
            ax.plot([0, _WIDTH], [middle, middle], color=colour, linewidth=_LINE)
        bend = [_WIDTH, _WIDTH + 0.035, _WIDTH + 0.075, _WIDTH + 0.085]
        ax.plot(bend, [middle, middle, height, height], color=colour, linewidth=0.8)
        here = "  ·  force evaluated here" if scenario.force.evaluation_surface == name else ""
        note = "  (thinner than the line that shows it)" if thin else ""
        title = f"{name.replace('_', ' ')}  {pretty_quantity(layer.thickness, 'm')}"
        at: dict[str, Any] = {
            "xy": (_WIDTH + 0.095, height),
            "textcoords": "offset points",
            "color": "#222222",
        }
        ax.annotate(title + note, xytext=(0, 1.5), va="bottom", fontsize=8.5, fontweight="bold", **at)
        ax.annotate(values(layer, scenario) + here, xytext=(0, -1.5), va="top", fontsize=8, **at)


def values(layer: Layer, scenario: Scenario) -> str:
    """Write what a layer is made of: permittivity, conductivity, and what else is declared.

    Parameters
    ----------
    layer : Layer
        One of the scenario's.
    scenario : Scenario
        Its band decides where the permittivity of a dispersive layer is quoted.

    Returns
    -------
    str
        One line.
    """
    material = layer.material
    kind = type(material).__name__
    grid = scenario.frequency
    frequency = min(max(_SHOWN_FREQUENCY, grid.low), grid.high)
    permittivity = float(np.real(material.bound_permittivity(np.array(frequency))))
    if kind == "Constant":
        parts = [f"ε = {permittivity:.4g}"]
    else:
        parts = [f"ε′ = {permittivity:.4g} at {pretty_quantity(frequency, 'Hz')} ({kind})"]
    conducts = f"σ = {pretty_quantity(material.conductivity, 'S/m', digits=4)}"
    parts.append(conducts if material.conductivity else "does not conduct")
    if layer.initial_charge:
        parts.append(f"charged with {pretty_quantity(layer.initial_charge, 'C/m2', digits=4)}")
    if layer.breakdown_field is not None:
        parts.append(f"breaks down at {pretty_quantity(layer.breakdown_field, 'V/m', digits=4)}")
    return ", ".join(parts)


def _spread(wanted: Sequence[float], distance: float, low: float, high: float) -> list[float]:
    """Move the heights of labels apart, in order, and keep them in the drawing where there is room."""
    placed: list[float] = []
    for height in wanted:
        placed.append(max(height, placed[-1] + distance) if placed else max(height, low + distance / 2))
    ceiling = high - distance / 2
    for index in range(len(placed) - 1, -1, -1):
        placed[index] = min(placed[index], ceiling)
        ceiling = placed[index] - distance
    return placed


def _tidy(ax: Axes) -> None:
    ax.grid(visible=False)
    ax.xaxis.set_visible(False)
    ax.spines["bottom"].set_visible(False)
    ax.set_title("stack, to scale (plate and finger are not)", fontsize=8.5, color="#555555")
    label_axis(ax.yaxis, "distance from the plate", "m")
