"""Exact quantiles over fingers at each time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.choice import compiled
from electrovib.solve.population.kernels.stepping import factors, first_order_hold_many, gather

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.solve.population.kernels.time_steps import TimeSteps


def quantiles(values: ArrayLike, probabilities: ArrayLike, *, threads: int | None = None) -> Real:
    """Return exact quantiles over fingers at each time.

    `values` (fingers, n), `probabilities` (p,); returns `quantiles` (p, n).

    The quantile of probability p is interpolated between the order statistics on both sides of index p (fingers - 1),
    definition 7 of Hyndman and Fan, in float64.
    """
    given = np.ascontiguousarray(values, np.float32)
    if given.ndim != 2 or not len(given):
        raise InputError(f"values has shape {given.shape}: expected (fingers, n) with one finger or more.")
    wanted = _Places(probabilities, len(given))
    places = wanted.places
    if (kernel := compiled()) is not None:
        ordered = kernel.order_statistics(given, places, threads)
    else:
        ordered = np.partition(given, places, axis=0)[places].astype(np.float64)
        ordered[:, np.isnan(given).any(axis=0)] = np.nan
    return wanted.interpolated(ordered)


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
    known: Mapping[int, NDArray[np.float32]] | None = None,
    threads: int | None = None,
) -> Real:
    """Return exact quantiles over fingers of factor times the squared response, without storing responses of all times.

    `factor` (fingers,), `outputs` (n,), `probabilities` (p,); returns `quantiles` (p, n).
    """
    fingers = gather(rates, residues, direct, state, voltage, time)
    squared, at = factors(factor, fingers), np.asarray(outputs, np.intp)
    if (kernel := compiled()) is not None and len(squared):
        wanted = _Places(probabilities, len(squared))
        return wanted.interpolated(
            kernel.square_order_statistics(fingers, squared, at, wanted.places, known or {}, threads)
        )
    values = first_order_hold_many(*fingers, factor=squared, dtype=np.float32)[:, at]
    for first, rows in (known or {}).items():
        values[first : first + len(rows)] = rows
    return quantiles(values, probabilities)


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

    def interpolated(self, ordered: Real) -> Real:
        """Return the quantiles, (p, n), from the order statistics at the places, (places, n)."""
        places, upper = self.places, self.share[:, np.newaxis]
        low = ordered[np.searchsorted(places, self.below)]
        high = ordered[np.searchsorted(places, self.above)]
        with np.errstate(invalid="ignore"):  # infinities of both signs
            return np.asarray(np.where(low == high, low, low * (1 - upper) + high * upper))
