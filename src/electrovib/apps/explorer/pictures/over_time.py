"""Plots over time: drive, attraction, friction, and the voltage across each layer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from electrovib.apps.explorer.pictures.figure import PINNED, Axis, PlottedCurve, figure
from electrovib.view.style import COLOURS, layer_colours

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed

TIME: Final = Axis("time", "s")
_VOLTAGES: Final = {
    "drive_voltage": "drive",
    "plate_voltage": "plate, behind the amplifier",
    "effective_voltage": "effective",
}
_FORCES: Final = {
    "lateral_force": "friction",
    "lateral_force_measured": "friction as the tribometer reads it",
}


def over_time(shown: Computed, pinned: Sequence[Computed] = ()) -> list[dict[str, Any]]:
    """Plot voltages, attraction, friction and fields over time.

    Parameters
    ----------
    shown : Computed
        Scenario of the page.
    pinned : sequence of Computed
        Kept for comparison, with dashed curves.

    Returns
    -------
    figures : list of dict
        Four plots at most.
    """
    plots = [
        _signals("Voltage", Axis("voltage", "V"), _VOLTAGES, shown, pinned),
        _signals("Drive current", Axis("current", "A"), {"drive_current": "drive"}, shown, pinned),
        _signals(
            "Electrostatic force", Axis("force", "N"), {"electrostatic_force": "attraction"}, shown, pinned
        ),
        _signals("Lateral force", Axis("force", "N"), _FORCES, shown, pinned),
        _layers(shown),
    ]
    return [plot for plot in plots if plot is not None][:4]


def _signals(
    title: str, axis: Axis, names: dict[str, str], shown: Computed, pinned: Sequence[Computed]
) -> dict[str, Any] | None:
    curves = [
        PlottedCurve(each.trace["time"].values, each.trace[signal].values, words, COLOURS[index], dash)
        for each, dash in zip([shown, *pinned], ("solid", *PINNED), strict=False)
        for index, (signal, words) in enumerate(names.items())
        if signal in each.trace and each.trace[signal].dims == ("time",)
    ]
    return figure(title, TIME, axis, curves) if curves else None


def _layers(shown: Computed) -> dict[str, Any] | None:
    """Plot the voltage across each layer: its field times its thickness."""
    if "field" not in shown.trace:
        return None
    layers = shown.scenario.stack.layers
    colours = layer_colours(list(layers))
    field = shown.trace["field"]
    curves = [
        PlottedCurve(
            shown.trace["time"].values,
            field.sel(layer=name).values * layer.thickness,
            name.replace("_", " "),
            colours[name],
        )
        for name, layer in layers.items()
    ]
    return figure("Voltage across each layer", TIME, Axis("voltage", "V"), curves)
