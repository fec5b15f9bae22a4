"""The least-squares problem of one edge and one form of relaxation, and where its search begins."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.transitions.forms import EXPONENTIAL, RelaxationForm
from electrovib.recordings.transitions.separable import Separable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.recordings.fit.estimate import LeastSquaresEstimate
    from electrovib.recordings.transitions.edges import EdgeRecord
    from electrovib.recordings.transitions.sensor import Sensor

_STRETCHINGS: Final = (0.3, 1.5)
"""Bounds of the exponent of a stretched exponential, where its reading through a sensor is accurate."""
_BEST_STARTS: Final = 2
_COARSE: Final = 400
"""Samples on which the starts of a search are compared."""


@dataclass(frozen=True, kw_only=True)
class EdgeProblem:
    """What the fits of all forms to one edge share; times are between the `fractions` of the change."""

    edge: EdgeRecord
    fractions: tuple[float, float]
    sensor: Sensor | None
    estimated: bool

    @property
    def rough(self) -> float:
        """Time between the levels as recorded [s]."""
        return self.edge.passages.time

    @property
    def step(self) -> float:
        """Time between samples [s]."""
        return float(np.median(np.diff(self.edge.fit_time)))

    @property
    def window(self) -> float:
        """Time after the reference up to which there are samples [s]."""
        return float(self.edge.fit_time[-1])

    def free(self, form: RelaxationForm) -> dict[str, FreeParameter]:
        """Return the nonlinear parameters with their bounds."""
        passages = self.edge.passages
        low = max(float(self.edge.fit_time[2]), passages.first - 3 * self.rough - 2 * self.step)
        found = {"start": FreeParameter(start=passages.first, lower=low, upper=passages.last)}
        fall = FreeParameter(start=self.rough, lower=self.step / 10, upper=2 * self.window, logarithmic=True)
        found |= {name: fall.starting_at(self.rough) for name in form.time_constants}
        if form.stretched:
            low, high = _STRETCHINGS
            found["stretching"] = FreeParameter(start=1.0, lower=low, upper=high, logarithmic=True)
        if self.estimated:
            slow, fast = 0.5 / self.window, 1 / (6 * self.step)
            found["frequency"] = FreeParameter(
                start=math.sqrt(slow * fast), lower=slow, upper=fast, logarithmic=True
            )
            found["quality"] = FreeParameter(start=2.0, lower=0.6, upper=100.0, logarithmic=True)
        return found

    def separable(
        self, form: RelaxationForm, *, coarse: bool = False, free: dict[str, FreeParameter] | None = None
    ) -> Separable:
        """Return the problem of one form, on few samples to compare starts."""
        every = max(1, len(self.edge.fit_time) // _COARSE) if coarse else 1
        time, values = self.edge.fit_time[::every], self.edge.fit_values[::every]
        return Separable(
            columns=lambda at: form.columns(time, at, self.seen_by(at)),
            data=values,
            free=self.free(form) if free is None else free,
            names=form.amplitudes,
            ranges={"start": self.rough},
        )

    def seen_by(self, values: Mapping[str, float]) -> tuple[float, float] | None:
        """Return the sensor at some parameters."""
        if self.estimated:
            return values["frequency"], values["quality"]
        return (self.sensor.frequency, self.sensor.quality) if self.sensor else None


def starts(
    problem: EdgeProblem, form: RelaxationForm, found: Mapping[str, LeastSquaresEstimate]
) -> list[dict[str, float]]:
    """Compare many starts of a search on few samples, and return the best of them."""
    passages, rough = problem.edge.passages, problem.rough
    coarse = problem.separable(form, coarse=True)
    known = found.get(EXPONENTIAL.name)
    sensors: list[dict[str, float]] = [{}]
    if problem.estimated and known is not None:
        sensors = [{name: known.values[name] for name in ("frequency", "quality")}]
    elif problem.estimated:
        slow, fast = 0.5 / problem.window, 1 / (6 * problem.step)
        sensors = [
            {"frequency": float(frequency), "quality": quality}
            for frequency in np.geomspace(max(1.2 * slow, 0.02 / rough), min(fast / 1.2, 0.5 / rough), 14)
            for quality in (1.0, 3.0, 10.0)
        ]
    shift = 0.0 if problem.seen_by(sensors[0]) is None else 0.7 * rough
    begins = [passages.first - shift - part * rough for part in (0.0, 0.1, 0.4)]
    if known is not None:
        begins.append(known.values["start"])
    centre = known.values["time_constant"] if known is not None else rough / 2.2
    if form.exponentials > 1:
        ratios = list(itertools.combinations((0.05, 0.15, 0.4, 1.0, 2.0, 5.0, 12.0), form.exponentials))
        begins = begins[-2:]
    else:
        ratios = [(ratio,) for ratio in (0.03, 0.2, 0.6, 1.0)] if form.exponentials else [()]
    grid = [
        {
            "start": begin,
            **sensor,
            **extra,
            **dict(zip(form.time_constants, (centre * each for each in ratio), strict=True)),
        }
        for begin in begins
        for sensor in sensors
        for ratio in ratios
        for extra in ([{"stretching": 0.6}, {"stretching": 1.0}] if form.stretched else [{}])
    ]
    moved = [
        {name: each.starting_at(start[name]).start for name, each in coarse.free.items()} for start in grid
    ]
    costs = [coarse.sum_of_squares(start) for start in moved]
    return [moved[at] for at in np.argsort(costs)[:_BEST_STARTS]]
