"""Result of the measurement of times: rising and falling edges, each with and without the sensor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.recordings.transitions.statements import in_few

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.recordings.transitions.edges import EdgeRecord
    from electrovib.recordings.transitions.estimate import Interval
    from electrovib.recordings.transitions.relaxation import FittedForm


@dataclass(frozen=True, kw_only=True)
class EdgeTimes:
    """Times of one edge: the time between the levels as recorded, and the forms of relaxation by name."""

    record: EdgeRecord
    recorded: Interval
    fitted: Mapping[str, FittedForm]


@dataclass(frozen=True, kw_only=True)
class DirectionTimes:
    """Times of all edges of one direction, ``rising`` or ``falling``.

    - `recorded`: time between the levels as recorded, as a mean over the edges.
    - `without_sensor`: that of the fitted force, the sensor taken out; without a sensor, of the fitted
      signal.
    - `form`: simplest form of relaxation whose criterion is at most 2 above the lowest.
    - `criteria`: AICc of each form over the lowest, summed over the edges; infinite for one of those in
      `rejected`.
    - `parameters`: of the best form as means over the edges, in SI: ``delay`` (with a drive),
      ``time_constant`` or ``time_constant_1`` and ``share_1`` and so on from the shortest, ``stretching``,
      and ``frequency`` and ``quality`` of an estimated sensor; `exponential` has those of the exponential,
      whichever form is best.
    - `sensor_limit`: time between the levels that an instantaneous change would show through the sensor; NaN
      without a sensor.
    - `misfit`: largest rms residual over the noise before the edge.
    """

    direction: str
    edges: tuple[EdgeTimes, ...]
    recorded: Interval
    without_sensor: Interval
    form: str
    criteria: Mapping[str, float]
    rejected: Mapping[str, str]
    parameters: Mapping[str, Interval]
    exponential: Mapping[str, Interval]
    sensor_limit: float
    misfit: float
    words: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class MeasuredTimes:
    """Times between levels of the edges of a recorded signal; a direction without edges is None.

    `levels` are fractions of the range between the levels before and after an edge, counted from the lower
    one. `sensor` was ``none``, ``declared`` or ``estimated``; `driven` says whether the edges are those of a
    drive. `skipped` says which edges were not evaluated, and why.
    """

    signal: str
    unit: str
    levels: tuple[float, float]
    rising: DirectionTimes | None
    falling: DirectionTimes | None
    sensor: str
    driven: bool
    skipped: tuple[str, ...]

    @property
    def directions(self) -> tuple[DirectionTimes, ...]:
        """The directions that have edges, rising before falling."""
        return tuple(each for each in (self.rising, self.falling) if each is not None)

    @property
    def words(self) -> tuple[str, ...]:
        """All sentences."""
        return (*(text for each in self.directions for text in each.words), *in_few(self.skipped))
