"""The stacks of many fingers as a force law reads them."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.physics.interface import interface_place
from electrovib.solve.population.together.arrays import (
    Column,
    ManyDebye,
    ManyMaterial,
    debye_of,
    flat,
    free_of_material,
)
from electrovib.solve.population.together.circuits import ManyCircuits
from electrovib.solve.population.together.layers import ManySlab
from electrovib.solve.population.together.modes import ManyModes
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.stack.expand import Surroundings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.physics.interface import Role
    from electrovib.physics.stack import Layer
    from electrovib.scenario import Scenario
    from electrovib.solve.population.together.reduced import SharedReduction
    from electrovib.solve.population.together.transfers import Transfers


class ManyLayer:
    """State of one layer of many fingers as transfer functions.

    Parameters
    ----------
    layer : Layer
        With columns.
    material : ManyMaterial
        Dielectric that fills it.
    modes : ManyModes
        Of the stacks.
    index : int
        Its place from the plate.
    """

    def __init__(self, layer: Layer, material: ManyMaterial, modes: ManyModes, index: int) -> None:
        self.thickness: Column = layer.thickness
        self.material: Any = material
        self._modes, self._index = modes, index

    @functools.cached_property
    def field(self) -> Transfers:
        """Field [V/m per volt]."""
        return self._modes.field(self._index)

    @functools.cached_property
    def displacement(self) -> Transfers:
        """Bound displacement [C/m2 per volt]."""
        return self._modes.displacement(self._index)


class ManySection:
    """The stacks of many fingers as relaxation modes, as a force law reads them.

    Parameters
    ----------
    scenario : Scenario
        With columns, as `with_columns` makes it.
    free : tuple of str
        Paths of the columns.
    reduced : mapping of str to SharedReduction
        Bound permittivity of the layers whose materials are no finite sums of Debye terms.
    fingers : int
        Number of fingers.

    Attributes
    ----------
    modes : ManyModes
        Relaxation modes.
    """

    def __init__(
        self,
        scenario: Scenario,
        free: tuple[str, ...],
        reduced: Mapping[str, SharedReduction],
        fingers: int,
    ) -> None:
        layers = scenario.stack.layers
        self.roles: Mapping[str, Role] = scenario.stack.roles
        debye = {
            name: _debye(name, layer, free_of_material(free, name), reduced) for name, layer in layers.items()
        }
        slabs = [
            ManySlab(
                thickness=flat(layer.thickness),
                debye=debye[name],
                conductivity=flat(layer.material.conductivity),
                charge=flat(layer.initial_charge),
            )
            for name, layer in layers.items()
        ]
        around = Surroundings.of(scenario)
        circuit = ManyCircuits.around(area=around.area, element=around.element, second=around.second)
        self.modes = ManyModes(slabs, circuit, fingers)
        self._debye = debye
        self._layers = {
            name: ManyLayer(
                layer,
                ManyMaterial(layer.material, debye[name], free_of_material(free, name)),
                self.modes,
                index,
            )
            for index, (name, layer) in enumerate(layers.items())
        }

    @property
    def frequency(self) -> Any:
        """Raise a TypeError: a law that reads the frequency has no time-domain form."""
        raise TypeError("modes have no single frequency")

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self._layers)

    def __getitem__(self, name: str) -> ManyLayer:
        """Return a layer by its name."""
        return self._layers[name]

    @functools.cached_property
    def voltage(self) -> Transfers:
        """Voltage across all layers."""
        return self.modes.voltage()

    @property
    def current_density(self) -> Transfers:
        """Raise an error: the current is a small difference of large terms, which modes of many fingers do not resolve."""
        raise NotTogetherError("the current is a small difference of large terms of the modes")

    @functools.cached_property
    def interface_displacement(self) -> Transfers:
        """Displacement at the interface without a gap: initial charge, and charge delivered by the current."""
        return self.modes.delivered(interface_place(self.roles.values()))

    def inverse_root_thickness(self, names: Sequence[str]) -> Column:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2], which must not be dispersive."""
        total: Any = 0.0
        for name in names:
            debye = self._debye[name]
            if any(np.any(strength) for strength in debye.strengths):
                raise NotTogetherError(
                    f"the force law filters by the permittivity of '{name}', which depends on frequency"
                )
            total = total + self[name].thickness / debye.high
        return total**-0.5


def _debye(
    name: str, layer: Layer, free: tuple[str, ...], reduced: Mapping[str, SharedReduction]
) -> ManyDebye:
    """Return the Debye terms of a layer."""
    if name in reduced:
        return reduced[name].of_fingers(ManyMaterial(layer.material, None, free))
    found = debye_of(f"stack.{name}", layer.material, free)
    if found is None:
        raise NotTogetherError(f"the reduction of stack.{name}.material is not known")
    return found
