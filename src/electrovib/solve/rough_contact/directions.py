"""Conjugate gradients in single precision for one correction: preconditioned, and within a radius where energy is not convex."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from electrovib.core.arrays import Numbers

REDUCTION = 0.1
"""A correction is refined until its remainder has fallen to this: what it improves is judged anew after it."""
MOST = 20
"""Steps of one correction."""


class Correction(NamedTuple):
    """A correction, its length in the preconditioner's norm, and the first preconditioned remainder, which tells the error.

    `bounded` where it ends at the radius, `concave` where the energy curves downwards along its last direction.
    """

    step: Numbers
    length: float
    first: Numbers
    bounded: bool
    concave: bool


def correction(
    operator: Callable[[Numbers], Numbers],
    preconditioner: Callable[[Numbers], Numbers],
    remainder: Numbers,
    *,
    radius: float = math.inf,
    worth: Callable[[Numbers], bool] = lambda _: True,
) -> Correction:
    """Solve operator x = remainder roughly, by preconditioned conjugate gradients that end at the radius (Steihaug).

    Nothing is solved where the first preconditioned remainder is not `worth` it. Without a radius it ends before a direction
    along which the energy is not convex.
    """
    step = np.zeros_like(remainder)
    first = shape = preconditioner(remainder)
    begin = fall = float(np.vdot(remainder, shape))
    direction, along, across, length = shape, fall, 0.0, 0.0
    if not worth(first):
        return Correction(step, 0.0, first, bounded=False, concave=False)
    for _ in range(MOST):
        if fall <= REDUCTION**2 * begin:
            break
        answer = operator(direction)
        curvature = float(np.vdot(direction, answer))
        factor = fall / curvature if curvature > 0 else math.inf
        if curvature <= 0 or length + factor * (2 * across + factor * along) > radius**2:
            if math.isfinite(radius):
                to_edge = (math.sqrt(across**2 + along * (radius**2 - length)) - across) / along
                step += np.float32(to_edge) * direction
            return Correction(step, radius, first, bounded=True, concave=curvature <= 0)
        step += np.float32(factor) * direction
        length += factor * (2 * across + factor * along)
        former, remainder = remainder, remainder - np.float32(factor) * answer
        shape = preconditioner(remainder)
        before, fall = fall, float(np.vdot(remainder, shape))
        turn = max((fall - float(np.vdot(former, shape))) / before, 0.0)
        across = turn * (across + factor * along)
        along = fall + turn**2 * along
        direction = shape + np.float32(turn) * direction
    return Correction(step, math.sqrt(max(length, 0.0)), first, bounded=False, concave=False)
