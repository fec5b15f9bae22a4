"""Samples of a designed drive, with the force that is wanted and the force that is predicted."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


@dataclass(frozen=True, kw_only=True)
class FoundDrive:
    """Samples of a drive and the mean forces over successive intervals.

    Parameters
    ----------
    times, values : ndarray, shape (n,)
        Evenly spaced times from 0 [s], and samples [V, or A of a current drive].
    rate : float
        Samples per second [Hz].
    edges : ndarray, shape (m + 1,)
        Ends of the intervals over which forces are averaged [s].
    wanted, predicted : ndarray, shape (m,)
        Mean force of the target and of the full model over each interval [N].
    carrier : float or None
        Hz; None without a carrier.
    scale : float
        Largest multiple of the target that is within the limits without a compromise [1]; infinite without limits.
    limited : ndarray of bool
        Samples at which a limit prevents the target.
    ratios : dict of str to float
        Largest value over the limit [1], by the name of the limit.
    searches : int
        Searches for the smallest misfit from different starts; 0 where none was needed.
    agreeing : int
        How many of them ended within 1 % of the smallest misfit among them.
    """

    times: Real
    values: Real
    rate: float
    edges: Real
    wanted: Real
    predicted: Real
    carrier: float | None
    scale: float
    limited: NDArray[np.bool_]
    ratios: dict[str, float] = field(default_factory=dict)
    searches: int = 0
    agreeing: int = 0
