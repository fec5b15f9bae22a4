"""Layers of many fingers in series with their circuit, as sums of poles, and the roots of the whole impedance."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.population.together.circuits import ManyCircuits, body_poles, is_there
from electrovib.solve.population.together.layers import ManySlab, common_slots, poles_of
from electrovib.solve.population.together.roots import ManyRootsOf, roots_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real


class SeriesParts:
    """Layers in series, with the capacitor of the body as one more part.

    Parameters
    ----------
    slabs : sequence of ManySlab
        From the plate to the finger.
    circuit : ManyCircuits
        Source, return path and contact area.
    fingers : int
        Number of fingers.

    Attributes
    ----------
    layers : tuple of Poles
        Poles of the layers.
    parts : tuple of Poles
        The same, and those of the capacitor of the body if there is one.
    places : list of list of int
        Slot of each pole of each part.
    nodes, total : ndarray, shape (slots, fingers)
        Rate of each slot [1/s], and its residue in the impedance times area of the whole circuit [ohm m2/s].
    blocks : bool
        Whether a part does not conduct.
    regular : ndarray of bool, shape (fingers,)
        Fingers whose numbers have the form that all share: no conductivity, resistance or strength of 0 where others have
        more, and no two equal rates.
    roots : ManyRootsOf
        Zeros of the impedance.
    """

    def __init__(self, slabs: Sequence[ManySlab], circuit: ManyCircuits, fingers: int) -> None:
        self.circuit, self.fingers = circuit, fingers
        self.layers = tuple(poles_of(slab, fingers) for slab in slabs)
        self.parts = self.layers
        if is_there(circuit.elastance):
            self.parts = (*self.layers, body_poles(circuit, fingers))
        slots, self.places = common_slots(self.parts)
        self.nodes = np.empty((len(slots), fingers))
        for row, rate in zip(self.nodes, slots, strict=True):
            row[:] = rate
        self.blocks = any(isinstance(rate, float) and rate == 0 for rate in slots)
        self.total = np.zeros((len(slots), fingers))
        self.regular = np.ones(fingers, bool)
        for index, (part, mine) in enumerate(zip(self.parts, self.places, strict=True)):
            times = 1 + circuit.second if index < len(self.layers) else 1.0
            for residue, place in zip(part.residues, mine, strict=True):
                self.total[place] += residue * times
            self.regular &= part.regular
        self.roots = self._roots()

    def _roots(self) -> ManyRootsOf:
        constant = self.circuit.area * self.circuit.resistance
        if len(self.nodes) == 1 and not is_there(constant):
            nothing = np.zeros((0, self.fingers))
            return ManyRootsOf(nothing, nothing, np.zeros((0, 1, self.fingers)))
        found, apart = roots_of(self.nodes, self.total, constant, self.regular)
        self.regular &= apart
        return found

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

        `weights` (fingers,); returns `sums` (roots, fingers).
        """
        total = np.zeros_like(self.roots.values)
        with np.errstate(invalid="ignore"):
            for weight, place in zip(weights, self.places[index], strict=True):
                total = total - weight * self.roots.inverses[:, place]
        return total
