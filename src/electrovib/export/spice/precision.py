"""Limits from the digits of ngspice, which solves for node voltages and takes differences of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.export.spice.section import CAPACITANCE
from electrovib.solve.stack.expand import Surroundings

if TYPE_CHECKING:
    from electrovib.export.spice.circuit import BuiltCircuit
    from electrovib.export.spice.timing import Timing
    from electrovib.scenario import Scenario

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
    if problems:
        raise InputError(problems)


def _rate_needed(capacitance: float, leak: float, largest: float) -> float:
    """Return the rate [1/s] above which an admittance exceeds the rounding of the largest conductance."""
    return max(0.0, ROUNDING * largest / LOST - leak) / capacitance
