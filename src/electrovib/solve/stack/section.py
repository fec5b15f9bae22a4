"""The two forms of the stack that a force law reads: phasors of the materials as declared, and modes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.interface import Role, interface_place, roles_of
from electrovib.solve.stack.inverse_root import inverse_root_thickness
from electrovib.solve.stack.modes import Slab, StackModes, stack_modes
from electrovib.solve.stack.transfer import Column, NotInArraysError, Transfer, integrated, summed

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.material import Material
    from electrovib.physics.stack import Layer, Linear, Section

_APART: Final = (1e-3, 1e9)
"""Frequencies at which a permittivity is compared to find whether it is dispersive [Hz]."""
IDLE = 1e-12
"""Gain below which a mode of the stack's voltage is rounding [V per volt of the drive]."""


@dataclass(frozen=True)
class PhasorLayer:
    """State of a layer as complex amplitudes per volt of the drive, shape (frequencies,) or (cases, frequencies)."""

    thickness: Column
    material: Material
    field: Complex
    displacement: Complex


@dataclass(frozen=True)
class PhasorSection:
    """The stack at given frequencies, exact for the materials as declared."""

    frequency: Real
    layers: dict[str, PhasorLayer]
    roles: Mapping[str, Role]
    voltage: Complex
    current_density: Complex

    @property
    def interface_displacement(self) -> Complex:
        """Displacement at the interface of plate and finger without a gap: the charge delivered by the current."""
        return self.current_density / (2j * np.pi * self.frequency)

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self.layers)

    def __getitem__(self, name: str) -> PhasorLayer:
        """Return a layer by its name."""
        return self.layers[name]

    def inverse_root_thickness(self, names: Sequence[str]) -> Complex:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2]."""
        parts = [self[n].thickness / self[n].material.bound_permittivity(self.frequency) for n in names]
        return np.asarray(total_of(parts) ** -0.5)


@dataclass(frozen=True)
class ChargedSection(PhasorSection):
    """Response to initial charge as Laplace transforms at j w; `start` is the displacement before the interface [C/m2]."""

    start: float = 0.0

    @property
    def interface_displacement(self) -> Complex:
        """Displacement at the interface without a gap: initial value and charge delivered by the current."""
        return (self.start + self.current_density) / (2j * np.pi * self.frequency)


def phasor_section(
    layers: dict[str, Layer], *, area: Column, element: SeriesElement, second: Column, frequency: Real
) -> PhasorSection:
    """Return the stack over frequency, as a voltage divider of impedances."""
    drops = {name: layer.impedance(frequency) for name, layer in layers.items()}
    stack = total_of(drops.values())
    current = 1 / (stack * (1 + second) + area * element.impedance(frequency))
    states = {}
    for name, layer in layers.items():
        field = drops[name] * current / layer.thickness
        displacement = eps0 * layer.material.bound_permittivity(frequency) * field
        states[name] = PhasorLayer(layer.thickness, layer.material, field, displacement)
    return PhasorSection(frequency, states, roles_of(layers), stack * current, current)


def total_of(parts: Iterable[Any]) -> Any:
    """Return the sum of numbers and arrays of different shapes."""
    first, *rest = parts
    return sum(rest, start=first)


@dataclass(frozen=True)
class ModalLayer:
    """State of a layer as transfer functions."""

    thickness: Column
    material: Material
    field: Transfer
    displacement: Transfer


@dataclass(frozen=True)
class ModalSection:
    """The stack as relaxation modes, for any drive."""

    layers: dict[str, ModalLayer]
    debye: dict[str, DebyeSum]
    roles: Mapping[str, Role]
    modes: StackModes
    _roots: dict[tuple[str, ...], Transfer] = field(default_factory=dict, repr=False, compare=False)

    @property
    def frequency(self) -> Real:
        """Raise a TypeError: a law that reads the frequency has no time-domain form."""
        raise TypeError("modes have no single frequency")

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self.layers)

    def __getitem__(self, name: str) -> ModalLayer:
        """Return a layer by its name."""
        return self.layers[name]

    @property
    def voltage(self) -> Transfer:
        """Voltage across all layers."""
        drops: Transfer = total_of(layer.field * layer.thickness for layer in self.layers.values())
        return drops

    @property
    def current_density(self) -> Transfer:
        """Total current density."""
        return self.modes.current_density

    @property
    def interface_displacement(self) -> Transfer:
        """Displacement at the interface without a gap: initial charge and charge delivered by the current."""
        place = interface_place(self.roles.values())
        start = summed(self.modes.charges[..., place : place + 1])
        return integrated(self.modes.current_density, start=start)

    def inverse_root_thickness(self, names: Sequence[str]) -> Transfer:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2] as a filter, computed once for a section."""
        known = tuple(names)
        if known not in self._roots:
            slabs = [(self[name].thickness, self.debye[name]) for name in names]
            self._roots[known] = inverse_root_thickness(slabs, avoid=self.modes.rates.ravel())
        return self._roots[known]


def modal_section(
    layers: dict[str, Layer],
    debye: dict[str, DebyeSum],
    *,
    area: Column,
    element: SeriesElement,
    second: Column,
) -> ModalSection:
    """Expand the stack in modes."""
    modes = stack_modes(slabs_of(layers, debye), area=area, element=element, second=second)
    return section_of(layers, debye, modes)


def slabs_of(layers: dict[str, Layer], debye: dict[str, DebyeSum]) -> list[Slab]:
    """Return the layers as slabs."""
    return [
        Slab(layer.thickness, debye[name], layer.material.conductivity, layer.initial_charge)
        for name, layer in layers.items()
    ]


def section_of(layers: dict[str, Layer], debye: dict[str, DebyeSum], modes: StackModes) -> ModalSection:
    """Return modes as a section, with the names and roles of its layers."""
    states = {
        name: ModalLayer(layer.thickness, layer.material, field, displacement)
        for (name, layer), field, displacement in zip(
            layers.items(), modes.fields, modes.displacements, strict=True
        )
    }
    return ModalSection(states, debye, roles_of(layers), modes)


def field_in_gap(section: Section, *, thickness: float, conductivity: float = 0.0) -> Linear:
    """Return the field in a gap in series with all layers, under the voltage of the stack.

    E = V/(u + h eps_u), with the thickness u, h = sum T/eps* over the layers and eps_u = 1 + conductivity/(s
    eps0). V is the voltage across the layers without the gap, the same at every place: the area with this gap
    is assumed too small to change it.
    """
    if isinstance(section, ModalSection):
        return _gap_transfer(section, thickness, conductivity)
    assert isinstance(section, PhasorSection)
    return _gap_phasor(section, thickness, conductivity)


def _gap_phasor(section: PhasorSection, thickness: float, conductivity: float) -> Complex:
    layers = section.layers.values()
    parts = [layer.thickness / layer.material.complex_permittivity(section.frequency) for layer in layers]
    leaking = 1 + conductivity / (2j * np.pi * section.frequency * eps0)
    return np.asarray(section.voltage / (thickness + total_of(parts) * leaking))


def _gap_transfer(section: ModalSection, thickness: float, conductivity: float) -> Transfer:
    if any(np.any(layer.field.free) for layer in section.layers.values()):
        raise InputError(
            "stack: initial_charge is not supported with gaps that differ from place to place. Declare one layer 'gap' and a"
            " law that reads it, for instance force.model = MaxwellStressInGap, or remove the charge"
        )
    slabs = [
        Slab(layer.thickness, section.debye[name], layer.material.conductivity)
        for name, layer in section.layers.items()
    ]
    slabs.append(Slab(thickness, DebyeSum(1.0, (), ()), conductivity))
    field = stack_modes(slabs, area=1.0, element=SeriesElement()).fields[-1]
    return _busy(section.voltage) * _busy(field)


def _busy(transfer: Transfer) -> Transfer:
    """Omit modes that the drive does not excite, because a product divides by the distance between rates."""
    scale = np.abs(transfer.direct) + summed(np.abs(transfer.gains))
    kept = (np.abs(transfer.gains) > IDLE * scale) & (transfer.rates > 0)
    if np.any(kept != np.atleast_2d(kept)[:1]):
        raise NotInArraysError("the drive excites fewer modes in some cases")
    kept = np.atleast_2d(kept)[0]
    return Transfer(rates=transfer.rates[..., kept], gains=transfer.gains[..., kept], direct=transfer.direct)
