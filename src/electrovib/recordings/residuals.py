"""Measured signals beside predictions of them, and what is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.signals import SIGNALS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import xarray

    from electrovib.core.arrays import Complex, Real

_IMPORTED: Final = "file_sha256"
"""Attribute of a Trace that was imported from a file of an instrument."""


@dataclass(frozen=True, kw_only=True)
class Compared:
    """One signal of a measurement and of a prediction, whose labels are given, at the times or frequencies of the measurement."""

    measurement: str
    prediction: str
    name: str
    predicted_name: str
    along: str
    axis: Real
    measured: Real | Complex
    predicted: Real | Complex

    @property
    def residual(self) -> Real | Complex:
        """Measured less predicted, shape (n,), in the SI unit of the signal."""
        return np.asarray(np.subtract(self.measured, self.predicted))

    @property
    def signal(self) -> str:
        """Name of the signal, and of what was predicted where that is another one."""
        words, other = (name.replace("_", " ") for name in (self.name, self.predicted_name))
        return words if other == words else f"{words} (predicted: {other})"

    @property
    def mean(self) -> float:
        """Mean of the residual, in the SI unit of the signal; of an impedance the mean of its real part."""
        return float(np.mean(self.residual).real)


def rms(values: Real | Complex) -> float:
    """Return a root mean square, in the unit of the values [1]."""
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def compare(traces: Mapping[str, xarray.Dataset]) -> list[Compared]:
    """Compare every measurement with every prediction, by label, for each signal that they share."""
    return [
        each
        for measurement, recorded in traces.items()
        for prediction, computed in traces.items()
        if _IMPORTED in recorded.attrs and _IMPORTED not in computed.attrs
        for each in _shared(measurement, recorded, prediction, computed)
    ]


def _shared(
    measurement: str, recorded: xarray.Dataset, prediction: str, computed: xarray.Dataset
) -> Iterator[Compared]:
    """Iterate over the signals of both whose axes overlap in two samples.

    A measured force is compared with the force as the tribometer reads it, or with the force itself where
    none is modelled.
    """
    for name in map(str, recorded.data_vars):
        plain = name.removesuffix("_measured")
        other = name if name in computed else plain if plain in SIGNALS else name
        along = str(recorded[name].dims[-1])
        if other not in computed or {recorded[name].dims, computed[other].dims} != {(along,)}:
            continue
        axis, grid = np.asarray(recorded[along].values), np.asarray(computed[along].values)
        own, values = np.asarray(recorded[name].values), np.interp(axis, grid, computed[other].values)
        known = (axis >= grid[0]) & (axis <= grid[-1]) & np.isfinite(values) & np.isfinite(own)
        if np.count_nonzero(known) > 1:
            yield Compared(
                measurement=measurement, prediction=prediction, name=name, predicted_name=other, along=along,
                axis=axis[known], measured=own[known], predicted=values[known],
            )  # fmt: skip
