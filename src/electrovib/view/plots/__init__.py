"""Plots: functions of one Trace or several; each draws into Axes and returns them."""

from electrovib.view.plots.held_force import held_force
from electrovib.view.plots.indices import indices
from electrovib.view.plots.layers import stack
from electrovib.view.plots.over_fingers import bands, exceedance
from electrovib.view.plots.over_frequency import (
    frequency_response,
    gain,
    gain_phase,
    impedance,
    impedance_phase,
)
from electrovib.view.plots.over_parameters import quantity
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
from electrovib.view.plots.reproduced import panel
from electrovib.view.plots.trade_off import trade_off

__all__ = [
    "bands",
    "current",
    "drive",
    "effective_voltage",
    "exceedance",
    "field",
    "force",
    "frequency_response",
    "gain",
    "gain_phase",
    "held_force",
    "impedance",
    "impedance_phase",
    "indices",
    "lateral_force",
    "layer_voltages",
    "over_time",
    "panel",
    "quantity",
    "stack",
    "trade_off",
]
