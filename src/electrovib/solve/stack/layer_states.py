"""The stack as physical states: charge between the layers, polarisation in them, and series elements.

The bound displacement of a layer is that of the first layer plus the free charge between them, D_k = D_1 + Q_k, and
its field follows without the slow polarisation, E_k = (D_1 + Q_k - P_k)/(eps0 high_k). The sum of E_k times thickness
is the voltage, which gives D_1. Modes require fixed thicknesses and ohmic conduction; these states do not.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.conduction import PolarityConduction
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.stack import INTERFACE, beside_interface, interface_place, roles_of
from electrovib.solve.stack.keys import DisplacementOf, FieldOf
from electrovib.solve.stack.modes import Slab, merged_terms
from electrovib.solve.stack.section import slabs_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.conduction import Conduction
    from electrovib.physics.stack import Layer
    from electrovib.solve.stack.keys import Key


@dataclass(frozen=True, eq=False, kw_only=True)
class Moment:
    """Fields and conduction currents at one time, or at n times.

    Parameters
    ----------
    field : ndarray, shape (elements,) or (elements, n)
        Field of each element [V/m]; the last is the capacitor of the body, if there is one.
    flow : ndarray, same shape
        Conduction current density [A/m2].
    creep : ndarray, shape (terms,) or (terms, n)
        Rate of change of each polarisation [A/m2].
    elastance : float or ndarray, shape (n,)
        Elastance of all elements at infinite frequency, times area [m2/F].
    loss : float or ndarray, shape (n,)
        Rate at which the voltage across all elements falls without current [V/s].
    """

    field: Real
    flow: Real
    creep: Real
    elastance: Real
    loss: Real


@dataclass(frozen=True, eq=False, kw_only=True)
class StackStates:
    """Layers in series, with the capacitor of the body as one more element; see `stack_states`.

    Parameters
    ----------
    names : tuple of str
        Layers from the plate to the finger.
    thicknesses, permittivities, conductivities, repeats : ndarray, shape (elements,)
        Thickness [m], permittivity far above all relaxations [F/m], conductivity [S/m], and number of such elements in
        the circuit.
    leaks : tuple
        Index and law of each leak.
    owners, strengths, rates : ndarray, shape (terms,)
        Element of each Debye term, its strength [F/m], its relaxation rate [1/s].
    charges : ndarray, shape (elements - 1,)
        Free charge between the elements at time 0 [C/m2].
    area, resistance : float
        Contact area [m2]; series resistance [ohm].
    interface : int
        Index of the gap, or of the element of zero thickness in its place where the stack has none.
    moving : int or None
        Index of the layer whose thickness varies in time.
    """

    names: tuple[str, ...]
    thicknesses: Real
    permittivities: Real
    conductivities: Real
    repeats: Real
    leaks: tuple[tuple[int, Conduction], ...]
    owners: NDArray[np.intp]
    strengths: Real
    rates: Real
    charges: Real
    area: float
    resistance: float
    interface: int
    moving: int | None

    @property
    def size(self) -> int:
        """Number of states."""
        return len(self.charges) + len(self.rates) + (self.resistance > 0)

    @functools.cached_property
    def polarities(self) -> tuple[int, ...]:
        """Elements with a leak that has a kink where the field changes its sign."""
        return tuple(index for index, leak in self.leaks if isinstance(leak, PolarityConduction))

    def start(self) -> Real:
        """Return the state at time 0 and 0 V: charges with their image on the plate, no polarisation; shape (size,)."""
        state = np.zeros(self.size)
        state[: len(self.charges)] = self.charges
        return state

    def with_gap(self, gap: float | Real | None) -> Real:
        """Return the thickness of each element [m], with that of the moving one; shape (elements,) or (elements, n)."""
        if gap is None or self.moving is None:
            return self.thicknesses
        found = np.empty((*np.shape(gap), len(self.thicknesses)))
        found[:] = self.thicknesses
        found[..., self.moving] = gap
        return found.T

    def moment(
        self,
        state: Real,
        *,
        voltage: float | Real,
        gap: float | Real | None = None,
        closing: float | Real = 0.0,
        signs: Mapping[int, int] | None = None,
    ) -> Moment:
        """Return fields and conduction currents under a voltage.

        `state` (size,) or (size, n): charges and polarisations [C/m2], and the voltage of a series resistance [V]; `voltage` [V],
        `gap` [m] and its rate of change `closing` [m/s] at one time or at n times; `signs` fixes the side of a leak with a kink.
        """
        rows, (apart, owners, weights, fields) = state.T, self._matrices
        if self.moving is None:
            field = rows @ fields[:-1] + np.multiply.outer(voltage, fields[-1])
        else:
            weights = self.repeats * self.with_gap(gap).T / self.permittivities
            across = voltage - rows[..., -1] if self.resistance > 0 else voltage
            field = self._fields(rows @ apart, np.asarray(across), weights)
        flow = self.conductivities * field
        for index, leak in self.leaks:
            flow[..., index] += _leak(leak, field[..., index], None if signs is None else signs.get(index))
        first = len(self.charges)
        polarised = rows[..., first : first + len(self.rates)]
        creep = self.rates * (self.strengths * field[..., self.owners] - polarised)
        loss = ((flow + creep @ owners) * weights).sum(axis=-1)
        if self.moving is not None:
            loss = loss - self.repeats[self.moving] * closing * field[..., self.moving]
        elastance = weights.sum(axis=-1)
        return Moment(field=field.T, flow=flow.T, creep=creep.T, elastance=elastance, loss=loss)

    def _fields(self, apart: Real, across: Real, weights: Real) -> Real:
        """Return the field of each element, (..., elements), from the charge before it less its slow polarisation."""
        plate = (across - (weights * apart).sum(axis=-1)) / weights.sum(axis=-1)
        return np.asarray((plate[..., None] + apart) / self.permittivities)

    @functools.cached_property
    def _matrices(self) -> tuple[Real, Real, Real, Real]:
        """Charge before each element less its slow polarisation, elements of the terms, weights, fields; per state and voltage.

        The last is that of a fixed stack. The rates of change are differences of large numbers and are formed from the fields,
        never from sums of states.
        """
        apart, first = np.zeros((self.size, len(self.thicknesses))), len(self.charges)
        apart[:first] = np.tri(len(self.thicknesses), first, -1).T
        apart[first + np.arange(len(self.rates)), self.owners] = -1.0
        owners = np.equal.outer(self.owners, np.arange(len(self.thicknesses))).astype(float)
        weights = self.repeats * self.thicknesses / self.permittivities
        across = np.append(np.zeros(self.size), 1.0)
        if self.resistance > 0:
            across[self.size - 1] = -1.0
        every = np.vstack([apart, np.zeros(len(weights))])
        return apart, owners, weights, self._fields(every, across, weights)

    def density(self, state: Real, moment: Moment, *, slope: float | Real) -> Real:
        """Return the total current density [A/m2] under a rate of change of the voltage [V/s]."""
        if self.resistance > 0:
            return np.asarray(state[-1] / (self.resistance * self.area))
        return np.asarray((slope + moment.loss) / moment.elastance)

    def rate(self, state: Real, moment: Moment, *, slope: float | Real) -> Real:
        """Return the rate of change of the state [its unit per s] under a rate of change of the voltage [V/s]."""
        parts = [moment.flow[:-1] - moment.flow[1:], moment.creep]
        if self.resistance > 0:
            fall = moment.loss - moment.elastance * self.density(state, moment, slope=slope)
            parts.append(np.asarray(slope + fall)[None])
        return np.concatenate(parts)

    def displacement(self, state: Real, moment: Moment, index: int) -> Real:
        """Return the bound displacement of an element [C/m2]."""
        terms = np.arange(len(self.rates))[self.owners == index] + len(self.charges)
        return np.asarray(self.permittivities[index] * moment.field[index] + np.sum(state[terms], axis=0))

    def named(self, state: Real, moment: Moment, *, gap: float | Real | None = None) -> dict[Key, Real]:
        """Return the voltage across the layers, and each one's field and bound displacement.

        `state` (size, n), `gap` (n,) [m].
        """
        thickness, count = self.with_gap(gap), len(self.names)
        drops = moment.field * (thickness if thickness.ndim > 1 else thickness[:, None])
        found: dict[Key, Real] = {"stack_voltage": np.asarray(np.sum(drops[:count], axis=0))}
        for index, name in enumerate(self.names):
            found[FieldOf(name)] = moment.field[index]
            found[DisplacementOf(name)] = self.displacement(state, moment, index)
        return found


def _leak(leak: Conduction, field: Real, sign: int | None) -> Real:
    """Return the current density of a leak [A/m2], for a given sign of the field if there is one."""
    if sign is None or not isinstance(leak, PolarityConduction):
        return leak.current_density(field)
    return (leak.conductivity_positive if sign > 0 else leak.conductivity_negative) * field


def stack_states(
    layers: Mapping[str, Layer],
    debye: Mapping[str, DebyeSum],
    *,
    area: float,
    element: SeriesElement,
    second: float = 0.0,
    moving: str | None = None,
) -> StackStates:
    """Return the physical states of a stack with source and return path.

    The capacitor of the body is one more element, with its current as a density over the contact area. A
    stack without a gap has one of zero thickness at its interface, `INTERFACE`: its field is that of a
    vanishing gap.
    """
    _refuse(layers, second)
    roles, names = roles_of(layers), list(layers)
    slabs = slabs_of(dict(layers), dict(debye))
    place = interface_place(roles.values())
    if beside_interface(roles, "gap") is None:
        names.insert(place, INTERFACE)
        slabs.insert(place, Slab(0.0, DebyeSum(1.0, (), ()), 0.0))
    terms = [merged_terms(slab.debye) for slab in slabs]
    owners = np.concatenate([np.full(len(rates), k) for k, (rates, _) in enumerate(terms)])
    columns = np.array([[s.thickness, eps0 * s.debye.high, s.conductivity, 1 + second] for s in slabs])
    charges = [slab.charge for slab in slabs][:-1]
    if element.elastance > 0:
        columns = np.vstack([columns, [area * element.elastance * eps0, eps0, element.rate * eps0, 1.0]])
        charges.append(element.charge / area)
    thicknesses, permittivities, conductivities, repeats = columns.T
    return StackStates(
        names=tuple(names),
        thicknesses=thicknesses,
        permittivities=permittivities,
        conductivities=conductivities,
        repeats=repeats,
        leaks=tuple(
            (names.index(name), layer.leak) for name, layer in layers.items() if layer.leak is not None
        ),
        owners=owners.astype(np.intp),
        strengths=eps0 * np.concatenate([strengths for _, strengths in terms]),
        rates=np.concatenate([rates for rates, _ in terms]),
        charges=np.array(charges, dtype=float),
        area=area,
        resistance=element.resistance,
        interface=place,
        moving=None if moving is None else names.index(moving),
    )


def _refuse(layers: Mapping[str, Layer], second: float) -> None:
    for name, layer in layers.items():
        if second and layer.leak is not None:
            raise InputError(
                f"stack.{name}.leak: with a second electrode there would be two such layers, which no solver supports; use"
                " Grounded or Floating"
            )
        if second and layer.initial_charge:
            raise InputError(
                f"stack.{name}.initial_charge: supported with one contact only; use Grounded or Floating"
            )
