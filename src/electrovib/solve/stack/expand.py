"""The stack of a scenario over frequency, and as relaxation modes under a voltage or a prescribed current.

With a given current, the field of a layer is E_k = z_k J/T_k: the poles are those of each layer and not the zeros of their
sum, and it is independent of the other layers. A layer that does not conduct is an integrator.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.arrays import Complex, Real
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.interface import interface_place, roles_of
from electrovib.physics.stack import Layer
from electrovib.scenario import Scenario
from electrovib.solve.stack.modes import (
    StackModes,
    bound_residues,
    slab_impedance,
    slots,
    spread,
)
from electrovib.solve.stack.reduce import HIGHEST, LOWEST, Reduction, reduce_material, run_band
from electrovib.solve.stack.section import (
    ModalSection,
    PhasorSection,
    modal_section,
    phasor_section,
    section_of,
    section_of_voltages,
    slabs_of,
)
from electrovib.solve.stack.transfer import INTEGRATING, Column, Transfer, row_of, side_by_side

if TYPE_CHECKING:
    from electrovib.physics.debye_sum import DebyeSum


@dataclass(frozen=True)
class Surroundings:
    """Contact area, series element and second contact of a scenario, which the sections need besides the layers."""

    area: float
    element: SeriesElement
    second: float

    @classmethod
    def of(cls, scenario: Scenario, area: Any = None) -> Surroundings:
        """Return those of a scenario, with other contact areas [m2] if given."""
        area = scenario.contact_area if area is None else area
        second = scenario.circuit.return_path.second_contact(area)
        return cls(area, scenario.circuit.element(), second)


def phasors(scenario: Scenario, frequency: Real, *, leaks: bool = True) -> PhasorSection:
    """Return the scenario's stack over frequency, exact for the materials as declared.

    `frequency` (n,) [Hz].
    """
    section = per_volt_of(scenario, frequency, leaks=leaks)
    area = scenario.contact_area
    return per_ampere(section, area=area) if scenario.drive.quantity == "current" else section


def per_volt_of(
    scenario: Scenario, frequency: Real, *, leaks: bool = True, area: Real | None = None
) -> PhasorSection:
    """Return the scenario's stack over frequency per volt, also where the drive prescribes the current.

    With an `area` [m2] for each of some contacts, instead of that of the scenario, one frequency gives as many values.
    """
    around, layers = Surroundings.of(scenario, area), scenario.stack.layers
    return phasor_section(
        linearised(layers) if leaks else layers,
        area=around.area,
        element=around.element,
        second=around.second,
        frequency=frequency,
    )


def linearised(layers: Mapping[str, Layer]) -> dict[str, Layer]:
    """Return layers with every leak replaced by its conductivity at vanishing amplitude."""
    found = {}
    for name, layer in layers.items():
        found[name] = layer
        if layer.leak is not None:
            conductivity = layer.material.conductivity + layer.leak.small_signal
            material = layer.material.conducting(conductivity)
            found[name] = layer.model_copy(update={"material": material, "leak": None})
    return found


def left_by_charge(scenario: Scenario, frequency: Real, charges: Real) -> PhasorSection:
    """Return the response to initial charge as Laplace transforms at j w, exact for the materials as declared.

    `frequency` (n,) [Hz], `charges` (layers + 1,) [C/m2].

    E_k T_k = z_k (Q_k + J), J = -(sum z_j Q_j)/Z over all parts of the circuit, the body's capacitor among them;
    J = 0 under a prescribed current.
    """
    around, layers = Surroundings.of(scenario), scenario.stack.layers
    drops = {name: layer.impedance(frequency) for name, layer in layers.items()}
    held = dict(zip(layers, charges, strict=False))
    current: Complex = np.zeros(len(frequency), complex)
    if scenario.drive.quantity == "voltage":
        element = around.element
        stack = np.sum(list(drops.values()), axis=0) * (1 + around.second)
        body = around.area * element.elastance / (2j * np.pi * frequency + element.rate)
        driving = np.sum([drops[name] * held[name] for name in layers], axis=0)
        driving = driving + body * (charges[-1] + element.charge / around.area)
        current = -driving / (stack + around.area * element.impedance(frequency))
    voltages = {name: drop * (held[name] + current) for name, drop in drops.items()}
    start = float(charges[interface_place(roles_of(layers).values())])
    return section_of_voltages(layers, frequency, voltages, current, start)


def behind_amplifier(scenario: Scenario, section: PhasorSection) -> PhasorSection:
    """Return a section per volt of the drive from one per volt of the plate."""
    amplifier = scenario.circuit.amplifier
    if amplifier is None:
        return section
    pole = 1.0 if amplifier.bandwidth is None else 1 + 1j * section.frequency / amplifier.bandwidth
    return section.times(amplifier.gain / pole)


def reductions(scenario: Scenario, times: Real | None = None) -> dict[str, Reduction]:
    """Return the bound permittivity of every layer as Debye terms, over the band that a run needs.

    `times` (n,) [s].
    """
    layers = scenario.stack.layers
    exact = {name: layer.material.debye() for name, layer in layers.items()}
    low, high = LOWEST, HIGHEST
    if None in exact.values():  # materials that are declared as Debye sums do not depend on the band
        low, high = run_band(scenario, scenario.time.times(scenario.drive) if times is None else times)
    return {
        name: reduce_material(layer.material, low=low, high=high)
        if (debye := exact[name]) is None
        else Reduction(debye, 0.0)
        for name, layer in layers.items()
    }


def modes(scenario: Scenario, times: Real | None = None) -> tuple[ModalSection, float]:
    """Return the stack without leaks as modes per unit of the drive, and the largest error of a bound permittivity."""
    found = reductions(scenario, times)
    debye = {name: reduction.debye for name, reduction in found.items()}
    return modes_of(scenario, debye), max(reduction.largest_error for reduction in found.values())


def modes_of(scenario: Scenario, debye: dict[str, DebyeSum]) -> ModalSection:
    """Return the stack without leaks as modes per unit of the drive, for given relaxations of its layers.

    A number of the scenario, or of the relaxations, may be a column with one value for each case.
    """
    around, layers = Surroundings.of(scenario), scenario.stack.layers
    if scenario.drive.quantity == "current":
        return current_section(layers, debye, area=around.area)
    return modal_section(layers, debye, area=around.area, element=around.element, second=around.second)


def per_ampere(section: PhasorSection, *, area: Column) -> PhasorSection:
    """Return the stack at given frequencies per ampere of the drive."""
    return section.times(1 / (section.current_density * area))


def current_section(layers: dict[str, Layer], debye: dict[str, DebyeSum], *, area: Column) -> ModalSection:
    """Expand the stack in the modes of its layers, per ampere of the drive.

    E_k T_k = z_k (J + Q_k), with Q_k the free charge at time 0 on the interfaces on the plate's side of layer
    k. The plate itself carries only the charge delivered by the current.
    """
    slabs = slabs_of(layers, debye)
    expanded = [slab_impedance(slab) for slab in slabs]
    nodes, places = slots([rates for rates, _ in expanded])
    rates = side_by_side(np.where(nodes == 0, INTEGRATING, nodes), np.zeros(1))  # the last: trapped charge
    held = np.cumsum(side_by_side(np.zeros(1), *(row_of(slab.charge) for slab in slabs)), axis=-1)
    fields: list[Transfer] = []
    displacements: list[Transfer] = []
    for index, (slab, each, mine) in enumerate(zip(slabs, expanded, places, strict=True)):
        charge = held[..., index : index + 1]
        for found, residues in (
            (fields, each[1] / slab.thickness),
            (displacements, bound_residues(slab, *each)),
        ):
            spread_out = spread(residues, mine, nodes.shape[-1])
            found.append(_answer(rates, spread_out / area, spread_out * charge))
    current = Transfer(rates=rates, gains=np.zeros(rates.shape[-1]), direct=1 / area)
    modes = StackModes(rates, tuple(fields), tuple(displacements), current, nodes.shape[-1], held)
    return section_of(layers, debye, modes)


def _answer(rates: Real, residues: Real, free: Real) -> Transfer:
    """Return sum residue/(s + rate); the free part at a rate of 0 is constant."""
    integrates = rates[..., :-1] == INTEGRATING
    gains = side_by_side(residues / rates[..., :-1], np.zeros(1))
    constant = np.where(integrates, free, 0.0).sum(axis=-1, keepdims=True)
    fading = side_by_side(np.where(integrates, 0.0, free), constant)
    return Transfer(rates=rates, gains=gains, free=fading)
