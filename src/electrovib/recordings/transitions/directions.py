"""Times of the edges of one direction: of each edge, as means over the edges, and what limits them."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Panel, Table
from electrovib.core.errors import InputError
from electrovib.recordings.interval import NORMAL, Interval, from_noise, mean_of, more_than
from electrovib.recordings.transitions.crossings import passages
from electrovib.recordings.transitions.edges import EdgeRecord
from electrovib.recordings.transitions.modes import MISFIT, MOST_FIGURES, above_lowest, chosen_form
from electrovib.recordings.transitions.relaxation import (
    EXPONENTIAL,
    INSTANTANEOUS,
    FittedForm,
    Sensor,
    fit_forms,
)

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_AFTER: Final = 8.0
"""Length of the drawn section after an edge, in times between the levels as recorded."""
_SUPPORT: Final = 10.0
"""Difference of the criterion above which a form has essentially no support (Burnham and Anderson 2002)."""


@dataclass(frozen=True, kw_only=True)
class GivenEdges:
    """How the edges of one record are measured."""

    sensor: Sensor | None
    estimated: bool
    driven: bool


@dataclass(frozen=True, kw_only=True)
class EdgeTimes:
    """Times of one edge: the time between the levels as recorded, and the forms of relaxation by name."""

    given: GivenEdges
    record: EdgeRecord
    fitted: Mapping[str, FittedForm]

    @property
    def recorded(self) -> Interval:
        """Time between the levels as recorded."""
        passed = self.record.passages
        return from_noise(passed.time, passed.standard_error, freedom=passed.freedom)

    def longer(self, form: str) -> float:
        """Return how much longer the time is if the signal ends at the level of a form; infinite beyond the record."""
        fitted, levels = self.fitted[form], self.record.levels
        estimate, passed = fitted.estimate, self.record.passages
        if fitted.form.endless or "upper" in {
            estimate.on_bound.get(each) for each in fitted.form.time_constants
        }:
            return math.inf
        unsure = NORMAL * np.nan_to_num(estimate.standard_deviations["after"])
        after = estimate.values["after"] + math.copysign(unsure, levels.change)
        if (after - levels.after) * levels.change <= 0:
            return 0.0
        at = replace(levels, after=after)
        begin = passed.first - passed.time
        try:
            found = passages(
                self.record.time, self.record.values, at, fractions=self.record.fractions, edge=begin
            )
        except InputError:
            return math.inf
        return max(found.time - passed.time, 0.0)

    def parameters(self, form: str) -> dict[str, Interval]:
        """Return the parameters of a fitted form, each with its interval, by the names of `DirectionTimes`."""
        fitted, found = self.fitted[form], {}
        estimate, values = fitted.estimate, fitted.estimate.values
        if self.given.driven:
            error = math.hypot(estimate.standard_deviations["start"], self.record.reference_error)
            found["delay"] = from_noise(values["start"], error, freedom=estimate.degrees_of_freedom)
        ordered = sorted(fitted.form.time_constants, key=lambda name: values[name])
        changes = fitted.form.amplitudes[:-1]
        whole = sum(values[name] for name in changes)
        for place, name in enumerate(ordered, start=1):
            if len(ordered) == 1:
                found["time_constant"] = _from_profile(fitted) or estimate.parameter(name)
                continue
            found[f"time_constant_{place}"] = estimate.parameter(name)
            own = name.replace("time_constant", "change")
            share = values[own] / whole
            slopes = {each: ((each == own) - share) / whole for each in changes}
            found[f"share_{place}"] = estimate.derived(share, slopes)
        for name in ("stretching", *(("frequency", "quality") if self.given.estimated else ())):
            if name in values:
                found[name] = estimate.parameter(name)
        return found


def _from_profile(fitted: FittedForm) -> Interval | None:
    """Return the interval of the time constant of an exponential whose time between levels has a profile."""
    between, value = fitted.between, fitted.estimate.values["time_constant"]
    if fitted.form is not EXPONENTIAL or not between.method.startswith("profile"):
        return None
    lower, upper, error = (
        each * value / between.value for each in (between.lower, between.upper, between.standard_error)
    )
    return replace(between, value=value, lower=lower, upper=upper, standard_error=error)


@dataclass(frozen=True, kw_only=True)
class DirectionTimes:
    """Times of all edges of one direction, ``rising`` or ``falling``."""

    given: GivenEdges
    edges: tuple[EdgeTimes, ...]

    @property
    def direction(self) -> str:
        """Direction of the edges."""
        return self.edges[0].record.direction

    @functools.cached_property
    def _sums(self) -> dict[str, float]:
        """Criterion of each form that was fitted to all edges, summed over these."""
        common = [name for name in self.edges[0].fitted if all(name in each.fitted for each in self.edges)]
        return {name: sum(each.fitted[name].aicc for each in self.edges) for name in common}

    @property
    def form(self) -> str:
        """Simplest form of relaxation whose criterion is at most 2 above the lowest."""
        return chosen_form(self._sums)

    @property
    def criteria(self) -> Mapping[str, float]:
        """AICc of each form over the lowest, summed over the edges; infinite for one of those in `rejected`."""
        return above_lowest(self._sums)

    @property
    def rejected(self) -> Mapping[str, str]:
        """Forms that are no relaxation of their kind, and why."""
        every = [(name, each.fitted[name].rejected) for each in self.edges[::-1] for name in self._sums]
        return {name: why for name, why in every if why}

    @property
    def misfit(self) -> float:
        """Largest rms residual over the noise before the edge."""
        return max(each.fitted[self.form].misfit for each in self.edges)

    @functools.cached_property
    def close(self) -> list[str]:
        """Forms that the record does not exclude, the chosen one among them."""
        return [name for name, above in self.criteria.items() if above < _SUPPORT + self.criteria[self.form]]

    @functools.cached_property
    def _longer(self) -> float:
        """By how much the time is longer if the signal ends at the level of a form; infinite if it may not have settled."""
        if any(each.record.creeps for each in self.edges):
            return math.inf
        simplest = self.close.index(self.form)
        held = [
            name
            for at, name in enumerate(self.close)
            if at <= simplest or self.criteria[name] < self.criteria[self.form]
        ]
        return float(np.mean([max(map(each.longer, held)) for each in self.edges]))

    @property
    def settled(self) -> bool:
        """Whether the record shows that the signal has settled after its edges, so that the times have values."""
        return math.isfinite(self._longer)

    @functools.cached_property
    def recorded(self) -> Interval:
        """Time between the levels as recorded, as a mean over the edges; a bound if the signal has not settled."""
        if not self.settled:
            shortest = float(np.mean([each.record.passages.lower for each in self.edges]))
            return more_than(shortest, "the record ends before the signal has settled", count=len(self.edges))
        mean = mean_of([each.recorded for each in self.edges])
        return replace(mean, upper=mean.upper + self._longer)

    @functools.cached_property
    def without_sensor(self) -> Interval:
        """That of the fitted force, the sensor taken out; without a sensor, of the fitted signal."""
        if not self.settled:
            least = self.recorded.lower - np.nan_to_num(self.sensor_limit)
            return replace(self.recorded, lower=max(least, 0.0))
        if self.form != INSTANTANEOUS.name:
            return self._with_sensor_error(mean_of([each.fitted[self.form].between for each in self.edges]))
        uppers = [each.fitted[EXPONENTIAL.name].between.upper for each in self.edges]
        if not np.isfinite(uppers).all():
            return Interval(value=0.0, method="an instantaneous change fits; an exponential has no upper end")
        return Interval(
            value=0.0, lower=0.0, upper=float(np.mean(uppers)), count=len(self.edges),
            method="an instantaneous change fits best; upper end from the profile of an exponential",
        )  # fmt: skip

    def _with_sensor_error(self, mean: Interval) -> Interval:
        """Add what the uncertainty of a declared sensor contributes, which is common to all edges."""
        sensor = self.given.sensor
        if sensor is None or not (sensor.frequency_error or sensor.quality_error):
            return mean
        moved = []
        for other in (
            replace(sensor, frequency=sensor.frequency + sensor.frequency_error),
            replace(sensor, quality=sensor.quality + sensor.quality_error),
        ):
            each = [
                fit_forms(one.record, forms=[one.fitted[self.form].form], sensor=other) for one in self.edges
            ]
            moved.append(float(np.mean([one[self.form].between.value for one in each])) - mean.value)
        half = math.hypot((mean.upper - mean.lower) / 2, 1.96 * math.hypot(*moved))
        centre = (mean.upper + mean.lower) / 2
        return replace(
            mean, lower=max(centre - half, 0.0), upper=centre + half,
            standard_error=math.hypot(mean.standard_error, *moved), method=f"{mean.method}, and the declared sensor",
        )  # fmt: skip

    @property
    def parameters(self) -> Mapping[str, Interval]:
        """Parameters of the best form as means over the edges, in SI.

        ``delay`` (with a drive), ``time_constant`` or ``time_constant_1`` and ``share_1`` and so on from the shortest,
        ``stretching``, and ``frequency`` and ``quality`` of an estimated sensor.
        """
        return self._parameters(self.form)

    @property
    def exponential(self) -> Mapping[str, Interval]:
        """Parameters of the exponential, whichever form is best."""
        return self._parameters(EXPONENTIAL.name)

    def _parameters(self, form: str) -> dict[str, Interval]:
        per_edge = [each.parameters(form) for each in self.edges]
        known = [name for name in per_edge[0] if self.settled or name == "delay"]
        found = {name: mean_of([each[name] for each in per_edge]) for name in known}
        return {name: each if name == "delay" else each.above(0.0) for name, each in found.items()}

    @property
    def impossible(self) -> list[str]:
        """Why these are no edges of this drive and this sensor: they begin before their cause, or are faster than the sensor."""
        first, said = self.edges[0], []
        delay = self.parameters.get("delay")
        if delay is not None and delay.upper < -float(np.median(np.diff(first.record.time))):
            said.append(
                f"by: the {self.direction} edges begin {-delay.value * 1e3:.3g} ms before the drive switches"
                f" ({-delay.upper * 1e3:.3g} ms at least): no change comes before its cause. Bring the clocks of both signals"
                " together when they are imported, name the signal that drives it, or omit it"
            )
        longest = 1.1 * (
            self.recorded.upper if self.settled else max(e.record.passages.time for e in self.edges)
        )
        sensor = first.fitted[self.form].sensor
        if sensor is not None and self.sensor_limit > longest:
            said.append(
                f"sensor: an instantaneous change would show {self.sensor_limit * 1e3:.3g} ms through a sensor of"
                f" {sensor.frequency:.3g} Hz and quality factor {sensor.quality:.3g}, but the {self.direction} edges take"
                f" {self.edges[0].record.passages.time * 1e3:.3g} ms: they do not show this sensor. Declare the"
                " one that was used, or none"
            )
        return said

    @property
    def sensor_limit(self) -> float:
        """Time between the levels that an instantaneous change would show through the sensor; NaN without a sensor."""
        seen = [(each.fitted[self.form].sensor, each.record.fractions) for each in self.edges]
        times = [sensor.shortest_time(fractions) for sensor, fractions in seen if sensor is not None]
        return float(np.mean(times)) if times else math.nan

    @property
    def drifts(self) -> bool:
        """Whether the signal drifts before an edge."""
        return any(each.record.levels.drift for each in self.edges)

    @property
    def begun(self) -> bool:
        """Whether the record begins within an edge."""
        return any(each.record.levels.begun for each in self.edges)

    @property
    def interpolated(self) -> bool:
        """Whether a passage lies between two samples alone."""
        return any(each.record.passages.interpolated for each in self.edges)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What limits the times, warnings first."""
        which = self.direction.capitalize()
        warnings = {
            "the record ends before the signal has settled, or it never settles: the times are longer than stated, and no fitted"
            " form is worth more than another. Record longer, or give a longer window.": not self.settled,
            "the record does not determine a time between the levels: its interval reaches 0. Choose the window after an edge so"
            " that the signal reaches both levels, or measure the other edges alone.": not self.recorded.lower
            > 0
            and self.settled,
            "the record has no noise before an edge, as a computed one, so no error of the fitted form"
            f" ({self.form}) is known; the intervals state none.": math.isinf(self.misfit),
            f"the best form ({self.form}) leaves a residual of {self.misfit:.2g} times the noise before the edge, so the time"
            " from the fit has an error beyond its interval.": self.settled
            and MISFIT < self.misfit < math.inf,
            "the record begins within an edge: its first sample is taken as the level before. If the signal began to change"
            " earlier, the times are longer than stated.": self.begun,
            "the signal drifts before an edge; both levels are taken as constant, which shifts the times.": self.drifts,
            "fewer than five samples lie near a level, so that the time as recorded is interpolated between two samples and may"
            " be wrong by up to a sampling interval.": self.interpolated,
        }
        said = [f"Warning: {which} edges: {text}" for text, holds in warnings.items() if holds]
        said += self._about_sensor(which)
        if len(self.close) > 1:
            ranked = ", ".join(
                f"{name} (AICc {self.criteria[name] - self.criteria[self.form]:+.1f})"
                for name in self.close
                if name != self.form
            )
            said.append(f"{which} edges: the record does not exclude other forms than {self.form}: {ranked}.")
        if len(self.edges) == 1:
            said.append(
                f"{which} edges: there is one; its interval is due to noise alone and does not contain the scatter between edges."
            )
        return tuple(said)

    def _about_sensor(self, which: str) -> list[str]:
        sensor = self.given.sensor
        if math.isnan(self.sensor_limit):
            return [
                f"{which} edges: no sensor was taken out; a resonance or bandwidth of the sensor is part of these times."
            ]
        limit = f"an instantaneous change would show {self.sensor_limit * 1e3:.3g} ms through this sensor"
        said = []
        if self.form == INSTANTANEOUS.name:
            said.append(
                f"{which} edges: an instantaneous change through the sensor reproduces the record as well as a relaxation does"
                f" ({limit}); only an upper end of the time is known."
            )
            if "delay" in self.parameters:
                fall = self.exponential["time_constant"].upper
                shorter = f"up to {fall * 1e3:.2g} ms earlier" if math.isfinite(fall) else "earlier"
                said.append(
                    f"{which} edges: the delay is that of an instantaneous change; if the force relaxes exponentially, it begins"
                    f" to change {shorter}."
                )
        else:
            said.append(f"{which} edges: {limit}.")
        if self.given.estimated:
            said.append(
                f"{which} edges: the sensor was estimated from the same edges, with one resonance. Delay, time constant and"
                " resonance then share what the record determines."
            )
        elif sensor is not None and not (sensor.frequency_error or sensor.quality_error):
            said.append(f"{which} edges: the declared sensor is taken as exact.")
        return said


def criteria_table(found: DirectionTimes) -> Table:
    """List the forms of relaxation with their criterion, and why some were rejected."""
    rows = tuple(
        (name, f"{above:.4g}" if math.isfinite(above) else "rejected", found.rejected.get(name, ""))
        for name, above in found.criteria.items()
    )
    return Table(
        f"Forms of relaxation of the {found.direction} edges",
        ("Form", "AICc above the lowest", "Why it was rejected"),
        rows,
        caption=f"Summed over {len(found.edges)} edge{'s' * (len(found.edges) > 1)}, after the correlation of the noise"
        " has been filtered out.",
    )


def edges_panel(found: DirectionTimes, words: str, unit: str, *, sensor: bool) -> Panel:
    """Make the figure of the first edges of one direction, with the best form, and with the force where a sensor is taken out."""
    most = MOST_FIGURES - sensor  # each has two lines then
    curves: list[Curve] = []
    records: list[tuple[Real, Real]] = []
    for number, each in enumerate(found.edges[:most]):
        fitted, record = each.fitted[found.form], each.record
        reach = record.passages.last + _AFTER * record.passages.time
        part = (record.fit_time > record.passages.first - 2 * record.passages.time) & (
            record.fit_time < reach
        )
        time = record.fit_time[part]
        name = f", edge {number + 1}" if len(found.edges) > 1 else ""
        records.append((time, record.fit_values[part]))
        form = f"{found.form}{' through the sensor' * sensor}{name}"
        curves.append(Curve(label=form, x=time, y=fitted.reading[part]))
        if sensor:
            values = fitted.estimate.values
            fine = np.linspace(time[0], time[-1], 2000)
            force = fitted.form.columns(fine, values, None) @ [
                values[part] for part in fitted.form.amplitudes
            ]
            curves.append(Curve(label=f"force, the sensor taken out{name}", x=fine, y=force, kind="dashed"))
    x, y = (np.concatenate(each) for each in zip(*records, strict=True))
    curves.append(Curve(label="record", x=x, y=y, kind="points", look=REFERENCE))
    more = f" The first {most} of {len(found.edges)} edges." if len(found.edges) > most else ""
    return Panel(
        id=f"edges-{found.direction}",
        title=f"{found.direction.capitalize()} edges",
        caption=f"Points: record, averaged where it is dense. Lines: best form of relaxation.{more}",
        x=("time after the edge", "s"),
        y=(words, unit),
        curves=tuple(curves),
    )
