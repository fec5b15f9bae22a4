"""Grids that hold the wanted times and the jumps of a force, and are halved between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.physics.drive.parts import Indices
    from electrovib.solve.filters.filter import Real

FEWEST = 3000
"""Pieces of the first grid, whatever the times."""
PER_CHANGE = 8
"""Pieces of the first grid in the shortest time in which the force changes."""
ROUNDING = 8 * float(np.finfo(float).eps)
"""How far, over the largest time, a grid may be off and still count as even."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Knots, between which a force is smooth, and how each stretch between them is divided.

    Parameters
    ----------
    knots : ndarray, shape (n,)
        The wanted times and the jumps between them [s].
    wanted, jumps : ndarray of int
        Which knots are wanted times, and which are jumps.
    step : float or None
        Distance of even knots [s].
    """

    knots: Real
    wanted: Indices
    jumps: Indices
    step: float | None

    @classmethod
    def over(cls, stamps: Real, jumps: Real) -> Grid:
        """Lay a grid over wanted times with jumps.

        Parameters
        ----------
        stamps : ndarray, shape (n,)
            Wanted times [s], increasing.
        jumps : ndarray, shape (m,)
            Any times [s]; those after the first stamp and up to the last count.

        Returns
        -------
        Grid
            Undivided.
        """
        inside = jumps[(jumps > stamps[0]) & (jumps <= stamps[-1])]
        slack = ROUNDING * max(abs(stamps[0]), abs(stamps[-1]))
        near = stamps[np.clip(np.searchsorted(stamps, inside - slack), 0, len(stamps) - 1)]
        inside = np.where(np.abs(near - inside) <= slack, near, inside)  # a jump at a stamp, but for rounding
        knots = np.union1d(stamps, inside)
        even = np.linspace(stamps[0], stamps[-1], len(knots))
        step = (stamps[-1] - stamps[0]) / max(1, len(knots) - 1)
        is_even = len(knots) > 1 and np.max(np.abs(knots - even)) <= slack
        places = np.searchsorted(knots, stamps), np.unique(np.searchsorted(knots, inside))
        return cls(knots, *places, float(step) if is_even else None)

    @property
    def is_point(self) -> bool:
        """Tell whether it is one time."""
        return len(self.knots) == 1

    def first_divisions(self, shortest: float, most: int) -> Indices:
        """Divide each stretch so that there are FEWEST pieces, and PER_CHANGE in the shortest change.

        Parameters
        ----------
        shortest : float
            Shortest time in which the force changes [s].
        most : int
            Half of it is not exceeded, so that every stretch can be halved.

        Returns
        -------
        ndarray of int, shape (knots - 1,)
            Pieces of each stretch.

        Raises
        ------
        InputError
            If there are more stretches than that.
        """
        lengths = np.diff(self.knots)
        if 2 * len(lengths) > most:
            raise InputError(
                f"most = {most}: {len(lengths)} times need twice as many pieces. Raise it, or ask for fewer times."
            )
        span = float(self.knots[-1] - self.knots[0])
        if span == 0.0:
            return np.zeros(0, np.intp)
        pieces = min(max(FEWEST, PER_CHANGE * span / shortest), most / 2 - len(lengths))
        # lengths of an even grid differ in their last digit only
        divisions = np.ceil(lengths * (pieces / span) * (1 - 1e-9))
        return np.asarray(np.maximum(divisions, 1), np.intp)

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
        lengths = np.repeat(np.diff(self.knots) / divisions, divisions)
        since = np.arange(len(lengths)) - np.repeat(np.cumsum(divisions) - divisions, divisions)
        return np.repeat(self.knots[:-1], divisions) + since * lengths, lengths


def increasing(times: ArrayLike) -> Real:
    """Give times as numbers, refusing what does not increase.

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
