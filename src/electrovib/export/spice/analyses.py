"""Analyses of the netlist and the tables that ngspice writes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.export.spice.text import continued, number, remark

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from electrovib.export.spice.ladder import LayerElements
    from electrovib.export.spice.section import ReadSection
    from electrovib.export.spice.timing import Timing
    from electrovib.scenario import FrequencyGrid

OPTIONS = ".options method=gear reltol=1e-6 vntol=1e-12 abstol=1e-15 trtol=1"
"""Tolerances below the error of the steps; Gear, because the trapezoidal rule rings where a resistance is small."""


def analyses(timing: Timing, grid: FrequencyGrid, *, smallest_charge: float) -> list[str]:
    """Return the analyses over time, from the given initial state, and over frequency for a drive of 1 V or 1 A."""
    decades = math.log10(grid.high / grid.low)
    density = max(1, math.ceil((grid.samples - 1) / decades * (1 - 1e-9)))
    step = number(timing.step)
    return [
        f"{OPTIONS} chgtol={number(smallest_charge)}",
        f".tran {step} {number(timing.duration)} 0 {step} uic",
        f".ac dec {density} {number(grid.low)} {number(grid.high)}",
    ]


def saved(nodes: Iterable[str]) -> list[str]:
    """Return the line that keeps the voltages of these nodes and the current."""
    return [continued(f".save {' '.join(f'v({node})' for node in nodes)} i(V_current)")]


def results(section: ReadSection, nodes: Mapping[str, str], name: str, *, step: float) -> list[str]:
    """Return the commands that run the analyses and write two tables."""
    over_time, over_frequency = _over_time(section, nodes), _over_frequency(section.slabs, nodes)
    return [
        remark(
            "Columns: the signals of the same names, in SI units; complex ones as real and imaginary part."
        ),
        ".control",
        "set wr_vecnames",
        "set wr_singlescale",
        "set numdgt = 12",
        *_operating_point(section.slabs, step),
        "run",
        *_table("tran1", over_time, f"{name}.time.txt"),
        *_table("ac1", over_frequency, f"{name}.frequency.txt"),
        "if $?batchmode",
        "quit",
        "end",
        ".endc",
    ]


def _operating_point(slabs: Mapping[str, LayerElements], step: float) -> list[str]:
    """Return how .ac finds its operating point; with a leak, which is not linear, it has to be that without a drive."""
    if any(slab.layer.leak is not None for slab in slabs.values()):
        return []
    why = (
        "* blocking layers leave no path for direct current, so the operating point is found by time stepping"
    )
    return [why, f"optran 0 0 0 {number(step)} {number(100 * step)} 0"]


def _table(plot: str, columns: Mapping[str, str], file: str) -> list[str]:
    lets = [f"let {column} = {text.lower()}" for column, text in columns.items()]
    return [f"setplot {plot}", *lets, f"wrdata {file} {' '.join(columns)}"]


def _over_time(section: ReadSection, nodes: Mapping[str, str]) -> dict[str, str]:
    columns = {
        "drive_voltage": "V(drive)",
        "stack_voltage": section.voltage.text,
        "current": "I(V_current)",
    }
    columns |= {f"field_{slab.name}": section[name].field.text for name, slab in section.slabs.items()}
    columns |= {
        f"displacement_{slab.name}": section[name].displacement.text for name, slab in section.slabs.items()
    }
    columns |= {_column(name, node): f"V({node})" for name, node in nodes.items()}
    return columns | {"electrostatic_force": "V(force)"}


def _over_frequency(slabs: Mapping[str, LayerElements], nodes: Mapping[str, str]) -> dict[str, str]:
    columns = {"impedance": "V(drive)/I(V_current)"}
    columns |= {f"field_gain_{slab.name}": f"{slab.voltage}/V(drive)" for slab in slabs.values()}
    return columns | {f"{_column(name, node)}_gain": f"V({node})/V(drive)" for name, node in nodes.items()}


def _column(name: str, node: str) -> str:
    return name if name == "effective_voltage" else f"force_{node}"
