"""Plots over time: drive, attraction, friction, and the voltage across each layer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.pictures.axis import Axis
from electrovib.apps.explorer.pictures.figure import LAYER_DASHES, PlottedCurve, figure, with_kept
from electrovib.view.style import COLOURS, layer_colours
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed

TIME: Final = Axis("time", "s")
_VOLTAGES: Final = {
    "drive_voltage": "drive",
    "plate_voltage": "plate, behind the amplifier",
    "effective_voltage": "effective",
}
_COMPARABLE: Final = 20.0
"""Ratio of the largest voltages of two layers up to which both can be read on one axis."""
_CURRENTS: Final = {"drive_current": "drive"}
_ATTRACTION: Final = {"electrostatic_force": "attraction"}
_FORCES: Final = {
    "lateral_force": "friction",
    "lateral_force_measured": "friction as the tribometer reads it",
}


def over_time(shown: Computed, pinned: Sequence[Computed] = ()) -> list[dict[str, Any]]:
    """Plot voltages, attraction, friction and fields over time; results that are pinned have dashed curves."""
    plots = [
        _signals("Voltage", Axis("voltage", "V"), _VOLTAGES, shown, pinned),
        _signals("Drive current", Axis("current", "A"), _CURRENTS, shown, pinned),
        _signals("Electrostatic force", Axis("force", "N"), _ATTRACTION, shown, pinned),
        _signals("Lateral force", Axis("force", "N"), _FORCES, shown, pinned),
        _layers(shown),
    ]
    return [plot for plot in plots if plot is not None][:4]


def _signals(
    title: str, axis: Axis, names: dict[str, str], shown: Computed, pinned: Sequence[Computed]
) -> dict[str, Any] | None:
    curves = [
        PlottedCurve(
            each.values("time"),
            each.values(signal),
            f"{words}{kept}",
            COLOURS[index],
            dash,
            in_legend=not kept,
        )
        for each, dash, kept in with_kept(shown, pinned)
        for index, (signal, words) in enumerate(names.items())
        if _is_known(each, signal)
    ]
    if not curves:
        return None
    present = [words for signal, words in names.items() if _is_known(shown, signal)]
    if len(names) > 1 and len(present) == 1:  # the legend, which would name the only curve, is omitted
        title = f"{title}: {present[0]}"
    return figure(title, TIME, axis, curves)


def unknown_signals(shown: Computed) -> list[str]:
    """Return the names, in words, of the signals over time that have no value at all."""
    names = (*_VOLTAGES, *_CURRENTS, *_ATTRACTION, *_FORCES)
    return [name.replace("_", " ") for name in names if shown.has(name) and not _is_known(shown, name)]


def _is_known(shown: Computed, signal: str) -> bool:
    """Return whether a result has a signal over time with a finite value."""
    if not shown.has(signal) or shown.dimensions(signal) != ("time",):
        return False
    return bool(np.isfinite(shown.values(signal)).any())


def _layers(shown: Computed) -> dict[str, Any] | None:
    """Plot the voltage across each layer, its field times its thickness; relative ones where they differ by much."""
    if not shown.has("field"):
        return None
    layers = shown.scenario.stack.layers
    colours = layer_colours(list(layers))
    voltages = {name: shown.values("field", layer=name) * layer.thickness for name, layer in layers.items()}
    largest = {name: float(np.nanmax(np.abs(each), initial=0.0)) for name, each in voltages.items()}
    sizes = [each for each in largest.values() if each > 0]
    is_relative = bool(sizes) and max(sizes) > _COMPARABLE * min(sizes)
    curves = [
        PlottedCurve(
            shown.values("time"),
            each / largest[name] if is_relative and largest[name] > 0 else each,
            name.replace("_", " ")
            + (f" (1 is {pretty_quantity(largest[name], 'V', digits=3)})" if is_relative else ""),
            colours[name],
            LAYER_DASHES[place % len(LAYER_DASHES)],
        )
        for place, (name, each) in enumerate(voltages.items())
    ]
    if is_relative:
        return figure(
            "Voltage across each layer over its largest", TIME, Axis("voltage / largest", "1"), curves
        )
    return figure("Voltage across each layer", TIME, Axis("voltage", "V"), curves)
