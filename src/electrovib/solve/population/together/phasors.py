"""The stacks of many fingers over frequency, exact for the materials as declared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.constants import eps0
from electrovib.solve.population.together.arrays import Column, ManyMaterial, debye_of, free_of_material
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.stack.expand import Surroundings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.interface import Role
    from electrovib.scenario import Scenario


@dataclass(frozen=True, eq=False)
class ManyPhasorLayer:
    """State of a layer of many fingers as complex amplitudes per volt, shape (fingers, frequencies)."""

    thickness: Column
    material: ManyMaterial
    field: Complex
    displacement: Complex


class ManyPhasors:
    """The stacks of many fingers at given frequencies, as a force law reads them.

    Parameters
    ----------
    scenario : Scenario
        With columns, as `with_columns` makes it.
    free : tuple of str
        Paths of the columns.
    frequency : ndarray, shape (frequencies,)
        Frequencies above 0 [Hz].

    Attributes
    ----------
    voltage, current_density : ndarray of complex, shape (fingers, frequencies)
        Voltage across the layers [1] and current density [A/m2], per volt.

    Notes
    -----
    The formulas are those of `section.phasor_section`.
    """

    def __init__(self, scenario: Scenario, free: tuple[str, ...], frequency: Real) -> None:
        self.frequency = frequency
        self.roles: Mapping[str, Role] = scenario.stack.roles
        layers, around = scenario.stack.layers, Surroundings.of(scenario)
        axis = 2j * np.pi * frequency
        drops: dict[str, Any] = {}
        materials = {}
        for name, layer in layers.items():
            mine = free_of_material(free, name)
            materials[name] = ManyMaterial(layer.material, _debye(name, layer.material, mine), mine)
            permittivity = eps0 * materials[name].complex_permittivity(frequency)
            drops[name] = layer.thickness / (axis * permittivity)
        stack = _total(drops.values())
        impedance = around.element.impedance(frequency)
        self.current_density: Complex = 1 / (stack * (1 + around.second) + around.area * impedance)
        self.voltage: Complex = stack * self.current_density
        self._layers = {}
        for name, layer in layers.items():
            field = drops[name] * self.current_density / layer.thickness
            bound = eps0 * materials[name].bound_permittivity(frequency) * field
            self._layers[name] = ManyPhasorLayer(layer.thickness, materials[name], field, bound)

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self._layers)

    def __getitem__(self, name: str) -> ManyPhasorLayer:
        """Return a layer by its name."""
        return self._layers[name]

    @property
    def interface_displacement(self) -> Complex:
        """Displacement at the interface without a gap: the charge delivered by the current."""
        return self.current_density / (2j * np.pi * self.frequency)

    def inverse_root_thickness(self, names: Sequence[str]) -> Complex:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2]."""
        parts = [
            self[name].thickness / self[name].material.bound_permittivity(self.frequency) for name in names
        ]
        return np.asarray(_total(parts) ** -0.5)


def _debye(name: str, material: Any, free: tuple[str, ...]) -> Any:
    """Return the Debye terms of a material with columns; None where it is no finite sum, or its terms are not known."""
    try:
        return debye_of(f"stack.{name}", material, free)
    except NotTogetherError:
        return None


def _total(parts: Any) -> Any:
    """Return the sum, term after term."""
    first, *rest = parts
    for part in rest:
        first = first + part
    return first
