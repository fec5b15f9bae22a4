"""Plots over frequency: force with the band of a population, time constant of the skin, share of each layer, impedance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.pictures.axis import Axis
from electrovib.apps.explorer.pictures.figure import LAYER_DASHES, PlottedCurve, figure, with_kept
from electrovib.view.style import COLOURS, NEUTRAL, layer_colours

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.apps.explorer.computed import Computed

FREQUENCY: Final = Axis("frequency", "Hz", is_logarithmic=True)


def over_frequency(
    shown: Computed, pinned: Sequence[Computed] = (), *, band: Mapping[str, NDArray[Any]] | None = None
) -> list[dict[str, Any]]:
    """Plot the mean force, the time constant of each layer, its share of the voltage, and the impedance.

    Results that are pinned have dashed curves. `band` has ``frequency`` [Hz], ``low`` and ``high`` [N] of a
    population of fingers, each of shape (n,).
    """
    plots = [_force(shown, pinned, band), _time_constant(shown), _shares(shown), _impedance(shown, pinned)]
    return [plot for plot in plots if plot is not None]


def _force(
    shown: Computed, pinned: Sequence[Computed], band: Mapping[str, NDArray[Any]] | None
) -> dict[str, Any] | None:
    if not shown.has("mean_force"):
        return None
    curves = []
    if band is not None:
        curves.append(
            PlottedCurve(
                band["frequency"],
                band["high"],
                "5 to 95 % of fingers",
                COLOURS[5],
                fill_from=band["low"],
            )
        )
    curves += [
        PlottedCurve(
            each.values("frequency"),
            each.values("mean_force"),
            f"mean force of the scenario{kept}",
            dash=dash,
            in_legend=not kept,
        )
        for each, dash, kept in with_kept(shown, pinned)
        if each.has("mean_force")
    ]
    return figure("Mean force under a sine", FREQUENCY, Axis("force", "N", is_logarithmic=True), curves)


def _time_constant(shown: Computed) -> dict[str, Any] | None:
    """Plot permittivity over conductivity, the time in which a layer loses its charge."""
    colours = layer_colours(list(shown.scenario.stack.layers))
    frequency = shown.values("frequency")
    curves = []
    for place, name in enumerate(shown.scenario.stack.layers):
        value = shown.values("permittivity", layer=name)
        loss = -value.imag * 2 * np.pi * frequency
        if np.any(loss > 0):
            with np.errstate(divide="ignore"):
                tau = np.where(loss > 0, value.real / np.where(loss > 0, loss, 1.0), np.nan)
            dash = LAYER_DASHES[place % len(LAYER_DASHES)]
            curves.append(PlottedCurve(frequency, tau, name.replace("_", " "), colours[name], dash))
    if not curves:
        return None
    words = Axis("time constant", "s", is_logarithmic=True)
    return figure("Time constant of each layer: permittivity / conductivity", FREQUENCY, words, curves)


def _shares(shown: Computed) -> dict[str, Any] | None:
    if not shown.has("field_gain"):
        return None
    colours = layer_colours(list(shown.scenario.stack.layers))
    curves = [
        PlottedCurve(
            shown.values("frequency"),
            np.abs(shown.values("field_gain", layer=name)),
            name.replace("_", " "),
            colours[name],
            LAYER_DASHES[place % len(LAYER_DASHES)],
        )
        for place, name in enumerate(shown.scenario.stack.layers)
    ]
    words = Axis("share", "1", is_logarithmic=True)
    return figure("Share of the voltage across each layer", FREQUENCY, words, curves)


def _impedance(shown: Computed, pinned: Sequence[Computed]) -> dict[str, Any] | None:
    curves = [
        PlottedCurve(
            each.values("frequency"),
            np.abs(each.values("impedance")),
            f"magnitude{kept}",
            NEUTRAL if kept else COLOURS[2],
            dash,
            in_legend=not kept,
        )
        for each, dash, kept in with_kept(shown, pinned)
        if each.has("impedance")
    ]
    if not curves:
        return None
    words = Axis("impedance", "ohm", is_logarithmic=True, lowest=1e-12)
    return figure("Magnitude of the impedance", FREQUENCY, words, curves)
