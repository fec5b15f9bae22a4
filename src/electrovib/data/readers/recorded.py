"""Content of a file of an instrument: channels with names and units as written, and the times of their samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


@dataclass(frozen=True, kw_only=True)
class DataColumn:
    """One column of a file, with name and unit as written in it; `values` are in that unit, NaN where a field is empty."""

    name: str
    unit: str
    values: Real


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """The content of one file.

    All `channels` have one length. `time` names the one that is the time; it is empty if the time follows
    from `step` [s] and `start` [s], the time of the first sample, or is not known. `attributes` are
    statements of the preamble: make, model, date, settings.
    """

    channels: tuple[DataColumn, ...]
    time: str = ""
    step: float | None = None
    start: float = 0.0
    attributes: Mapping[str, str] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of samples of each channel."""
        return self.channels[0].values.size if self.channels else 0

    def times(self) -> Real | None:
        """Return the time of each sample, shape (n,), in the unit of its channel, or in s by the step; None if it is unknown."""
        if self.time:
            return next(each.values for each in self.channels if each.name == self.time)
        if self.step is None:
            return None
        return np.asarray(self.start + self.step * np.arange(self.size))
