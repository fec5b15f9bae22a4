"""What is left of the data of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.recordings.fit.measured import Observed
from electrovib.recordings.fit.prediction import Prediction

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Residuals:
    """What is left of one signal of one recording; `noise` is the standard deviation over the scale of the data."""

    recording: str
    observed: Observed
    predicted: NDArray[np.float64] | NDArray[np.complex128]
    noise: float

    @property
    def values(self) -> NDArray[np.float64] | NDArray[np.complex128]:
        """Data less prediction, shape (n,), in the signal's unit."""
        return np.asarray(self.observed.y - self.predicted)

    @property
    def root_mean_square(self) -> float:
        """Of the residuals over the scale of the data, of each part where they are complex."""
        return float(np.sqrt(np.mean(np.abs(self.values / self.observed.scale) ** 2) / self.observed.parts))


def residuals_of(
    prediction: Prediction, values: Mapping[str, float], noise: Sequence[float]
) -> list[Residuals]:
    """Collect the residuals of every signal of every recording."""
    found, at = prediction(values), 0
    residuals = []
    names = [
        measured.name
        for measured, group in zip(prediction.measured, prediction.columns, strict=True)
        for _ in group
    ]
    columns = [each for group in prediction.columns for each in group]
    for name, column, sigma in zip(names, columns, noise, strict=True):
        size = column.x.size
        row: NDArray[np.float64] | NDArray[np.complex128] = found[at : at + size]
        if column.parts == 2:
            row = row + 1j * found[at + size : at + 2 * size]
        at += size * column.parts
        residuals.append(Residuals(recording=name, observed=column, predicted=row, noise=sigma))
    return residuals
