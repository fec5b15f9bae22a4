"""Interpolation of a force that is costly to evaluate, by cubics between its corners."""

from __future__ import annotations

import copy
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

KNOTS = 2000
"""Even times at which the force is evaluated first, besides the output times."""
PER_CHANGE = 4
"""Even times in the shortest time in which the force changes."""
MOST = 4_000_000
"""Largest number of evaluations."""
TOLERANCE = 1e-6
"""Largest error of a cubic in its middle, over the largest force."""
COARSER = 15
"""Difference of cubics through every other knot from those through all, over the error of these."""
MOST_HALVINGS = 40
_SINCE_CORNER = np.geomspace(1e-5, 0.5, 40)
"""Times after a corner, over the time to the next, added where the force is evaluated only once and may decay quickly."""
_BEFORE = 1e-6
"""Time before a corner at which the force before it is evaluated, over the time since the previous corner."""
_SOON = 1e-9
"""Upper limit of the same time, over the whole time."""
_ROUNDING = 64 * float(np.finfo(float).eps)
"""Relative rounding of times; corners nearer to each other than 16 times this share of the whole time are one."""


def cubic(knots: Any, values: Any, slopes: Any, place: Any, time: Any) -> Any:
    """Return the force [N] in the interval after a knot, at a time [s], for one of both or many.

    The compiled time stepping uses this function too.
    """
    length = knots[place + 1] - knots[place]
    share = (time - knots[place]) / length
    rise = values[place + 1] - values[place]
    early, late = slopes[place] * length - rise, rise - slopes[place + 1] * length
    return values[place] + share * (rise + (1 - share) * (early * (1 - share) + late * share))


class Cubics(NamedTuple):
    """Cubics over intervals; at a corner two knots coincide, with the force before it and the force after it.

    Parameters
    ----------
    knots, values, slopes : ndarray, shape (n,)
        Times of the knots [s], force there [N] and its rate of change [N/s].
    """

    knots: Real
    values: Real
    slopes: Real

    def at(self, place: Any, time: Any) -> Any:
        """Return the force in the interval after a knot, at a time [s]; for one of both or many [N]."""
        return cubic(self.knots, self.values, self.slopes, place, time)


class Between:
    """A force as cubics between its corners, where it or its slope may be discontinuous; right-continuous there.

    Parameters
    ----------
    force_at : callable
        Force [N] at increasing times [s]; at a discontinuity the value after it.
    times : ndarray, shape (n,)
        Times at which the force is evaluated exactly, the last one the end [s].
    corners : ndarray
        Times at which the force or its slope may be discontinuous [s].
    shortest : float
        Shortest time in which the force changes [s].
    once : bool
        Whether it is evaluated only once, at even times, as a time-stepping solver requires; else intervals are halved
        until the error in their middle is below `TOLERANCE`.

    Attributes
    ----------
    pieces : Cubics
        Cubics of the force.

    Raises
    ------
    InputError
        If resolving every change and every corner takes more than `MOST` times.
    """

    def __init__(
        self,
        force_at: Callable[[Real], Real],
        times: Real,
        corners: Real,
        *,
        shortest: float = math.inf,
        once: bool = False,
    ) -> None:
        end = float(times[-1])
        inside = np.unique(corners[(corners > 0) & (corners < end)])
        apart = 16 * _ROUNDING * end
        inside = inside[(np.diff(inside, prepend=0.0) > apart) & (end - inside > apart)]
        self.ends = np.unique(np.concatenate([[0.0], inside, [end]]))
        lengths = np.diff(self.ends)
        early = np.maximum(np.minimum(_BEFORE * lengths, _SOON * end), _ROUNDING * end)
        self._just = self.ends[1:] - early
        count = math.ceil(max((4 if once else 1) * KNOTS, PER_CHANGE * end / shortest))
        if (needed := count + len(times) + 3 * len(self.ends)) > MOST:
            changes = f"changes {end / shortest:.4g} times and " if end / shortest > 1 else ""
            raise InputError(
                f"time.duration = {format_quantity(end, 's')}: in that time the force on the finger {changes}has"
                f" {len(inside)} corners, and has to be evaluated at {needed} times, more than {MOST}. Choose a shorter"
                " time.duration, or a slower drive"
            )
        even = np.linspace(0.0, end, count + 1)
        soon = (self.ends[:-1, np.newaxis] + lengths[:, np.newaxis] * _SINCE_CORNER).ravel()
        soon = soon if once and len(soon) < count else soon[:0]
        asked = np.unique(np.concatenate([even, times, self.ends, soon]))
        # an even time and an output time that are one but for rounding would have a slope of rounding over rounding
        again = np.diff(asked, prepend=-math.inf) < _ROUNDING * end
        asked = asked[~again | np.isin(asked, self.ends)]
        beyond = np.searchsorted(self.ends, asked, side="right") - 1
        near = (asked > self.ends[beyond]) & (
            (asked - self.ends[beyond] < apart) | (asked >= self._just[np.minimum(beyond, len(lengths) - 1)])
        )
        near[asked >= end] = True
        self._asked, self._force = self._looked(force_at, np.concatenate([asked[~near], self._just]))
        self._missed = 0.0
        self.pieces = self._cubics(np.ones(len(self._asked), bool))
        if once:
            self._missed = self._every_other()
        else:
            self._halve(force_at)

    def __call__(self, time: Any) -> Any:
        """Return the force at times [s], scalar or array [N]."""
        return self.pieces.at(self._place(np.asarray(time)), np.asarray(time))

    def error(self) -> float:
        """Return the estimated error of the cubics over the largest force [1]."""
        return self._missed / self._scale

    @property
    def _scale(self) -> float:
        return float(np.max(np.abs(self._force))) or 1.0

    def _place(self, time: Real) -> Any:
        """Return the index of the knot at the start of the interval that contains each time."""
        last = len(self.pieces.knots) - 2
        return np.clip(np.searchsorted(self.pieces.knots, time, side="right") - 1, 0, last)

    def _looked(self, force_at: Callable[[Real], Real], times: Real) -> tuple[Real, Real]:
        times = np.unique(times)
        return times, np.asarray(force_at(times), dtype=float)

    def _every_other(self) -> float:
        """Return the error of cubics through all knots [N], from that of cubics through every other knot."""
        return float(np.max(np.abs(self.coarser()(self._asked) - self._force), initial=0.0)) / COARSER

    def coarser(self) -> Between:
        """Return the force as cubics through every other knot, which differ from these by `COARSER` times their error."""
        kept = np.zeros(len(self._asked), bool)
        kept[::2] = True
        kept |= np.isin(self._asked, np.concatenate([self.ends, self._just]))
        found = copy.copy(self)
        found.pieces = self._cubics(kept)
        return found

    def _halve(self, force_at: Callable[[Real], Real]) -> None:
        """Halve intervals until the cubics agree with the force in their middle, or `MOST` times are used."""
        if not np.all(np.isfinite(self._force)):
            return
        unmet = 0.0
        open_ends = self.pieces.knots[:-1][np.diff(self.pieces.knots) > 0]
        for _ in range(MOST_HALVINGS):
            place = self._place(open_ends)
            lengths = self.pieces.knots[place + 1] - self.pieces.knots[place]
            middle = self.pieces.knots[place] + lengths / 2
            just = self._just[np.searchsorted(self.ends, middle, side="right") - 1]
            divisible = (lengths > 4 * _ROUNDING * self.ends[-1]) & (middle < just)
            place, middle = place[divisible], middle[divisible]
            if not len(middle) or len(self._asked) + len(middle) > MOST:
                break
            force = np.asarray(force_at(middle), dtype=float)
            missed = np.abs(force - self.pieces.at(place, middle))
            found = np.concatenate([self._asked, middle])
            order = np.argsort(found, kind="stable")
            self._asked, self._force = found[order], np.concatenate([self._force, force])[order]
            starts = self.pieces.knots[place]
            self.pieces = self._cubics(np.ones(len(self._asked), bool))
            wrong = ~(missed <= TOLERANCE * self._scale)
            self._missed = max(float(np.max(missed[~wrong], initial=0.0)), self._missed)
            unmet = float(np.max(missed[wrong], initial=0.0))
            open_ends = np.sort(np.concatenate([starts[wrong], middle[wrong]]))
        self._missed = max(self._missed, unmet)

    def _cubics(self, kept: NDArray[np.bool_]) -> Cubics:
        """Return cubics with continuous curvature between the corners; the last value before a corner extends to it."""
        from scipy.linalg import solve_banded

        knots, values = self._asked[kept], self._force[kept]
        last = np.flatnonzero(np.isin(knots, self._just))
        knots[last] = self.ends[1:]
        first = np.append(0, last[:-1] + 1)
        lengths, size = np.diff(knots), len(knots)
        jump = np.zeros(size - 1, bool)
        jump[last[:-1]] = True
        lengths = np.where(
            jump, 1.0, lengths
        )  # between two knots of one corner, which is used in no equation
        rise = np.diff(values) / lengths
        before, after = np.append(1.0, lengths), np.append(lengths, 1.0)
        band = np.zeros((3, size))
        band[0, 1:], band[1], band[2, :-1] = before[:-1], 2 * (before + after), after[1:]
        right = np.zeros(size)
        right[1:-1] = 3 * (after[1:-1] * rise[:-1] + before[1:-1] * rise[1:])
        few = last - first < 3
        for edge, sign in ((first, 1), (last, -1)):
            inner = edge if sign == 1 else edge - 1  # the interval at the edge
            side, slope = lengths[inner], rise[inner]
            beyond = np.clip(inner + sign, 0, size - 2)
            next_, next_slope = lengths[beyond], rise[beyond]
            both = side + next_
            band[1, edge] = np.where(few, 2.0, next_)
            towards = np.where(few, 1.0, both)
            if sign == 1:
                band[0, edge + 1], band[2, edge[1:] - 1] = towards, 0.0
            else:
                band[2, edge - 1], band[0, edge[:-1] + 1] = towards, 0.0
            smooth = ((side + 2 * both) * next_ * slope + side**2 * next_slope) / both
            right[edge] = np.where(few, 3 * slope, smooth)
        slopes = solve_banded((1, 1), band, right, overwrite_ab=True, overwrite_b=True, check_finite=False)
        return Cubics(knots, values, slopes)
