"""Relaxation modes of the stacks of many fingers under a voltage."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.constants import eps0
from electrovib.solve.population.together.arrays import flat
from electrovib.solve.population.together.layers import ManySlab, Poles, common_slots, poles_of
from electrovib.solve.population.together.roots import ManyRootsOf, roots_of
from electrovib.solve.population.together.transfers import Transfers
from electrovib.solve.stack.integrator import INTEGRATING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import SeriesElement


@dataclass(frozen=True, eq=False, kw_only=True)
class Circuit:
    """What surrounds the layers, each number shared or one for each finger.

    Parameters
    ----------
    area : float or ndarray, shape (fingers,)
        Contact area [m2].
    resistance : float or ndarray, shape (fingers,)
        Series resistance [ohm].
    elastance, rate : float or ndarray, shape (fingers,)
        One over the capacitance of the body [1/F], 0 for none, and the rate of its leak [1/s].
    second : float or ndarray, shape (fingers,)
        First contact area over that of a second, equal stack; 0 for none.
    charge : float or ndarray, shape (fingers,)
        Net charge of the body at time 0 [C].
    """

    area: Any
    resistance: Any
    elastance: Any
    rate: Any
    second: Any
    charge: Any = 0.0

    @classmethod
    def around(cls, *, area: Any, element: SeriesElement, second: Any) -> Circuit:
        """Return the circuit of a series element with columns.

        Parameters
        ----------
        area, second : float or ndarray, shape (fingers, 1)
            Contact area [m2]; first contact area over that of a second [1].
        element : SeriesElement
            Source and return path, its numbers shared or columns.

        Returns
        -------
        Circuit
            The same numbers, as rows.
        """
        return cls(
            area=flat(area),
            resistance=flat(element.resistance),
            elastance=flat(element.elastance),
            rate=flat(element.rate),
            second=flat(second),
            charge=flat(element.charge),
        )


def _column(value: Any) -> Any:
    """Return a shared number as it is, and a row (fingers,) as a column."""
    return value[:, None] if isinstance(value, np.ndarray) and value.ndim == 1 else value


def _is_there(value: Any) -> bool:
    """Return whether a number is not 0 for all fingers."""
    return isinstance(value, np.ndarray) or bool(value)


class ManyModes:
    """Fields of the layers of many fingers per volt of the drive, over common modes.

    Parameters
    ----------
    slabs : sequence of ManySlab
        From the plate to the finger.
    circuit : Circuit
        Source, return path and contact area.
    fingers : int
        Number of fingers.

    Attributes
    ----------
    regular : ndarray of bool, shape (fingers,)
        Fingers whose numbers have the form that all share: no conductivity, resistance or strength of 0 among others above
        it, and no two equal rates.

    Notes
    -----
    The formulas are those of `stack.modes`, with one slot for each pole in the place of sorted nodes.
    """

    def __init__(self, slabs: Sequence[ManySlab], circuit: Circuit, fingers: int) -> None:
        self.slabs, self.circuit, self.fingers = tuple(slabs), circuit, fingers
        self.poles = [poles_of(slab, fingers) for slab in slabs]
        parts = list(self.poles)
        if _is_there(circuit.elastance):
            parts.append(_body(circuit, fingers))
        slots, places = common_slots(parts)
        self.parts, self.places = parts, places
        self.nodes = np.empty((len(slots), fingers))
        for row, rate in zip(self.nodes, slots, strict=True):
            row[:] = rate
        self.blocks = any(isinstance(rate, float) and rate == 0 for rate in slots)
        self.total = np.zeros((len(slots), fingers))
        for index, (part, mine) in enumerate(zip(parts, places, strict=True)):
            times = 1 + circuit.second if index < len(self.poles) else 1.0
            for residue, place in zip(part.residues, mine, strict=True):
                self.total[place] += residue * times
        self.regular = np.ones(fingers, bool)
        for part in parts:
            self.regular &= part.regular
        self.roots = self._roots()
        self._fields: dict[int, Transfers] = {}

    def _roots(self) -> ManyRootsOf:
        constant = self.circuit.area * self.circuit.resistance
        if len(self.nodes) == 1 and not _is_there(constant):
            nothing = np.zeros((0, self.fingers))
            return ManyRootsOf(nothing, nothing, np.zeros((0, 1, self.fingers)))
        found, apart = roots_of(self.nodes, self.total, constant, self.regular)
        self.regular &= apart
        return found

    @functools.cached_property
    def charge(self) -> StackCharge | None:
        """Response to the charge at time 0; None without charge."""
        held = [slab.charge for slab in self.slabs]
        if not any(_is_there(charge) for charge in [*held, self.circuit.charge]):
            return None
        return StackCharge(self, held, self.circuit.charge / self.circuit.area)

    @functools.cached_property
    def rates(self) -> Real:
        """Rates of the modes [1/s], shape (modes, fingers): those that the drive excites, then those of charge alone."""
        if self.charge is None:
            return self.roots.values
        return np.concatenate([self.roots.values, self.nodes[self.charge.shared]])

    def _padded(self, residues: Real) -> Real:
        """Return residues with 0 for the modes that the drive does not excite."""
        if self.charge is None:
            return residues
        return np.concatenate([residues, np.zeros((len(self.charge.shared), self.fingers))])

    @functools.cached_property
    def forced(self) -> Real:
        """Residues of the current density [A/m2 per volt and second], shape (modes, fingers)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(-1 / self.roots.slope)

    @functools.cached_property
    def elastance(self) -> Real:
        """Sum of all residues, the impedance times s at infinite frequency without resistance, shape (fingers,)."""
        return np.asarray(np.add.reduce(self.total, axis=0))

    def of_part(self, index: int, weights: Sequence[Any]) -> Real:
        """Return minus the sum of weight/(root - node) over the poles of a part.

        Parameters
        ----------
        index : int
            Layer, or the capacitor of the body after them.
        weights : sequence of float or ndarray, shape (fingers,)
            Weight of each pole, in any unit.

        Returns
        -------
        sums : ndarray, shape (roots, fingers)
            In the unit of the weights times s.
        """
        total = np.zeros_like(self.roots.values)
        with np.errstate(invalid="ignore"):
            for weight, place in zip(weights, self.places[index], strict=True):
                total = total - weight * self.roots.inverses[:, place]
        return total

    def _at_once(self, poles: Poles) -> Any:
        """Return the share of a layer in the voltage at infinite frequency."""
        if _is_there(self.circuit.resistance):
            return 0.0
        return sum(poles.residues[1:], start=poles.residues[0]) / self.elastance

    def field(self, index: int) -> Transfers:
        """Return the field of a layer [V/m per volt], computed once."""
        if index not in self._fields:
            self._fields[index] = self._field(index)
        return self._fields[index]

    def _field(self, index: int) -> Transfers:
        slab, poles = self.slabs[index], self.poles[index]
        drops = self.of_part(index, poles.residues)
        return Transfers(
            rates=self.rates,
            residues=self._padded(drops * self.forced / slab.thickness),
            direct=self._at_once(poles) / slab.thickness,
            free=self.charge and self.charge.left(index, poles.residues) / slab.thickness,
        )

    def displacement(self, index: int) -> Transfers:
        """Return the bound displacement of a layer [C/m2 per volt]."""
        slab, poles = self.slabs[index], self.poles[index]
        if not slab.debye.strengths:
            return self.field(index) * (eps0 * _column(slab.debye.high))
        drops = self.of_part(index, poles.bound)
        return Transfers(
            rates=self.rates,
            residues=self._padded(drops * self.forced),
            direct=self._at_once(poles) / slab.thickness * (eps0 * flat(slab.debye.high)),
            free=self.charge and self.charge.left(index, poles.bound),
        )

    def voltage(self) -> Transfers:
        """Return the voltage across all layers [1]."""
        fields = [self.field(index) * _column(slab.thickness) for index, slab in enumerate(self.slabs)]
        return sum(fields[1:], start=fields[0])

    def delivered(self, interface: int) -> Transfers:
        """Return the charge per area before a layer since time 0, by current and initial charge [C/m2 per volt].

        Parameters
        ----------
        interface : int
            Number of layers on the plate's side.

        Returns
        -------
        charge : Transfers
            Integral of the current density, with a mode that integrates where every layer conducts.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            residues = self._padded(-self.forced / self.roots.values)
        direct = 0.0 if _is_there(self.circuit.resistance) else 1 / self.elastance
        rates, free = self.rates, None
        if not self.blocks:
            static = 1 / (
                self.circuit.resistance * self.circuit.area + np.add.reduce(self.total / self.nodes, axis=0)
            )
            rates = np.concatenate([rates, np.full((1, self.fingers), INTEGRATING)])
            residues = np.concatenate([residues, static[None]])
        if self.charge is not None:
            left, constant = self.charge.delivered(interface)
            nothing = np.zeros((len(rates) - len(left), self.fingers))
            free = np.concatenate([left, nothing, constant[None]])
            rates = np.concatenate([rates, np.zeros((1, self.fingers))])
            residues = np.concatenate([residues, np.zeros((1, self.fingers))])
        return Transfers(rates=rates, residues=residues, direct=direct, free=free)


class StackCharge:
    """Response of the stacks of many fingers to charge at time 0, as `stack.modes.stack_modes` describes it.

    Parameters
    ----------
    modes : ManyModes
        Of the stacks.
    charges : sequence of float or ndarray, shape (fingers,)
        Free charge on the face of each layer towards the finger [C/m2].
    of_body : float or ndarray, shape (fingers,)
        Charge of the body over the contact area [C/m2].

    Attributes
    ----------
    shared : list of int
        Slots where more than one part has a pole.
    """

    def __init__(self, modes: ManyModes, charges: Sequence[Any], of_body: Any) -> None:
        self.modes = modes
        held = [np.zeros(modes.fingers)]
        for charge in charges:
            held.append(held[-1] + charge)
        elastances = [sum(part.residues[1:], start=part.residues[0]) for part in modes.parts]
        on_parts = [*held[: len(modes.poles)], held[-1] + of_body][: len(modes.parts)]
        whole = sum(elastance * on for elastance, on in zip(elastances, on_parts, strict=True))
        image = whole / sum(elastances)
        self.before = [each - image for each in held]
        self.on_parts = [each - image for each in on_parts]
        counts = [sum(slot in mine for mine in modes.places) for slot in range(len(modes.nodes))]
        self.shared = [slot for slot, count in enumerate(counts) if count > 1]

    @functools.cached_property
    def charged(self) -> Real:
        """Residues of the current density due to charge, shape (roots, fingers)."""
        driving = np.zeros_like(self.modes.roots.values)
        for index, (part, on) in enumerate(zip(self.modes.parts, self.on_parts, strict=True)):
            driving = driving + on * self.modes.of_part(index, part.residues)
        return -driving * self.modes.forced

    def left(self, index: int, weights: Sequence[Any]) -> Real:
        """Return amplitudes at time 0 of the response of a layer to charge.

        Parameters
        ----------
        index : int
            The layer.
        weights : sequence of float or ndarray, shape (fingers,)
            Weight of each pole: residues for the voltage across the layer, `Poles.bound` for its bound displacement.

        Returns
        -------
        left : ndarray, shape (modes, fingers)
            In the unit of the weights times C/m2.
        """
        modes = self.modes
        driven = modes.of_part(index, weights) * self.charged
        idle = np.zeros((len(self.shared), modes.fingers))
        for row, slot in zip(idle, self.shared, strict=True):
            if slot not in modes.places[index]:
                continue
            driving = np.zeros(modes.fingers)
            for part, mine, on in zip(modes.parts, modes.places, self.on_parts, strict=True):
                if slot in mine:
                    driving = driving + part.residues[mine.index(slot)] * on
            share = driving / modes.total[slot]
            row[:] = weights[modes.places[index].index(slot)] * (self.before[index] - share)
        return np.concatenate([driven, idle])

    def delivered(self, interface: int) -> tuple[Real, Real]:
        """Return amplitudes at time 0 of the charge before a layer, and its constant part.

        Parameters
        ----------
        interface : int
            Number of layers on the plate's side.

        Returns
        -------
        left : ndarray, shape (modes, fingers)
            Relaxing part [C/m2].
        constant : ndarray, shape (fingers,)
            Constant part [C/m2].
        """
        driven = -self.charged / self.modes.roots.values
        constant = self.before[interface] - np.add.reduce(driven, axis=0)
        return self.modes._padded(driven), constant  # noqa: SLF001 - of the same module


def _body(circuit: Circuit, fingers: int) -> Poles:
    """Return the capacitor of the body as a part in series."""
    regular = np.ones(fingers, bool)
    if isinstance(circuit.rate, np.ndarray):
        regular = circuit.rate > 0
    return Poles(
        rates=(circuit.rate,), residues=(circuit.area * circuit.elastance,), bound=(0.0,), regular=regular
    )
