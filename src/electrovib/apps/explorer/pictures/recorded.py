"""Plots of a recording beside the prediction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.apps.explorer.pictures.axis import Axis
from electrovib.apps.explorer.pictures.figure import PlottedCurve, figure
from electrovib.apps.explorer.pictures.over_frequency import FREQUENCY
from electrovib.apps.explorer.pictures.over_time import TIME
from electrovib.core.signals import SIGNALS
from electrovib.view.style import COLOURS, NEUTRAL

if TYPE_CHECKING:
    import xarray

    from electrovib.apps.explorer.computed import Computed


def recorded(shown: Computed, measured: xarray.Dataset) -> list[dict[str, Any]]:
    """Plot each signal of a recording with the same signal of the page; the modulus of complex ones."""
    plots = []
    for name in map(str, measured.data_vars):
        dims = measured[name].dims
        if name not in SIGNALS or dims not in (("time",), ("frequency",)):
            continue
        dimension = str(dims[0])
        cases = [("recorded", measured, NEUTRAL, 4.0), ("computed", shown.trace, COLOURS[0], 1.8)]
        curves = [
            PlottedCurve(
                each[dimension].values,
                np.abs(values) if np.iscomplexobj(values) else values,
                words,
                colour,
                width=width,
            )
            for words, each, colour, width in cases
            if name in each and each[name].dims == dims
            for values in [each[name].values]
        ]
        declared = SIGNALS[name]
        axis = Axis(declared.doc.partition(",")[0], declared.unit, is_logarithmic=dimension == "frequency")
        plots.append(figure(name.replace("_", " "), TIME if dimension == "time" else FREQUENCY, axis, curves))
    return plots
