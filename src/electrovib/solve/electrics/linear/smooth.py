"""Response to a smooth drive: a polynomial through each step, integrated in closed form."""

from __future__ import annotations

import functools
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.parts import Smooth

DEGREE = 6
RADIANS_PER_STEP = 0.3
"""Phase of the fastest oscillation in one step: interpolation error below 1e-10 of the amplitude."""


_STEPS_AT_ONCE = 4096


def smooth_states(part: Smooth, rates: Real, times: Real) -> Real:
    """Compute the states of the modes x' = rate (v - x) under a smooth drive, from rest.

    `rates` (modes,), `times` (n,) [s]; returns `states` (modes, n) [V].
    """
    grid = _grid(part, times)
    wanted = np.searchsorted(grid, times)
    found, state = np.zeros((len(rates), len(times))), np.zeros(len(rates))
    for first in range(0, len(grid) - 1, _STEPS_AT_ONCE):
        piece = grid[first : first + _STEPS_AT_ONCE + 1]
        states = _march(part, rates, piece, state)
        here = slice(*np.searchsorted(wanted, [first, first + len(piece)]))
        found[:, here] = states[:, wanted[here] - first]
        state = states[:, -1]
    return found


def _march(part: Smooth, rates: Real, grid: Real, state: Real) -> Real:
    """Return the states at the points of a grid, from that at its first point."""
    inside = (grid[:-1] >= part.start) & (grid[1:] <= part.stop)
    states, steps = np.empty((len(rates), len(grid))), np.diff(grid)
    states[:, 0] = state
    cached: dict[float, tuple[Real, Real]] = {}
    nodes = np.arange(DEGREE + 1) / DEGREE
    values = part.formula(grid[:-1, None] + steps[:, None] * nodes)
    for index, step in enumerate(steps):
        key = float(step)
        if key not in cached:
            cached[key] = _weights(rates * step)
        decay, weights = cached[key]
        state = decay * state
        if inside[index]:
            state = state + weights @ values[index]
        states[:, index + 1] = state
    return states


def _grid(part: Smooth, times: Real) -> Real:
    """Return output times, switching times, and enough points between them."""
    ends = np.unique(np.concatenate([[0.0], times, [part.start, part.stop]]))
    ends = ends[(ends >= 0) & (ends <= times[-1])]
    longest = RADIANS_PER_STEP / (2 * np.pi * part.highest_frequency)
    pieces = [ends[:1]]
    for first, last in pairwise(ends):
        count = max(1, int(np.ceil((last - first) / longest)))
        pieces.append(np.append(first + (last - first) * np.arange(1, count) / count, last))
    return np.concatenate(pieces)


def _weights(z: Real) -> tuple[Real, Real]:
    """Return decay and quadrature weights of one step, z = rate times step.

    Moments m_k = z integral of exp(-z (1 - s)) s^k over 0..1: m_k = 1 - k m_(k-1)/z is stable for large z;
    Gauss quadrature is exact to rounding for small z.
    """
    moments = np.empty((len(z), DEGREE + 1))
    small = z < 16
    s, gauss, powers, to_values = _rules()
    moments[small] = (np.exp(-z[small, None] * (1 - s)) * z[small, None] * gauss) @ powers
    fast = z[~small]
    moment = -np.expm1(-fast)
    for k in range(DEGREE + 1):
        moment = moment if k == 0 else 1 - k * moment / fast
        moments[~small, k] = moment
    return np.exp(-z), moments @ to_values


@functools.cache
def _rules() -> tuple[Real, Real, Real, Real]:
    """Return Gauss points and weights on 0 to 1, powers of the points, and the matrix from nodal values to coefficients."""
    points, gauss = np.polynomial.legendre.leggauss(32)
    s, orders = (points + 1) / 2, np.arange(DEGREE + 1)
    to_values = np.asarray(np.linalg.inv((orders / DEGREE)[:, None] ** orders), float)
    return s, gauss / 2, s[:, None] ** orders, to_values
