"""Rough contact with attraction: the gap that makes elastic energy, load and potential least, no gap below 0.

The unknown is the gap where it is open or about to open (primal). Newton's directions come from conjugate gradients in single
precision, preconditioned by the compliance; the exact energy of each round judges them. Where the energy curves downwards,
the state is beyond a pull-in: the direction is then followed to a radius that grows while the energy falls, so that the
state runs down into the next rest and does not step over it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from electrovib.core.arrays import Numbers, Real
from electrovib.solve.rough_contact.cell import Attraction, Cell, Correction, Local, correction

ROUNDS = 300
FIRST_RADIUS = 5.0
"""Of the first step from a state that is not stable, over the step that the preconditioner alone would take."""
GROWTH, SHRINKAGE = 2.0, 3.0
ROUNDING = 1e-10
"""Rise of the energy, over itself, that is no rise."""


class Attracted(NamedTuple):
    """Gap, pressure of the contact, attraction, energy per point; error of the gap over the unit of length, rounds.

    `fell`: the energy curved downwards between start and rest, so that this may be another rest than that near the start.
    """

    gap: Real
    pressure: Real
    attraction: Real
    energy: float
    residual: float
    rounds: int
    fell: bool


class _State(NamedTuple):
    """A gap, the pressure of its displacement, and the potential there."""

    gap: Real
    elastic: Real
    local: Local
    energy: float


def attract(
    heights: Real, cell: Cell, attraction: Attraction, gap: Real, *, load: float, tolerance: float
) -> Attracted:
    """Let a contact that begins with a gap come to rest under load and attraction."""
    state, radius, fell, held = _state(gap, heights, cell, attraction, load), math.inf, False, False
    for rounds in range(ROUNDS):  # noqa: B007 - their number is stated
        found = _direction(state, cell, load, radius, tolerance)
        residual = float(np.abs(found.first).max())
        if residual <= tolerance:
            break
        fell |= found.concave
        if found.concave and math.isinf(radius):
            remainder = -(state.elastic + load + state.local.stress) * _free(state, load)
            radius = FIRST_RADIUS * math.sqrt(max(float(np.vdot(remainder, found.first)), 0.0))
            continue
        trial = _state(np.maximum(state.gap + found.step, 0.0), heights, cell, attraction, load)
        if trial.energy > state.energy + ROUNDING * abs(state.energy):
            radius, held = found.length / SHRINKAGE, True
            continue
        radius *= GROWTH if found.bounded and not held else 1.0
        fell |= _curves_down(state, trial)
        state, held = trial, False
    pressure = np.where(state.gap > 0, 0.0, state.elastic + load + state.local.stress)
    energy = state.energy / heights.size
    return Attracted(state.gap, pressure, state.local.stress, energy, residual, rounds, fell)


def _state(gap: Real, heights: Real, cell: Cell, attraction: Attraction, load: float) -> _State:
    displacement = gap + heights
    elastic, local = cell.pressure(displacement), attraction(gap)
    energy = float(np.vdot(displacement, elastic)) / 2 + load * float(gap.sum()) + float(local.energy.sum())
    return _State(gap, elastic, local, energy)


def _curves_down(before: _State, after: _State) -> bool:
    """Whether the energy is concave at the end of a step, along it: a long step can pass a place that is not stable."""
    step = after.gap - before.gap
    return bool(np.vdot(step, after.elastic - before.elastic) + np.vdot(step * step, after.local.slope) < 0)


def _free(state: _State, load: float) -> Numbers:
    """Places that are open or that the contact does not press together."""
    opening = state.elastic + load + state.local.stress < 0
    return np.asarray((state.gap > 0) | opening)


def _direction(state: _State, cell: Cell, load: float, radius: float, tolerance: float) -> Correction:
    """Return the correction of the gap by the energy's second derivative, stiffness and slope of the attraction."""
    free = _free(state, load)
    weight = free.astype(np.float32)
    force = ((state.elastic + load + state.local.stress) * free).astype(np.float32)
    slope = (state.local.slope * free).astype(np.float32)

    def stiffened(gap: Numbers) -> Numbers:
        return np.asarray(cell.pressure_roughly(gap) * weight + slope * gap)

    def softened(pressure: Numbers) -> Numbers:
        return np.asarray(cell.levelled(pressure) * weight)

    return correction(
        stiffened, softened, -force, radius=radius, worth=lambda first: np.abs(first).max() > tolerance
    )
