"""Layers in series as physical states: fields, conduction currents and rates of change under a voltage."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.conduction import PolarityConduction
from electrovib.solve.stack.keys import DisplacementOf, FieldOf

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.conduction import Conduction
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

    def mixing(self) -> Real:
        """Return the charge before each element minus its slow polarisation, per state; shape (elements, size)."""
        count, interfaces = len(self.thicknesses), len(self.charges)
        found = np.zeros((count, self.size))
        found[:, :interfaces] = np.tri(count, interfaces, -1)
        found[self.owners, interfaces + np.arange(len(self.rates))] = -1.0
        return found

    def start(self) -> Real:
        """Return the state at time 0 and 0 V: charges with their image on the plate, no polarisation; shape (size,)."""
        state = np.zeros(self.size)
        state[: len(self.charges)] = self.charges
        return state

    def with_gap(self, gap: float | Real | None) -> Real:
        """Return the thickness of each element [m], with that of the moving one; shape (elements,) or (elements, n)."""
        if gap is None or self.moving is None:
            return self.thicknesses
        rows = np.shape(gap)
        found = np.broadcast_to(_column(self.thicknesses, rows), (len(self.thicknesses), *rows)).copy()
        found[self.moving] = gap
        return found

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

        `state` (size,) [C/m2], `voltage` (n,) [V], `gap`, `closing` (n,) [m].
        """
        if gap is None and self.moving is None:
            return self._fixed_moment(state, voltage, signs)
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
        return Moment(field=field, flow=flow, creep=creep, elastance=elastance, loss=loss)

    @functools.cached_property
    def _matrix(self) -> tuple[Real, Real, Real]:
        """Linear map from state and voltage to the fields of a fixed stack, owners of the terms, and the weights.

        The rates of change are differences of large numbers and are formed from the fields, never from sums of states.
        """
        every = np.eye(self.size + 1)
        fields = (
            replace(self, leaks=()).moment(every[:-1], voltage=every[-1], gap=0.0).field
        )  # any gap: none moves
        owners = np.equal.outer(np.arange(len(self.thicknesses)), self.owners).astype(float)
        return fields, owners, self.repeats * self.thicknesses / self.permittivities

    def _fixed_moment(self, state: Real, voltage: float | Real, signs: Mapping[int, int] | None) -> Moment:
        """Return the same as `moment` for a gap that does not move: products with small matrices, a time in a row."""
        fields, owners, weights = self._matrix
        rows, first = state.T, len(self.charges)
        field = rows @ fields[:, :-1].T + np.multiply.outer(voltage, fields[:, -1])
        flow = self.conductivities * field
        for index, leak in self.leaks:
            flow[..., index] += _leak(leak, field[..., index], None if signs is None else signs.get(index))
        polarised = rows[..., first : first + len(self.rates)]
        creep = self.rates * (self.strengths * field[..., self.owners] - polarised)
        loss = (flow + creep @ owners.T) @ weights
        elastance = np.asarray(np.sum(weights))
        return Moment(field=field.T, flow=flow.T, creep=creep.T, elastance=elastance, loss=loss)

    def density(self, state: Real, moment: Moment, *, slope: float | Real) -> Real:
        """Return the total current density.

        `state` (size,), `slope` (n,) [V/s]; returns `density` () [A/m2].
        """
        if self.resistance > 0:
            return np.asarray(state[-1] / (self.resistance * self.area))
        return np.asarray((slope + moment.loss) / moment.elastance)

    def rate(self, state: Real, moment: Moment, *, slope: float | Real) -> Real:
        """Return the rate of change of the state.

        `state` (size,), `slope` (n,) [V/s]; returns `rate` (size,) [A/m2].
        """
        parts = [moment.flow[:-1] - moment.flow[1:], moment.creep]
        if self.resistance > 0:
            fall = moment.loss - moment.elastance * self.density(state, moment, slope=slope)
            parts.append(np.asarray(slope + fall)[None])
        return np.concatenate(parts)

    def displacement(self, state: Real, moment: Moment, index: int) -> Real:
        """Return the bound displacement of an element.

        `state` (size,); returns `displacement` () [C/m2].
        """
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


def _column(values: Real, rows: tuple[int, ...]) -> Real:
    """Return values of elements as a column that broadcasts over n times."""
    return values[:, None] if rows and values.ndim == 1 else values
