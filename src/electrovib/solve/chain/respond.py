"""Mechanics and sensors under a force that is no straight line, to a stated error."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.chain.grid import Grid, increasing
from electrovib.solve.filters.follow import finite, march_through

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike, NDArray

    from electrovib.physics.drive.parts import Indices
    from electrovib.solve.filters.filter import Filter, Real

FAINT = 1e-9
"""Outputs are compared with no less than this share of what the filter could put out: below is rounding."""
FORGOTTEN = 25.0
"""Time constants after which nothing is left of a force: 1e-11 of it."""
TOGETHER = 64
"""Outputs that are followed until all of them stand still."""


def respond_mechanically(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    times: ArrayLike,
    *,
    tolerance: float = 1e-6,
    most: int = 4_000_000,
    jumps: ArrayLike = (),
    shortest: float = math.inf,
    held: float = math.inf,
) -> tuple[dict[str, Real], float]:
    """Outputs of linear mechanics and sensors under one force, to a stated error.

    Parameters
    ----------
    force_at : callable
        Force [N] at increasing times [s], the value after at a jump; asked only between the first and the last
        of `times`.
    filters : mapping of str to Filter
        What to compute.
    times : array_like, shape (n,)
        When the outputs are wanted [s], increasing, need not be even.
    tolerance : float
        Largest change of an extrapolated output by the last halving, as a share of its largest value.
    most : int
        Pieces of the finest grid allowed; where they do not suffice the error returned is above `tolerance`.
    jumps : array_like, shape (m,)
        Times [s] at which the force jumps or bends, any order; between them it is smooth. A jump that is not
        named costs the order of convergence.
    shortest : float
        Shortest time in which the force changes, for instance a period of its fastest oscillation [s]: a grid
        that meets it at the same phase again and again would not see it.
    held : float
        For how long the force at the first time had been held before [s]; 0 for rest, infinite for steadiness.

    Returns
    -------
    outputs : dict of str to ndarray, shape (n,)
        In the order of `filters`.
    error : float
        Largest change by the last halving, relative; some fifteen times the error of a smooth force.

    Raises
    ------
    InputError
        If times do not increase, the force is not finite, or one piece for each time is more than `most`.

    Notes
    -----
    The force is taken as straight between the points of a grid, on which the modes are followed exactly, however
    stiff. What is left is the bend of the force in a piece, of second order in its length; from two grids it is
    known and taken away (Richardson), which leaves the fourth order. What no output remembers any more is not looked
    at, and no more than once what only outputs remember that stand still already.
    """
    stamps = increasing(times)
    grid = Grid.over(stamps, np.asarray(jumps, dtype=float).ravel(), FORGOTTEN / _slowest(filters))
    density, halvings = grid.density(shortest, most), 0
    remaining, moved = np.ones(len(stamps), bool), np.zeros(len(stamps))
    divisions = grid.divisions(density, halvings, grid.counts(remaining))
    coarse, possible = _on_grid(force_at, filters, grid, divisions, held)
    found = before = {name: row.copy() for name, row in coarse.items()}
    while True:
        halvings += 1
        divisions = grid.divisions(density, halvings, grid.counts(remaining))
        fine, possible = _on_grid(force_at, filters, grid, divisions, held)
        now = {name: np.where(remaining, _extrapolated(coarse[name], fine[name]), found[name]) for name in found}
        moved[remaining] = 0.0
        for name, output in now.items():
            scale = max(float(np.max(np.abs(output))), FAINT * possible[name]) or 1.0
            change = np.minimum(np.abs(output - before[name]), np.abs(fine[name] - coarse[name])) / scale
            moved = np.where(remaining, np.maximum(moved, change), moved)
        found = before = now
        remaining = _with_neighbours(moved > tolerance)
        more = grid.divisions(density, halvings + 1, grid.counts(remaining)).sum()
        if not np.any(remaining) or more > most or grid.is_point:
            return found, float(np.max(moved, initial=0.0)) if filters else 0.0
        coarse = fine


def _slowest(filters: Mapping[str, Filter]) -> float:
    """Slowest rate of all filters [1/s]; 1e9 if none has a memory."""
    return min((float(np.min(-each.poles.real, initial=1e9)) for each in filters.values()), default=1e9)


def _with_neighbours(moved: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mark whole groups of outputs, in which no single one stands still by chance."""
    groups = np.arange(len(moved)) // TOGETHER
    return np.isin(groups, groups[moved])


def _extrapolated(coarse: Real, fine: Real) -> Real:
    """Output for a force without bends in its pieces, from two grids of which one halves the other's pieces."""
    return fine + (fine - coarse) / 3


def _on_grid(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    grid: Grid,
    divisions: Indices,
    held: float,
) -> tuple[dict[str, Real], dict[str, float]]:
    """Follow all filters on one grid; and the largest output that each could give."""
    begins, lengths = grid.points(divisions)
    force = finite(force_at(np.append(begins, grid.knots[-1])))
    starts, ends = force[:-1], force[1:]
    marks = np.cumsum(np.append(0, divisions))
    if grid.jumps.size:
        ends, last = ends.copy(), marks[grid.jumps] - 1
        moments = grid.knots[grid.jumps]
        back = np.maximum(1e-6 * lengths[last], 64 * np.finfo(float).eps * np.abs(moments))
        ends[last] = finite(force_at(moments - back))
    even = grid.step is not None and divisions.min() == divisions.max()
    found: dict[str, Real] = {}
    largest: dict[str, float] = {}
    for name, filter_ in filters.items():
        state = filter_.state(float(force[0]), held)
        if grid.is_point:
            output = march_through(filter_, force, force, 0.0, state)[:1]
        elif even and grid.step is not None:
            each = int(divisions[0])
            output = march_through(filter_, starts, ends, grid.step / each, state, each)
        else:
            output = march_through(filter_, starts, ends, lengths, state)[marks]
        if grid.jumps.size and grid.jumps[-1] == len(grid.knots) - 1:
            output[-1] += filter_.direct * (force[-1] - ends[-1])
        possible = (abs(filter_.direct) + 2 * np.abs(filter_.gains).sum()) * np.abs(force).max()
        found[name], largest[name] = output[grid.wanted], float(possible)
    return found, largest

