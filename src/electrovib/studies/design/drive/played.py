"""Samples of a drive in a scenario, the force that the full model predicts for them, and those that were found."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.model import read_model
from electrovib.core.samples import Samples
from electrovib.physics.drive.current import CurrentAmplifier
from electrovib.physics.drive.sampled import Sampled
from electrovib.scenario import TimeGrid
from electrovib.solve.expanded import FORCE, Expanded

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario

SENSE: Final = 1e3
"""Command voltage over current of a designed current drive [ohm]."""
_SIMPSON: Final = np.array([1.0, 4.0, 1.0]) / 6


class Played:
    """A scenario under a drive of straight lines between evenly spaced samples, `rate` per second, from rest."""

    def __init__(self, scenario: Scenario, rate: float) -> None:
        self.base = scenario
        self.rate = rate
        self._last: Expanded | None = None

    def times(self, count: int) -> Real:
        """Return the times of a number of samples [s]."""
        return np.asarray(np.arange(count) / self.rate)

    def scenario(self, values: Real) -> Scenario:
        """Return the scenario with samples [V, or A of a current drive] as its drive."""
        return self.base.model_copy(update={"drive": self._drive(values), "time": TimeGrid()})

    def _drive(self, values: Real) -> Drive:
        current = self.base.drive.quantity == "current"
        volts = values * SENSE if current else values
        table = {"time_samples": Samples(self.times(len(values))), "voltage_samples": Samples(volts)}
        drive = read_model(Sampled, table)
        if not current:
            return drive
        return read_model(CurrentAmplifier, {"command": drive, "sense_resistance": SENSE})

    def expanded(self, values: Real) -> Expanded:
        """Return the scenario under these samples [V or A], prepared for evaluation at any times."""
        self._last = Expanded(self.scenario(values), before=self._last, mechanics=False)
        return self._last

    def halves(self, count: int) -> Real:
        """Return the times of a number of samples and the middles between them [s]."""
        return np.asarray(np.arange(2 * count - 1) / (2 * self.rate))

    def force(self, values: Real) -> Real:
        """Return the predicted force (2 n - 1,) at the n samples and in the middles between them."""
        record = self.expanded(values).at(self.halves(len(values)), wanted=FORCE)
        return np.asarray(record.solution.attraction)

    def means(self, force: Real, first: int, count: int, width: int) -> Real:
        """Return the mean of a result of `force` over successive groups of intervals, by Simpson's rule."""
        inside = force[2 * first : 2 * (first + count * width) + 1]
        intervals = _SIMPSON[0] * inside[:-2:2] + _SIMPSON[1] * inside[1:-1:2] + _SIMPSON[2] * inside[2::2]
        return np.asarray(np.mean(intervals.reshape(count, width), axis=1))


@dataclass(frozen=True, kw_only=True)
class FoundDrive:
    """Samples of a drive and the mean forces over successive intervals.

    - `times`, `values`: evenly spaced from 0, and samples [V, or A of a current drive].
    - `edges`, `wanted`, `predicted`: ends of the intervals, and mean force of the target and of the full
      model.
    - `scale`: largest multiple of the target within the limits without a compromise; infinite without limits.
    - `limited`: samples at which a limit prevents the target; `ratios`: largest value over each limit.
    - `searches`, `agreeing`: searches for the smallest misfit, 0 where none was needed, and those within 1 %
      of it.
    """

    times: Real
    values: Real
    rate: float
    edges: Real
    wanted: Real
    predicted: Real
    carrier: float | None
    scale: float
    limited: NDArray[np.bool_]
    ratios: dict[str, float] = field(default_factory=dict)
    searches: int = 0
    agreeing: int = 0
