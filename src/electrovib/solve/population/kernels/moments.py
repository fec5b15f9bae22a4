"""Mean and variance over fingers at each time, in fixed blocks merged in the order of their index."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.choice import compiled
from electrovib.solve.population.kernels.stepping import blocks_of_times, factors, gather
from electrovib.solve.population.kernels.time_steps import BLOCK

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real


class Moments(NamedTuple):
    """Number of fingers, mean and sum of squared deviations of a population at each time.

    Parameters
    ----------
    fingers : int
        Number of fingers.
    mean : ndarray, shape (n,)
        Mean, in the unit of the values.
    squares : ndarray, shape (n,)
        Sum over fingers of the squared deviation from the mean, in that unit squared.
    """

    fingers: int
    mean: Real
    squares: Real

    def variance(self) -> Real:
        """Return the unbiased variance, in the unit of the values squared; nan for fewer than two fingers."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.squares / np.float64(self.fingers - 1 if self.fingers > 1 else np.nan))


def block_moments(values: ArrayLike, *, threads: int | None = None) -> list[Moments]:
    """Return the moments of each block of 1024 fingers.

    `values` (fingers, n).
    """
    given = _table(values)
    if (kernel := compiled()) is not None:
        return [Moments(*each) for each in kernel.moments(given, threads)]
    found = []
    for begin in range(0, len(given), BLOCK):
        some = np.asarray(given[begin : begin + BLOCK], np.float64)
        mean = some.sum(axis=0) / len(some)
        found.append(Moments(len(some), mean, np.square(some - mean).sum(axis=0)))
    return found


def merged(blocks: Iterable[Moments]) -> Moments:
    """Return the moments of all blocks together, merged one after the other in the order given."""
    total: Moments | None = None
    for block in blocks:
        total = block if total is None else _together(total, block)
    if total is None:
        raise InputError("moments of no fingers: give at least one finger.")
    return total


def _together(one: Moments, other: Moments) -> Moments:
    """Return the moments of two groups of fingers together."""
    count = one.fingers + other.fingers
    apart = other.mean - one.mean
    mean = one.mean + apart * (other.fingers / count)
    squares = one.squares + other.squares + apart * apart * (one.fingers * other.fingers / count)
    return Moments(count, mean, squares)


def moments(values: ArrayLike, *, threads: int | None = None) -> Moments:
    """Return number of fingers, mean and sum of squared deviations over fingers at each time.

    `values` (fingers, n).
    """
    return merged(block_moments(values, threads=threads))


def square_moments_many(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike,
    *,
    factor: ArrayLike = 1.0,
    threads: int | None = None,
) -> list[Moments]:
    """Return the moments of factor times the squared response of each block of 1024 fingers, without storing responses.

    `factor` (fingers,).
    """
    fingers = gather(rates, residues, direct, state, voltage, time)
    squared = factors(factor, fingers)
    if (kernel := compiled()) is not None:
        return [Moments(*each) for each in kernel.square_moments(fingers, squared, threads)]
    found = []
    for begin in range(0, len(squared), BLOCK):
        part, size = slice(begin, begin + BLOCK), fingers.voltage.size
        mean, squares = np.empty(size), np.empty(size)
        for place, rows in blocks_of_times(fingers.some(part), squared[part]):
            here = slice(place, place + len(rows))
            mean[here] = rows.mean(axis=1)
            squares[here] = np.square(rows - mean[here, np.newaxis]).sum(axis=1)
        found.append(Moments(len(squared[part]), mean, squares))
    return found


def _table(values: ArrayLike) -> Real:
    """Return values as a contiguous table of float64 or float32."""
    given = np.asarray(values)
    given = np.ascontiguousarray(given, np.float32 if given.dtype == np.float32 else np.float64)
    if given.ndim != 2:
        raise InputError(f"values has shape {given.shape}: expected (fingers, n).")
    return given
