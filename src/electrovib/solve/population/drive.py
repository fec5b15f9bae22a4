"""The drive that fingers share: straight pieces on a grid of all outputs and corners, and sines."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.physics.drive.parts import SLACK, Linear, Smooth, Tones, cosine_and_sine
from electrovib.solve.population.stepping import TimeSteps, time_steps
from electrovib.solve.stack.harmonics import drive_mean, settled_integral
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario

MOST_CORNERS: Final = 200_000
"""Corners of a drive up to the last output time beyond which fingers are computed one by one."""
MOST_PIECES: Final = 4096
"""Straight pieces of one period beyond which the periodic state is computed one by one."""
_SAME: Final = 1e-13
"""Difference over the largest number up to which two drives agree."""
_TEST_FACTORS: Final = ((0.53, 0.75, 0.11), (0.97, 0.51, 0.37), (0.81, 0.93, 0.73))
"""Factors of a value at which a drive is compared with a linear one, for paths in turn; of the largest value for a 0."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DriveTiming:
    """The times and frequencies of a drive, without its amplitudes.

    Parameters
    ----------
    outputs : ndarray, shape (n,)
        Output times, increasing, >= 0 [s].
    time : ndarray, shape (m,)
        Time 0, outputs and corners of the straight pieces, not decreasing; a discontinuity has its time twice [s].
    places : ndarray of int, shape (n,)
        Index of each output in `time`.
    breaks : tuple of ndarray, shape (pieces + 1,)
        Breaks in one period of each part that has been repeating since long before time 0 [s].
    frequencies : ndarray, shape (tones,)
        Frequencies of the sines, which are on at all outputs [Hz]; 0 for a constant.
    settled, is_straight : bool
        Whether the drive has been on since long before time 0, and whether it has straight pieces.
    """

    outputs: Real
    time: Real
    places: Indices
    breaks: tuple[Real, ...]
    frequencies: Real
    settled: bool
    is_straight: bool

    @functools.cached_property
    def steps(self) -> TimeSteps:
        """Steps of the grid."""
        return time_steps(self.time)

    @functools.cached_property
    def waves(self) -> Real:
        """Cosines and minus sines of all tones at the outputs, shape (2 tones, n)."""
        found = [cosine_and_sine(frequency, self.outputs) for frequency in self.frequencies.tolist()]
        rows = [cosine for cosine, _ in found] + [-sine for _, sine in found]
        return np.array(rows).reshape(len(rows), len(self.outputs))

    def agrees_with(self, other: DriveTiming) -> bool:
        """Return whether another drive has the same times and frequencies."""
        mine, its = ((each.time, each.places, each.frequencies, *each.breaks) for each in (self, other))
        return len(mine) == len(its) and all(map(np.array_equal, mine, its))


class PiecewiseDrive:
    """A drive as sums of straight pieces and of sines: its timing, and all of its amplitudes [V] in one row.

    Attributes
    ----------
    slopes, integral : ndarray, shape (n,)
        Rate of change of the straight pieces after each output [V/s]; integral of a settled drive without a mean [V s].
    rises, voltage : ndarray, shape (m,)
        Rise from each time of the grid to the next, no difference of large values, and the straight pieces there [V].
    mean, level : float
        Mean of a settled drive, and the constant to which all modes have settled at time 0 [V].
    tones : ndarray of complex, shape (tones,)
        Amplitudes of the sines [V].
    """

    def __init__(self, timing: DriveTiming, row: Real) -> None:
        self.timing, self.row = timing, row
        outputs, grid, tones = len(timing.outputs), len(timing.time), len(timing.frequencies)
        parts = np.split(row, np.cumsum([outputs, outputs, grid, grid, 1, 1, tones, tones]))
        self.slopes, self.integral, self.rises, self.voltage, mean, level, real, imag, self._ends = parts
        self.mean, self.level, self.tones = float(mean[0]), float(level[0]), real + 1j * imag

    def repeated(self) -> list[Linear]:
        """Return each repeated part."""
        rest, found = self._ends, []
        for times in self.timing.breaks:
            before, after, rest = np.split(rest, [len(times), 2 * len(times)])
            found.append(Linear(times, before, after, period=float(times[-1])))
        return found

    def values(self) -> Real:
        """Return the drive at its output times [V], shape (n,)."""
        waves = np.concatenate([self.tones.real, self.tones.imag]) @ self.timing.waves
        return np.asarray(self.voltage[self.timing.places] + self.level + waves)


SharedDrive: TypeAlias = "dict[str, PiecewiseDrive]"
"""A drive as the sum of its values times these, by the paths of its parameters; of the empty path the value is 1."""


def piecewise_drive(drive: Drive, time: Real, *, settled: bool) -> PiecewiseDrive:
    """Return a drive as straight pieces and sines.

    `time` (n,) [s].
    """
    parts, kind = drive.parts(), type(drive).__name__
    straight = [part for part in parts if isinstance(part, Linear)]
    tones = [part for part in parts if isinstance(part, Tones)]
    if any(isinstance(part, Smooth) for part in parts):
        raise NotInArraysError(f"{kind} is neither made of straight pieces nor of sines")
    for part in tones:
        always = part.start == -np.inf if settled else part.start <= 0
        if not (always and part.stop > time[-1]):
            raise NotInArraysError(f"{kind} has sines that are switched within the output times")
    level = 0.0
    if settled:
        level = sum(float(part.after[0]) for part in straight if part.is_step)
        straight = [part for part in straight if not part.is_step]
    grid, voltage, places = _grid(straight, time, kind) if straight else _only_outputs(time)
    rises = _rises(straight, grid, voltage)
    slopes = sum((part.slope(time) for part in straight), start=np.zeros(len(time)))
    repeated = straight if settled else []
    if any(part.period is None or len(part.times) > MOST_PIECES for part in repeated):
        raise NotInArraysError(f"{kind} has more than {MOST_PIECES} straight pieces in a period")
    amplitudes = np.concatenate([np.zeros(0), *(part.amplitudes for part in tones)])
    timing = DriveTiming(
        outputs=time,
        time=grid,
        places=places,
        breaks=tuple(part.times for part in repeated),
        frequencies=np.concatenate([np.zeros(0), *(part.frequencies for part in tones)]),
        settled=settled,
        is_straight=bool(straight),
    )
    ends = [each for part in repeated for each in (part.before, part.after)]
    mean = drive_mean(drive) if settled else 0.0
    integral = settled_integral(drive, time) if settled and not mean else np.zeros(len(time))
    row: list[Any] = [
        slopes,
        integral,
        rises,
        voltage,
        [mean, level],
        amplitudes.real,
        amplitudes.imag,
        *ends,
    ]
    return PiecewiseDrive(timing, np.concatenate(row))


def _only_outputs(time: Real) -> tuple[Real, Real, Indices]:
    """Return time 0 and the outputs, at which there is no voltage of straight pieces."""
    return np.concatenate([[0.0], time]), np.zeros(len(time) + 1), np.arange(1, len(time) + 1)


def _grid(parts: Sequence[Linear], time: Real, kind: str) -> tuple[Real, Real, Indices]:
    """Return outputs and corners, the drive there, and the places of the outputs.

    An output within the rounding of a corner is at that corner, as for one finger.
    """
    end = float(time[-1])
    if sum(part.count_breaks(end) for part in parts) > MOST_CORNERS:
        raise NotInArraysError(f"{kind} has more than {MOST_CORNERS} corners up to the last output time")
    corners = np.unique(np.concatenate([[0.0], *[part.until(end).times for part in parts]]))
    corners = corners[corners < end * (1 + SLACK)]
    corners = corners[
        np.diff(corners, prepend=-1.0) > 2 * SLACK * np.abs(corners)
    ]  # one point for two that agree
    after = np.sum([part.value(corners) for part in parts], axis=0)
    before = after.copy()
    before[1:] = np.sum([part.value_before(corners[1:]) for part in parts], axis=0)
    nearest = np.clip(np.searchsorted(corners, time * (1 + SLACK), side="right") - 1, 0, None)
    met = np.abs(time - corners[nearest]) <= SLACK * np.abs(time)
    times = np.where(met, corners[nearest], time)
    steps = np.flatnonzero(before != after)
    lone = np.setdiff1d(np.arange(len(corners)), nearest[met])
    grid = np.concatenate([corners[steps], corners[lone], times])
    kinds = np.concatenate([np.zeros(len(steps)), np.ones(len(lone)), np.full(len(times), 2.0)])
    values = [before[steps], after[lone], np.sum([part.value(times) for part in parts], axis=0)]
    order = np.lexsort((kinds, grid))
    places = np.flatnonzero(kinds[order] == 2)
    return grid[order], np.concatenate(values)[order], places


def _rises(parts: Sequence[Linear], grid: Real, voltage: Real) -> Real:
    """Return the rise of straight pieces from each time of a grid to the next [V], shape (m,)."""
    steps = np.diff(grid)
    slopes = sum((part.slope(grid[:-1] + steps / 2) for part in parts), start=np.zeros(len(steps)))
    return np.append(np.where(steps > 0, slopes * steps, np.diff(voltage)), 0.0)


def shared_drive(scenario: Scenario, begin: Mapping[str, float], time: Real, *, settled: bool) -> SharedDrive:
    """Find the fixed drives whose sum is the drive of every finger, with the values of its free parameters in the scenario.

    `time` (n,) [s].
    """
    base = piecewise_drive(scenario.drive, time, settled=settled)
    if not begin:
        return {"": base}
    slopes, rest = {}, base.row
    own = slice(2 * len(time) + len(base.timing.time), None)  # what precedes it follows from it
    for path in begin:
        nudged = 0.5 * begin[path] or 0.5 * quantity_at(scenario, path).high
        other = _with(scenario, {**begin, path: nudged}, base)  # a level may follow another
        slopes[path] = (other.row - base.row) / (nudged - begin[path])
        rest = rest - slopes[path] * begin[path]
    sizes = [float(np.max(np.abs(slope[own]))) * abs(begin[path]) for path, slope in slopes.items()]
    size = max([float(np.max(np.abs(base.row[own]), initial=0.0)), *sizes])
    for factors in _TEST_FACTORS:
        point = {
            path: begin[path] * factors[place % 2] or factors[2] * quantity_at(scenario, path).high
            for place, path in enumerate(begin)
        }
        expected = rest + sum(slopes[path] * point[path] for path in begin)
        seen = _with(scenario, point, base).row[own]
        if np.any(np.abs(seen - expected[own]) > _SAME * max(size, float(np.max(np.abs(seen), initial=0.0)))):
            raise NotInArraysError(f"the drive is not linear in {', '.join(begin)}")
    rows = slopes if np.all(np.abs(rest[own]) <= _SAME * size) else {"": rest} | slopes
    return {path: PiecewiseDrive(base.timing, row) for path, row in rows.items()}


def _with(scenario: Scenario, point: Mapping[str, float], base: PiecewiseDrive) -> PiecewiseDrive:
    """Return the drive at other values of its parameters, which has to have the timing of the first."""
    try:
        changed = scenario.replace(dict(point)).drive
    except InputError as error:
        listed = ", ".join(point)
        raise NotInArraysError(f"the range of {listed} depends on other parameters: {error}") from None
    found = piecewise_drive(changed, base.timing.outputs, settled=base.timing.settled)
    if not found.timing.agrees_with(base.timing):
        raise NotInArraysError(f"{', '.join(point)} changes more of the drive than its amplitude")
    return found
