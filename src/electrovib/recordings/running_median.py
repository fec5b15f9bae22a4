"""Medians of successive samples, which follow a record without its single wrong values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


def running_median(values: Real, size: int, *, beyond: Literal["edge", "symmetric"]) -> Real:
    """Return the median of the odd number `size` of samples around each, shape (samples,).

    Beyond its ends a record goes on with its last value, ``"edge"``, or as in a mirror, ``"symmetric"``.
    By pandas: median filters of SciPy from 1.15.0 to 1.16.0 return other values in each run, or wrong ones
    where there are fewer samples than `size`.
    """
    import pandas as pd

    row = pd.Series(np.pad(values, size // 2, mode=beyond))
    return np.asarray(row.rolling(size).median().to_numpy()[size - 1 :])
