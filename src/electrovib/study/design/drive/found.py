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

    - `times`, `values`: evenly spaced from 0, samples [V, or A of a current drive]; `rate`: samples per
      second.
    - `edges`, shape (m + 1,): ends of the intervals over which forces are averaged [s].
    - `wanted`, `predicted`, shape (m,): mean force of the target and of the full model over each interval
      [N].
    - `scale`: largest multiple of the target that is within the limits without a compromise; infinite without
      limits.
    - `limited`: samples at which a limit prevents the target; `ratios`: largest value over each limit.
    - `searches`, `agreeing`: searches for the smallest misfit from different starts, 0 where none was needed,
      and how many of them ended within 1 % of the smallest.
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
