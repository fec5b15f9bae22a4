"""Responses of many fingers to one piecewise linear drive, as a table."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from electrovib.solve.recursion.hold import hold_weights

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Indices, Real

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
