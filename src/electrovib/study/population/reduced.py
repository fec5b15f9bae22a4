"""Statistics of some consecutive fingers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.solve.population.kernels import Histogram, Moments
    from electrovib.study.population.counts import FingerCounts


class SquareForm(NamedTuple):
    """Signals of a block of fingers in the form from which `square_quantiles` computes them again.

    Parameters
    ----------
    rates, residues, direct, state : ndarray, shape (fingers, modes) but for direct, (fingers,)
        As for `square_quantiles`.
    factor : ndarray, shape (fingers,)
        Signal over the square of the response.
    """

    rates: Real
    residues: Real
    direct: Real
    state: Real
    factor: Real


Form: TypeAlias = "SquareForm | NDArray[np.float32]"
"""Signals of a block of fingers: the form from which they are computed again, or as they are, shape (fingers, n)."""


@dataclass
class ReducedSignal:
    """Statistics of one signal over some consecutive fingers.

    Parameters
    ----------
    blocks : list of Moments
        Of each block of 1024 fingers.
    counts : FingerCounts
        Of all fingers.
    values : ndarray of float32, shape (fingers, n), or None
        Signals of the fingers, where they are needed.
    histogram : Histogram or None
        Of the signals, in place of them where it is smaller.
    forms : list of SquareForm or ndarray of float32, shape (fingers, n)
        Signals of each block, where they are computed again for percentiles or histogram.
    """

    blocks: list[Moments]
    counts: FingerCounts
    values: NDArray[np.float32] | None
    histogram: Histogram | None
    forms: list[Form] = field(default_factory=list)


@dataclass
class TileResult:
    """What is known of a tile of fingers.

    Parameters
    ----------
    start, stop : int
        Indices of the first finger and of the one after the last.
    kernel : str
        Kernels and vector width with which it was computed.
    seconds : float
        Computing time [s].
    raw : dict of str to ndarray, shape (fingers, n)
        Signals of a tile that is part of a block; empty otherwise.
    reduced : dict of str to ReducedSignal
        Signals of a tile of whole blocks; empty otherwise.
    problems : list of str
        Mistakes for which it cannot be computed.
    """

    start: int
    stop: int
    kernel: str = ""
    seconds: float = 0.0
    raw: dict[str, Real] = field(default_factory=dict)
    reduced: dict[str, ReducedSignal] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)


def of_blocks(forms: Sequence[Form]) -> tuple[SquareForm | None, dict[int, NDArray[np.float32]]]:
    """Return the form of the fingers of all blocks, and the signals of those that have none."""
    first = next((each for each in forms if isinstance(each, SquareForm)), None)
    known: dict[int, NDArray[np.float32]] = {}
    count, blocks = 0, list[SquareForm]()
    for each in forms:
        if isinstance(each, SquareForm):
            blocks.append(each)
            count += len(each.factor)
            continue
        known[count] = each
        count += len(each)
        if first is not None:
            blocks.append(SquareForm(*(np.zeros((len(each), *part.shape[1:])) for part in first)))
    if first is None:
        return None, known
    return SquareForm(*(np.concatenate(parts) for parts in zip(*blocks, strict=True))), known


def count_in(histogram: Histogram, part: ReducedSignal, threads: int | None) -> None:
    """Count signals in a histogram; a value that is not known is counted as 0, because no quantile is given at its sample."""
    values = part.values
    if values is not None:
        if part.counts.unknown.any():
            values = np.where(np.isnan(values), np.float32(0), values)
        histogram.add(values, threads=threads)


def binned(part: ReducedSignal, threads: int | None) -> None:
    """Replace the kept values of a signal, if there are any, by their histogram."""
    from electrovib.solve.population.kernels import Histogram

    if part.values is not None:
        part.histogram = Histogram(part.values.shape[1])
        count_in(part.histogram, part, threads)
        part.values = None


def joined(one: ReducedSignal, other: ReducedSignal) -> ReducedSignal:
    """Return the statistics of fingers that follow each other."""
    one.counts.merge(other.counts)
    found = ReducedSignal([*one.blocks, *other.blocks], one.counts, None, None, [*one.forms, *other.forms])
    if one.values is not None and other.values is not None:
        found.values = np.concatenate([one.values, other.values])
    if one.histogram is not None and other.histogram is not None:
        found.histogram = one.histogram + other.histogram
    return found
