"""Mechanics and sensors under a force that is no straight line, to a stated error."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from electrovib.solve.chain.grid import Grid, increasing
from electrovib.solve.filters.follow import finite, march_through

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike

    from electrovib.physics.drive.parts import Indices
    from electrovib.solve.filters.filter import Filter, Real

FAINT = 1e-9
"""Outputs are compared with no less than this share of what the filter could put out: below is rounding."""
_Outputs: TypeAlias = "dict[str, tuple[Real, float]]"


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
    known and taken away (Richardson), which leaves the fourth order. Outputs that two grids agree on are not looked at
    again.
    """
    stamps = increasing(times)
    grid = Grid.over(stamps, np.asarray(jumps, dtype=float).ravel())
    divisions = grid.first_divisions(shortest, most)
    coarse = before = _on_grid(force_at, filters, grid, divisions, held)
    while True:
        divisions = 2 * divisions
        fine = _on_grid(force_at, filters, grid, divisions, held)
        found = {name: (_extrapolated(coarse[name][0], output), size) for name, (output, size) in fine.items()}
        moved = [
            min(_moved(before[name], found[name]), _moved(coarse[name], fine[name])) for name in filters
        ]
        error = max(moved, default=0.0)
        if error <= tolerance or 2 * divisions.sum() > most or grid.is_point:
            return {name: output for name, (output, _) in found.items()}, error
        coarse, before = fine, found


def _extrapolated(coarse: Real, fine: Real) -> Real:
    """Output for a force without bends in its pieces, from two grids of which one halves the other's pieces."""
    return fine + (fine - coarse) / 3


def _on_grid(
    force_at: Callable[[Real], Real],
    filters: Mapping[str, Filter],
    grid: Grid,
    divisions: Indices,
    held: float,
) -> _Outputs:
    """Follow all filters on one grid; beside each output the largest one the filter could give."""
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
    found: _Outputs = {}
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
        found[name] = output[grid.wanted], float(possible)
    return found


def _moved(coarse: tuple[Real, float], fine: tuple[Real, float]) -> float:
    """Largest change of an output, as a share of its largest value."""
    scale = max(float(np.max(np.abs(fine[0]))), FAINT * fine[1])
    return float(np.max(np.abs(fine[0] - coarse[0]))) / scale if scale else 0.0
