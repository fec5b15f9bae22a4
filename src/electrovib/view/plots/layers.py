"""The stack, with every layer thick enough to be read, and maps of a rough contact over one period of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import number_in
from electrovib.physics.material.library import find_substance
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.view.style import (
    COLOURS,
    drawing,
    label_axis,
    layer_colours,
    prefix_for,
    pretty_quantity,
    pretty_unit,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes

    from electrovib.physics.stack import Layer
    from electrovib.studies.rough_contact import RestingContact

_WIDTH = 0.27
"""Of the drawing; the words stand at its right."""
_STRIP = 0.55
"""Height of plate and finger, over that of the thinnest layer."""
_RANGE = 1.5
"""How much higher the thickest layer is drawn than the thinnest, over the height of the thinnest."""
_DECADES = 3.0
"""Thicknesses over fewer decades are drawn as if they covered a part of so many."""
_INCH = 0.42
"""Height of the thinnest layer, which holds a label of two lines [inch]."""
_LOWEST = 2.1
"""Height of a figure whose vertical axis has room for its label [inch]."""
_SHOWN_FREQUENCY = 1e3
"""Where the permittivity of a dispersive layer is quoted [Hz], if it lies in the scenario's band."""


def stack(source: Source, *, ax: Axes | None = None) -> Axes:
    """Draw the layers between plate and finger with their values.

    Parameters
    ----------
    source : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`; of a sweep, the scenario it started from.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Not to scale: the height of a layer grows with the logarithm of its thickness, and the thinnest is drawn 1 high.
        The numbers at the vertical axis are the true distances of the boundaries from the plate.

    Raises
    ------
    InputError
        If the Trace carries no scenario, as a measurement does.

    Examples
    --------
    >>> [text.get_text() for text in ev.plot.stack("bau_2010/sine").texts][3]
    'insulator, 1 µm, silica'
    """
    scenario = read_scenario(source, before_sweep=True)
    heights = drawn_heights({name: layer.thickness for name, layer in scenario.stack.layers.items()})
    with drawing(ax, (7.2, figure_height(scenario))) as axes:
        top = sum(heights.values())
        axes.set_xlim(0, 1)
        axes.set_ylim(-_STRIP, top + _STRIP)
        _surroundings(axes, scenario, top)
        _slabs(axes, scenario, heights)
        _tidy(axes, scenario, heights)
        return axes


def drawn_heights(thicknesses: Mapping[str, float]) -> dict[str, float]:
    """Compute the heights of layers in the drawing, 1 to 2.5, which grow with the logarithm of the thickness."""
    least, most = min(thicknesses.values()), max(thicknesses.values())
    decades = max(_DECADES, math.log10(most / least))
    return {name: 1 + _RANGE * math.log10(each / least) / decades for name, each in thicknesses.items()}


def figure_height(scenario: Scenario) -> float:
    """Height of a figure in which the label of every layer has room [inch]."""
    heights = drawn_heights({name: layer.thickness for name, layer in scenario.stack.layers.items()})
    return max(_LOWEST, 0.35 + _INCH * (sum(heights.values()) + 2 * _STRIP))


def _surroundings(ax: Axes, scenario: Scenario, top: float) -> None:
    """Draw plate and finger as strips, with the return path of the current."""
    from matplotlib.patches import Rectangle

    strips = (("plate electrode", -_STRIP, "#7d7d7d", "white"), ("finger", top, "#e6e0da", "#222222"))
    for words, low, colour, text in strips:
        ax.add_patch(Rectangle((0, low), _WIDTH, _STRIP, facecolor=colour, edgecolor="none"))
        ax.text(_WIDTH / 2, low + _STRIP / 2, words, ha="center", va="center", color=text, fontsize=8)
    words = f"return path: {return_path(scenario)}"
    ax.text(_WIDTH + 0.03, top + _STRIP / 2, words, va="center", fontsize=7.5, color="#5a5a5a")


def return_path(scenario: Scenario) -> str:
    """Write the model of the return path and its values."""
    back = scenario.circuit.return_path
    values = [
        f"{path} {pretty_quantity(value, quantity.unit)}"
        for path, value, quantity in back.parameters()
        if value is not None
    ]
    return ", ".join([type(back).__name__, *values])


def _slabs(ax: Axes, scenario: Scenario, heights: Mapping[str, float]) -> None:
    """Draw the layers, each with its label at its right."""
    from matplotlib.patches import Rectangle

    layers = scenario.stack.layers
    colours = layer_colours([*layers])
    low = 0.0
    for name, layer in layers.items():
        height, colour = heights[name], colours[name]
        ax.add_patch(
            Rectangle((0, low), _WIDTH, height, facecolor=colour, alpha=0.45, edgecolor="white", label=name)
        )
        middle = low + height / 2
        ax.plot([_WIDTH, _WIDTH + 0.02], [middle, middle], color=colour, linewidth=2.5)
        here = "; force evaluated here" if scenario.force.evaluation_surface == name else ""
        here += "; with unverified values" if _unverified(scenario, name) else ""
        substance = f", {written_name(layer.material.substance)}" if layer.material.substance else ""
        title = f"{name.replace('_', ' ')}, {pretty_quantity(layer.thickness, 'm')}{substance}"
        at: dict[str, Any] = {
            "xy": (_WIDTH + 0.03, middle),
            "textcoords": "offset points",
            "color": "#222222",
        }
        ax.annotate(title, xytext=(0, 1.5), va="bottom", fontsize=8.5, fontweight="bold", **at)
        ax.annotate(values(layer, scenario) + here, xytext=(0, -1.5), va="top", fontsize=8, **at)
        low += height


def values(layer: Layer, scenario: Scenario) -> str:
    """Write what a layer is made of: permittivity, conductivity, and what else is declared."""
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


def written_name(name: str) -> str:
    """Return the name of a material of the library as it is usually written: ``SU-8`` for ``su8``."""
    found = find_substance(name)
    same = [each for each in found.aliases if _letters(each) == _letters(name)] if found else []
    return same[0] if same else name.replace("_", " ")


def _letters(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum())


def _unverified(scenario: Scenario, name: str) -> bool:
    """Return whether the source of a value of the layer is cited from memory."""
    inside = f"stack.{name}."
    return any(path.startswith(inside) and "unverified" in text for path, text in scenario.sources.items())


def _tidy(ax: Axes, scenario: Scenario, heights: Mapping[str, float]) -> None:
    """Number the boundaries of the layers by their true distances from the plate, in one unit."""
    edges = np.cumsum([0.0, *(layer.thickness for layer in scenario.stack.layers.values())])
    prefix, scale = prefix_for(float(edges[-1]), "m")
    ax.set_yticks(np.cumsum([0.0, *heights.values()]), labels=[f"{edge / scale:.6g}" for edge in edges])
    ax.grid(visible=False)
    ax.xaxis.set_visible(False)
    ax.spines["bottom"].set_visible(False)
    ax.set_title(
        "not to scale: heights grow with the logarithm of the thickness", fontsize=8, color="#5a5a5a"
    )
    ax.set_ylabel(f"distance from the plate [{pretty_unit(prefix + 'm')}]")


MAP_SIZE: Final = (5.2, 4.4)
"""Width and height of the figure [inch]."""
_MAPS: Final = {
    "gap": ("gap", "m"),
    "pressure": ("pressure of the contact", "Pa"),
    "attraction": ("attraction", "Pa"),
}
_COARSE: Final = 512
"""Points along a side that are drawn; of a finer grid every nth."""


def contact_map(
    found: RestingContact, *, quantity: str = "gap", voltage: float | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the gap, the pressure of the contact or the attraction over one period of a rough contact.

    Parameters
    ----------
    found : RestingContact
        From `electrovib.rough_contact`.
    quantity : str
        ``"gap"``, ``"pressure"`` or ``"attraction"``.
    voltage : float, optional
        One of the voltages [V], the last time that the contact was there; by default the one that is largest in size.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Places in SI, with a bar of colours. In a map of the gap the places that touch have a colour of their own.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4)
    >>> found = ev.rough_contact("bau_2010/sine", roughness=rough, body=ev.Elastic(modulus=1e7), voltage=20.0)
    >>> ev.plot.contact_map(found).get_xlabel()
    'along the plate [mm]'
    """
    if quantity not in tuple(_MAPS):
        raise InputError(f"quantity = {quantity!r}: expected one of {', '.join(_MAPS)}")
    at = found.at_largest_voltage if voltage is None else _place(found, number_in("V", "voltage", voltage))
    rest = found.rests[at]
    values = getattr(rest, quantity)
    every = -(-values.shape[0] // _COARSE)
    shown = np.ma.masked_where(rest.pressure > 0, values) if quantity == "gap" else values
    across, along = found.roughness.periods
    with drawing(ax, MAP_SIZE) as axes:
        axes.set_facecolor(COLOURS[1])
        image = axes.imshow(
            shown[::every, ::every], origin="lower", extent=(0.0, along, 0.0, across), cmap="Blues", vmin=0.0
        )
        axes.grid(visible=False)
        label_axis(axes.xaxis, "along the plate", "m")
        label_axis(axes.yaxis, "across the plate", "m")
        bar = axes.figure.colorbar(image, ax=axes)
        label_axis(bar.ax.yaxis, *_MAPS[quantity])
        colour = " (orange)" if quantity == "gap" else ""
        held = pretty_quantity(float(found.voltage[at]), "V")
        axes.set_title(f"{held}: {100 * rest.contact_share:.3g} % of the area touch{colour}")
        return axes


def _place(found: RestingContact, voltage: float) -> int:
    """Return the last place at which the contact was under a voltage."""
    places = np.flatnonzero(np.isclose(found.voltage, voltage, rtol=1e-9, atol=0.0))
    if not places.size:
        known = ", ".join(f"{each:g}" for each in dict.fromkeys(found.voltage.tolist()))
        raise InputError(f"voltage = {voltage:g} V: the contact was computed at {known} V")
    return int(places[-1])
