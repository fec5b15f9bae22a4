"""Sums of polynomials and decaying exponentials on the straight pieces of a drive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Numbers, Real
    from electrovib.physics.drive.pieces import Linear

_DECAYED: Final = 80.0
"""Time constants after which an exponential counts as 0: 2e-35 of it remains."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Output times, each in the straight piece of a drive that contains it.

    Parameters
    ----------
    values, slopes : ndarray, shape (pieces,)
        Drive just after the begin of each piece [V] and its rate of change [V/s].
    ends : ndarray, shape (pieces,)
        Drive just before the end of each piece [V]; that at the begin for the last piece, which has no end.
    begins, lengths : ndarray, shape (pieces,)
        Begin and duration of each piece [s]; the duration of the last is infinite.
    groups : tuple of (int, slice, ndarray)
        Pieces that contain output times: number of the piece, which output times, and these times since its begin [s].
    count : int
        Number of output times.
    """

    values: Real
    slopes: Real
    ends: Real
    begins: Real
    lengths: Real
    groups: tuple[tuple[int, slice, Real], ...]
    count: int

    @classmethod
    def of(cls, part: Linear, times: Real) -> Pieces:
        """Assign output times to the pieces of a drive, at a break to the later one.

        `times` (n,) [s].
        """
        part = part.until(float(times[-1]))
        index, elapsed = part.locate(times)
        edges = np.searchsorted(index, np.arange(len(part.times) + 1))
        groups = tuple(
            (piece, slice(first, last), elapsed[first:last])
            for piece, (first, last) in enumerate(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))
            if last > first
        )
        return cls(
            values=part.after,
            slopes=part.slopes(),
            ends=np.append(part.before[1:], part.after[-1]),
            begins=part.times,
            lengths=np.append(part.lengths, np.inf),
            groups=groups,
            count=len(times),
        )


@dataclass(frozen=True, eq=False)
class Decays:
    """Exponentials exp(-rate s) of the time s since the begin of a piece.

    Parameters
    ----------
    pieces : Pieces
        Pieces and output times.
    rates : ndarray, shape (modes,)
        Rates, above 0 [1/s].
    inside : tuple of ndarray, shape (modes, n)
        Exponentials at the output times of each group [1].
    """

    pieces: Pieces
    rates: Real
    inside: tuple[Real, ...]

    @classmethod
    def of(cls, pieces: Pieces, rates: Real) -> Decays:
        """Evaluate the exponentials at the output times.

        `rates` (modes,).
        """
        return cls(pieces, rates, tuple(_decays(rates, since) for _, _, since in pieces.groups))


def _decays(rates: Real, since: Real) -> Real:
    """Return exp(-rate s) at increasing times, shape (modes, n), 0 where it is below rounding."""
    found = np.zeros((len(rates), len(since)))
    for row, rate, last in zip(found, rates, np.searchsorted(since, _DECAYED / rates), strict=True):
        np.exp(-rate * since[:last], out=row[:last])
    return found


@dataclass(frozen=True, eq=False)
class ExponentialSum:
    """Signal that is sum c_m s^m + sum w_km s^m exp(-r_k s) + sum W_jk exp(-(r_j + r_k) s) on each piece.

    Parameters
    ----------
    decays : Decays
        The exponentials.
    polynomial : ndarray, shape (pieces, 3)
        Coefficients c, in the unit of the signal over s^m.
    modes : ndarray, shape (pieces, modes, 2)
        Coefficients w, likewise.
    pairs : ndarray, shape (pieces, modes, modes) or None
        Coefficients W in the unit of the signal; None where they are 0.
    """

    decays: Decays
    polynomial: Numbers
    modes: Numbers
    pairs: Numbers | None = None

    def values(self) -> Real:
        """Return the signal at the output times, shape (n,), in its unit."""
        pieces = self.decays.pieces
        found = np.empty(pieces.count)
        for (piece, where, since), decay in zip(pieces.groups, self.decays.inside, strict=True):
            first, second, third = self.polynomial[piece]
            row = found[where]
            row[:] = (third * since + second) * since + first if third else second * since + first
            if not len(self.decays.rates):
                continue
            row += self.modes[piece, :, 0] @ decay
            if self.modes[piece, :, 1].any():
                row += since * (self.modes[piece, :, 1] @ decay)
            if self.pairs is not None:
                row += np.einsum("kn,kn->n", self.pairs[piece] @ decay, decay)
        return found

    def at_begins(self) -> Numbers:
        """Return the signal just after the begin of each piece, shape (pieces,), in its unit."""
        found = self.polynomial[:, 0] + self.modes[:, :, 0].sum(axis=1)
        return np.asarray(found if self.pairs is None else found + self.pairs.sum(axis=(1, 2)))

    def at_ends(self) -> Numbers:
        """Return the signal just before the end of each piece but the last, shape (pieces - 1,), in its unit."""
        since = self.decays.pieces.lengths[:-1]
        decay = np.exp(np.outer(since, -self.decays.rates))
        polynomial, modes = self.polynomial[:-1], self.modes[:-1]
        found = polynomial[:, 0] + since * (polynomial[:, 1] + since * polynomial[:, 2])
        found = found + np.einsum("pk,pk->p", modes[:, :, 0] + since[:, None] * modes[:, :, 1], decay)
        if self.pairs is not None:
            found = found + np.einsum("pjk,pj,pk->p", self.pairs[:-1], decay, decay)
        return np.asarray(found)

    def __mul__(self, factor: float) -> ExponentialSum:
        """Return the signal multiplied by a factor."""
        pairs = None if self.pairs is None else self.pairs * factor
        return ExponentialSum(self.decays, self.polynomial * factor, self.modes * factor, pairs)

    def __add__(self, other: ExponentialSum) -> ExponentialSum:
        """Return the sum of two signals of the same exponentials."""
        pairs = self.pairs if other.pairs is None else other.pairs
        if self.pairs is not None and other.pairs is not None:
            pairs = self.pairs + other.pairs
        return ExponentialSum(
            self.decays, self.polynomial + other.polynomial, self.modes + other.modes, pairs
        )

    def shifted(self, level: float) -> ExponentialSum:
        """Return the signal with a constant added."""
        polynomial = self.polynomial.copy()
        polynomial[:, 0] += level
        return ExponentialSum(self.decays, polynomial, self.modes, self.pairs)


def product(one: ExponentialSum, other: ExponentialSum) -> ExponentialSum:
    """Multiply two signals that are linear in the drive."""
    a, b, left, right = one.polynomial, other.polynomial, one.modes[:, :, 0], other.modes[:, :, 0]
    polynomial = np.stack(
        [a[:, 0] * b[:, 0], a[:, 0] * b[:, 1] + a[:, 1] * b[:, 0], a[:, 1] * b[:, 1]], axis=1
    )
    modes = np.stack([a[:, [m]] * right + b[:, [m]] * left for m in (0, 1)], axis=2)
    return ExponentialSum(one.decays, polynomial, modes, left[:, :, None] * right[:, None, :])
