"""Filters of an attraction in closed form: a sum of polynomials and decaying exponentials on each straight piece of a drive.

The amplitudes of the law are linear in the drive: on a piece each is a straight line and one exponential for each mode. The
attraction is a quadratic form of them, and so is the steady friction under a constant load; a filter of friction, skin or
sensor adds the exponentials of its poles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.physics.drive.parts import Linear
from electrovib.solve.choice import chosen
from electrovib.solve.electrics.attraction import total_pull
from electrovib.solve.electrics.fading import exponentials
from electrovib.solve.electrics.straight import BreakStates
from electrovib.solve.electrics.transient import Response

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Numbers, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.mechanics.filters import Filter
    from electrovib.solve.stack.section import ModalSection


MOST_PIECES: Final = 64
"""Largest number of pieces of the drive for which the closed form is used."""
MOST_MODES: Final = 16
"""Largest number of modes for which it is used."""
_APART: Final = 1e-4
"""Relative distance between a pole of a filter and an exponential of its input below which there is no such form."""


class TimesInPiece(NamedTuple):
    """Output times in one piece: its number, which times, these since its begin (n,) [s], and exponentials (1 + modes, n)."""

    piece: int
    where: slice
    since: Real
    decays: Real


@dataclass(frozen=True, eq=False)
class ExponentialSum:
    """Signal that is the sum of c_mjk s^m exp(-(r_j + r_k) s) on each piece, s being the time since its begin.

    `part` are the pieces, `rates` (1 + modes,) the rates r, of which the first is 0 [1/s], and `terms` (powers, pieces,
    1 + modes, 1 + modes) the coefficients c.
    """

    part: Linear
    rates: Real
    terms: Numbers

    def groups(self, times: Real) -> list[TimesInPiece]:
        """Assign output times (n,) [s] to the pieces, at a break to the later one, with the exponentials there."""
        index, elapsed = self.part.locate(times)
        edges = np.searchsorted(index, np.arange(len(self.part.times) + 1)).tolist()
        places = [(piece, slice(*ends)) for piece, ends in enumerate(pairwise(edges)) if ends[0] < ends[1]]
        return [
            TimesInPiece(piece, some, elapsed[some], exponentials(self.rates, elapsed[some]))
            for piece, some in places
        ]

    def values(self, groups: list[TimesInPiece]) -> Real:
        """Return the signal at the times of groups, shape (n,)."""
        found = np.zeros(groups[-1].where.stop)
        for piece, where, since, decays in groups:
            row = found[where]
            for terms in self.terms[::-1, piece]:
                row *= since
                if terms.any():
                    row += np.einsum("jn,jn->n", terms @ decays, decays)
        return found

    def at_ends(self) -> Numbers:
        """Return the signal just before the end of each piece but the last, shape (pieces - 1,)."""
        since = self.part.lengths
        decay = np.exp(np.outer(since, -self.rates))
        powers = since ** np.arange(len(self.terms))[:, None]
        found: Numbers = np.einsum("mp,mpjk,pj,pk->p", powers, self.terms[:, :-1], decay, decay)
        return found

    def line(self, *, slope: float, start: float) -> ExponentialSum:
        """Return start + slope times the signal."""
        terms = slope * self.terms
        terms[0, :, 0, 0] += start
        return replace(self, terms=terms)

    def filtered(self, filter_: Filter, groups: list[TimesInPiece], *, level: float) -> Real | None:
        """Return the output (n,) of a filter that has settled to a level before the first piece; None without closed form.

        z' = p (z - u) for each pole p. For u = s^m exp(-r s) it has the particular solution Q(s) exp(-r s) with
        Q' - (p + r) Q = -p s^m; the homogeneous solution Z exp(p s) continues z from piece to piece.
        """
        near = np.abs(filter_.poles[:, None] + (self.rates[:, None] + self.rates).ravel())
        if np.any(near <= _APART * np.abs(filter_.poles)[:, None]):
            return None
        total, free = self.terms * filter_.direct, []
        for pole, gain in zip(filter_.poles.tolist(), filter_.gains.tolist(), strict=True):
            particular = self._particular(pole)
            weight = gain if pole.imag == 0 else 2 * gain
            free.append((pole, weight * particular.homogeneous(pole, level)))
            total = total + (particular.terms * weight).real
        output = replace(self, terms=total).values(groups)
        for piece, where, since, _ in groups:
            for pole, amplitude in free:
                output[where] += _oscillation(pole, complex(amplitude[piece]), since)
        return output

    def _particular(self, pole: complex) -> ExponentialSum:
        """Return the particular solution of z' = p (z - u) that has the exponentials of this signal u."""
        apart, found = pole + self.rates[:, None] + self.rates, self.terms * pole
        found[-1] /= apart
        for power in reversed(range(len(found) - 1)):
            found[power] = (found[power] + (power + 1) * found[power + 1]) / apart
        return replace(self, terms=found)

    def homogeneous(self, pole: complex, level: float) -> Complex:
        """Return the amplitude of exp(p s) in each piece that continues a level to this particular solution, (pieces,)."""
        begins, ends = self.terms[0].sum(axis=(1, 2)), self.at_ends()
        decay = np.exp(pole * self.part.lengths)
        found = np.empty(len(begins), complex)
        state = complex(level)
        for piece, begin in enumerate(begins.tolist()):
            found[piece] = state - begin
            if piece < len(ends):
                state = found[piece] * decay[piece] + ends[piece]
        return found


def _oscillation(pole: complex, amplitude: complex, since: Real) -> Real:
    """Return the real part of amplitude exp(pole s)."""
    decay = np.exp(pole.real * since)
    if pole.imag == 0:
        return np.asarray(amplitude.real * decay)
    angle = pole.imag * since
    return np.asarray(decay * (amplitude.real * np.cos(angle) - amplitude.imag * np.sin(angle)))


def attraction_in_pieces(scenario: Scenario, section: ModalSection, *, end: float) -> ExponentialSum | None:
    """Return the attraction from rest up to a time as a sum of exponentials; None where it is none of a few terms."""
    if not _is_quadratic(scenario, end):
        return None
    (part,) = scenario.drive.parts()
    assert isinstance(part, Linear)
    part = part.until(end)
    response = Response(scenario.force.amplitudes(section), [part])
    ((names, _, left, modes), *others) = response.groups
    if others or np.any(left) or len(modes.rates) > MOST_MODES:
        return None
    states, every = BreakStates(part, modes.rates, np.zeros(len(modes.rates))), np.arange(len(part.times))
    weights, _, gentle = modes.in_exponentials(states, every, 0 * every, longest=end)
    if not np.all(gentle):
        return None
    lines = dict(zip(names, weights, strict=True))
    for name, slope in response.slopes.items():
        lines[name][:, 1] += slope * part.slopes()

    def pull(*ones: str) -> float:
        return float(total_pull(scenario, {name: np.array(float(name in ones)) for name in lines}))

    terms = [(name, name, pull(name)) for name in lines]
    terms += [(a, b, pull(a, b) - pull(a) - pull(b)) for a, b in combinations(lines, 2)]
    area = scenario.contact.gross_area()
    found = np.zeros((3, len(part.times), 1 + len(modes.rates), 1 + len(modes.rates)))
    for a, b, weight in terms:
        if weight:
            found += weight * area * _product(lines[a], lines[b])
    return ExponentialSum(part, np.append(0.0, modes.rates), found)


def _is_quadratic(scenario: Scenario, end: float) -> bool:
    """Tell whether the attraction is a quadratic form of quantities that are linear in few straight pieces of voltage."""
    parts = scenario.drive.parts()
    return (
        len(parts) == 1
        and isinstance(parts[0], Linear)
        and scenario.drive.count_corners(end) <= MOST_PIECES
        and scenario.circuit.amplifier is None
        and not scenario.time.settled
        and scenario.force.of_second_degree
        and not scenario.contact.grows
        and chosen(scenario).method.each_alone
    )


def _product(one: Real, other: Real) -> Real:
    """Return the coefficients (3, pieces, 1 + modes, 1 + modes) of the product of quantities of (pieces, 2 + modes) weights."""
    found = np.zeros((3, len(one), one.shape[1] - 1, one.shape[1] - 1))
    found[0] = one[:, 1:, None] * other[:, None, 1:]
    found[1, :, 0] = one[:, :1] * other[:, 1:]
    found[1, :, :, 0] += one[:, 1:] * other[:, :1]
    found[2, :, 0, 0] = one[:, 0] * other[:, 0]
    return found
