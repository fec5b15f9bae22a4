"""Steps of an integration over time: fine after a discontinuity of the drive, growing from there."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import numpy as np

from electrovib.solve.electrics.transient import transient

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.conduction import Conduction
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.stack.transfer import Transfer

T = TypeVar("T")
MOST_HALVINGS = 4
STEPS = 400
"""Least number of steps over the whole time."""
STEPS_PER_PERIOD = 64
GROWTH = 1.1
"""Ratio of successive steps after a discontinuity, so that every time constant is resolved by suitable steps."""
FIRST = 0.01
"""First step after a discontinuity, times the fastest rate."""
FEW = 200
"""Largest number of slope changes of a drive after which the steps are fine, as they are after its discontinuities."""
_SLACK = 512 * float(np.finfo(float).eps)
"""Steps shorter than this share of the time could not be halved."""


def halved(
    grid: Real, march: Callable[[Real], T], field: Callable[[T], Real], *, order: int, tolerance: float
) -> tuple[Real, T, T, float]:
    """Halve all steps until a field is exact enough at the ends of the steps before, `MOST_HALVINGS` times at most.

    `field` returns it from an integration, shape (..., n). Returns the last steps, the last two integrations, the finer first,
    and the error over the largest value, as far as the integration is of the given order.
    """
    fine = coarse = march(grid)
    error = 0.0
    for _ in range(MOST_HALVINGS if len(grid) > 1 else 0):
        grid, coarse = np.insert(grid, np.arange(1, len(grid)), (grid[:-1] + grid[1:]) / 2), fine
        fine = march(grid)
        exact = field(fine)
        moved = float(np.max(np.abs(exact[..., ::2] - field(coarse))))
        error = moved / (float(np.max(np.abs(exact))) or 1.0) / (2**order - 1)
        if error < tolerance:
            break
    return grid, fine, coarse, error


def step_grid(drive: Drive, time: Real, driven: Transfer, leaking: Transfer, *, leak: Conduction) -> Real:
    """Return the first steps of the integration.

    `time` (n,) [s].
    """
    end = float(time[-1])
    if end <= 0:
        return np.zeros(1)
    marks, heights = drive.corners(end)
    points = [time, marks, *_even(drive, end)]
    fields = transient({"field": driven}, drive, np.unique(np.concatenate(points)))["field"]
    speed = float(np.max(np.concatenate([driven.rates, leaking.rates, [1 / end]])))
    speed += float(np.sum(np.abs(leaking.gains * leaking.rates)) * np.max(leak.slope(fields)))
    return _with_marks([*points, *_after(marks[heights != 0], FIRST / speed, end)], marks, end)


def smooth_grid(
    drive: Drive, *, end: float, speed: float, spans: Sequence[tuple[float, float]], fastest: float
) -> Real:
    """Return the steps of an integration of high order under a moving layer."""
    if end <= 0:
        return np.zeros(1)
    marks, heights = drive.corners(end)
    kinks = marks if len(marks) <= FEW else marks[heights != 0]
    bends = np.array([each for span in spans for each in span if 0 < each < end])
    points = [*_even(drive, end), *(_resolved(*span, fastest) for span in spans)]
    points += _after(kinks, FIRST / speed, end)
    return _with_marks(points, np.concatenate([marks, bends]), end)


def with_outputs(grid: Real, time: Real) -> Real:
    """Insert output times between the ends of steps, except those that almost coincide with one.

    `grid` (n,) [s], `time` (m,) [s].
    """
    return _with_marks([time], grid, float(grid[-1]))


def _even(drive: Drive, end: float) -> list[Real]:
    """Return even points over the whole time, and those that resolve each oscillation of the drive."""
    ends = [(max(part.start, 0.0), min(part.stop, end), part.highest_frequency) for part in drive.parts()]
    return [np.linspace(0.0, end, STEPS + 1), *(_resolved(*each) for each in ends)]


def _resolved(first: float, last: float, frequency: float) -> Real:
    """Return equal shares of the shortest period between two times; the first alone where nothing oscillates."""
    count = int(np.ceil(max(last - first, 0.0) * frequency * STEPS_PER_PERIOD))
    return np.linspace(first, max(first, last), count + 1)


def _after(jumps: Real, first: float, end: float) -> list[Real]:
    """Return the ends of steps that grow after time 0 and after each discontinuity, up to the next one."""
    begins = np.unique(np.append(jumps, 0.0))
    return [at + _growing(first, span) for at, span in zip(begins, np.diff(begins, append=end), strict=True)]


def _growing(first: float, span: float) -> Real:
    """Return the ends of steps after a discontinuity that grow geometrically."""
    if span <= first:
        return np.zeros(1)
    count = int(np.ceil(np.log1p((GROWTH - 1) * span / first) / np.log(GROWTH)))
    times = first * (GROWTH ** np.arange(count + 1, dtype=float) - 1) / (GROWTH - 1)
    return np.asarray(np.minimum(times, span), dtype=float)


def _with_marks(pieces: Sequence[Real], marks: Real, end: float) -> Real:
    """Sort points between 0 and the end; a point that almost coincides with another, or with a mark, is omitted."""
    points = np.unique(np.concatenate(pieces))
    points = points[(points >= 0) & (points <= end)]
    points = points[np.diff(points, prepend=-1.0) > _SLACK * points]
    fixed = np.unique(np.concatenate([[0.0], marks, [end]]))
    places = np.clip(np.searchsorted(fixed, points), 1, len(fixed) - 1)
    nearest = np.minimum(np.abs(points - fixed[places - 1]), np.abs(points - fixed[places]))
    return np.unique(np.concatenate([fixed, points[nearest > _SLACK * points]]))


def jump_heights(drive: Drive, grid: Real) -> Real:
    """Return the height of the drive's discontinuity at each of some times.

    `grid` (n,) [s]; returns `heights` (n,).
    """
    marks, heights = drive.corners(float(grid[-1]))
    found = np.zeros(len(grid))
    np.add.at(found, np.searchsorted(grid, marks), heights)
    return found
