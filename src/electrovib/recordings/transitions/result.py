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
    """Times of one edge.

    Parameters
    ----------
    record : EdgeRecord
        Samples, levels and passages.
    recorded : Interval
        Time between the levels as recorded [s].
    fitted : mapping of str to FittedForm
        Forms of relaxation by name.
    """

    record: EdgeRecord
    recorded: Interval
    fitted: Mapping[str, FittedForm]


@dataclass(frozen=True, kw_only=True)
class DirectionTimes:
    """Times of all edges of one direction.

    Parameters
    ----------
    direction : str
        ``rising`` or ``falling``.
    edges : tuple of EdgeTimes
        In the order of the record.
    recorded : Interval
        Time between the levels as recorded, as a mean over the edges [s].
    without_sensor : Interval
        Time between the levels of the fitted force, the sensor taken out [s]; without a sensor, of the fitted signal.
    form : str
        Simplest form of relaxation whose criterion is at most 2 above the lowest.
    criteria : mapping of str to float
        AICc of each form over the lowest, summed over the edges, dimensionless; infinite for a form that was rejected.
    rejected : mapping of str to str
        Forms that were rejected, and why.
    parameters : mapping of str to Interval
        Parameters of the best form as means over the edges, in SI: ``delay`` (with a drive), ``time_constant`` or
        ``time_constant_1`` and ``share_1`` and so on from the shortest, ``stretching``, and ``frequency`` and ``quality`` of an
        estimated sensor.
    exponential : mapping of str to Interval
        The same of the exponential, whichever form is best.
    sensor_limit : float
        Time between the levels that an instantaneous change would show through the sensor [s]; NaN without a sensor.
    misfit : float
        Largest rms residual over the noise before the edge, dimensionless.
    words : tuple of str
        Sentences about the result, first those that may change its use.
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
    """Times between levels of the edges of a recorded signal.

    Parameters
    ----------
    signal : str
        Name of the signal.
    unit : str
        Its unit.
    levels : tuple of float
        Fractions of the range between the levels before and after an edge, counted from the lower one.
    rising, falling : DirectionTimes or None
        By direction of the signal; None if there is no such edge.
    sensor : str
        How the sensor was known: ``none``, ``declared`` or ``estimated``.
    driven : bool
        Whether the edges are those of a drive.
    skipped : tuple of str
        Edges that were not evaluated, and why.
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
