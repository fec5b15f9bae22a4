"""Responses of many fingers to one piecewise linear drive, as a table."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Indices, Real

_ROUNDING: Final = 4 * float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class TimeSteps:
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

    @cached_property
    def pieces(self) -> _EqualSteps:
        """The pieces of equal steps that the loops follow; the last time is a piece of one step without duration."""
        from electrovib.solve.population.kernels.loops import COMPENSATED, TIMES

        kind = np.append(self.kind, self.duration.size)
        duration = np.append(self.duration, 0.0)
        order = np.argsort(kind, kind="stable")
        among = np.empty(kind.size, np.intp)  # index of each step among those of its duration
        among[order] = np.arange(kind.size) - np.searchsorted(kind[order], kind[order])
        compensated = (among + 1) % COMPENSATED == 0
        begins = (np.arange(kind.size) % TIMES == 0) | (np.diff(kind, prepend=-1) != 0)
        begins[1:] |= compensated[:-1]
        begin = np.flatnonzero(begins)
        end = np.append(begin[1:], kind.size)
        chunks = np.searchsorted(begin, np.arange(0, kind.size + TIMES, TIMES))
        # a place for the weights of each duration of a chunk; they are new where it occurs first
        earlier = begin // TIMES * duration.size
        pairs, first, inverse = np.unique(earlier + kind[begin], return_index=True, return_inverse=True)
        slot, is_new = inverse.reshape(-1) - np.searchsorted(pairs, earlier), np.zeros(begin.size, bool)
        is_new[first] = True
        rows = np.stack([begin, end, slot, is_new, compensated[end - 1]], axis=1).astype(np.intp)
        return _EqualSteps(chunks, rows, duration[kind[begin]], int(slot.max()) + 1)


class _EqualSteps(NamedTuple):
    """Pieces of equal steps: each ends with its chunk of times, or where the rounding of the decay is compensated.

    Parameters
    ----------
    chunks : ndarray of int, shape (chunks + 1,)
        Index of the first piece of each chunk.
    rows : ndarray of int, shape (pieces, 5)
        First and last step, place of the weights, whether these are new, and whether the piece ends with a compensation.
    duration : ndarray, shape (pieces,)
        Duration of each step [s].
    slots : int
        Number of places of weights.
    """

    chunks: Indices
    rows: Indices
    duration: Real
    slots: int


def time_steps(time: ArrayLike) -> TimeSteps:
    """Return the distinct steps of a time grid; differences that are equal up to the rounding of the times count as one.

    `time` (n,) [s].

    The duration of a group of steps is their mean, so that rounding does not accumulate over the grid.
    """
    times = np.ascontiguousarray(time, np.float64)
    if times.ndim != 1 or not times.size:
        raise InputError(f"time has shape {times.shape}: expected one row of times, at least one.")
    steps = np.diff(times)
    if not (np.isfinite(times).all() and (steps >= 0.0).all()):
        raise InputError(
            "time has a value that is not finite or lies before the one preceding it: sort the times."
        )
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
    modes follow a slow drive. Of all times those at the increasing indices `places` (outputs,) are returned.
    """
    from electrovib.solve.population.kernels import loops

    rate, residue, level, begin, drive = (
        np.ascontiguousarray(each, np.float64) for each in (rates, residues, direct, state, voltage)
    )
    given = drive if rises is None else np.ascontiguousarray(rises, np.float64)
    steps = time if isinstance(time, TimeSteps) else time_steps(time)
    shapes = residue.shape, begin.shape, (*level.shape, rate.shape[-1])
    if (
        rate.ndim != 2
        or any(shape != rate.shape for shape in shapes)
        or not drive.shape == given.shape == (len(steps.kind) + 1,)
    ):
        raise InputError(
            f"rates, residues, state, direct, voltage and rises have the shapes {rate.shape}, {residue.shape}, "
            f"{begin.shape}, {level.shape}, {drive.shape} and {given.shape}: expected (fingers, modes) three times,"
            f" (fingers,) and twice ({len(steps.kind) + 1},)."
        )
    if not (np.isfinite(rate).all() and (rate >= 0.0).all()):
        raise InputError("rates has a value that is negative or not finite: expected minus the poles [1/s].")
    chunks, pieces, duration, slots = steps.pieces
    outputs = np.arange(len(drive)) if places is None else places
    firsts = np.searchsorted(outputs, np.arange(len(chunks)) * loops.TIMES)  # outputs of each chunk
    lanes, modes, result = loops.LANES, rate.shape[1], np.empty((len(rate), len(outputs)))
    memory = (  # for the parameters of a tile, the weights of its steps, and its responses
        np.empty((2 * modes + 1) * lanes),
        np.empty(slots * (4 * modes + 1) * lanes),
        np.empty(loops.TIMES * lanes),
    )
    grid = drive, given, rises is not None, chunks, pieces, duration
    loops.responses((rate, residue, level, begin), grid, memory, outputs, firsts, result)
    return result
