"""Output of filters for straight pieces, in groups of pieces (stretches); equal stretches share one matrix product."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.mechanics.filters.follow import march_through
from electrovib.solve.recursion.blocks import states_before
from electrovib.solve.recursion.hold import weights_of

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Indices, Real
    from electrovib.solve.mechanics.filters.filter import Filter

_ALIKE = 1e-9
"""Relative difference of lengths below which they count as equal."""
_FEW = 64
"""Pieces for each kind of stretch, below which each piece is computed separately."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Stretches:
    """Straight pieces, in stretches that may begin with a discontinuity.

    Parameters
    ----------
    begins, lengths : ndarray, shape (pieces,)
        Begin and duration of the pieces [s].
    divisions, graded : ndarray of int, of bool, shape (stretches,)
        Number of pieces of each stretch, and whether they grow within it.
    force : ndarray, shape (pieces + 1,)
        Input at the begin of each piece, and at the end.
    ends : ndarray, shape (stretches,)
        Input just before the end of each stretch.
    """

    begins: Real
    lengths: Real
    divisions: Indices
    graded: Any
    force: Real
    ends: Real

    def output(self, filter_: Filter, *, held: float) -> Real:
        """Return the output of a filter at the first begin and at the ends of the stretches.

        Returns `output` (stretches + 1,).
        """
        marks = np.cumsum(np.append(0, self.divisions))
        state = filter_.state(float(self.force[0]), held=held)
        kinds, kind = self._kinds(marks)
        if not len(filter_.poles):
            return np.asarray(filter_.direct * self.force[marks])
        if _FEW * kinds > len(self.lengths):
            ends = self.force[1:].copy()
            ends[marks[1:] - 1] = self.ends
            found = march_through(filter_, self.force[:-1], ends, steps=self.lengths, state=state)[marks]
            found[-1] += filter_.direct * (self.force[-1] - self.ends[-1])
            return np.asarray(found)
        states = self._states(filter_, state, marks, kinds, kind)
        weights = np.where(filter_.poles.imag == 0, 1.0, 2.0) * filter_.gains
        return np.asarray((states @ weights).real + filter_.direct * self.force[marks])

    def _kinds(self, marks: Indices) -> tuple[int, Indices]:
        """Return the number of kinds of stretches, equal in length and division, and the kind of each."""
        whole = np.add.reduceat(self.lengths, marks[:-1])
        numbers = np.stack([np.round(np.log(whole) / _ALIKE), self.divisions, self.graded])
        _, kind = np.unique(numbers, axis=1, return_inverse=True)
        kind = np.ravel(kind)
        return int(kind.max()) + 1, kind

    def _states(self, filter_: Filter, state: Complex, marks: Indices, kinds: int, kind: Indices) -> Complex:
        """Return the states of the modes at the begin of every stretch, and at the end."""
        count, poles = len(self.divisions), filter_.poles
        pushes, spans = np.empty((count, len(poles)), complex), np.empty(count)
        order = np.argsort(kind, kind="stable")
        for members in np.split(order, np.cumsum(np.bincount(kind, minlength=kinds))[:-1]):
            first, pieces = marks[members[0]], self.divisions[members[0]]
            lengths = self.lengths[first : first + pieces]
            left = np.append(np.cumsum(lengths[::-1])[::-1], 0.0)  # time to the end of the stretch
            _, start, last = weights_of(np.multiply.outer(lengths, poles))
            after = np.exp(np.multiply.outer(left, poles))
            weights = start * after[1:]
            weights[1:] += (last * after[1:])[:-1]
            inputs = self.force[marks[members][:, np.newaxis] + np.arange(pieces)]
            parts = inputs @ np.concatenate([weights.real, weights.imag], axis=1)
            pushes[members] = parts[:, : len(poles)] + 1j * parts[:, len(poles) :]
            pushes[members] += np.multiply.outer(self.ends[members], last[-1])
            spans[members] = left[0]
        return states_before(pushes, np.multiply.outer(spans, poles), state)
