"""Grids that contain the output times and the corners of a force, and are halved between them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real

FEWEST = 3000
"""Pieces of the first grid, whatever the times."""
PER_CHANGE = 4
"""Pieces of the first grid in the shortest time in which the force changes."""
GROWTH = 3
"""Power of a piece's index with which its end grows after a corner."""
ROUNDING = 8 * float(np.finfo(float).eps)
"""Difference of times over the largest one, below which they count as equal."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid:
    """Knots between which a force is smooth, and the division of the stretches between them.

    Parameters
    ----------
    knots : ndarray, shape (n,)
        Output times and corners between them [s].
    wanted, corners : ndarray of int
        Indices of the knots that are output times, and of those that are corners.
    graded : ndarray of bool, shape (n - 1,)
        Whether a stretch begins with a corner, after which the force may decay quickly, so that its pieces grow.
    memory : float
        Time after which the response to a force has decayed [s].
    """

    knots: Real
    wanted: Indices
    corners: Indices
    graded: NDArray[np.bool_]
    memory: float = math.inf

    @classmethod
    def over(cls, stamps: Real, corners: Real, *, memory: float = math.inf) -> Grid:
        """Return the grid of output times and corners.

        `stamps` (n,) [s], `corners` (m,) [s].
        """
        inside = corners[(corners > stamps[0]) & (corners <= stamps[-1])]
        slack = ROUNDING * max(abs(stamps[0]), abs(stamps[-1]))
        near = stamps[np.clip(np.searchsorted(stamps, inside - slack), 0, len(stamps) - 1)]
        inside = np.where(
            np.abs(near - inside) <= slack, near, inside
        )  # a corner at an output time, apart from rounding
        begins = (stamps - memory)[1:][np.diff(stamps) > 2 * memory]
        counts = ~_is_idle(inside, stamps, memory)
        inside = inside[counts]
        knots = np.union1d(np.union1d(stamps, inside), begins)
        graded = np.isin(knots[:-1], np.append(inside, corners[np.abs(corners - stamps[0]) <= slack]))
        return cls(
            knots=knots,
            wanted=np.searchsorted(knots, stamps),
            corners=np.unique(np.searchsorted(knots, inside)),
            graded=graded,
            memory=memory,
        )

    @property
    def is_point(self) -> bool:
        """Whether the grid is a single time."""
        return len(self.knots) == 1

    def counts(self, remaining: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which stretches affect some of the output times.

        `remaining` (wanted,); returns `affects` (knots - 1,).
        """
        if not np.any(remaining):
            return np.zeros(len(self.knots) - 1, bool)
        return ~_is_idle(self.knots[1:], self.knots[self.wanted[remaining]], self.memory)

    def density(self, *, shortest: float, most: int) -> float:
        """Return the density of pieces for FEWEST pieces in all and PER_CHANGE in the shortest change."""
        lengths = np.diff(self.knots)
        if 2 * len(lengths) > most:
            raise InputError(
                f"the force on finger and rig has {len(lengths)} corners and output times up to {self.knots[-1]:.6g} s, which"
                f" take twice as many pieces, more than {most}. Choose a shorter time.duration, fewer time.samples or a slower"
                " drive"
            )
        span = float(np.sum(lengths[self.counts(np.ones(len(self.wanted), bool))]))
        if span == 0.0:
            return 0.0
        return min(max(FEWEST, PER_CHANGE * span / shortest), most / 2 - len(lengths)) / span

    def divisions(self, *, density: float, halvings: int, counts: NDArray[np.bool_]) -> Indices:
        """Return the number of pieces of each stretch.

        `counts` (knots - 1,); returns `divisions` (knots - 1,).
        """
        # lengths of an even grid differ in their last digit only
        even = np.maximum(np.ceil(np.diff(self.knots) * density * (1 - 1e-9)), 1)
        first = np.where(self.graded, GROWTH * even, even)  # the last piece is as long as the others
        return np.asarray(np.where(counts, first * 2**halvings, 1), np.intp)

    def points(self, divisions: Indices) -> tuple[Real, Real]:
        """Return begin and duration of every piece.

        `divisions` (knots - 1,); returns `begins`, `lengths` (pieces,) [s].
        """
        whole, since = np.repeat(np.diff(self.knots), divisions), np.repeat(self.knots[:-1], divisions)
        count, power = np.repeat(divisions, divisions), np.repeat(np.where(self.graded, GROWTH, 1), divisions)
        place = np.arange(len(whole)) - np.repeat(np.cumsum(divisions) - divisions, divisions)
        first = (place / count) ** power
        return since + whole * first, whole * (((place + 1) / count) ** power - first)


def _is_idle(times: Real, wanted: Real, memory: float) -> NDArray[np.bool_]:
    """Return which times affect no output time."""
    after = np.append(wanted, math.inf)[np.searchsorted(wanted, times, side="left")]
    return np.asarray(after - times >= memory * (1 - 1e-9))


def increasing(times: ArrayLike) -> Real:
    """Return times as an array, refusing those that do not increase.

    `times` (n,) [s]; returns `stamps` (n,) [s].
    """
    stamps = np.asarray(times, dtype=float)
    if stamps.ndim != 1 or not stamps.size or not np.all(np.isfinite(stamps)) or np.any(np.diff(stamps) <= 0):
        raise InputError(
            "times: expected finite times that increase, at least one. Sort them, drop equal ones."
        )
    return stamps
