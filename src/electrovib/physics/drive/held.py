"""A drive from samples that an output holds, as digital generators play them."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.pieces import Linear
from electrovib.physics.drive.sampled import Sampled

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real

_ROUNDED: Final = 1e-9
"""Difference over a time that counts as rounding."""


class Held(Drive):
    """A voltage that is held from each sample to the next, with a straight edge between two levels.

    Notes
    -----
    The edge to each level begins at the time stamp of its sample; the first one is from 0 V. `edge` is the height of a step
    over its steepest slope: for one pole at the frequency f that is 1/(2 pi f), and the straight edge then takes up at least
    as much current as that pole, because it keeps the steepest slope for the whole edge. An edge of one interval joins the
    samples by straight lines, one interval later.
    """

    example: ClassVar[Mapping[str, Any]] = {"samples": Sampled.example, "edge": 1e-5}

    samples: Annotated[Sampled, Field(description="the samples, as a table of the drive Sampled")]
    edge: Annotated[
        Number, Quantity("s", 0, 1e3, "height of a step over its steepest slope; 0 for a discontinuity")
    ] = 0.0

    @model_validator(mode="after")
    def _ends_before_the_next(self) -> Self:
        shortest = float(np.min(np.diff(self.samples.time_stamps)))
        if self.edge > shortest * (1 + _ROUNDED):
            why = "the edge of {edge} s is longer than the shortest interval between samples, {shortest} s"
            raise PydanticCustomError(
                "edge", why, {"edge": f"{self.edge:.9g}", "shortest": f"{shortest:.9g}"}
            )
        return self

    @functools.cached_property
    def _pieces(self) -> Linear:
        """Levels and edges, or levels alone where an edge takes no time."""
        (record,) = self.samples.parts()
        time, voltage = record.times, record.after
        last = np.append(0.0, voltage[:-1])
        if self.edge == 0:
            return Linear(time, last, voltage, step=record.step)
        times = np.stack([time, time + self.edge], axis=1).ravel()
        values = np.stack([last, voltage], axis=1).ravel()
        apart = np.append(np.diff(times) > _ROUNDED * self.edge, True)  # one edge ends where the next begins
        times, values = times[apart], values[apart]
        return Linear(times, values, values)

    def parts(self) -> tuple[Linear, ...]:
        """Return the levels and the edges between them."""
        return (self._pieces,)

    @property
    def duration(self) -> float:
        """Time from the first sample to the end of the edge to the last [s]."""
        return float(self._pieces.times[-1])

    @property
    def time_stamps(self) -> Real:
        """Times at which levels begin and edges end, counted from the first sample [s]."""
        return self._pieces.times
