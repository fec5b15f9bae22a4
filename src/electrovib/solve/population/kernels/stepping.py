"""Responses of many fingers to one piecewise linear drive, as a table."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, DTypeLike, NDArray

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
        """The pieces of equal steps that the loops follow."""
        return _pieces(self)


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


def _pieces(steps: TimeSteps) -> _EqualSteps:
    """Divide a time grid; the last time is a piece of one step without duration."""
    from electrovib.solve.population.kernels.loops import COMPENSATED, TIMES

    kind = np.append(steps.kind, steps.duration.size)
    duration = np.append(steps.duration, 0.0)
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


class _Fingers(NamedTuple):
    """Sums of relaxing modes of many fingers, and the drive that all of them share, as `first_order_hold_many` takes them."""

    rates: Real
    residues: Real
    direct: Real
    state: Real
    voltage: Real
    steps: TimeSteps
    factor: Real

    @property
    def arrays(self) -> tuple[Real, Real, Real, Real]:
        """The arrays of the fingers as the loops expect them."""
        return self.rates, self.residues, self.direct, self.state


def _gathered(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike | TimeSteps,
    factor: ArrayLike,
) -> _Fingers:
    """Convert the arguments of `first_order_hold_many` into contiguous arrays, and refuse arguments that disagree."""
    rate, residue, level, begin, drive = (
        np.ascontiguousarray(each, np.float64) for each in (rates, residues, direct, state, voltage)
    )
    steps = time if isinstance(time, TimeSteps) else time_steps(time)
    if (
        rate.ndim != 2
        or residue.shape != rate.shape
        or begin.shape != rate.shape
        or level.shape != rate.shape[:1]
    ):
        raise InputError(
            f"rates, residues and state have the shapes {rate.shape}, {residue.shape} and {begin.shape}, direct "
            f"{level.shape}: expected (fingers, modes) three times, and (fingers,)."
        )
    if drive.shape != (steps.kind.size + 1,):
        raise InputError(
            f"voltage has shape {drive.shape}: expected one value for each of {steps.kind.size + 1} times."
        )
    if not (np.isfinite(rate).all() and (rate >= 0.0).all()):
        raise InputError("rates has a value that is negative or not finite: expected minus the poles [1/s].")
    factors = np.ascontiguousarray(np.broadcast_to(np.asarray(factor, np.float64), level.shape))
    return _Fingers(rate, residue, level, begin, drive, steps, factors)


def first_order_hold_many(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike | TimeSteps,
    *,
    factor: ArrayLike | None = None,
    dtype: DTypeLike = np.float64,
    out: NDArray[Any] | None = None,
) -> NDArray[Any]:
    """Compute the responses of many fingers to one piecewise linear drive, exact at every time.

    `rates` (fingers, modes), `residues` (fingers, modes), `direct` (fingers,), `state` (fingers, modes),
    `voltage` (n,) [V], `time` (n,) [s], `factor` (fingers,), `out` (fingers, n); returns `response` (fingers, n), or
    factor times its square.

    Each mode is advanced by its exact weights for a straight drive.
    """
    from electrovib.solve.population.kernels import loops

    fingers = _gathered(rates, residues, direct, state, voltage, time, 1.0 if factor is None else factor)
    shape = len(fingers.direct), fingers.voltage.size
    result = np.empty(shape, dtype) if out is None else out
    if result.shape != shape or result.dtype != np.dtype(dtype) or not result.flags.c_contiguous:
        raise InputError(
            f"out has shape {result.shape} and type {result.dtype}: expected {shape} and {np.dtype(dtype)}."
        )
    chunks, pieces, duration, slots = fingers.steps.pieces
    grid, lanes, modes = (fingers.voltage, chunks, pieces, duration), loops.LANES, fingers.rates.shape[1]
    memory = (  # for the parameters of a tile, the weights of its steps, and its responses
        np.empty((2 * modes + 2) * lanes),
        np.empty(slots * (4 * modes + 1) * lanes),
        np.empty(loops.TIMES * lanes),
    )
    loops.responses(fingers.arrays, fingers.factor, factor is not None, grid, memory, result)
    return result
