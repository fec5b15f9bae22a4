"""The stack as a force law reads it: as phasors of the materials as declared, and as modes."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.stack import Role, interface_place, roles_of
from electrovib.solve.stack.modes import Slab, StackModes, relaxations, stack_modes
from electrovib.solve.stack.secular import secular_roots
from electrovib.solve.stack.transfer import Column, NotInArraysError, Transfer, integrated, summed

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from electrovib.core.arrays import Complex
    from electrovib.physics.material import Material
    from electrovib.physics.stack import Layer, Linear, Section

APART: Final = (1e-3, 1e9)
"""Frequencies at which a permittivity is compared to find whether it is dispersive [Hz]."""
IDLE = 1e-12
"""Gain below which a mode of the stack's voltage is rounding [V per volt of the drive]."""


@dataclass(frozen=True)
class StackLayer:
    """State of a layer per unit of the drive: phasors (..., frequencies), transfer functions, or values over time."""

    thickness: Column
    material: Material
    field: Any
    displacement: Any


@dataclass(frozen=True, kw_only=True)
class StackSection:
    """The states of the layers of a stack, from the plate to the finger."""

    layers: dict[str, StackLayer]
    roles: Mapping[str, Role]

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self.layers)

    def __getitem__(self, name: str) -> StackLayer:
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
        states[name] = StackLayer(layer.thickness, layer.material, field, displacement)
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
        name: StackLayer(layer.thickness, layer.material, field, displacement)
        for (name, layer), field, displacement in zip(
            layers.items(), modes.fields, modes.displacements, strict=True
        )
    }
    return ModalSection(layers=states, roles=roles_of(layers), debye=debye, modes=modes)


def field_in_gap(section: Section, *, thickness: Column, conductivity: Column = 0.0) -> Linear:
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


def fields_in_gaps(section: Section, thickness: Real) -> list[Linear]:
    """Return the field in each of several gaps, as `field_in_gap` does; their thicknesses are the last axis."""
    if isinstance(section, ModalSection) and thickness.ndim == 1 and _is_one_case(section):
        with contextlib.suppress(NotInArraysError):  # raised where some gaps have fewer modes
            many: Any = field_in_gap(section, thickness=thickness[:, None])
            own = np.broadcast_to(many.direct, (len(thickness), 1))[:, 0].tolist()
            rates = np.broadcast_to(many.rates, many.gains.shape)
            return [Transfer(rates=rates[i], gains=many.gains[i], direct=each) for i, each in enumerate(own)]
    return [field_in_gap(section, thickness=each) for each in np.moveaxis(thickness, -1, 0)]


def _is_one_case(section: ModalSection) -> bool:
    """Return whether no number of a stack is a column of cases."""
    fields = [layer.field for layer in section.layers.values()]
    return all(each.gains.ndim == 1 and np.ndim(each.direct) == 0 for each in fields)


def _gap_transfer(section: ModalSection, thickness: Column, conductivity: Column) -> Transfer:
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


TOLERANCE = 1e-11
"""Relative error for which the number of nodes on each branch cut is chosen."""
MOST_NODES = 40
"""Nodes on one cut with even angles; a cut that nearly touches the next one has graded angles instead."""
CLEARANCE = 1e-2
"""Distance between poles of two factors, over the residue of this one, with which a product keeps 13 digits."""
NARROW = 1e-11
"""Relative length below which a cut has one node: next to a strong cut it contributes up to 1e-9."""
SHORTEST = 1e-15
"""Relative length below which a cut is rounding."""
ALIKE = 1e-6
"""Relative distance below which rates count as equal."""


def inverse_root_thickness(
    slabs: Sequence[tuple[float, DebyeSum]], *, avoid: Real | None = None, tolerance: float = TOLERANCE
) -> Transfer:
    """Expand (sum T/eps_pol(s))^(-1/2) in real poles with positive weights.

    K(-x) is negative on one interval for each Debye term, from a zero y to a pole b of K, and K^(-1/2)(s) =
    K_inf^(-1/2) + (1/pi) sum over cuts of integral |K(-x)|^(-1/2)/(s + x) dx. With x = y (b/y)^(sin^2 angle)
    the integrand is smooth and even in the angle at both ends, so that even angles are a Gauss rule: no fit,
    all weights positive.
    """
    infinite, static, poles, weights = _expand(slabs)
    if not len(poles):
        return Transfer(rates=np.zeros(0), gains=np.zeros(0), direct=infinite**-0.5)
    # in 1/x the equation K(-x) = 0 is again a secular equation with positive weights
    reversed_roots = secular_roots(1 / poles[::-1], (weights / poles**2)[::-1], constant=static)
    cuts = [cut for cut in _cuts(1 / reversed_roots.values[::-1], poles) if cut.length > SHORTEST]
    best = (-1.0, np.zeros(0), np.zeros(0))
    for more in range(6):
        nodes = [cut.nodes(tolerance, more) for cut in cuts]
        rates, strengths = np.concatenate(nodes, axis=1) if nodes else np.zeros((2, 0))
        best = max(best, (_clearance(rates, strengths, avoid), rates, strengths), key=lambda found: found[0])
        if best[0] > CLEARANCE:
            break
    _, rates, strengths = best
    return Transfer(rates=rates, gains=strengths / rates * infinite**-0.5, direct=infinite**-0.5)


def _expand(slabs: Sequence[tuple[float, DebyeSum]]) -> tuple[float, float, Real, Real]:
    """Return the terms of K(s) = K_inf - sum weight/(s + pole), and K(0), which that difference would lose digits of."""
    infinite, static = 0.0, 0.0
    poles, weights = [np.zeros(0)], [np.zeros(0)]
    for thickness, debye in slabs:
        rates, shares = relaxations(
            debye, 0.0
        )  # the first rate is 0: a material that does not conduct holds charge
        infinite, static = infinite + thickness / debye.high, static + summed(thickness / shares[..., :1])
        if rates.shape[-1] > 1:  # without relaxations the numbers may be columns
            poles.append(rates[1:])
            weights.append(thickness * rates[1:] / shares[1:])
    return infinite, static, *_merged(np.concatenate(poles), np.concatenate(weights))


def _merged(rates: Real, weights: Real) -> tuple[Real, Real]:
    """Merge rates that almost agree at their weighted mean, with an error of the order of the distance squared."""
    order = np.argsort(rates)
    rates, weights = rates[order], weights[order]
    starts = np.flatnonzero(np.diff(rates, prepend=-np.inf) > ALIKE * rates)
    if len(starts) == len(rates):
        return rates, weights
    together = np.add.reduceat(weights, starts)
    return np.add.reduceat(rates * weights, starts) / together, together


@dataclass(frozen=True, eq=False, kw_only=True)
class _Cut:
    """Branch cut: an interval on which K(-x) is negative.

    Parameters
    ----------
    low, length : float
        Begin of the interval [1/s], and the logarithm of its end over its begin.
    below, above : float
        Logarithms of the distances to the next cuts, infinite where there is none.
    zeros, poles : ndarray
        Ends of all other cuts.
    """

    low: float
    length: float
    below: float
    above: float
    zeros: Real
    poles: Real

    def nodes(self, tolerance: float, more: int) -> Real:
        """Return quadrature nodes x and weights of |K_inf/K(-x)|^(1/2) dx/pi, shape (2, nodes)."""
        if self.length < NARROW:
            return self._middle()
        angles, steps = self._angles(np.log(1 / tolerance), more)
        share = np.sin(angles) ** 2
        x = self.low * np.exp(self.length * share)
        from_low = self.low * np.expm1(self.length * share)
        to_high = x * np.expm1(self.length * np.cos(angles) ** 2)
        others = (x[:, None] - self.poles) / (
            x[:, None] - self.zeros
        )  # K is a product over its poles and zeros
        inverse_root = np.sqrt(to_high / from_low * np.prod(others, axis=1))
        return np.array([x, inverse_root * x * self.length * np.sin(2 * angles) * steps / np.pi])

    def _middle(self) -> Real:
        """Return one node, whose weight is the integral with all other factors constant."""
        x = self.low * np.exp(self.length / 2)
        others = np.abs(np.prod((x - self.poles) / (x - self.zeros)))
        return np.array([[x], [np.sqrt(others) * self.low * np.expm1(self.length) / 2]])

    def _angles(self, digits: float, more: int) -> tuple[Real, Real]:
        """Return angles from 0 to pi/2 and their steps, as many as an error of exp(-digits) needs."""
        free = max(min(self.below, self.above), NARROW)
        # region of the complex plane in which the integrand is analytic: next cut, logarithm of imaginary frequencies
        ellipse = min(np.arccosh(1 + 2 * free / self.length), np.arcsinh(np.pi / self.length))
        count = max(2, int(np.ceil(digits / (2 * ellipse)))) + more
        if count > MOST_NODES:
            return self._graded_angles(digits, more)
        steps: Real = np.full(count, np.pi / (2 * count + 1))
        angles: Real = np.pi / 2 - steps * np.arange(1, count + 1)
        return angles, steps

    def _graded_angles(self, digits: float, more: int) -> tuple[Real, Real]:
        """Return Gauss points on panels that grow from both ends with the distance from a singularity."""
        widest = min(np.pi / 8, np.pi / (2 * self.length))
        ends = [
            _panels(np.sqrt(max(free, NARROW) / self.length), widest) for free in (self.below, self.above)
        ]
        edges = np.concatenate([ends[0], np.pi / 2 - ends[1][-2::-1]])
        points, weights = np.polynomial.legendre.leggauss(int(np.ceil(digits / 1.7)) + more)
        half = np.diff(edges) / 2
        angles: Real = (edges[:-1] + half)[:, None] + half[:, None] * points
        steps: Real = half[:, None] * weights
        return angles.ravel(), steps.ravel()


def _panels(first: float, widest: float) -> Real:
    """Return edges from 0 to pi/4, with a first panel of a given width, then each twice as wide as all before it."""
    edges = [0.0, min(first, widest)]
    while edges[-1] < np.pi / 4:
        edges.append(edges[-1] + min(2 * edges[-1], widest))
    edges[-1] = np.pi / 4
    return np.array(edges)


def _cuts(zeros: Real, poles: Real) -> list[_Cut]:
    lengths = np.log1p((poles - zeros) / zeros)
    gaps = np.concatenate([[np.inf], np.log(zeros[1:] / poles[:-1]), [np.inf]])
    found = []
    for own, low in enumerate(zeros.tolist()):
        others = np.arange(len(poles)) != own
        length, below, above = float(lengths[own]), float(gaps[own]), float(gaps[own + 1])
        found.append(
            _Cut(low=low, length=length, below=below, above=above, zeros=zeros[others], poles=poles[others])
        )
    return found


def _clearance(rates: Real, strengths: Real, avoid: Real | None) -> float:
    """Return the smallest distance between two sets of rates, over the strength of the first."""
    if avoid is None or not len(avoid) or not len(rates):
        return np.inf
    return float(np.min(np.abs(rates[:, None] - avoid[None, :]) / strengths[:, None]))
