"""The weights of a fit: noise that is estimated in turn with the parameters."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.recordings.fit.problem import Callback, WeightedProblem
from electrovib.recordings.fit.residuals import residuals_of

if TYPE_CHECKING:
    from electrovib.recordings.fit.estimate import LeastSquaresEstimate
    from electrovib.recordings.fit.least_squares import FreeParameter
    from electrovib.recordings.fit.measured import Observed
    from electrovib.recordings.fit.prediction import Prediction

_SETTLED: Final = 1e-3
"""Relative change of an estimated noise, or of a scale, from which on the parameters are not estimated again."""
_MOST_ROUNDS: Final = 20
_PRECISION: Final = 1e-9
"""Noise relative to the largest value that is always assumed: the accuracy of a prediction."""


def weighted(
    prediction: Prediction, begin: Mapping[str, FreeParameter], progress: Callback | None, *, near: bool
) -> tuple[list[float], LeastSquaresEstimate, WeightedProblem]:
    """Estimate parameters, and in turn with them the noise, over the scale of its data, that is not stated."""
    columns = [each for group in prediction.columns for each in group]
    stated = [each.noise for each in columns]
    alone = len(columns) == 1 and stated[0] is None
    noise = [
        each if each is not None else 1.0 if alone else first_noise(column)
        for each, column in zip(stated, columns, strict=True)
    ]
    sizes = np.array([each.x.size * each.parts for each in columns], dtype=float)
    free, evaluations = begin, 0
    for _ in range(_MOST_ROUNDS):
        problem = WeightedProblem(prediction, noise, progress)
        search = problem.minimum_near if near else problem.minimum
        estimate = search(free, known=None not in stated)
        evaluations += estimate.evaluations
        free = {name: each.starting_at(estimate.values[name]) for name, each in prediction.free.items()}
        moved = prediction.rescale(estimate.values)
        taken = len(free) / sizes.sum()
        left = [each.root_mean_square for each in residuals_of(prediction, estimate.values, noise)]
        scatter = [float(rms / np.sqrt(max(1 - taken, 1e-3))) for rms in left]
        after = [
            max(found, _least_noise(column)) if each is None else each
            for each, found, column in zip(stated, scatter, columns, strict=True)
        ]
        if alone or None not in stated:
            if moved < _SETTLED:
                noise = after
                break
            continue
        change = max(abs(new / old - 1) for new, old in zip(after, noise, strict=True))
        if max(change, moved) < _SETTLED:
            break
        noise = after
    return noise, dataclasses.replace(estimate, evaluations=evaluations), problem


def first_noise(column: Observed) -> float:
    """Return the noise of a signal over its scale [1], stated or from its third differences, in which a smooth course cancels."""
    if column.noise is not None:
        return column.noise
    least = _least_noise(column)
    if column.y.size > 8:
        rough = np.diff(column.y / column.scale, 3)
        found = float(np.median(np.abs(rough)) / 0.6745 / np.sqrt(20 * column.parts))
        if found > least:
            return found
    return 1e6 * least


def _least_noise(column: Observed) -> float:
    """Noise over the scale of a signal below which its residuals are those of rounding."""
    return _PRECISION * float(np.max(np.abs(column.y / column.scale))) or 1.0
