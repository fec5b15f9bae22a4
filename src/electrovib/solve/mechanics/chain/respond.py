"""Response of mechanics and sensors to a force of any course in time, to a stated error."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.mechanics.chain.grid import PER_CHANGE, Grid, increasing
from electrovib.solve.mechanics.filters.follow import finite, march_through
from electrovib.solve.mechanics.filters.stretches import Stretches

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.solve.mechanics.filters.filter import Filter

FAINT = 1e-9
"""Smallest scale of an output's error, over the largest possible output: smaller outputs are rounding."""
ROUNDING = 1e-13
"""Change by rounding alone, over the largest possible output."""
FORGOTTEN = 25.0
"""Time constants after which the response to a force counts as decayed: 1e-11 of it remains."""
PIECES = 100_000
"""Pieces of a first grid that are computed at once: more take memory, fewer take time for the preceding decay."""
EXTRAPOLATIONS = 2
"""Number of even powers of the length of a piece that extrapolation eliminates."""
TOGETHER = 64
"""Outputs in a group that is refined until all of them have converged."""


def respond_mechanically(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    times: ArrayLike,
    *,
    tolerance: float = 1e-6,
    most: int = 4_000_000,
    corners: ArrayLike = (),
    shortest: float = math.inf,
    held: float = math.inf,
) -> tuple[dict[str, Real], float]:
    """Compute the outputs of linear mechanics and sensors under one force, to a stated error.

    `times` (n,) [s], `corners` (m,) [s].

    The force is linear between the points of a grid, for which the modes are exact, however stiff. The remaining error
    is that of the curvature of the force in a piece, of second order in its length; extrapolation over grids of halved
    pieces (Romberg) eliminates two orders, which leaves the sixth. Times that no output depends on any more are not
    evaluated, and times that affect only converged outputs are not refined.
    """
    stamps, marks = increasing(times), np.asarray(corners, dtype=float).ravel()
    memory = FORGOTTEN / _slowest(filters)
    found = {name: np.empty(len(stamps)) for name in filters}
    sizes = {name: _Size() for name in filters}
    for group in _groups(stamps, marks, memory, shortest):
        begins = max(stamps[group.start] - memory, stamps[0])
        early = begins < stamps[group.start]
        grid = Grid.over(np.append(begins, stamps[group]) if early else stamps[group], marks, memory=memory)
        before = held if begins == stamps[0] else math.inf
        rows = _settled(force_at, filters, grid, before, shortest, most, tolerance, sizes)
        for name, row in rows.items():
            found[name][group] = row[int(early) :]
    return found, max((size.moved / (size.largest or 1.0) for size in sizes.values()), default=0.0)


@dataclass
class _Size:
    """Largest value of an output so far, and its change by the last halving of its grid."""

    largest: float = 0.0
    moved: float = 0.0


def _groups(stamps: Real, corners: Real, memory: float, shortest: float) -> list[slice]:
    """Return the groups of outputs computed together: some `PIECES` of a first grid, if long compared with the memory [s]."""
    lengths = np.append(0.0, np.minimum(np.diff(stamps), memory))
    pieces = np.cumsum(lengths * PER_CHANGE / shortest) + np.searchsorted(np.sort(corners), stamps)
    together = max(PIECES, 4 * memory * PER_CHANGE / shortest)
    edges = np.flatnonzero(np.diff(np.floor(pieces / together), prepend=0.0))
    bounds = [0, *edges[edges > 0].tolist(), len(stamps)]
    return [slice(first, last) for first, last in itertools.pairwise(bounds)]


def _settled(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    grid: Grid,
    held: float,
    shortest: float,
    most: int,
    tolerance: float,
    sizes: dict[str, _Size],
) -> dict[str, Real]:
    """Halve the pieces of a grid where outputs change, until they have converged or `most` pieces are used."""
    density, halvings = grid.density(shortest=shortest, most=most), 0
    remaining = np.ones(len(grid.wanted), bool)
    divisions = grid.divisions(density=density, halvings=halvings, counts=grid.counts(remaining))
    coarse, possible = _on_grid(force_at, filters, grid, divisions, held)
    found, moved = dict(coarse), {name: np.zeros(len(remaining)) for name in filters}
    tables = {name: [row] for name, row in coarse.items()}
    while True:
        halvings += 1
        divisions = grid.divisions(density=density, halvings=halvings, counts=grid.counts(remaining))
        fine, possible = _on_grid(force_at, filters, grid, divisions, held)
        moves = np.zeros(len(remaining), bool)
        for name, size in sizes.items():
            row = _extrapolated(tables[name], fine[name])
            changes = [np.abs(now - before) for now, before in zip(row, tables[name], strict=False)]
            change = np.maximum(np.min(changes, axis=0) - ROUNDING * possible[name], 0.0)
            moved[name] = np.where(remaining, change, moved[name])
            found[name] = np.where(remaining, row[-1], found[name])
            tables[name] = row
            size.largest = max(size.largest, float(np.max(np.abs(found[name]))), FAINT * possible[name])
            moves |= moved[name] > tolerance * size.largest
        remaining = _with_neighbours(moves)
        more = grid.divisions(density=density, halvings=halvings + 1, counts=grid.counts(remaining)).sum()
        if not np.any(remaining) or more > most or grid.is_point:
            for name, size in sizes.items():
                size.moved = max(size.moved, float(np.max(moved[name])))
            return found


def _slowest(filters: Mapping[str, Filter]) -> float:
    """Return the slowest rate of all filters [1/s]; 1e9 if none has a memory."""
    return min((float(np.min(-each.poles.real, initial=1e9)) for each in filters.values()), default=1e9)


def _with_neighbours(moved: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mark whole groups of outputs, so that none counts as converged by coincidence."""
    groups = np.arange(len(moved)) // TOGETHER
    return np.isin(groups, groups[moved])


def _extrapolated(before: list[Real], fine: Real) -> list[Real]:
    """Return the next row of Romberg's table, for halved pieces and an error in even powers of their length."""
    row = [fine]
    for order, coarse in zip(range(1, EXTRAPOLATIONS + 1), before, strict=False):
        row.append(row[-1] + (row[-1] - coarse) / (4**order - 1))
    return row


def _on_grid(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    grid: Grid,
    divisions: Indices,
    held: float,
) -> tuple[dict[str, Real], dict[str, float]]:
    """Return the outputs of all filters on one grid, and the largest possible output of each."""
    begins, lengths = grid.points(divisions)
    force = finite(force_at(np.append(begins, grid.knots[-1])))
    marks = np.cumsum(np.append(0, divisions))
    before = force[marks[1:]]
    if grid.corners.size:
        moments = grid.knots[grid.corners]
        last = lengths[marks[grid.corners] - 1]
        back = np.maximum(1e-6 * last, 64 * np.finfo(float).eps * np.abs(moments))
        before[grid.corners - 1] = finite(force_at(moments - back))
    stretches = Stretches(
        begins=begins, lengths=lengths, divisions=divisions, graded=grid.graded, force=force, ends=before
    )
    found: dict[str, Real] = {}
    largest: dict[str, float] = {}
    for name, filter_ in filters.items():
        if grid.is_point:
            state = filter_.state(float(force[0]), held=held)
            output = march_through(filter_, force, force, steps=0.0, state=state)[:1]
        else:
            output = stretches.output(filter_, held=held)
        possible = (abs(filter_.direct) + 2 * np.abs(filter_.gains).sum()) * np.abs(force).max()
        found[name], largest[name] = output[grid.wanted], float(possible)
    return found, largest
