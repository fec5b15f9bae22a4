"""Sums of sines of many fingers at the output times, in numpy or compiled: the same bits."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.population.kernels.choice import compiled

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


def write_sines(
    out: Real,
    *,
    start: Real | None,
    in_phase: Real,
    behind: Real,
    cosines: Real,
    sines: Real,
    level: Real | None,
    factor: Real | None,
) -> None:
    """Write a sum of sines of each finger, or a factor times its square.

    `out` (fingers, n), `start` (fingers, n), `in_phase`, `behind` (tones, fingers), `cosines`, `sines`
    (tones, n), `level` (fingers,), `factor` (fingers,).

    Products and sums are formed in the same order by numpy and by the compiled function, without fused operations.
    """
    if compiled() is not None and out.flags.c_contiguous:
        none = np.zeros(0)
        _function()(
            out,
            np.zeros((0, 0)) if start is None else np.ascontiguousarray(start),
            np.ascontiguousarray(in_phase),
            np.ascontiguousarray(behind),
            cosines,
            sines,
            none if level is None else np.ascontiguousarray(level),
            none if factor is None else np.ascontiguousarray(factor),
        )
        return
    total = np.zeros(out.shape) if start is None else start.copy()
    for place in range(len(in_phase)):
        total += in_phase[place][:, None] * cosines[place]
        total += behind[place][:, None] * sines[place]
    if level is not None:
        total += level[:, None]
    if factor is not None:
        np.multiply(total, total, out=total)
        total *= factor[:, None]
    out[:] = total


@functools.cache
def _function() -> Any:
    """Return the compiled function; other threads run meanwhile."""
    from numba import njit

    try:
        return njit(_in_loops, cache=True, error_model="numpy", nogil=True)
    except RuntimeError:  # no folder for the cache
        return njit(_in_loops, error_model="numpy", nogil=True)


def _in_loops(
    out: Real,
    start: Real,
    in_phase: Real,
    behind: Real,
    cosines: Real,
    sines: Real,
    level: Real,
    factor: Real,
) -> None:
    """Write the results of `write_sines`, in the part of Python that numba compiles; empty arrays stand for None."""
    fingers, samples = out.shape
    row = np.empty(samples)
    for finger in range(fingers):
        if start.size:
            row[:] = start[finger]
        else:
            row[:] = 0.0
        for tone in range(len(in_phase)):
            along, across = in_phase[tone, finger], behind[tone, finger]
            for sample in range(samples):
                row[sample] = (row[sample] + along * cosines[tone, sample]) + across * sines[tone, sample]
        if level.size:
            for sample in range(samples):
                row[sample] += level[finger]
        if factor.size:
            for sample in range(samples):
                row[sample] = (row[sample] * row[sample]) * factor[finger]
        for sample in range(samples):
            out[finger, sample] = row[sample]
