"""Calls of the compiled kernels that keep the values of some times of all fingers in memory: memory and threads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.solve.population.kernels.compiled import intervals, selection
from electrovib.solve.population.kernels.compiled.calls import SharedArguments, aligned
from electrovib.solve.population.kernels.compiled.stepping import TIMES
from electrovib.solve.population.kernels.threads import in_threads, ranges

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real

_FINGERS: Final = 2048
"""Fingers of one call, whose states and parameters stay in memory."""
_ROWS: Final = 16
"""Times of one call."""


class _Stepped:
    """Squared responses of fingers, some times after the other.

    Parameters
    ----------
    fingers : Fingers
        Sums of modes and their drive.
    factor : ndarray, shape (fingers,)
        Factor of each finger.
    threads : int, optional
        Number of threads.
    """

    def __init__(self, fingers: Any, factor: Real, threads: int | None) -> None:
        self.drive, self.factor, self.threads = SharedArguments(fingers), factor, threads
        self.parts = ranges(len(factor), _FINGERS)
        self.states = [aligned(_FINGERS * max(1, self.drive.modes)) for _ in self.parts]
        self.since = [np.zeros((1, self.drive.kinds), np.int64) for _ in self.parts]

    def write(self, time: int, stop: int, out: NDArray[np.float32]) -> None:
        """Write the values from one time to another, (times, fingers and more); calls follow each other in time."""
        drive = self.drive

        def work(place: int) -> None:
            memory, tags, _ = drive.memory(1)
            since, states = self.since[place], self.states[place]
            some = np.empty((TIMES, intervals.TOGETHER), np.float32)
            intervals.squares_between(
                drive.fingers,
                self.factor,
                drive.voltage,
                drive.pieces,
                *self.parts[place],
                time,
                stop,
                memory,
                tags,
                since,
                states,
                some,
                out,
            )

        in_threads(work, range(len(self.parts)), self.threads)


def _outputs(places: Indices, size: int) -> Iterator[tuple[int, int, slice]]:
    """Yield intervals of times, and the range of the outputs in each."""
    for time in range(0, size, TIMES):
        stop = min(time + TIMES, size)
        first, last = np.searchsorted(places, [time, stop]).tolist()
        yield time, stop, slice(first, last)


def square_order_statistics(
    fingers: Any,
    factor: Real,
    outputs: Indices,
    places: Indices,
    known: Mapping[int, NDArray[np.float32]],
    threads: int | None,
) -> Real:
    """Return the numbers at some places in the order of factor times the squared responses, at some times.

    `factor` (fingers,), `outputs` (n,), `places` (p,); returns `ordered` (p, n).
    """
    count, stepped = len(factor), _Stepped(fingers, factor, threads)
    # rows begin at different lines of a page, or they would displace each other from the cache
    table = np.empty((TIMES, count + -count % 1024 + 16), np.float32)
    patterns, found = table.view(np.int32), np.empty((len(places), len(outputs)), np.int32)
    for time, stop, some in _outputs(outputs, fingers.voltage.size):
        stepped.write(time, stop, table)
        rows = outputs[some] - time
        for first, values in known.items():
            table[rows, first : first + len(values)] = values[:, some].T

        def work(part: tuple[int, int], rows: Indices = rows, into: Any = found[:, some]) -> None:
            kept, counts = np.empty((2, count + 1), np.int32), np.empty(selection.BUCKETS, np.int32)
            here = slice(*part)
            intervals.order_statistics_of_rows(
                patterns, count, places, rows[here], kept[0], kept[1], counts, into[:, here]
            )

        in_threads(work, ranges(len(rows), _ROWS), threads)
    return selection.numbers(found)


def count_squares(
    fingers: Any,
    factor: Real,
    outputs: Indices,
    known: Mapping[int, NDArray[np.float32]],
    histogram: Any,
    threads: int | None,
) -> None:
    """Count factor times the squared responses, at some times, in a histogram."""
    count, stepped = len(factor), _Stepped(fingers, factor, threads)
    table = np.empty((TIMES, count + -count % 1024 + 16), np.float32)
    patterns = table.view(np.int32)
    found = np.zeros(histogram.pages.shape, bool)
    for time, stop, some in _outputs(outputs, fingers.voltage.size):
        stepped.write(time, stop, table)
        rows = outputs[some] - time
        for first, values in known.items():
            table[rows, first : first + len(values)] = values[:, some].T
        parts = ranges(len(rows), _ROWS)
        for again in (False, True):
            missed = np.zeros(len(parts), np.int64)

            def work(
                place: int,
                rows: Indices = rows,
                begin: int = some.start,
                again: bool = again,
                lost: Any = missed,
            ) -> None:
                first, last = parts[place]  # noqa: B023 - called within this round
                bins = np.empty(count, np.int32)
                lost[place] = intervals.count_rows(
                    patterns,
                    count,
                    rows[first:last],
                    begin + first,
                    histogram.pages,
                    histogram.counts,
                    bins,
                    found,
                    again,
                )

            in_threads(work, range(len(parts)), threads)
            if not missed.any():
                break
            histogram.allocate(found)


def add_counts(histogram: Any, other: Any) -> None:
    """Add the counts of another histogram, for whose octaves there is memory."""
    intervals.add_pages(histogram.pages, histogram.counts, other.pages, other.counts)
