"""Modes under a drive that is a formula: a chirp in closed form, any other smooth one by a polynomial through each step.

The response to a linear chirp is the integral of an exponential of a quadratic, an error function of a complex argument.
Written with Faddeeva's function no factor of it grows: it is an envelope times the sine at that time, plus a decaying part
from the beginning. The envelope varies slowly; at many times it is evaluated from polynomials.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.electrics.fading import chebyshev_rule, fading
from electrovib.solve.meter import Meter
from electrovib.solve.recursion.blocks import states_before

if TYPE_CHECKING:
    from collections.abc import Iterator

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.drive.parts import Chirped, Smooth

FAR = 30.0
"""Modulus of an argument from which on `TERMS` terms of the expansion of Faddeeva's function are exact to rounding."""
TERMS = 7
GONE = 40.0
"""Above this value of rate^2/(2 pi sweep), the state from before the chirp passed the rate has decayed by exp(-GONE)."""
DEGREE = 16
"""Degree of the polynomials through the envelope."""
FEW = 4 * DEGREE
"""Largest number of times of a piece at each of which the envelope is computed."""
SMOOTH_DEGREE = 6
RADIANS_PER_STEP = 0.3
"""Phase of the fastest oscillation in one step: interpolation error below 1e-10 of the amplitude."""
_STEPS_AT_ONCE = 4096


def chirp_response(part: Chirped, rates: Real, gains: Real, time: Real, *, lag: bool = False) -> Real:
    """Compute the response of modes x' = rate (v - x) to a chirp, from rest.

    `rates` (modes,), `gains` (outputs, modes), `time` (n,) [s]; returns `response` (outputs, n) [V].

    With p = rate + j w(0) and a = pi sweep, exp(E(u)), E = p u + j a u^2, has the integral exp(E) W,
    W = sqrt(pi)/(2 j alpha) w(E'/(2 alpha)), alpha^2 = j a, E' = rate + j w(u), where w(z) is Faddeeva's function
    and w(u) the angular frequency. Fast modes use the root alpha whose argument lies in the upper complex half plane,
    where W is close to 1/E', the response to a sine of the frequency at that time. Where a rising chirp passes w = rate
    the root changes, and W by a term that has decayed in these modes. Slow modes keep one root.
    """
    modes = _Modes(part, rates, gains, lag)
    found = np.zeros((len(gains), len(time)))
    ends = np.array([max(part.start, 0.0), part.stop])
    first, last = np.searchsorted(time, ends)
    on, after = time[first:last], time[last:]
    (begun, over), (start, stop) = ends.tolist(), (modes.answer(ends) * np.exp(1j * part.phase(ends))).imag.T
    if len(on):
        found[:, first:last] = (modes.envelope(on) * np.exp(1j * part.phase(on))).imag
        found[:, first:last] -= np.array(fading(gains * start, rates, on - begun))
    if len(after) and over > begun:
        left = stop - start * np.exp(-rates * (over - begun))
        found[:, last:] = np.array(fading(gains * left, rates, after - over))
    return part.amplitude * found


@dataclass(frozen=True)
class _Modes:
    """Outputs of modes under a chirp: rates [1/s], gains, and whether each mode enters as x - v."""

    part: Chirped
    rates: Real
    gains: Real
    lag: bool

    def envelope(self, time: Real) -> Complex:
        """Return the complex envelope at increasing times: the outputs are the imaginary part of envelope exp(j phase)."""
        found = np.empty((len(self.gains), len(time)), complex)
        for first, last, coefficients in self._pieces(time, 0, len(time)):
            some = time[first:last]
            if coefficients is None:
                found[:, first:last] = self.gains @ self.answer(some, lag=self.lag)
            else:
                inside = (2 * some - some[0] - some[-1]) / (some[-1] - some[0])
                found[:, first:last] = np.polynomial.chebyshev.chebval(inside, coefficients)
        return found

    def _pieces(self, time: Real, first: int, last: int) -> Iterator[tuple[int, int, Complex | None]]:
        """Halve a stretch of times until a polynomial is exact to rounding on it, or few times are left."""
        if last - first <= FEW:
            yield first, last, None
            return
        nodes, to_coefficients = chebyshev_rule(DEGREE)
        begin, end = time[first], time[last - 1]
        states = self.answer((begin + end) / 2 + (end - begin) / 2 * nodes, lag=self.lag)
        coefficients = to_coefficients @ (self.gains @ states).T
        rounding = 8 * np.finfo(float).eps * np.max(np.abs(self.gains) @ np.abs(states), axis=1)
        if np.all(np.abs(coefficients[-3:]) <= rounding):
            yield first, last, coefficients
            return
        middle = int(np.searchsorted(time, (begin + end) / 2))
        middle = min(max(middle, first + 1), last - 1)
        yield from self._pieces(time, first, middle)
        yield from self._pieces(time, middle, last)

    def answer(self, time: Real, *, lag: bool = False) -> Complex:
        """Return rate W of each mode, less 1 for the lag."""
        from scipy.special import wofz

        rates, sweep = self.rates[:, None], self.part.sweep
        angular = 2 * np.pi * (self.part.first + sweep * time)
        root = complex(np.sqrt(np.pi * abs(sweep)) * np.exp(0.25j * np.pi * np.sign(sweep)))
        slope = rates + 1j * angular
        near = np.abs(slope) < 2 * FAR * abs(root)
        small = 2 * (root / np.where(near, np.inf, slope)) ** 2  # 1/(2 z^2)
        more = np.zeros_like(small)
        for order in range(TERMS, 0, -1):
            more = (2 * order - 1) * small * (1 + more)
        answer = (rates * more - 1j * angular) / slope if lag else rates * (1 + more) / slope
        if np.any(near):
            rate = np.broadcast_to(rates, near.shape)[near]
            other = (slope.real > slope.imag)[near] & (rate**2 > 2 * GONE * np.pi * sweep) & (sweep > 0)
            side = np.where(other, -1.0, 1.0)
            answer[near] = rate * side * wofz(side * slope[near] / (2 * root)) * np.sqrt(np.pi) / (2j * root)
            answer[near] -= lag
        return np.asarray(answer, complex)


def smooth_states(part: Smooth, rates: Real, times: Real) -> Real:
    """Compute the states of the modes x' = rate (v - x) under a smooth drive, from rest.

    `rates` (modes,), `times` (n,) [s]; returns `states` (modes, n) [V].
    """
    grid = _grid(part, times)
    wanted = np.searchsorted(grid, times)
    found, state = np.zeros((len(rates), len(times))), np.zeros(len(rates))
    meter = Meter("the drive, a formula,", end=float(grid[-1]))
    for first in range(0, len(grid) - 1, _STEPS_AT_ONCE):
        meter.count(float(grid[first]))
        piece = grid[first : first + _STEPS_AT_ONCE + 1]
        states = _march_steps(part, rates, piece, state)
        here = slice(*np.searchsorted(wanted, [first, first + len(piece)]))
        found[:, here] = states[:, wanted[here] - first]
        state = states[:, -1]
    return found


def _march_steps(part: Smooth, rates: Real, grid: Real, state: Real) -> Real:
    """Return the states at the points of a grid, from that at its first point."""
    inside, steps = (grid[:-1] >= part.start) & (grid[1:] <= part.stop), np.diff(grid)
    nodes = np.arange(SMOOTH_DEGREE + 1) / SMOOTH_DEGREE
    values = np.where(inside[:, None], part.formula(grid[:-1, None] + steps[:, None] * nodes), 0.0)
    distinct, kind = np.unique(steps, return_inverse=True)
    weights = _weights(np.outer(distinct, rates).ravel()).reshape(len(distinct), len(rates), -1)
    pushes = np.einsum("skn,sn->sk", weights[kind], values)
    return states_before(pushes, -np.outer(steps, rates), state).T


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


def _weights(z: Real) -> Real:
    """Return the quadrature weights of steps, z = rate times step, shape (len(z), nodes).

    Moments m_k = z integral of exp(-z (1 - s)) s^k over 0..1: m_k = 1 - k m_(k-1)/z is stable for large z;
    Gauss quadrature is exact to rounding for small z.
    """
    moments = np.empty((len(z), SMOOTH_DEGREE + 1))
    small = z < 16
    s, gauss, powers, to_values = _rules()
    moments[small] = (np.exp(-z[small, None] * (1 - s)) * z[small, None] * gauss) @ powers
    fast = z[~small]
    moment = -np.expm1(-fast)
    for k in range(SMOOTH_DEGREE + 1):
        moment = moment if k == 0 else 1 - k * moment / fast
        moments[~small, k] = moment
    return np.asarray(moments @ to_values)


@functools.cache
def _rules() -> tuple[Real, Real, Real, Real]:
    """Return Gauss points and weights on 0 to 1, powers of the points, and the matrix from nodal values to coefficients."""
    points, gauss = np.polynomial.legendre.leggauss(32)
    s, orders = (points + 1) / 2, np.arange(SMOOTH_DEGREE + 1)
    to_values = np.asarray(np.linalg.inv((orders / SMOOTH_DEGREE)[:, None] ** orders), float)
    return s, gauss / 2, s[:, None] ** orders, to_values
