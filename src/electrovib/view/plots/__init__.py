"""Plots: functions of one Trace or several; each draws into Axes and returns them."""

from collections.abc import Callable
from typing import Any

from electrovib.view.plots.layers import MAP_SIZE, contact_map, stack
from electrovib.view.plots.of_answers import (
    SIZE,
    bands,
    exceedance,
    indices,
    limits,
    panel,
    size_of,
    trade_off,
)
from electrovib.view.plots.over_parameters import (
    frequency_response,
    gain,
    gain_phase,
    impedance,
    impedance_phase,
    quantity,
)
from electrovib.view.plots.over_time import (
    current,
    drive,
    effective_voltage,
    field,
    force,
    lateral_force,
    layer_voltages,
    over_time,
)

SIZES: dict[str, Callable[[Any], tuple[float, float]]] = {
    "indices": size_of,
    "trade_off": lambda _: SIZE,
    "contact_map": lambda _: MAP_SIZE,
    "limits": lambda found: (7.2, 1.2 + 0.3 * len(found.rows)),
}
"""Plot to width and height of its figure [inch], a function of what it shows."""

__all__ = [
    "bands",
    "contact_map",
    "current",
    "drive",
    "effective_voltage",
    "exceedance",
    "field",
    "force",
    "frequency_response",
    "gain",
    "gain_phase",
    "impedance",
    "impedance_phase",
    "indices",
    "lateral_force",
    "layer_voltages",
    "limits",
    "over_time",
    "panel",
    "quantity",
    "stack",
    "trade_off",
]
