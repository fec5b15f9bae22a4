"""Even times of samples whose stamps repeat, because they are cut off at a coarser step than the samples have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


_STATE: Final = "state the step (--set step='10 us')"
_UNEVEN: Final = 1.5
"""Largest interval of stamps over the smallest one up to which both are one step, rounded."""
_ROUNDING: Final = 1e-6
"""Error of a stamp, in units of the step of the stamps, that is its rounding."""


@dataclass(frozen=True, kw_only=True)
class EvenTimes:
    """Times of samples [s], the sentence that says how they were found, and what may be wrong with them."""

    time: Real
    words: str
    diagnostics: tuple[Diagnostic, ...] = ()


def even_times(stamps: Real) -> EvenTimes:
    """Return even times that explain stamps which repeat: each is its time, cut off at the step of the stamps.

    A first or a last stamp with fewer rows than the others does not change the step. Stamps that no even
    step explains are refused.
    """
    change = np.diff(stamps)
    first = np.flatnonzero(np.concatenate([[True], change > 0]))
    last = np.concatenate([first[1:] - 1, [stamps.size - 1]])
    values, rows = stamps[first], np.diff(np.append(first, stamps.size))
    if rows.size < 3:
        raise InputError(f"time: all samples have {rows.size} time stamps, too few for a time step; {_STATE}")
    least, most = float(change[change > 0].min()), float(change.max())
    resolution = 2 * most - least if most < _UNEVEN * least else least
    words = format_quantity(least, "s", digits=3)

    def room(step: float) -> float:
        """Return by how much the time of the first sample is free if the samples have this step, below 0 if none fits."""
        return float(np.min(values + resolution - step * last) - np.max(values - step * first))

    allowed = -_ROUNDING * resolution
    inner = rows[1:-1]
    step = least / round(float(np.median(inner)))
    if most > least * (1 + _ROUNDING) or room(step) <= allowed:
        from scipy.optimize import minimize_scalar

        about = float(values[-1] - values[1]) / float(first[-1] - first[1])
        near = 2 * resolution / stamps.size
        found = minimize_scalar(
            lambda each: -room(each),
            bounds=(about - near, about + near),
            method="bounded",
            options={"xatol": 1e-9 * about},
        )
        step = float(found.x)
    if room(step) <= allowed:
        apart = format_quantity(most, "s", digits=3)
        raise InputError(
            f"time: the stamps are cut off at {words} and repeat, with {rows.min()} to {rows.max()} rows each and up to {apart}"
            " between them: no even step explains them, samples are missing or were not taken evenly; cut the file where it"
            f" pauses, or {_STATE}"
        )
    start = float(np.max(values - step * first))
    often = " to ".join(str(each) for each in sorted({inner.min(), inner.max()}))
    text = (
        f"time: the stamps are cut off at {words} and repeat, {often} times each; replaced by"
        f" {stamps.size} even times in steps of {format_quantity(step, 's')}"
    )
    time = np.asarray(start + step * np.arange(stamps.size), dtype=float)
    if inner.min() == inner.max():
        return EvenTimes(time=time, words=text)
    why = f"the number of rows for each time stamp varies from {often}: a sample may be missing"
    doubt = Diagnostic("rows of a time stamp", "unknown", why)
    return EvenTimes(time=time, words=text, diagnostics=(doubt,))
