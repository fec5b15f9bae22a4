"""Relaxation modes of the stacks of many fingers under a voltage."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.constants import eps0
from electrovib.solve.population.together.arrays import flat
from electrovib.solve.population.together.layers import ManySlab, Poles, common_slots, poles_of
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.population.together.roots import ManyRootsOf, roots_of
from electrovib.solve.population.together.transfers import Transfers

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
    """

    area: Any
    resistance: Any
    elastance: Any
    rate: Any
    second: Any

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
        if _is_there(element.charge):
            raise NotTogetherError("the body carries a charge at time 0")
        return cls(
            area=flat(area),
            resistance=flat(element.resistance),
            elastance=flat(element.elastance),
            rate=flat(element.rate),
            second=flat(second),
        )


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
        if any(_is_there(slab.charge) for slab in slabs):
            raise NotTogetherError("a layer carries a charge at time 0")
        self.poles = [poles_of(slab, fingers) for slab in slabs]
        parts = list(self.poles)
        if _is_there(circuit.elastance):
            parts.append(_body(circuit, fingers))
        slots, places = common_slots(parts)
        self.places = places[: len(self.poles)]
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

    def _roots(self) -> ManyRootsOf:
        constant = self.circuit.area * self.circuit.resistance
        if len(self.nodes) == 1 and not _is_there(constant):
            nothing = np.zeros((0, self.fingers))
            return ManyRootsOf(nothing, nothing, np.zeros((0, 1, self.fingers)))
        found, apart = roots_of(self.nodes, self.total, constant, self.regular)
        self.regular &= apart
        return found

    @property
    def rates(self) -> Real:
        """Rates of the modes [1/s], shape (modes, fingers)."""
        return self.roots.values

    @functools.cached_property
    def forced(self) -> Real:
        """Residues of the current density [A/m2 per volt and second], shape (modes, fingers)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(-1 / self.roots.slope)

    @functools.cached_property
    def elastance(self) -> Real:
        """Sum of all residues, the impedance times s at infinite frequency without resistance, shape (fingers,)."""
        return np.asarray(np.add.reduce(self.total, axis=0))

    def _of_layer(self, index: int, weights: Sequence[Any]) -> Real:
        """Return minus the sum of weight/(root - node) over the poles of a layer, shape (modes, fingers)."""
        total = np.zeros_like(self.rates)
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
        """Return the field of a layer [V/m per volt]."""
        slab, poles = self.slabs[index], self.poles[index]
        drops = self._of_layer(index, poles.residues)
        return Transfers(
            rates=self.rates,
            residues=drops * self.forced / slab.thickness,
            direct=self._at_once(poles) / slab.thickness,
        )

    def displacement(self, index: int) -> Transfers:
        """Return the bound displacement of a layer [C/m2 per volt]."""
        slab, poles = self.slabs[index], self.poles[index]
        drops = self._of_layer(index, poles.bound)
        return Transfers(
            rates=self.rates,
            residues=drops * self.forced,
            direct=self._at_once(poles) / slab.thickness * (eps0 * flat(slab.debye.high)),
        )

    def voltage(self) -> Transfers:
        """Return the voltage across all layers [1]."""
        drops = [self._of_layer(index, poles.residues) for index, poles in enumerate(self.poles)]
        shares = [self._at_once(poles) for poles in self.poles]
        return Transfers(
            rates=self.rates,
            residues=sum(drops[1:], start=drops[0]) * self.forced,
            direct=sum(shares[1:], start=shares[0]),
        )

    def delivered(self) -> Transfers:
        """Return the charge per area that the current has delivered since time 0 [C/m2 per volt]."""
        from electrovib.solve.stack.integrator import INTEGRATING

        residues = -self.forced / self.rates
        direct = 0.0 if _is_there(self.circuit.resistance) else 1 / self.elastance
        if self.blocks:
            return Transfers(rates=self.rates, residues=residues, direct=direct)
        static = 1 / (
            self.circuit.resistance * self.circuit.area + np.add.reduce(self.total / self.nodes, axis=0)
        )
        rates = np.concatenate([self.rates, np.full((1, self.fingers), INTEGRATING)])
        return Transfers(rates=rates, residues=np.concatenate([residues, static[None]]), direct=direct)


def _body(circuit: Circuit, fingers: int) -> Poles:
    """Return the capacitor of the body as a part in series."""
    regular = np.ones(fingers, bool)
    if isinstance(circuit.rate, np.ndarray):
        regular = circuit.rate > 0
    return Poles(
        rates=(circuit.rate,), residues=(circuit.area * circuit.elastance,), bound=(0.0,), regular=regular
    )
