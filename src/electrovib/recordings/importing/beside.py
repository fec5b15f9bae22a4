"""A measurement beside a prediction: residuals of the signals that both have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.signals import SIGNALS

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Complex, Real

MEASURED_OF: Final = {f"{name}_measured": name for name in SIGNALS if f"{name}_measured" in SIGNALS}
"""Signals of a sensor to the quantities that they measure, which are used where a prediction has no sensor."""
_MEASURED: Final = "file_sha256"
"""Attribute of a Trace that was imported."""


@dataclass(frozen=True, kw_only=True)
class SignalResidual:
    """The residual of one signal at the times or frequencies of the measurement; the prediction is interpolated linearly."""

    name: str
    predicted_name: str
    along: str
    axis: Real
    measured: Real | Complex
    predicted: Real | Complex

    @property
    def residual(self) -> Real | Complex:
        """Measured less predicted, shape (n,), in the SI unit of the signal."""
        found: Real | Complex = np.subtract(self.measured, self.predicted)
        return found

    @property
    def rms(self) -> float:
        """Root mean square of the residual, in the SI unit of the signal."""
        return float(np.sqrt(np.mean(np.abs(self.residual) ** 2)))

    @property
    def mean(self) -> float:
        """Mean of the residual, in the SI unit of the signal; of an impedance the mean of its real part."""
        return float(np.mean(self.residual).real)

    @property
    def relative_rms(self) -> float:
        """Root mean square of the residual over that of the measurement, dimensionless; NaN if the measurement is 0."""
        size = float(np.sqrt(np.mean(np.abs(self.measured) ** 2)))
        return self.rms / size if size else float("nan")


def is_measured(trace: xarray.Dataset) -> bool:
    """Return whether a Trace was imported from a file of an instrument."""
    return _MEASURED in trace.attrs


def residuals(predicted: xarray.Dataset, measured: xarray.Dataset) -> list[SignalResidual]:
    """Compare each signal of a measurement with the same one of a prediction, where their axes overlap in two samples.

    A measured force is compared with the force as the tribometer reads it, or with the force itself where
    none is modelled.
    """
    found = []
    for name in map(str, measured.data_vars):
        other = name if name in predicted else MEASURED_OF.get(name, name)
        if other not in predicted:
            continue
        along = str(measured[name].dims[-1])
        if measured[name].dims != (along,) or predicted[other].dims != (along,):
            continue
        found += _of_signal(predicted[other], measured[name], name, along)
    return found


def _of_signal(
    predicted: xarray.DataArray, measured: xarray.DataArray, name: str, along: str
) -> list[SignalResidual]:
    """Return the residual of one signal; none where the axes do not overlap."""
    axis, grid = np.asarray(measured[along].values), np.asarray(predicted[along].values)
    values = np.interp(axis, grid, np.asarray(predicted.values))
    known = (axis >= grid[0]) & (axis <= grid[-1]) & np.isfinite(values) & np.isfinite(measured.values)
    if np.count_nonzero(known) < 2:
        return []
    return [
        SignalResidual(
            name=name, predicted_name=str(predicted.name), along=along, axis=axis[known],
            measured=np.asarray(measured.values)[known], predicted=values[known],
        )
    ]  # fmt: skip
