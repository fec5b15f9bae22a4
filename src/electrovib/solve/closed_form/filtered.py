"""The output of a linear filter for a sum of exponentials."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.solve.closed_form.sums import ExponentialSum

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Real
    from electrovib.solve.mechanics.filters import Filter

_APART: Final = 1e-4
"""Relative distance between a pole of the filter and an exponential of its input below which there is no such form."""


def has_closed_form(filter_: Filter, rates: Real) -> bool:
    """Tell whether no pole of a filter is close to an exponential of its input or to a product of two.

    `rates` (modes,).
    """
    all_rates = np.concatenate([rates, (rates[:, None] + rates).ravel()])
    near = np.abs(filter_.poles[:, None] + all_rates)
    return bool(np.all(near > _APART * np.abs(filter_.poles)[:, None]))


def filtered_sum(filter_: Filter, given: ExponentialSum, level: float) -> Real:
    """Compute the output of a filter.

    Returns `output` (n,).

    z' = p (z - u) for each pole p. For u = s^m exp(-r s) it has the particular solution Q(s) exp(-r s) with
    Q' - (p + r) Q = -p s^m; the homogeneous solution Z exp(p s) continues z from piece to piece.
    """
    rest = given * filter_.direct
    free = []
    for pole, gain in zip(filter_.poles.tolist(), filter_.gains.tolist(), strict=True):
        particular = _particular(pole, given)
        weight = gain if pole.imag == 0 else 2 * gain
        free.append((pole, weight * _homogeneous(pole, particular, level)))
        share = particular * weight
        pairs = None if share.pairs is None else share.pairs.real
        rest = rest + ExponentialSum(given.decays, share.polynomial.real, share.modes.real, pairs)
    output = rest.values()
    for piece, where, since in given.decays.pieces.groups:
        for pole, amplitude in free:
            output[where] += _oscillation(pole, complex(amplitude[piece]), since)
    return output


def _oscillation(pole: complex, amplitude: complex, since: Real) -> Real:
    """Return the real part of amplitude exp(pole s)."""
    decay = np.exp(pole.real * since)
    if pole.imag == 0:
        return np.asarray(amplitude.real * decay)
    angle = pole.imag * since
    return np.asarray(decay * (amplitude.real * np.cos(angle) - amplitude.imag * np.sin(angle)))


def _particular(pole: complex, given: ExponentialSum) -> ExponentialSum:
    """Return the particular solution of z' = p (z - u) that has the exponentials of u."""
    rates = given.decays.rates
    first, second, third = given.polynomial.T
    top = third + 0j
    middle = second + 2 * top / pole
    polynomial = np.stack([first + middle / pole, middle, top], axis=1)
    apart = pole + rates
    growing = pole * given.modes[:, :, 1] / apart
    modes = np.stack([(pole * given.modes[:, :, 0] + growing) / apart, growing], axis=2)
    pairs = None if given.pairs is None else given.pairs * (pole / (pole + rates[:, None] + rates))
    return ExponentialSum(given.decays, polynomial, modes, pairs)


def _homogeneous(pole: complex, particular: ExponentialSum, level: float) -> Complex:
    """Return the amplitude of exp(p s) in each piece, shape (pieces,)."""
    begins, ends = particular.at_begins(), particular.at_ends()
    decay = np.exp(pole * particular.decays.pieces.lengths[:-1])
    found = np.empty(len(begins), complex)
    state = complex(level)
    for piece, begin in enumerate(begins.tolist()):
        found[piece] = state - begin
        if piece < len(ends):
            state = found[piece] * decay[piece] + ends[piece]
    return found
