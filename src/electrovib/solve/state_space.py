"""The stack as physical states: charge between the layers, polarisation in them, and what lies in series.

A layer's bound displacement is that of the plate plus all free charge between, D_k = D_1 + Q_k, and its field
is what the slow polarisation leaves of it, E_k = (D_1 + Q_k - P_k)/(eps0 high_k). The thicknesses then add up
to the voltage, which gives D_1. Modes need fixed thicknesses and conduction in proportion; these states do not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.conduction import PolarityConduction
from electrovib.solve.modes import merged_terms
from electrovib.solve.section import slabs_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.conduction import Conduction
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.stack import Layer
    from electrovib.solve.transfer import Real


@dataclass(frozen=True, eq=False)
class Moment:
    """Fields and flows at one time, or at n times.

    Parameters
    ----------
    field : ndarray, shape (elements,) or (elements, n)
        V/m; the last element is the body's capacitor, if there is one.
    flow : ndarray, same shape
        Conduction current density [A/m2].
    creep : ndarray, shape (terms,) or (terms, n)
        Rate of change of each polarisation [A/m2].
    elastance : float or ndarray, shape (n,)
        Of all elements at infinite frequency, times area [m2/F].
    loss : float or ndarray, shape (n,)
        Rate at which the voltage across all elements falls without current [V/s].
    """

    field: Real
    flow: Real
    creep: Real
    elastance: Real
    loss: Real


@dataclass(frozen=True, eq=False)
class StackStates:
    """Layers, and a body's capacitor as one more, in series; see `stack_states`.

    Parameters
    ----------
    names : tuple of str
        Layers from the plate to the finger.
    thicknesses, permittivities, conductivities, repeats : ndarray, shape (elements,)
        m; F/m, far above all relaxations; S/m; how often the element is in the circuit.
    leaks : tuple
        Index and law of each leak.
    owners, strengths, rates : ndarray, shape (terms,)
        Element of each Debye term, its strength [F/m], its relaxation rate [1/s].
    charges : ndarray, shape (elements - 1,)
        Free charge between the elements at time 0 [C/m2].
    area, resistance : float
        m2; ohm, in series.
    moving : int or None
        Which layer's thickness is told anew at each time.
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
    moving: int | None

    @property
    def size(self) -> int:
        """How many states there are."""
        return len(self.charges) + len(self.rates) + (self.resistance > 0)

    @property
    def polarities(self) -> tuple[int, ...]:
        """Elements with a leak that has a kink where the field changes its sign."""
        return tuple(index for index, leak in self.leaks if isinstance(leak, PolarityConduction))

    def mixing(self) -> Real:
        """Charge before each element less its slow polarisation, per state; shape (elements, size)."""
        count, interfaces = len(self.thicknesses), len(self.charges)
        found = np.zeros((count, self.size))
        found[:, :interfaces] = np.tri(count, interfaces, -1)
        found[self.owners, interfaces + np.arange(len(self.rates))] = -1.0
        return found

    def start(self) -> Real:
        """State of time 0 at 0 V: charge in its place, nothing polarised; shape (size,)."""
        state = np.zeros(self.size)
        state[: len(self.charges)] = self.charges
        if self.resistance > 0:  # the charge drives a current from the beginning
            held = np.concatenate([[0.0], np.cumsum(self.charges)])
            state[-1] = -float(self.repeats * self.thicknesses / self.permittivities @ held)
        return state

    def with_gap(self, gap: float | Real | None) -> Real:
        """Thickness of each element [m] with the moving one replaced; shape (elements,) or (elements, n)."""
        if gap is None or self.moving is None:
            return self.thicknesses
        rows = np.shape(gap)
        found = np.broadcast_to(_column(self.thicknesses, rows), (len(self.thicknesses), *rows)).copy()
        found[self.moving] = gap
        return found

    def moment(
        self,
        state: Real,
        voltage: float | Real,
        *,
        gap: float | Real | None = None,
        closing: float | Real = 0.0,
        signs: Mapping[int, float | Real] | None = None,
    ) -> Moment:
        """Fields and flows under a voltage.

        Parameters
        ----------
        state : ndarray, shape (size,) or (size, n)
            Charges [C/m2], polarisations [C/m2], and with a resistance the voltage across it [V].
        voltage : float or ndarray, shape (n,)
            Of the plate against ground [V].
        gap, closing : float or ndarray, shape (n,)
            Thickness of the moving layer [m], and its rate of change [m/s].
        signs : mapping of int to float or ndarray, optional
            On which side of its kink each leak of `polarities` is taken; by default that of its field.

        Returns
        -------
        Moment
            Of all elements.
        """
        rows = np.shape(state)[1:]
        interfaces, terms = len(self.charges), len(self.rates)
        thickness = self.with_gap(gap)
        permittivity = _column(self.permittivities, rows)
        weights = _column(self.repeats, rows) * _column(thickness, rows) / permittivity
        held = np.concatenate([np.zeros((1, *rows)), np.cumsum(state[:interfaces], axis=0)])
        polarised = state[interfaces : interfaces + terms]
        slow = np.zeros((len(self.thicknesses), *rows))
        np.add.at(slow, self.owners, polarised)
        apart = held - slow
        across = voltage - state[-1] if self.resistance > 0 else voltage
        elastance = np.sum(weights, axis=0)
        plate = (across - np.sum(weights * apart, axis=0)) / elastance
        field = (plate + apart) / permittivity
        flow = _column(self.conductivities, rows) * field
        for index, leak in self.leaks:
            flow[index] += _leak(leak, field[index], None if signs is None else signs.get(index))
        creep = _column(self.rates, rows) * (_column(self.strengths, rows) * field[self.owners] - polarised)
        lost = flow.copy()
        np.add.at(lost, self.owners, creep)
        loss = np.sum(weights * lost, axis=0)
        if self.moving is not None:
            loss = loss - self.repeats[self.moving] * closing * field[self.moving]
        return Moment(field, flow, creep, elastance, loss)

    def density(self, state: Real, slope: float | Real, moment: Moment) -> Real:
        """Total current density [A/m2] while the voltage changes by `slope` [V/s]."""
        if self.resistance > 0:
            return np.asarray(state[-1] / (self.resistance * self.area))
        return np.asarray((slope + moment.loss) / moment.elastance)

    def rate(self, state: Real, slope: float, moment: Moment) -> Real:
        """Rate of change of the state [its unit/s] while the voltage changes by `slope` [V/s]."""
        parts = [moment.flow[:-1] - moment.flow[1:], moment.creep]
        if self.resistance > 0:
            fall = moment.loss - moment.elastance * self.density(state, slope, moment)
            parts.append(np.array([slope + fall]))
        return np.concatenate(parts)

    def displacement(self, state: Real, moment: Moment, index: int) -> Real:
        """Bound displacement of an element [C/m2]."""
        terms = np.arange(len(self.rates))[self.owners == index] + len(self.charges)
        return np.asarray(self.permittivities[index] * moment.field[index] + np.sum(state[terms], axis=0))

    def named(self, state: Real, moment: Moment, gap: float | Real | None = None) -> dict[str, Real]:
        """Give the voltage across the layers, and each one's field and bound displacement by its name.

        Parameters
        ----------
        state : ndarray, shape (size, n)
            At n times.
        moment : Moment
            Of the same times.
        gap : float or ndarray, shape (n,)
            Thickness of the moving layer [m].

        Returns
        -------
        dict of str to ndarray, shape (n,)
            `stack_voltage` [V], ``field NAME`` [V/m] and ``displacement NAME`` [C/m2].
        """
        thickness, count = self.with_gap(gap), len(self.names)
        drops = moment.field * (thickness if thickness.ndim > 1 else thickness[:, None])
        found = {"stack_voltage": np.asarray(np.sum(drops[:count], axis=0))}
        for index, name in enumerate(self.names):
            found[f"field {name}"] = moment.field[index]
            found[f"displacement {name}"] = self.displacement(state, moment, index)
        return found


def stack_states(
    layers: Mapping[str, Layer],
    debye: Mapping[str, DebyeSum],
    *,
    area: float,
    element: SeriesElement,
    second: float = 0.0,
    moving: str | None = None,
) -> StackStates:
    """Write a stack and its surroundings as physical states.

    Parameters
    ----------
    layers : mapping of str to Layer
        From the plate to the finger, with any number of leaks.
    debye : mapping of str to DebyeSum
        Their polarisations.
    area : float
        Contact area [m2].
    element : SeriesElement
        Source and return path.
    second : float
        First contact area over that of a second, equal stack; 0 for none.
    moving : str, optional
        Layer whose thickness changes in time.

    Returns
    -------
    StackStates
        As many states as there are interfaces, Debye terms, and a resistance.

    Raises
    ------
    InputError
        If a leak or a charge goes with a second contact, or the layer that moves is missing.

    Notes
    -----
    A body's capacitor is one more element, on which the current is spread over the contact area. Initial charge
    is taken to have come from the finger, as `stack_modes` takes it.
    """
    _refuse(layers, second, moving)
    slabs = slabs_of(dict(layers), dict(debye))
    terms = [merged_terms(slab.debye) for slab in slabs]
    owners = np.concatenate([np.full(len(rates), k) for k, (rates, _) in enumerate(terms)])
    columns = np.array([[s.thickness, eps0 * s.debye.high, s.conductivity, 1 + second] for s in slabs])
    charges = [slab.charge for slab in slabs][:-1]
    if element.elastance > 0:
        columns = np.vstack([columns, [area * element.elastance * eps0, eps0, element.rate * eps0, 1.0]])
        charges.append(-sum(charges))
    thicknesses, permittivities, conductivities, repeats = columns.T
    return StackStates(
        tuple(layers),
        thicknesses,
        permittivities,
        conductivities,
        repeats,
        tuple((k, layer.leak) for k, layer in enumerate(layers.values()) if layer.leak is not None),
        owners.astype(np.intp),
        eps0 * np.concatenate([strengths for _, strengths in terms]),
        np.concatenate([rates for rates, _ in terms]),
        np.array(charges, dtype=float),
        area,
        element.resistance,
        None if moving is None else list(layers).index(moving),
    )


def _refuse(layers: Mapping[str, Layer], second: float, moving: str | None) -> None:
    if moving is not None and moving not in layers:
        raise InputError(
            f"motion.distance: it is the thickness of the layer '{moving}', and the stack has"
            f" {', '.join(layers)} only; add a table stack.{moving}"
        )
    for name, layer in layers.items():
        if second and layer.leak is not None:
            raise InputError(
                f"stack.{name}.leak: with a second electrode there are two such layers; use Grounded or Floating"
            )
        if second and layer.initial_charge:
            raise InputError(
                f"stack.{name}.initial_charge goes with one contact only; use Grounded or Floating"
            )


def _leak(leak: Conduction, field: Real, sign: float | Real | None) -> Real:
    """Current density of a leak, on one side of its kink where that is told."""
    if sign is None or not isinstance(leak, PolarityConduction):
        return leak.current_density(field)
    sides = leak.conductivity_positive, leak.conductivity_negative
    return np.asarray(np.where(np.asarray(sign) > 0, *sides) * field)


def _column(values: Real, rows: tuple[int, ...]) -> Real:
    """Stand values of elements beside n times."""
    return values[:, None] if rows and values.ndim == 1 else values
