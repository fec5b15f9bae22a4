"""Relaxation modes of the stacks of many fingers under a voltage."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.constants import eps0
from electrovib.solve.population.together.arrays import flat
from electrovib.solve.population.together.charge import StackCharge
from electrovib.solve.population.together.circuits import ManyCircuits, is_there
from electrovib.solve.population.together.layers import ManySlab, Poles
from electrovib.solve.population.together.series import SeriesParts
from electrovib.solve.population.together.transfers import Transfers
from electrovib.solve.stack.transfer import INTEGRATING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


class ManyModes:
    """Fields of the layers of many fingers per volt of the drive, over common modes.

    Parameters
    ----------
    slabs : sequence of ManySlab
        From the plate to the finger.
    circuit : ManyCircuits
        Source, return path and contact area.
    fingers : int
        Number of fingers.

    Notes
    -----
    The formulas are those of `stack.modes`, with one slot for each pole in the place of sorted nodes.
    """

    def __init__(
        self,
        slabs: Sequence[ManySlab],
        circuit: ManyCircuits,
        fingers: int,
    ) -> None:
        self.slabs, self.circuit, self.fingers = tuple(slabs), circuit, fingers
        self.series = SeriesParts(slabs, circuit, fingers)
        self._fields: dict[int, Transfers] = {}

    @property
    def regular(self) -> NDArray[np.bool_]:
        """Fingers whose numbers have the form that all share, shape (fingers,)."""
        return self.series.regular

    @functools.cached_property
    def charge(self) -> StackCharge | None:
        """Response to the charge at time 0; None without charge."""
        held = [slab.charge for slab in self.slabs]
        if not any(is_there(charge) for charge in [*held, self.circuit.charge]):
            return None
        return StackCharge(self.series, held, self.circuit.charge / self.circuit.area)

    @functools.cached_property
    def rates(self) -> Real:
        """Rates of the modes [1/s], shape (modes, fingers): those that the drive excites, then those of charge alone."""
        if self.charge is None:
            return self.series.roots.values
        return np.concatenate([self.series.roots.values, self.series.nodes[self.charge.shared]])

    def _padded(self, residues: Real) -> Real:
        """Return residues with 0 for the modes that the drive does not excite."""
        if self.charge is None:
            return residues
        return np.concatenate([residues, np.zeros((len(self.charge.shared), self.fingers))])

    def _at_once(self, poles: Poles) -> Any:
        """Return the share of a layer in the voltage at infinite frequency."""
        if is_there(self.circuit.resistance):
            return 0.0
        return sum(poles.residues[1:], start=poles.residues[0]) / self.series.elastance

    def field(self, index: int) -> Transfers:
        """Return the field of a layer [V/m per volt], computed once."""
        if index not in self._fields:
            self._fields[index] = self._field(index)
        return self._fields[index]

    def _field(self, index: int) -> Transfers:
        slab, poles = self.slabs[index], self.series.layers[index]
        drops = self.series.of_part(index, poles.residues)
        return Transfers(
            rates=self.rates,
            residues=self._padded(drops * self.series.forced / slab.thickness),
            direct=self._at_once(poles) / slab.thickness,
            free=None if self.charge is None else self.charge.left(index, poles.residues) / slab.thickness,
        )

    def displacement(self, index: int) -> Transfers:
        """Return the bound displacement of a layer [C/m2 per volt]."""
        slab, poles = self.slabs[index], self.series.layers[index]
        if not slab.debye.strengths:
            return self.field(index).times(eps0 * _column(slab.debye.high))
        drops = self.series.of_part(index, poles.bound)
        return Transfers(
            rates=self.rates,
            residues=self._padded(drops * self.series.forced),
            direct=self._at_once(poles) / slab.thickness * (eps0 * flat(slab.debye.high)),
            free=None if self.charge is None else self.charge.left(index, poles.bound),
        )

    def voltage(self) -> Transfers:
        """Return the voltage across all layers [1]."""
        fields = [self.field(index).times(_column(slab.thickness)) for index, slab in enumerate(self.slabs)]
        total = fields[0]
        for field in fields[1:]:
            total = total + field
        return total

    def delivered(self, interface: int) -> Transfers:
        """Return the charge per area before a layer since time 0, by current and initial charge [C/m2 per volt]."""
        with np.errstate(divide="ignore", invalid="ignore"):
            residues = self._padded(-self.series.forced / self.series.roots.values)
        direct = 0.0 if is_there(self.circuit.resistance) else 1 / self.series.elastance
        rates, free = self.rates, None
        if not self.series.blocks:
            static = 1 / (
                self.circuit.resistance * self.circuit.area
                + np.add.reduce(self.series.total / self.series.nodes, axis=0)
            )
            rates = np.concatenate([rates, np.full((1, self.fingers), INTEGRATING)])
            residues = np.concatenate([residues, static[None]])
        if self.charge is not None:
            left, constant = self.charge.delivered(interface)
            left = self._padded(left)
            nothing = np.zeros((len(rates) - len(left), self.fingers))
            free = np.concatenate([left, nothing, constant[None]])
            rates = np.concatenate([rates, np.zeros((1, self.fingers))])
            residues = np.concatenate([residues, np.zeros((1, self.fingers))])
        return Transfers(rates=rates, residues=residues, direct=direct, free=free)


def _column(value: Any) -> Any:
    """Return a shared number as it is, and a row (fingers,) as a column."""
    return value[:, None] if isinstance(value, np.ndarray) and value.ndim == 1 else value
