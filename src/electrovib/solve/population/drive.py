"""The drive that fingers share: straight pieces on a grid of all outputs and corners, and sines; its responses, as a table."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.physics.drive.parts import SLACK, Linear, Smooth, Tones, cosine_and_sine
from electrovib.solve.recursion.hold import hold_weights
from electrovib.solve.stack.harmonics import drive_mean, settled_integral
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario

KERNEL: Final = f"numpy {np.__version__}"
"""What computes fingers in arrays, with the version on which the last bits of results depend."""
BLOCK: Final = 32
"""Equal steps that are taken together."""
_MANY: Final = 16
"""Equal steps from which blocks are faster than single steps."""
_FEWEST: Final = 8
"""Fingers that are computed together at least; more would take gigabytes for long records."""
_NUMBERS: Final = 1 << 19
"""Responses that are computed together, about: enough that few operations on arrays remain."""
_ROUNDING: Final = 4 * float(np.finfo(float).eps)


class TimeSteps(NamedTuple):
    """Steps of a time grid, equal ones counted once.

    Parameters
    ----------
    kind : ndarray of int, shape (n - 1,)
        Index of the duration of each step.
    duration : ndarray, shape (kinds,)
        Distinct durations, increasing [s].
    """

    kind: Indices
    duration: Real


def time_steps(time: ArrayLike) -> TimeSteps:
    """Return the distinct steps of a time grid; differences that are equal up to the rounding of the times count as one.

    `time` (n,) [s].

    The duration of a group of steps is their mean, so that rounding does not accumulate over the grid.
    """
    times = np.ascontiguousarray(time, np.float64)
    steps = np.diff(times)
    if not steps.size:
        return TimeSteps(np.zeros(0, np.intp), np.zeros(0))
    distinct, kind, counts = np.unique(steps, return_inverse=True, return_counts=True)
    slack = _ROUNDING * float(np.max(np.abs(times)))
    group, first = np.zeros(distinct.size, np.intp), distinct[0]
    for place in np.flatnonzero(np.diff(distinct, prepend=distinct[0]) > 0).tolist():
        new = distinct[place] - first > slack or (first == 0.0)
        group[place] = group[place - 1] + new
        first = distinct[place] if new else first
    total = np.bincount(group, distinct * counts) / np.bincount(group, counts)
    return TimeSteps(group[kind.reshape(-1)].astype(np.intp), total)


def first_order_hold_many(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike | TimeSteps,
    *,
    rises: ArrayLike | None = None,
    places: Indices | None = None,
) -> Real:
    """Compute the responses of many fingers to one piecewise linear drive, exact at every time.

    `rates`, `residues`, `state` (fingers, modes), `direct` (fingers,), `voltage` (n,) [V], `time` (n,) [s]; returns
    `response` (fingers, n).

    The response is direct v + sum residue s with s' = v - rate s from residue s = `state`. With `rises` (n,) [V], those of
    the drive from each time to the next, the second term is sum residue l with l = rate s - v, which loses no digits where
    modes follow a slow drive. Of all times those at the increasing indices `places` (outputs,) are returned. The numbers of
    a finger do not depend on the others.
    """
    rate, residue, level, begin, drive = (
        np.ascontiguousarray(each, np.float64) for each in (rates, residues, direct, state, voltage)
    )
    lags = rises is not None
    grid = _Grid(drive, np.ascontiguousarray(rises, np.float64) if lags else drive, lags)
    steps = time if isinstance(time, TimeSteps) else time_steps(time)
    outputs = None if places is None or len(places) == len(drive) else places
    result = np.empty((len(rate), len(drive) if outputs is None else len(outputs)))
    together = min(max(_FEWEST, _NUMBERS // len(drive)), len(rate))
    # new memory takes longer than the responses in it
    memory = np.empty((3, together * (len(drive) + BLOCK)))
    for first in range(0, len(rate), together):
        some = slice(first, min(first + together, len(rate)))
        fingers = _Fingers(rate[some], residue[some], level[some], memory[1:])
        size = len(fingers.direct)
        rows = result[some] if outputs is None else memory[0, : size * len(drive)].reshape(size, -1)
        _respond(fingers, begin[some], grid, steps, rows)
        if outputs is not None:
            np.take(rows, outputs, axis=1, out=result[some], mode="clip")
    return result


class _Fingers(NamedTuple):
    """Rates [1/s] and residues of modes (fingers, modes), shares of the drive (fingers,), and memory of responses (2, n)."""

    rates: Real
    residues: Real
    direct: Real
    memory: Real

    def step(self, durations: Real, *, lags: bool) -> tuple[Real, Real, Real]:
        """Return loss and weights of the drive at the beginning and the end of steps, `durations` [s] (steps, 1, 1) or (1,).

        A state times its residue advances by ``s - loss s + first v + last v'``, a lag by ``l - loss l + first rise``.
        """
        z = -self.rates * durations
        loss = -np.expm1(z)
        if lags:
            mean = np.divide(-loss, z, out=np.ones_like(z), where=z != 0)
            return loss, -self.residues * mean, np.zeros_like(z)
        _, first, last = hold_weights(z)
        scale = np.divide(self.residues, self.rates, out=self.residues * durations / 2, where=z != 0)
        return loss, scale * np.where(z != 0, first, 1.0), scale * np.where(z != 0, last, 1.0)


class _Grid(NamedTuple):
    """Drive at each time [V], what excites the modes there, the drive or its rises, and whether it is the rises."""

    voltage: Real
    given: Real
    lags: bool

    def part(self, begin: int, end: int) -> _Grid:
        """Return some steps, with the time after them."""
        return _Grid(self.voltage[begin : end + 1], self.given[begin : end + 1], self.lags)


def _respond(fingers: _Fingers, state: Real, grid: _Grid, steps: TimeSteps, rows: Real) -> None:
    """Write the responses of some fingers at all times of a grid, stretch after stretch."""
    for begin, end, is_even in _stretches(steps.kind):
        part, durations = grid.part(begin, end), steps.duration[steps.kind[begin:end]]
        respond = _in_blocks if is_even else _one_by_one
        state = respond(fingers, state, part, durations, rows[:, begin:end])
    rows[:, -1] = fingers.direct * grid.voltage[-1] + state.sum(axis=1)


def _stretches(kinds: Indices) -> Iterator[tuple[int, int, bool]]:
    """Yield first and last index of stretches of steps, and whether these are many equal ones."""
    ends = np.append(np.flatnonzero(np.diff(kinds, prepend=-1)), len(kinds))
    many = np.diff(ends) >= _MANY
    begins = np.append(np.ones(len(many[:1]), bool), many[1:] | many[:-1])
    for first, last in pairwise([*np.flatnonzero(begins).tolist(), len(many)]):
        yield int(ends[first]), int(ends[last]), bool(many[first])


def _one_by_one(fingers: _Fingers, state: Real, grid: _Grid, durations: Real, rows: Real) -> Real:
    """Write the responses at the beginnings of some steps, and return the state after them."""
    for first in range(0, len(durations), BLOCK):
        some = slice(first, min(first + BLOCK, len(durations)))
        loss, early, late = fingers.step(durations[some, None, None], lags=grid.lags)
        pushed = early * grid.given[some, None, None]
        if not grid.lags:
            pushed += late * grid.given[some.start + 1 : some.stop + 1, None, None]
        states = np.empty_like(loss)
        for place in range(len(states)):
            states[place] = state
            state = state + (pushed[place] - loss[place] * state)  # a decay near 1 would be rounded
        rows[:, some] = fingers.direct[:, None] * grid.voltage[some] + states.sum(axis=2).T
    return state


def _in_blocks(fingers: _Fingers, state: Real, grid: _Grid, durations: Real, rows: Real) -> Real:
    """Write the responses at the beginnings of equal steps, and return the state after them.

    The state less its last weight times the drive u, z, advances by ``decay z + push u`` with ``push = decay last + first``.
    Within a block of steps the response is ``sum decay^k z`` of its begin, and those to what is given at its steps.
    """
    length, step = len(durations), durations[:1]
    count = -(-length // BLOCK)
    left = length - (count - 1) * BLOCK
    _, first, last = fingers.step(step, lags=grid.lags)
    powers = np.exp(-fingers.rates[:, :, None] * (step * np.arange(BLOCK + 1)))
    pushes = (powers[:, :, 1] * last + first)[:, :, None] * powers[:, :, :BLOCK]
    given = np.zeros((count, BLOCK))
    given.ravel()[:length] = grid.given[:length]
    pushed = np.matmul(pushes[:, :, ::-1], given.T)
    states = np.empty((count, *state.shape))
    states[0] = state - last * grid.voltage[0]
    for place in range(count - 1):
        np.multiply(states[place], powers[:, :, BLOCK], out=states[place + 1])
        states[place + 1] += pushed[:, :, place]
    level = fingers.direct + last.sum(axis=1)
    after = np.zeros((len(rows), 2 * BLOCK))  # what is given at a step, before it and after it
    after[:, BLOCK + 1 :] = pushes.sum(axis=1)[:, :-1]
    free, begins = powers[:, :, :BLOCK], states.transpose(1, 0, 2)
    if grid.lags:  # the drive is that at the begin of the block and its rises
        after[:, BLOCK + 1 :] += level[:, None]
        free = np.concatenate([free, np.broadcast_to(level[:, None, None], (len(rows), 1, BLOCK))], axis=1)
        voltage = np.broadcast_to(grid.voltage[:length:BLOCK, None], (len(rows), count, 1))
        begins = np.concatenate([begins, voltage], axis=2)
    else:
        after[:, BLOCK] = level
    impulses = np.ascontiguousarray(sliding_window_view(after, BLOCK, axis=1)[:, BLOCK:0:-1])
    size = len(rows) * count * BLOCK
    found = fingers.memory[:, :size].reshape(2, len(rows), count * BLOCK)
    for out, amounts, each in zip(found, (given, begins), (impulses, free), strict=True):
        np.matmul(amounts, each, out=out.reshape(len(rows), count, BLOCK))
    np.add(found[0, :, :length], found[1, :, :length], out=rows)
    reached = powers[:, :, left] * states[-1] + pushes[:, :, :left][:, :, ::-1] @ given[-1, :left]
    return np.asarray(reached + last * grid.voltage[length])


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
