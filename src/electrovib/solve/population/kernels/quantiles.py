"""Exact quantiles over fingers at each time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.choice import compiled

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real


def quantiles(values: ArrayLike, probabilities: ArrayLike, *, threads: int | None = None) -> Real:
    """Return exact quantiles over fingers at each time.

    Parameters
    ----------
    values : array_like, shape (fingers, n)
        Values of each finger, float32; others are rounded to float32.
    probabilities : array_like, shape (p,)
        From 0 to 1.
    threads : int, optional
        Threads of the compiled kernel; by default one for each available processor.

    Returns
    -------
    quantiles : ndarray, shape (p, n)
        In the unit of the values; nan at a time at which a value is nan.

    Raises
    ------
    InputError
        If there is no finger, or a probability is not between 0 and 1.

    Notes
    -----
    The quantile of probability p is interpolated between the order statistics on both sides of index p (fingers - 1),
    definition 7 of Hyndman and Fan, in float64.

    References
    ----------
    .. [1] R. J. Hyndman, Y. Fan, "Sample quantiles in statistical packages", The American Statistician 50,
           361-365, 1996.
    """
    given, below, share = _checked(values, probabilities)
    above = below + (share > 0)
    places = np.unique([below, above])
    if (kernel := compiled()) is not None:
        ordered = kernel.order_statistics(given, places, threads)
    else:
        ordered = np.partition(given, places, axis=0)[places].astype(np.float64)
        ordered[:, np.isnan(given).any(axis=0)] = np.nan
    low, high = ordered[np.searchsorted(places, below)], ordered[np.searchsorted(places, above)]
    upper = share[:, np.newaxis]
    with np.errstate(invalid="ignore"):  # infinities of both signs
        return np.asarray(np.where(low == high, low, low * (1 - upper) + high * upper))


def _checked(values: ArrayLike, probabilities: ArrayLike) -> tuple[NDArray[np.float32], Indices, Real]:
    """Return the values as contiguous float32, and index and share of the upper neighbour of each probability."""
    given = np.ascontiguousarray(values, np.float32)
    if given.ndim != 2 or not len(given):
        raise InputError(f"values has shape {given.shape}: expected (fingers, n) with one finger or more.")
    wanted = np.atleast_1d(np.asarray(probabilities, np.float64))
    if not ((wanted >= 0.0) & (wanted <= 1.0)).all():
        raise InputError(f"probabilities = {wanted.tolist()}: expected numbers from 0 to 1.")
    place = wanted * (len(given) - 1)
    below = np.floor(place)
    return given, below.astype(np.intp), place - below
