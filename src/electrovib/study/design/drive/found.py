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

    - `times`, `values`: evenly spaced from 0, and samples [V, or A of a current drive].
    - `edges`, `wanted`, `predicted`: ends of the intervals, and mean force of the target and of the full
      model.
    - `scale`: largest multiple of the target within the limits without a compromise; infinite without limits.
    - `limited`: samples at which a limit prevents the target; `ratios`: largest value over each limit.
    - `searches`, `agreeing`: searches for the smallest misfit, 0 where none was needed, and those within 1 %
      of it.
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
