"""Choice of a form by Akaike's criterion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

SUPPORTED: Final = 2.0
"""Difference of AICc up to which a form has substantial support (Burnham and Anderson 2002)."""


def chosen_form(aicc: Mapping[str, float]) -> str:
    """Choose the simplest form that the data support.

    Parameters
    ----------
    aicc : mapping of str to float
        Criterion of each form, dimensionless, from the simplest on; infinite for a form that was rejected.

    Returns
    -------
    name : str
        The first form whose criterion is at most 2 above the lowest, so that a more complex one is not chosen for its noise.
    """
    lowest = min(aicc.values())
    return next(
        name for name, value in aicc.items() if value <= lowest + SUPPORTED or not math.isfinite(lowest)
    )


def above_lowest(aicc: Mapping[str, float]) -> dict[str, float]:
    """Return the differences of a criterion from the lowest, dimensionless."""
    lowest = min(aicc.values())
    return {name: value - lowest if math.isfinite(lowest) else 0.0 for name, value in aicc.items()}
