"""Quantities that are linear in the drive, from rest, as sums of exponentials."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.solve.closed_form.sums import Decays, ExponentialSum

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.solve.closed_form.sums import Pieces
    from electrovib.solve.stack.transfer import Transfer

SLOWEST: Final = 1e-4
"""Product of a rate and the whole time below which the closed form would be a small difference of large numbers."""


def active_rates(transfers: list[Transfer], *, end: float) -> Real | None:
    """Return the rates of the modes that a drive excites, where the quantities have a closed form.

    Returns `rates` (modes,).
    """
    rates = transfers[0].rates
    for each in transfers:
        if (each.rates is not rates and not np.array_equal(each.rates, rates)) or np.any(each.free):
            return None
    active = rates[_active(transfers)]
    return active if np.all(active * end > SLOWEST) else None


def _active(transfers: list[Transfer]) -> Real:
    gains = np.array([each.gains for each in transfers])
    return np.asarray(np.any(gains != 0, axis=0) & (transfers[0].rates > 0))


def linear_sums(transfers: list[Transfer], decays: Decays) -> list[ExponentialSum]:
    """Compute quantities that are linear in the drive, from rest.

    In a piece with drive v + v' s every mode is x = v + v' s - v'/r + (x_0 - v + v'/r) exp(-r s).
    """
    pieces, active = decays.pieces, _active(transfers)
    deviations = _deviations(pieces, decays.rates)
    found = []
    for each in transfers:
        gains, level = each.gains[active], each.at_rest()
        constant = level * pieces.values + (each.slope - np.sum(gains / decays.rates)) * pieces.slopes
        polynomial = np.stack([constant, level * pieces.slopes, np.zeros_like(constant)], axis=1)
        modes = np.zeros((*deviations.shape, 2))
        modes[:, :, 0] = gains * deviations
        found.append(ExponentialSum(decays, polynomial, modes))
    return found


def _deviations(pieces: Pieces, rates: Real) -> Real:
    """Return x_0 - v + v'/r of each mode at the begin of each piece, shape (pieces, modes) [V]."""
    found = np.empty((len(pieces.values), len(rates)))
    found[0] = pieces.slopes[0] / rates - pieces.values[0]
    decay = np.exp(np.outer(pieces.lengths[:-1], -rates))
    changes = pieces.ends[:-1] - pieces.values[1:]
    bends = np.diff(pieces.slopes)
    for piece in range(len(found) - 1):
        found[piece + 1] = found[piece] * decay[piece] + changes[piece] + bends[piece] / rates
    return found
