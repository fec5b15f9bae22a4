"""The stack as a force law reads it: as phasors of the materials as declared, and as modes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
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

APART: Final = (1e-3, 1e9)
"""Frequencies at which a permittivity is compared to find whether it is dispersive [Hz]."""
IDLE = 1e-12
"""Gain below which a mode of the stack's voltage is rounding [V per volt of the drive]."""


@dataclass(frozen=True)
class LayerState:
    """State of a layer per unit of the drive: phasors (..., frequencies), transfer functions, or values over time."""

    thickness: Column
    material: Material
    field: Any
    displacement: Any


@dataclass(frozen=True, kw_only=True)
class StackSection:
    """The states of the layers of a stack, from the plate to the finger."""

    layers: dict[str, LayerState]
    roles: Mapping[str, Role]

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self.layers)

    def __getitem__(self, name: str) -> LayerState:
        """Return the state of a layer by its name."""
        return self.layers[name]


@dataclass(frozen=True, kw_only=True)
class PhasorSection(StackSection):
    """The stack at given frequencies, exact for the materials as declared.

    As the response to initial charge it holds Laplace transforms at j w, and `start` is the displacement before the
    interface [C/m2].
    """

    frequency: Real
    voltage: Complex
    current_density: Complex
    start: float = 0.0

    @property
    def interface_displacement(self) -> Complex:
        """Displacement at the interface without a gap: initial value, and charge delivered by the current."""
        return (self.start + self.current_density) / (2j * np.pi * self.frequency)

    def inverse_root_thickness(self, names: Sequence[str]) -> Complex:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2]."""
        parts = [self[n].thickness / self[n].material.bound_permittivity(self.frequency) for n in names]
        return np.asarray(total_of(parts) ** -0.5)

    def times(self, factor: Any) -> PhasorSection:
        """Return the section for a drive that is a factor of this one."""
        layers = {
            name: replace(each, field=each.field * factor, displacement=each.displacement * factor)
            for name, each in self.layers.items()
        }
        voltage, density = self.voltage * factor, self.current_density * factor
        return replace(self, layers=layers, voltage=voltage, current_density=density)


def phasor_section(
    layers: Mapping[str, Layer], *, area: Column, element: SeriesElement, second: Column, frequency: Real
) -> PhasorSection:
    """Return the stack over frequency, as a voltage divider of impedances."""
    drops = {name: layer.impedance(frequency) for name, layer in layers.items()}
    current = 1 / (total_of(drops.values()) * (1 + second) + area * element.impedance(frequency))
    return section_of_voltages(
        layers, frequency, {name: each * current for name, each in drops.items()}, current
    )


def section_of_voltages(
    layers: Mapping[str, Layer],
    frequency: Real,
    voltages: Mapping[str, Complex],
    current: Complex,
    start: float = 0.0,
) -> PhasorSection:
    """Return the stack over frequency from the voltage across each layer and the current density."""
    states = {}
    for name, layer in layers.items():
        field = voltages[name] / layer.thickness
        displacement = eps0 * layer.material.bound_permittivity(frequency) * field
        states[name] = LayerState(layer.thickness, layer.material, field, displacement)
    return PhasorSection(
        layers=states,
        roles=roles_of(layers),
        frequency=frequency,
        voltage=total_of(voltages.values()),
        current_density=current,
        start=start,
    )


def total_of(parts: Iterable[Any]) -> Any:
    """Return the sum of numbers and arrays of different shapes."""
    first, *rest = parts
    return sum(rest, start=first)


@dataclass(frozen=True, kw_only=True)
class ModalSection(StackSection):
    """The stack as relaxation modes, for any drive."""

    debye: dict[str, DebyeSum]
    modes: StackModes
    _roots: dict[tuple[str, ...], Transfer] = field(default_factory=dict, repr=False, compare=False)

    @property
    def frequency(self) -> Real:
        """Raise a TypeError: a law that reads the frequency has no time-domain form."""
        raise TypeError("modes have no single frequency")

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
        name: LayerState(layer.thickness, layer.material, field, displacement)
        for (name, layer), field, displacement in zip(
            layers.items(), modes.fields, modes.displacements, strict=True
        )
    }
    return ModalSection(layers=states, roles=roles_of(layers), debye=debye, modes=modes)


def field_in_gap(section: Section, *, thickness: float, conductivity: float = 0.0) -> Linear:
    """Return the field in a gap in series with all layers, under the voltage of the stack.

    E = V/(u + h eps_u), with the thickness u, h = sum T/eps* over the layers and eps_u = 1 + conductivity/(s
    eps0). V is the voltage across the layers without the gap, the same at every place: the area with this gap
    is assumed too small to change it.
    """
    if isinstance(section, ModalSection):
        return _gap_transfer(section, thickness, conductivity)
    assert isinstance(section, PhasorSection)
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
