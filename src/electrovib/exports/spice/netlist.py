"""The whole netlist: header, drive, circuit, layers, force, analyses."""

from __future__ import annotations

import math
import re
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError, NotCausalError, refuse
from electrovib.data.atomic import Form, unsigned
from electrovib.exports.spice.circuit import BuiltCircuit, Timing
from electrovib.exports.spice.section import (
    CAPACITANCE,
    Formula,
    MeterReading,
    Names,
    ReadSection,
    continued,
    number,
    remark,
    written,
)
from electrovib.solve.stack.expand import Surroundings

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from electrovib.exports.spice.section import LayerElements
    from electrovib.physics.force import ForceLaw
    from electrovib.scenario import FrequencyGrid, Scenario

OF_A_LAYER = {"thickness", "role", "material", "leak", "initial_charge", "breakdown_field"}
"""Parameters of a layer that a netlist represents; a layer with any other is refused."""


def netlist(scenario: Scenario, *, name: str) -> str:
    """Return a scenario as a netlist that ngspice runs without further input, if every part has an exact form there."""
    _check(scenario)
    timing = Timing.of(scenario.drive, scenario.time)
    circuit = BuiltCircuit.of(scenario)
    roles = scenario.stack.roles
    section = ReadSection(slabs=circuit.slabs, roles=roles, start=circuit.start, area=scenario.contact_area)
    second = Surroundings.of(scenario).second
    check_digits(scenario, circuit, timing)
    force, nodes = force_sources(scenario.force, section, second=second)
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", name) or "circuit"
    kept = [*circuit.nodes, *nodes.values(), "force"]
    blocks = [
        _header(scenario, timing, plain),
        [remark(f"drive: {type(scenario.drive).__name__}"), *circuit.sources(timing)],
        *circuit.blocks,
        force,
        [
            *analyses(timing, scenario.frequency, smallest_charge=smallest_charge(scenario, circuit, timing)),
            *saved(kept),
        ],
        [*results(section, nodes, plain, step=timing.step), ".end"],
    ]
    return "*\n".join("".join(f"{line}\n" for line in block) for block in blocks)


def _check(scenario: Scenario) -> None:
    law = scenario.force
    if not law.causal:
        raise NotCausalError(
            f"force = {type(law).__name__}: it gives the magnitude of a response at one frequency and is not causal, so no"
            f" circuit represents it. Use {law.instead or 'a causal law'}"
        )
    problems = [
        f"stack.{name}.{extra}: a netlist does not represent it; omit it, or use 'electrovib run'"
        for name, layer in scenario.stack.layers.items()
        for extra in sorted(set(type(layer).model_fields) - OF_A_LAYER)
        if getattr(layer, extra) != type(layer).model_fields[extra].default
    ]
    problems += [
        f"{path}: a netlist does not represent it; omit it, or use 'electrovib run'"
        for path in _moving(scenario)
    ]
    if scenario.contact.grows:
        problems.append(
            f"contact = {type(scenario.contact).__name__}: its area follows load and attraction, but that of a netlist is fixed;"
            " use contact.model = FixedArea with the gross_contact_area that 'electrovib run' gives"
        )
    refuse(problems)


def _moving(scenario: Scenario) -> list[str]:
    """Return the paths of parts of a scenario that change the circuit and that a netlist does not represent."""
    found = {
        "circuit.amplifier": scenario.circuit.amplifier is not None,
        "motion.distance": scenario.motion.moved_gap is not None,
        "motion.renews_film": scenario.motion.renews_film,
        "contact.closing": scenario.contact.closing is not None,
    }
    return [path for path, there in found.items() if there]


def _header(scenario: Scenario, timing: Timing, name: str) -> list[str]:
    title = " ".join(scenario.titled().split()) or "a finger on a plate"
    texts = [
        title,
        f"electrovib {version('electrovib')}, scenario {scenario.digest()}",
        f"ngspice -b of this file writes {name}.time.txt and {name}.frequency.txt into the working folder.",
        f"Over time: steps of at most {timing.step:.6g} s; a step of the drive takes {timing.edge:.6g} s.",
        "Over frequency: small signals; permittivities are those of the sums below, not the declared ones.",
        unsigned(Form.NETLIST),
    ]
    return [remark(text) for text in texts]


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
    columns = {"drive_voltage": "V(drive)", "stack_voltage": section.voltage.text, "current": "I(V_current)"}
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


def force_sources(law: ForceLaw, section: ReadSection, *, second: float) -> tuple[list[str], dict[str, str]]:
    """Return the sources of a force law, and the nodes of its linear quantities; node ``force`` has the attraction.

    `second` is the area of the first contact over that of a second one; 0 without one.
    """
    amplitudes = _readings(law, section)
    names, nodes = Names(), {}
    lines = [
        remark(
            f"force: {type(law).__name__}, Maxwell stress evaluated in: {law.evaluation_surface}; V(force) is the attraction"
            " in N"
        )
    ]
    sources = []
    for name, reading in amplitudes.items():
        nodes[name] = "effective" if name == "effective_voltage" else names.new(f"amplitude_{name}")
        sources.append(continued(f"B_{nodes[name]} {nodes[name]} 0 V = {reading.text}"))
    given = {name: Formula(f"V({node})") for name, node in nodes.items() if name != "effective_voltage"}
    pressure = written(law, "pressure", given, path="force")
    text = f"{number(section.area)}*{pressure.text}"
    if second:
        denser = {name: second * value for name, value in given.items()}
        area = number(section.area / second)
        text += f" + {area}*{written(law, 'pressure', denser, path='force').text}"
    return [*lines, *section.elements, *sources, continued(f"B_force force 0 V = {text}")], nodes


def _readings(law: ForceLaw, section: ReadSection) -> dict[str, MeterReading]:
    try:
        found: dict[str, Any] = dict(law.amplitudes(section))
        effective = law.effective_voltage(section)
    except (TypeError, AttributeError, ValueError, AssertionError) as error:
        found, effective, why = {"": None}, None, f" ({error})" if str(error) else ""
    else:
        why = ""
    if effective is not None:
        found["effective_voltage"] = effective
    if not all(isinstance(reading, MeterReading) for reading in found.values()):
        raise InputError(
            f"force = {type(law).__name__}: its amplitudes are not sums of voltages and currents of a circuit{why}; use"
            " 'electrovib run', or another force.model such as MaxwellStressInGap"
        )
    return found


ROUNDING = float(np.finfo(float).eps)
NOISE = 1e-8
"""A hundred times the relative rounding of a charge, over the tolerance of 1e-6 of a step."""
LOST = 1e-4
"""Largest rounding of the largest conductance, relative to an admittance in series with it."""


def smallest_charge(scenario: Scenario, circuit: BuiltCircuit, timing: Timing) -> float:
    """Return the charge [C] below which a change is rounding of the largest charge in the circuit."""
    voltage = sum(part.bound() for part in scenario.drive.parts()) or 1.0
    if scenario.drive.quantity == "current":  # its charge of a hundred steps on the smallest capacitor
        voltage *= 100 * timing.step / min(slab.high for slab in circuit.all_slabs)
    voltage = max([voltage, *(abs(slab.field) * slab.layer.thickness for slab in circuit.all_slabs)])
    capacitance = max(slab.admittances[2] for slab in circuit.all_slabs)
    return NOISE * voltage * max(capacitance, CAPACITANCE)


def check_digits(scenario: Scenario, circuit: BuiltCircuit, timing: Timing) -> None:
    """Refuse conductances so large that ngspice would lose the other admittances in rounding."""
    element = Surroundings.of(scenario).element
    largest = max(slab.admittances[0] for slab in circuit.all_slabs)
    if element.resistance:
        largest = max(largest, 1 / element.resistance)
    parts = [(f"stack.{slab.path}", slab.high, slab.admittances[1]) for slab in circuit.all_slabs]
    if element.elastance:
        parts.append(("circuit.return_path", 1 / element.elastance, element.rate / element.elastance))
    needed, path, capacitance = max(
        (_rate_needed(capacitance, leak, largest), path, capacitance) for path, capacitance, leak in parts
    )
    reason = f"{path}: {capacitance:.2g} F in series with a conductance of {largest:.2g} S is beyond the 16 digits of ngspice"
    problems = []
    if 1 / timing.step < needed:
        problems.append(
            f"{reason} in steps of {timing.step:.2g} s; steps of {1 / needed:.2g} s are needed, see time.samples"
        )
    if 2 * np.pi * scenario.frequency.low < needed:
        lowest = needed / (2 * np.pi)
        problems.append(
            f"{reason} at {scenario.frequency.low:.3g} Hz; set frequency.low to {lowest:.2g} Hz or more"
        )
    refuse(problems)


def _rate_needed(capacitance: float, leak: float, largest: float) -> float:
    """Return the rate [1/s] above which an admittance exceeds the rounding of the largest conductance."""
    return max(0.0, ROUNDING * largest / LOST - leak) / capacitance
