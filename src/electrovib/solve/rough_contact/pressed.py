"""Rough contact without attraction: the pressure at the places of contact, from coarse grids to the fine one.

The unknown is the pressure where surfaces touch (dual); elsewhere it is 0. One round corrects it there until the gap is 0,
then takes out what pulls and adds what penetrates (primal-dual active set). The correction is in single precision,
preconditioned by the stiffness of the body at every wave number, restricted to the contact; the exact gap of each round is in
double precision and judges it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from electrovib.core.arrays import Indices, Numbers, Real
from electrovib.solve.rough_contact.cell import Cell, correction

COARSEST = 32
"""Points along a side of the coarsest grid, at least."""
COARSE = 1e-2
"""Penetration over the rms height that a coarse grid may leave."""
ROUNDS = 200
PATIENCE = 30
"""Rounds of whole steps, of which nearly every contact needs less than half."""
SHRINKAGE = 3.0
ROUNDING = 1e-12
"""Rise of the energy, over itself, that is no rise."""


class Pressed(NamedTuple):
    """Pressure, gap, largest penetration over the unit of length, and rounds on the finest grid."""

    pressure: Real
    gap: Real
    residual: float
    rounds: int


def press(heights: Real, cell: Cell, *, load: float, tolerance: float) -> Pressed:
    """Press heights with a mean pressure against the body until no place penetrates by more than a tolerance.

    The gap is levelled so that its mean, weighted with the pressure, is 0.
    """
    pressure = _start(heights, cell, load=load, tolerance=tolerance)
    padded = np.zeros(heights.shape, dtype=np.float32)
    least, former, step = np.inf, pressure, np.zeros(0)
    for rounds in range(ROUNDS):
        np.maximum(pressure, 0.0, out=pressure)
        pressure *= load * pressure.size / pressure.sum()
        gap = cell.displacement(pressure)
        if rounds >= PATIENCE:  # the places of contact may return without end: from here on the energy falls
            energy = float(np.vdot(pressure, gap / 2 - heights))
            if step.size and energy > least + ROUNDING * abs(least):
                step /= SHRINKAGE
                pressure = former + step
                continue
            least, former, step = energy, pressure.copy(), np.zeros(heights.shape)
        gap -= heights
        gap -= np.vdot(pressure, gap) / pressure.sum()
        residual = -float(gap.min())
        if residual <= tolerance:
            break
        inside = np.flatnonzero((pressure > 0) | (gap < 0))
        change = _corrected(gap, inside, cell, padded)
        pressure.ravel()[inside] += change
        if step.size:
            step.ravel()[inside] = change
    return Pressed(pressure, gap, residual, rounds)


def _corrected(gap: Real, inside: Indices, cell: Cell, padded: Numbers) -> Numbers:
    """Return the change of pressure, with mean 0, that closes the gaps of some places."""
    flat = padded.ravel()
    padded.fill(0.0)

    def within(answer: Numbers) -> Numbers:
        found = answer.ravel()[inside]
        return np.asarray(found - found.mean())

    def displaced(pressure: Numbers) -> Numbers:
        flat[inside] = pressure
        return within(cell.displacement_roughly(padded))

    def stiffened(displacement: Numbers) -> Numbers:
        flat[inside] = displacement
        return within(cell.pressure_roughly(padded))

    return correction(displaced, stiffened, within(-gap.astype(np.float32))).step


def _start(heights: Real, cell: Cell, *, load: float, tolerance: float) -> Real:
    """Return the pressure of a coarser grid, spread; on the coarsest one the upper half of the heights."""
    if any(length % 2 or length < 2 * COARSEST for length in heights.shape):
        upper: Real = np.maximum(heights - np.median(heights), 0.0) + (np.ptp(heights) == 0)
        return upper
    coarse, coarser = heights[::2, ::2], cell.coarser()
    found = press(coarse, coarser, load=load, tolerance=max(COARSE, tolerance)).pressure
    cell.exact += coarser.exact / 4
    cell.single += coarser.single / 4
    pressure = np.empty(heights.shape)
    pressure[::2, ::2] = found
    pressure[1::2, ::2] = (found + np.roll(found, -1, 0)) / 2
    pressure[:, 1::2] = (pressure[:, ::2] + np.roll(pressure[:, ::2], -1, 1)) / 2
    return pressure
