"""Sums of polynomials and decaying exponentials on the straight pieces of a drive: linear quantities, squares, filters.

A quantity that is linear in the drive has one exponential for each mode, and a product of two such quantities the products
of two exponentials. With 1 as a further exponential, of rate 0, all are one form: a polynomial for each pair.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.physics.drive.parts import Linear

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Numbers, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.mechanics.filters import Filter
    from electrovib.solve.stack.transfer import Transfer

SLOWEST: Final = 1e-4
"""Product of a rate and the whole time below which the closed form would be a small difference of large numbers."""
_APART: Final = 1e-4
"""Relative distance between a pole of a filter and an exponential of its input below which there is no such form."""
_DECAYED: Final = 80.0
"""Time constants after which an exponential counts as 0: 2e-35 of it remains."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Output times (n,) [s], each in the straight piece of a drive that contains it, at a break in the later one.

    `groups` are the pieces that contain output times: number of the piece, which output times, and these times since its
    begin [s].
    """

    part: Linear
    times: Real
    groups: tuple[tuple[int, slice, Real], ...]

    @classmethod
    def of(cls, drive: Drive, times: Real) -> Pieces:
        """Assign output times to the pieces of a drive, which has one part."""
        (part,) = drive.parts()
        assert isinstance(part, Linear)
        part = part.until(float(times[-1]))
        index, elapsed = part.locate(times)
        edges = np.searchsorted(index, np.arange(len(part.times) + 1)).tolist()
        places = [(piece, slice(*ends)) for piece, ends in enumerate(pairwise(edges)) if ends[0] < ends[1]]
        return cls(part, times, tuple((piece, some, elapsed[some]) for piece, some in places))


@dataclass(frozen=True, eq=False)
class Decays:
    """Exponentials exp(-rate s) of the time s since the begin of a piece, the first of rate 0.

    `rates` (1 + modes,) [1/s]; `inside` are the exponentials at the output times of each group, (1 + modes, n).
    """

    pieces: Pieces
    rates: Real
    inside: tuple[Real, ...]

    @classmethod
    def of(cls, pieces: Pieces, rates: Real) -> Decays:
        """Evaluate the exponentials of rates (modes,) above 0 [1/s] at the output times."""
        inside = tuple(_decays(rates, since) for _, _, since in pieces.groups)
        return cls(pieces, np.append(0.0, rates), inside)


def _decays(rates: Real, since: Real) -> Real:
    """Return 1 and exp(-rate s) at increasing times, shape (1 + modes, n), 0 where it is below rounding."""
    found = np.zeros((1 + len(rates), len(since)))
    found[0] = 1.0
    for row, rate, last in zip(found[1:], rates, np.searchsorted(since, _DECAYED / rates), strict=True):
        np.exp(-rate * since[:last], out=row[:last])
    return found


@dataclass(frozen=True, eq=False)
class ExponentialSum:
    """Signal that is the sum of c_mjk s^m exp(-(r_j + r_k) s) on each piece.

    `terms` (powers, pieces, 1 or 1 + modes, 1 + modes) are the coefficients c, in the unit of the signal over s^m; a signal
    that is linear in the drive has the first row alone, whose rate is 0.
    """

    decays: Decays
    terms: Numbers

    def values(self) -> Real:
        """Return the signal at the output times, shape (n,), in its unit."""
        pieces, rows = self.decays.pieces, self.terms.shape[-2]
        found = np.zeros(len(pieces.times))
        for (piece, where, since), decay in zip(pieces.groups, self.decays.inside, strict=True):
            row = found[where]
            for terms in self.terms[::-1, piece]:
                row *= since
                if terms.any():
                    row += (
                        np.einsum("jn,jn->n", terms @ decay, decay[:rows]) if rows > 1 else terms[0] @ decay
                    )
        return found

    def at_begins(self) -> Numbers:
        """Return the signal just after the begin of each piece, shape (pieces,), in its unit."""
        return np.asarray(self.terms[0].sum(axis=(1, 2)))

    def at_ends(self) -> Numbers:
        """Return the signal just before the end of each piece but the last, shape (pieces - 1,), in its unit."""
        since = self.decays.pieces.part.lengths
        decay = np.exp(np.outer(since, -self.decays.rates))
        powers = since ** np.arange(len(self.terms))[:, None]
        sides = decay[:, : self.terms.shape[-2]], decay
        found: Numbers = np.einsum("mp,mpjk,pj,pk->p", powers, self.terms[:, :-1], *sides)
        return found

    def __mul__(self, factor: float) -> ExponentialSum:
        """Return the signal multiplied by a factor."""
        return ExponentialSum(self.decays, self.terms * factor)

    def __add__(self, other: ExponentialSum) -> ExponentialSum:
        """Return the sum of two signals of the same exponentials."""
        return ExponentialSum(self.decays, self.terms + other.terms)

    def shifted(self, level: float) -> ExponentialSum:
        """Return the signal with a constant added."""
        terms = self.terms.copy()
        terms[0, :, 0, 0] += level
        return ExponentialSum(self.decays, terms)


def product(one: ExponentialSum, other: ExponentialSum) -> ExponentialSum:
    """Multiply two signals that are linear in the drive."""
    a, b = one.terms[:, :, 0, :, None], other.terms[:, :, 0, None, :]
    return ExponentialSum(one.decays, np.stack([a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]]))


def active_rates(transfers: list[Transfer], *, end: float) -> Real | None:
    """Return the rates (modes,) of the modes that a drive excites; None where the quantities have no closed form."""
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
    part, rates, active = decays.pieces.part, decays.rates[1:], _active(transfers)
    slopes = part.slopes()
    bends = np.diff(slopes, prepend=0.0)[:, None] / rates - part.jumps[:, None]
    falls = np.exp(np.outer(np.append(0.0, part.lengths), -rates))
    deviations = [np.zeros(len(rates))]  # of x - v + v'/r, few pieces by a plain loop
    for fall, bend in zip(falls, bends, strict=True):
        deviations.append(deviations[-1] * fall + bend)
    found = []
    for each in transfers:
        gains, level = each.gains[active], each.at_rest()
        terms = np.zeros((2, len(slopes), 1, 1 + len(rates)))
        terms[0, :, 0, 0] = level * part.after + (each.slope - np.sum(gains / rates)) * slopes
        terms[1, :, 0, 0] = level * slopes
        terms[0, :, 0, 1:] = gains * deviations[1:]
        found.append(ExponentialSum(decays, terms))
    return found


def has_closed_form(filter_: Filter, rates: Real) -> bool:
    """Tell whether no pole of a filter is close to a sum of two of the rates of its input, the first of which is 0."""
    near = np.abs(filter_.poles[:, None] + (rates[:, None] + rates).ravel())
    return bool(np.all(near > _APART * np.abs(filter_.poles)[:, None]))


def filtered_sum(filter_: Filter, given: ExponentialSum, level: float) -> Real:
    """Compute the output (n,) of a filter that has settled to a level before the first piece.

    z' = p (z - u) for each pole p. For u = s^m exp(-r s) it has the particular solution Q(s) exp(-r s) with
    Q' - (p + r) Q = -p s^m; the homogeneous solution Z exp(p s) continues z from piece to piece.
    """
    total, free = given.terms * filter_.direct, []
    for pole, gain in zip(filter_.poles.tolist(), filter_.gains.tolist(), strict=True):
        particular = _particular(pole, given)
        weight = gain if pole.imag == 0 else 2 * gain
        free.append((pole, weight * _homogeneous(pole, particular, level)))
        total = total + (particular.terms * weight).real
    output = ExponentialSum(given.decays, total).values()
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
    rates, found = given.decays.rates, given.terms * pole
    apart = pole + rates[: found.shape[-2], None] + rates
    found[-1] /= apart
    for power in reversed(range(len(found) - 1)):
        found[power] = (found[power] + (power + 1) * found[power + 1]) / apart
    return ExponentialSum(given.decays, found)


def _homogeneous(pole: complex, particular: ExponentialSum, level: float) -> Complex:
    """Return the amplitude of exp(p s) in each piece, shape (pieces,)."""
    begins, ends = particular.at_begins(), particular.at_ends()
    decay = np.exp(pole * particular.decays.pieces.part.lengths)
    found = np.empty(len(begins), complex)
    state = complex(level)
    for piece, begin in enumerate(begins.tolist()):
        found[piece] = state - begin
        if piece < len(ends):
            state = found[piece] * decay[piece] + ends[piece]
    return found
