"""Calls of the compiled kernels of columns and of frequencies: memory and threads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.solve.population.kernels.compiled import frequencies, selection
from electrovib.solve.population.kernels.compiled.calls import aligned
from electrovib.solve.population.kernels.threads import in_threads, ranges
from electrovib.solve.recursion.vectors.width import WIDTH

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Complex, Indices, Real

_COLUMNS: Final = selection.COLUMNS  # columns of one call
_FINGERS: Final = 512  # fingers of one call
_PAST: Final = 1 << 25  # bytes of a table from which it is written past the caches


def order_statistics(values: NDArray[np.float32], places: Indices, threads: int | None) -> Real:
    """Return the numbers at some places in the order of each column.

    `values` (fingers, n), `places` (p,); returns `ordered` (p, n).
    """
    count, columns = values.shape
    patterns, found = values.view(np.int32), np.empty((places.size, columns), np.int32)
    together = selection.WIDE if count <= selection.FEW_ROWS else selection.COLUMNS

    def work(part: tuple[int, int]) -> None:
        # rows begin at different lines of a page, or they would displace each other from the cache
        length = count + -count % 1024 + 16
        keys, some = np.empty((together, length), np.int32), np.empty((2, count + 1), np.int32)
        counts = np.empty(selection.BUCKETS, np.int32)
        selection.order_statistics(patterns, places, *part, keys, some[0], some[1], counts, found)

    in_threads(work, ranges(columns, together), threads)
    return selection.numbers(found)


def octaves(values: NDArray[np.float32], threads: int | None) -> tuple[NDArray[np.bool_], bool]:
    """Return which octaves have values at each time, and whether no value is nan.

    `values` (fingers, n); returns `found` (n, 512).
    """
    parts, patterns = ranges(values.shape[1], _COLUMNS), values.view(np.int32)
    found, valid = np.zeros((values.shape[1], 512), bool), np.ones((len(parts), 1), bool)

    def work(place: int) -> None:
        selection.octaves_of(patterns, *parts[place], found, valid[place])

    in_threads(work, range(len(parts)), threads)
    return found, bool(valid.all())


def count(
    values: NDArray[np.float32], pages: NDArray[np.int32], counts: NDArray[np.int64], threads: int | None
) -> None:
    """Add values to the counts of a histogram.

    `values` (fingers, n).
    """
    patterns = values.view(np.int32)

    def work(part: tuple[int, int]) -> None:
        selection.count_bins(patterns, pages, *part, counts)

    in_threads(work, ranges(values.shape[1], _COLUMNS), threads)


def _filled_up(angular: Real) -> Real:
    """Return frequencies with some more, so that they are whole vectors."""
    whole = aligned(angular.size + -angular.size % WIDTH)
    whole[:] = 1.0
    whole[: angular.size] = angular
    return whole


def _target(result: Real) -> tuple[Real, int, bool]:
    """Return a table, its address, and whether it is written past the caches, in which it does not fit anyway."""
    return result, result.ctypes.data, result.nbytes >= _PAST


def transfer(
    rates: Real, residues: Real, direct: Real, angular: Real, result: Complex, threads: int | None
) -> None:
    """Write the transfer functions of fingers.

    `result` (fingers, n).
    """
    whole, out = _filled_up(angular), _target(result.view(np.float64))

    def work(part: tuple[int, int]) -> None:
        memory, groups = aligned(2 * whole.size), aligned(((rates.shape[1] + 3) // 4 * 12 + 8) * WIDTH)
        frequencies.transfers(rates, residues, direct, whole, *part, memory, groups, *out)

    in_threads(work, ranges(len(direct), _FINGERS), threads)


def mean_square(
    rates: Real, residues: Real, direct: Real, angular: Real, half: Real, result: Real, threads: int | None
) -> None:
    """Write a factor times the squared magnitudes of the transfer functions of fingers.

    `half` (fingers,), `result` (fingers, n).
    """
    whole, out = _filled_up(angular), _target(result)

    def work(part: tuple[int, int]) -> None:
        memory, groups = aligned(2 * whole.size), aligned(((rates.shape[1] + 3) // 4 * 12 + 8) * WIDTH)
        frequencies.mean_squares(rates, residues, direct, whole, half, *part, memory, groups, *out)

    in_threads(work, ranges(len(direct), _FINGERS), threads)


def cole_cole(
    level: Real,
    strength: Real,
    time: Real,
    alpha: Real,
    leak: Real,
    angular: Real,
    result: Any,
    threads: int | None,
) -> None:
    """Write the permittivities of Cole-Cole materials of fingers.

    `result` (fingers, n).
    """
    whole, power = _filled_up(angular), 1.0 - alpha
    turned = np.pi / 2 * power
    terms = np.stack(
        [strength, power, power * np.log(time), np.cos(turned), np.sin(turned)], axis=-1
    ).reshape(-1)
    logarithm, inverse, out = np.log(whole), 1.0 / whole, _target(result.view(np.float64))

    def work(part: tuple[int, int]) -> None:
        memory = aligned(2 * whole.size)
        frequencies.permittivities(level, terms, leak, inverse, logarithm, *part, memory, *out)

    in_threads(work, ranges(len(level), _FINGERS), threads)
