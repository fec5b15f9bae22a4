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
    """One column of a file.

    Parameters
    ----------
    name : str
        As written in the file; ``"column 2"`` where it has none.
    unit : str
        As written in the file; empty where it states none.
    values : ndarray, shape (n,)
        In that unit; not a number where a field is empty.
    """

    name: str
    unit: str
    values: Real


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """The content of one file.

    Parameters
    ----------
    channels : tuple of DataColumn
        In the order of the file, all of one length; the time among them only if it stands in a column.
    time : str
        Name of the channel that is the time; empty if it follows from `step`, or is not known.
    step : float or None
        Time between samples [s], where the file states it instead of a column.
    start : float
        Time of the first sample [s], where the file states a step.
    attributes : mapping of str to str
        Statements of the preamble of the file: make, model, date, settings.
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
