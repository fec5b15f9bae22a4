"""Axes of a plot: words, unit, scale and ticks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.view.units import prefix_for, pretty_unit

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_LOWEST: Final = 1e-6
"""Part of the largest value below which a logarithmic axis does not begin by itself."""
_FEW_DECADES: Final = 3.0
"""Decades up to which a logarithmic axis has plain numbers in a prefixed unit, and above which it has powers of ten."""


@dataclass(frozen=True)
class Axis:
    """Words, SI unit and scale of an axis.

    `lowest` is the part of the largest value below which a logarithmic axis does not begin.
    """

    words: str
    unit: str
    is_logarithmic: bool = False
    lowest: float = _LOWEST


def unit_of(axis: Axis, data: Sequence[ArrayLike]) -> tuple[str, float]:
    """Return the unit of a label, with its prefix, and its size in SI, by which data are divided.

    One prefix holds for the whole axis, none where it has powers of ten; the unit of a pure number is empty.
    """
    largest = max((high for low, high in map(_ends, data)), default=0.0)
    has_powers = axis.is_logarithmic and (axis.unit == "Hz" or span(axis, data) > _FEW_DECADES)
    prefix, scale = ("", 1.0) if has_powers else prefix_for(largest, axis.unit)
    return pretty_unit(f"{prefix}{axis.unit}" if axis.unit != "1" else "1"), scale


def _ends(values: ArrayLike) -> tuple[float, float]:
    """Return the smallest and the largest finite magnitude above 0; infinity and 0 where there is none."""
    sizes = np.abs(np.asarray(values, dtype=float))
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    return (float(sizes.min()), float(sizes.max())) if sizes.size else (math.inf, 0.0)


def span(axis: Axis, data: Sequence[ArrayLike]) -> float:
    """Return the decades that a logarithmic axis covers, largest over smallest magnitude; 0 for a linear axis."""
    if not axis.is_logarithmic:
        return 0.0
    ends = [_ends(each) for each in data]
    low, high = min((low for low, _ in ends), default=math.inf), max((high for _, high in ends), default=0.0)
    return math.log10(high / max(low, axis.lowest * high)) if 0 < low < high else 0.0


def axis_table(axis: Axis, unit: str, decades: float) -> dict[str, Any]:
    """Make the table of an axis for Plotly, without colours and range, from a unit and the decades it covers."""
    shown: dict[str, Any] = {
        "title": {"text": f"{axis.words} [{unit}]" if unit else axis.words, "standoff": 6},
        "zeroline": False,
        "ticks": "outside",
        "automargin": True,
        "hoverformat": ".4~g",
    }
    if axis.is_logarithmic:
        shown |= {"type": "log", "exponentformat": "power"}
        if decades > _FEW_DECADES or axis.unit == "Hz":
            shown["dtick"] = math.ceil(decades / 8) or 1
        elif decades > 1:  # a decade or less is left to Plotly, which then has linear steps
            digits = (1, 2, 5) if decades <= 2 else (1,)
            ticks = [digit * 10.0**power for power in range(-4, 5) for digit in digits]
            shown |= {"tickvals": ticks, "ticktext": [f"{each:g}" for each in ticks]}
    return shown
