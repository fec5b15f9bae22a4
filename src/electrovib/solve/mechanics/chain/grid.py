"""Grids that hold the wanted times and the jumps of a force, and are halved between them."""

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
"""Power of its number with which a piece after a jump ends."""
ROUNDING = 8 * float(np.finfo(float).eps)
"""How far, over the largest time, a grid may be off and still count as even."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid:
    """Knots, between which a force is smooth, and how each stretch between them is divided.

    Parameters
    ----------
    knots : ndarray, shape (n,)
        The wanted times and the jumps between them [s].
    wanted, jumps : ndarray of int
        Which knots are wanted times, and which are jumps.
    graded : ndarray of bool, shape (n - 1,)
        Whether a stretch begins with a jump, after which the force may fade quickly: its pieces grow.
    memory : float
        Time after which nothing is left of a force [s].
    """

    knots: Real
    wanted: Indices
    jumps: Indices
    graded: NDArray[np.bool_]
    memory: float = math.inf

    @classmethod
    def over(cls, stamps: Real, jumps: Real, *, memory: float = math.inf) -> Grid:
        """Lay a grid over wanted times with jumps.

        Parameters
        ----------
        stamps : ndarray, shape (n,)
            Wanted times [s], increasing.
        jumps : ndarray, shape (m,)
            Any times [s]; those after the first stamp and up to the last count.
        memory : float
            Time after which nothing is left of a force [s]: what lies further before every wanted time is one piece.

        Returns
        -------
        Grid
            Undivided.
        """
        inside = jumps[(jumps > stamps[0]) & (jumps <= stamps[-1])]
        slack = ROUNDING * max(abs(stamps[0]), abs(stamps[-1]))
        near = stamps[np.clip(np.searchsorted(stamps, inside - slack), 0, len(stamps) - 1)]
        inside = np.where(np.abs(near - inside) <= slack, near, inside)  # a jump at a stamp, but for rounding
        begins = (stamps - memory)[1:][np.diff(stamps) > 2 * memory]
        counts = ~_is_idle(inside, stamps, memory)
        inside = inside[counts]
        knots = np.union1d(np.union1d(stamps, inside), begins)
        graded = np.isin(knots[:-1], np.append(inside, jumps[np.abs(jumps - stamps[0]) <= slack]))
        return cls(
            knots=knots,
            wanted=np.searchsorted(knots, stamps),
            jumps=np.unique(np.searchsorted(knots, inside)),
            graded=graded,
            memory=memory,
        )

    @property
    def is_point(self) -> bool:
        """Tell whether it is one time."""
        return len(self.knots) == 1

    def counts(self, remaining: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Tell which stretches some of the wanted times remember.

        Parameters
        ----------
        remaining : ndarray of bool, shape (wanted,)
            Which of the wanted times count.

        Returns
        -------
        ndarray of bool, shape (knots - 1,)
            True where the force has to be followed.
        """
        if not np.any(remaining):
            return np.zeros(len(self.knots) - 1, bool)
        return ~_is_idle(self.knots[1:], self.knots[self.wanted[remaining]], self.memory)

    def density(self, *, shortest: float, most: int) -> float:
        """Pieces in a second that make FEWEST pieces, and PER_CHANGE in the shortest change.

        Parameters
        ----------
        shortest : float
            Shortest time in which the force changes [s].
        most : int
            Half of it is not exceeded, so that every stretch can be halved.

        Returns
        -------
        float
            1/s.

        Raises
        ------
        InputError
            If there are more stretches than that.
        """
        lengths = np.diff(self.knots)
        if 2 * len(lengths) > most:
            raise InputError(
                f"the force on finger and rig has {len(lengths)} corners and output times up to {self.knots[-1]:.6g} s, which"
                f" take twice as many pieces, more than {most}. Ask for a shorter time.duration, fewer time.samples or a slower"
                " drive"
            )
        span = float(np.sum(lengths[self.counts(np.ones(len(self.wanted), bool))]))
        if span == 0.0:
            return 0.0
        return min(max(FEWEST, PER_CHANGE * span / shortest), most / 2 - len(lengths)) / span

    def divisions(self, *, density: float, halvings: int, counts: NDArray[np.bool_]) -> Indices:
        """Divide each stretch.

        Parameters
        ----------
        density : float
            Pieces in a second [1/s] before any halving.
        halvings : int
            How often each piece is halved.
        counts : ndarray of bool, shape (knots - 1,)
            Stretches that are divided; of the others each is one piece.

        Returns
        -------
        ndarray of int, shape (knots - 1,)
            Pieces of each stretch.
        """
        # lengths of an even grid differ in their last digit only
        even = np.maximum(np.ceil(np.diff(self.knots) * density * (1 - 1e-9)), 1)
        first = np.where(self.graded, GROWTH * even, even)  # the last piece is as long as the others
        return np.asarray(np.where(counts, first * 2**halvings, 1), np.intp)

    def points(self, divisions: Indices) -> tuple[Real, Real]:
        """Begin of every piece, and how long it lasts.

        Parameters
        ----------
        divisions : ndarray of int, shape (knots - 1,)
            Pieces of each stretch.

        Returns
        -------
        begins, lengths : ndarray, shape (pieces,)
            s.
        """
        whole, since = np.repeat(np.diff(self.knots), divisions), np.repeat(self.knots[:-1], divisions)
        count, power = np.repeat(divisions, divisions), np.repeat(np.where(self.graded, GROWTH, 1), divisions)
        place = np.arange(len(whole)) - np.repeat(np.cumsum(divisions) - divisions, divisions)
        first = (place / count) ** power
        return since + whole * first, whole * (((place + 1) / count) ** power - first)


def _is_idle(times: Real, wanted: Real, memory: float) -> NDArray[np.bool_]:
    """Tell which times no wanted one remembers."""
    after = np.append(wanted, math.inf)[np.searchsorted(wanted, times, side="left")]
    return np.asarray(after - times >= memory * (1 - 1e-9))


def increasing(times: ArrayLike) -> Real:
    """Return times as numbers, refusing what does not increase.

    Parameters
    ----------
    times : array_like, shape (n,)
        s.

    Returns
    -------
    ndarray, shape (n,)
        The same.

    Raises
    ------
    InputError
        If there are none, or they are not finite and increasing.
    """
    stamps = np.asarray(times, dtype=float)
    if stamps.ndim != 1 or not stamps.size or not np.all(np.isfinite(stamps)) or np.any(np.diff(stamps) <= 0):
        raise InputError(
            "times: expected finite times that increase, at least one. Sort them, drop equal ones."
        )
    return stamps
