"""Sums of sines of many fingers at the output times."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

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
    """
    from electrovib.solve.population.kernels import row_loops

    none = np.zeros(0)
    written = out if out.flags.c_contiguous else np.empty(out.shape, out.dtype)
    row_loops.sines(
        written,
        np.zeros((0, 0)) if start is None else np.ascontiguousarray(start),
        *(np.ascontiguousarray(each) for each in (in_phase, behind, cosines, sines)),
        none if level is None else np.ascontiguousarray(level),
        none if factor is None else np.ascontiguousarray(factor),
    )
    if written is not out:
        out[:] = written
