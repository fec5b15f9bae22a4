"""Models compared by information criteria."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.recordings.fit.result import ScenarioFit

CLEAR: Final = 10.0
"""Difference of AICc from which on the worse model has essentially no support (Burnham and Anderson 2002)."""
_SOME: Final = 2.0


@dataclass(frozen=True, kw_only=True)
class FitComparison:
    """Fits of several models to the same data, the best first; `aicc` and `bic` are above those of the best by AICc."""

    names: tuple[str, ...]
    aicc: tuple[float, ...]
    bic: tuple[float, ...]
    sentence: str


def compare_fits(fits: Mapping[str, ScenarioFit]) -> FitComparison:
    """Compare models that were fitted to the same data.

    A difference of AICc below 2 does not distinguish two models, one above 10 leaves the worse one without
    support (Burnham and Anderson 2002). The criteria compare models with each other; none of them may be
    adequate.
    """
    sizes = {name: each.estimate.count for name, each in fits.items()}
    if len(set(sizes.values())) > 1:
        told = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(
            f"models are compared on the same data, but these were fitted to different numbers: {told}"
        )
    names = sorted(fits, key=lambda name: fits[name].aicc)
    best = fits[names[0]]
    aicc = tuple(fits[name].aicc - best.aicc if math.isfinite(best.aicc) else math.nan for name in names)
    bic = tuple(fits[name].bic - best.bic for name in names)
    return FitComparison(names=tuple(names), aicc=aicc, bic=bic, sentence=_sentence(names, aicc, bic))


def _sentence(names: list[str], aicc: tuple[float, ...], bic: tuple[float, ...]) -> str:
    if len(names) == 1:
        return ""
    first, second, apart = names[0], names[1], aicc[1]
    if not math.isfinite(apart):
        return f"there are too few data to compare {first} with {second} by AICc"
    if apart < _SOME:
        text = f"the data do not distinguish {first} from {second} (AICc differs by {apart:.2g})"
    elif apart < CLEAR:
        text = f"the data favour {first} over {second}, but not clearly (AICc lower by {apart:.2g})"
    else:
        text = f"the data support {first}; {second} has an AICc higher by {apart:.3g}, which leaves it no support"
    if min(bic) < 0:
        text += f"; BIC prefers {names[bic.index(min(bic))]}, which has fewer parameters"
    return text
