"""Times of single edges, and their means over the edges of a direction."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from electrovib.recordings.transitions.criterion import above_lowest, chosen_form
from electrovib.recordings.transitions.edges import EdgeRecord, of_change
from electrovib.recordings.transitions.estimate import Interval, from_noise, none, over_edges
from electrovib.recordings.transitions.forms import EXPONENTIAL, INSTANTANEOUS, forms
from electrovib.recordings.transitions.parameters import parameters_of
from electrovib.recordings.transitions.relaxation import fit_forms
from electrovib.recordings.transitions.result import DirectionTimes, EdgeTimes
from electrovib.recordings.transitions.sensor import Sensor
from electrovib.recordings.transitions.statements import statements

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """Measurement of the edges of one record at fractions of the range, counted from the lower level."""

    levels: tuple[float, float]
    sensor: Sensor | None
    estimated: bool
    driven: bool

    def measured(self, edge: EdgeRecord, exponentials: int) -> EdgeTimes:
        """Measure one edge."""
        fractions = of_change(self.levels, rising=edge.direction == "rising")
        fitted = fit_forms(
            edge,
            forms=forms(exponentials, sensor=self.sensor is not None or self.estimated),
            fractions=fractions,
            sensor=self.sensor,
            estimated=self.estimated,
        )
        passed = edge.passages
        recorded = from_noise(passed.time, passed.standard_error, freedom=passed.freedom)
        return EdgeTimes(record=edge, recorded=recorded, fitted=fitted)

    def summary(self, edges: Sequence[EdgeTimes]) -> DirectionTimes | None:
        """Choose the form for all edges of a direction, and average over them."""
        if not edges:
            return None
        names = [name for name in edges[0].fitted if all(name in each.fitted for each in edges)]
        sums = {name: sum(each.fitted[name].aicc for each in edges) for name in names}
        form = chosen_form(sums)
        rejected = {
            name: reason
            for name in names
            if (
                reason := next(
                    (each.fitted[name].rejected for each in edges if each.fitted[name].rejected), ""
                )
            )
        }
        fractions = of_change(self.levels, rising=edges[0].record.direction == "rising")
        found = DirectionTimes(
            direction=edges[0].record.direction,
            edges=tuple(edges),
            recorded=over_edges([each.recorded for each in edges]),
            without_sensor=self.without_sensor(edges, form, fractions),
            form=form,
            criteria=above_lowest(sums),
            rejected=rejected,
            parameters=self.parameters(edges, form),
            exponential=self.parameters(edges, EXPONENTIAL.name),
            sensor_limit=self.limit(edges, form, fractions),
            misfit=max(each.fitted[form].misfit for each in edges),
            words=(),
        )
        return replace(found, words=statements(found, sensor=self.sensor, estimated=self.estimated))

    def without_sensor(
        self, edges: Sequence[EdgeTimes], form: str, fractions: tuple[float, float]
    ) -> Interval:
        """Average the time between the levels of the fitted force."""
        if form == INSTANTANEOUS.name:
            others = [each.fitted[EXPONENTIAL.name].between for each in edges]
            uppers = [each.upper for each in others]
            if not np.isfinite(uppers).all():
                return none(0.0, "an instantaneous change fits; an exponential has no upper end")
            return Interval(
                value=0.0, lower=0.0, upper=float(np.mean(uppers)), standard_error=math.nan, count=len(edges),
                method="an instantaneous change fits best; upper end from the profile of an exponential",
            )  # fmt: skip
        mean = over_edges([each.fitted[form].between for each in edges])
        return self.with_sensor_error(mean, edges, form, fractions)

    def with_sensor_error(
        self, mean: Interval, edges: Sequence[EdgeTimes], form: str, fractions: tuple[float, float]
    ) -> Interval:
        """Add what the uncertainty of a declared sensor contributes, which is common to all edges."""
        sensor = self.sensor
        if sensor is None or not (sensor.frequency_error or sensor.quality_error):
            return mean
        changed = [
            replace(sensor, frequency=sensor.frequency + sensor.frequency_error),
            replace(sensor, quality=sensor.quality + sensor.quality_error),
        ]
        moved = []
        for other in changed:
            each = [
                fit_forms(one.record, forms=[one.fitted[form].form], fractions=fractions, sensor=other)[form]
                for one in edges
            ]
            moved.append(float(np.mean([one.between.value for one in each])) - mean.value)
        half = math.hypot((mean.upper - mean.lower) / 2, 1.96 * math.hypot(*moved))
        centre = (mean.upper + mean.lower) / 2
        return replace(
            mean, lower=max(centre - half, 0.0), upper=centre + half,
            standard_error=math.hypot(mean.standard_error, *moved), method=f"{mean.method}, and the declared sensor",
        )  # fmt: skip

    def parameters(self, edges: Sequence[EdgeTimes], form: str) -> dict[str, Interval]:
        """Average the parameters of the form over the edges."""
        per_edge = [parameters_of(each, form, driven=self.driven, estimated=self.estimated) for each in edges]
        return {name: over_edges([each[name] for each in per_edge]) for name in per_edge[0]}

    def limit(self, edges: Sequence[EdgeTimes], form: str, fractions: tuple[float, float]) -> float:
        """Compute the time that an instantaneous change would show through the sensor."""
        seen = [each.fitted[form].sensor for each in edges]
        times = [
            Sensor(frequency=one[0], quality=one[1]).shortest_time(fractions)
            for one in seen
            if one is not None
        ]
        return float(np.mean(times)) if times else math.nan
