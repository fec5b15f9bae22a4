"""Statistics over fingers at each time: moments that can be merged, and exact quantiles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.stepping import BLOCK, gather, mean_and_squares, square_rows
from electrovib.solve.population.kernels.threads import in_threads, ranges

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.solve.population.kernels.stepping import TimeSteps

    Rows = NDArray[np.float32]

_ROWS: Final = 16  # times of one call
_LARGEST: Final = 0x7F800000  # bit pattern of infinity as a float32: those beyond it are nan
_COLUMNS: Final = 32  # columns of a table that are turned into rows together


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
    given = np.asarray(values)
    if given.ndim != 2:
        raise InputError(f"values has shape {given.shape}: expected (fingers, n).")
    parts = ranges(len(given), BLOCK)
    found = [Moments(0, np.empty(0), np.empty(0))] * len(parts)

    def work(place: int) -> None:
        some = np.asarray(given[slice(*parts[place])], np.float64)
        mean = some.sum(axis=0) / len(some)
        found[place] = Moments(len(some), mean, np.square(some - mean).sum(axis=0))

    in_threads(work, range(len(parts)), threads)
    return found


def square_moments_many(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike | TimeSteps,
    *,
    factor: ArrayLike = 1.0,
    threads: int | None = None,
) -> list[Moments]:
    """Return the moments of factor times the squared response of each block of 1024 fingers, without storing responses.

    `factor` (fingers,).
    """
    fingers = gather(rates, residues, direct, state, voltage, time, factor)
    return [Moments(*each) for each in mean_and_squares(fingers, threads)]


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


def quantiles(values: ArrayLike, probabilities: ArrayLike, *, threads: int | None = None) -> Real:
    """Return exact quantiles over fingers at each time.

    `values` (fingers, n), `probabilities` (p,); returns `quantiles` (p, n).

    The quantile of probability p is interpolated between the order statistics on both sides of index p (fingers - 1),
    definition 7 of Hyndman and Fan, in float64.
    """
    given = np.asarray(values, np.float32)
    if given.ndim != 2 or not len(given):
        raise InputError(f"values has shape {given.shape}: expected (fingers, n) with one finger or more.")
    wanted = _Places(probabilities, len(given))
    found = np.empty((wanted.places.size, given.shape[1]))

    def work(part: tuple[int, int]) -> None:
        here = slice(*part)
        wanted.write(np.ascontiguousarray(given[:, here].T), range(part[1] - part[0]), found[:, here])

    in_threads(work, ranges(given.shape[1], _COLUMNS), threads)
    return wanted.interpolated(found)


def square_quantiles(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike | TimeSteps,
    *,
    factor: ArrayLike,
    outputs: ArrayLike,
    probabilities: ArrayLike,
    known: Mapping[int, Rows] | None = None,
    threads: int | None = None,
) -> Real:
    """Return exact quantiles over fingers of factor times the squared response, without storing responses of all times.

    `factor` (fingers,), `outputs` (n,), indices of times, `probabilities` (p,), `known` rows (fingers, n) that replace
    responses from a finger on; returns `quantiles` (p, n).
    """
    fingers = gather(rates, residues, direct, state, voltage, time, factor)
    at, wanted = np.asarray(outputs, np.intp), _Places(probabilities, len(fingers.factor))
    found = np.empty((wanted.places.size, at.size))
    for some, table, rows in square_rows(fingers, at, known or {}, threads):

        def work(
            part: tuple[int, int], table: Rows = table, rows: Indices = rows, into: Real = found[:, some]
        ) -> None:
            here = slice(*part)
            wanted.write(table, rows[here], into[:, here])

        in_threads(work, ranges(len(rows), _ROWS), threads)
    return wanted.interpolated(found)


class _Places:
    """Places of quantiles in the order of some fingers.

    Parameters
    ----------
    probabilities : array_like, shape (p,)
        From 0 to 1.
    fingers : int
        Number of fingers.
    """

    def __init__(self, probabilities: ArrayLike, fingers: int) -> None:
        wanted = np.atleast_1d(np.asarray(probabilities, np.float64))
        if not ((wanted >= 0.0) & (wanted <= 1.0)).all():
            raise InputError(f"probabilities = {wanted.tolist()}: expected numbers from 0 to 1.")
        place = wanted * (fingers - 1)
        self.below: Indices = np.floor(place).astype(np.intp)
        self.share: Real = place - self.below
        self.above: Indices = self.below + (self.share > 0)
        self.places: Indices = np.unique([self.below, self.above])

    def write(self, table: Rows, rows: Iterable[int], found: Real) -> None:
        """Write the numbers at the places in the order of some rows into the columns of `found`, (places, rows)."""
        from electrovib.solve.population.kernels import row_loops

        patterns, kept = table.view(np.int32), np.empty(table.shape[1] + 1, np.int32)
        counts, ranks = np.empty(row_loops.BUCKETS, np.int64), np.empty(self.places.size, np.int64)
        for column, row in enumerate(rows):
            size, low, high = row_loops.keep_near(patterns[row], self.places, counts, kept, ranks)
            if high > _LARGEST or low < -_LARGEST - 1:
                found[:, column] = np.nan
                continue
            order = np.partition(kept[:size], ranks)[ranks]
            bits = order ^ ((order >> 31) & np.int32(0x7FFFFFFF))
            found[:, column] = bits.view(np.float32).astype(np.float64) + 0.0  # -0 becomes 0

    def interpolated(self, ordered: Real) -> Real:
        """Return the quantiles, (p, n), from the order statistics at the places, (places, n)."""
        places, upper = self.places, self.share[:, np.newaxis]
        low = ordered[np.searchsorted(places, self.below)]
        high = ordered[np.searchsorted(places, self.above)]
        with np.errstate(invalid="ignore"):  # infinities of both signs
            return np.asarray(np.where(low == high, low, low * (1 - upper) + high * upper))
