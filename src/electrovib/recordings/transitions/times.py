"""Rise and fall times of the edges of a recording, as recorded and with the sensor taken out."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.fit.separable import above_lowest, chosen_form
from electrovib.recordings.interval import Interval, from_noise, mean_of
from electrovib.recordings.transitions.edges import (
    EdgeRecord,
    columns_of,
    edge_record,
    reference_times,
)
from electrovib.recordings.transitions.relaxation import (
    EXPONENTIAL,
    INSTANTANEOUS,
    Sensor,
    fit_forms,
    forms,
    read_sensor,
)
from electrovib.recordings.transitions.table import in_few, statements

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray

    from electrovib.physics.drive.readback import Readback
    from electrovib.recordings.transitions.relaxation import FittedForm

SensorSource: TypeAlias = Sensor | str | None
"""A declared sensor, as an object or as text, ``"estimate"``, or none."""


def measure_times(
    record: xarray.Dataset | str | Path,
    *,
    signal: str | None = None,
    levels: tuple[float, float] = (0.1, 0.9),
    by: str | None = None,
    readback: Readback | None = None,
    sensor: SensorSource = None,
    exponentials: int = 3,
    window: float | None = None,
    before: float | None = None,
    edges: Literal["both", "rising", "falling"] = "both",
) -> MeasuredTimes:
    """Measure the times between levels of rising and falling edges, as recorded and with the sensor taken out.

    Parameters
    ----------
    record : xarray.Dataset, str or Path
        Trace, for instance of `electrovib.import_file`, or its file.
    signal : str, optional
        Signal whose edges are measured; by default the only one besides `by`.
    levels : tuple of float
        Fractions of the range between the levels before and after an edge, counted from the lower one, increasing,
        between 0 and 1.
    by : str, optional
        Signal of the drive whose switching marks the edges; by default the edges are found in the signal itself.
    readback : Readback, optional
        Relation of `by` to the drive, for instance one of two electrodes in antiphase; by default `by` is the whole drive.
    sensor : Sensor, ``"estimate"``, str or None
        Sensor through which the force was recorded: declared, declared as ``"380 Hz:3"``, estimated from each edge together
        with the relaxation, or none.
    exponentials : int
        Largest number of exponentials that are compared, from 1 to 4.
    window, before : float, optional
        Length of the section after and before an edge [s]; by default 30 times the time between the levels, and half of that,
        or up to the neighbouring edges.
    edges : {"both", "rising", "falling"}
        Edges of the signal that are measured.

    Returns
    -------
    times : MeasuredTimes
        For each direction the time between the levels with its interval, the form of relaxation and its parameters.

    Raises
    ------
    InputError
        If an argument cannot be used, or if no edge can be measured.

    Notes
    -----
    As recorded, the time is that between the last passage through the first level before half of the change and the first
    passage through the second level after it, each found from a parabola through the neighbouring samples.

    The sensor is taken out by fitting a relaxation through it (y'' + (w/Q) y' + w^2 y = w^2 f), not by deconvolution, which
    would amplify the noise above its resonance. The time without the sensor is therefore that of the form that was fitted: it
    is biased where the force relaxes in another form, and the residual shows only a misfit above the noise. The forms are an
    instantaneous change (with a sensor), an exponential, a stretched exponential and sums of exponentials of equal sign. The
    simplest is chosen whose AICc, summed over the edges, is at most 2 above the lowest, after the correlation of the noise
    before the edge has been filtered out.

    With several edges the interval is Student's t over the edges. With one it follows from the noise of this edge alone.
    """
    given = Measurement(sensor=_sensor(sensor), estimated=sensor == "estimate", driven=by is not None)
    fractions = _checked_levels(levels)
    _check_numbers(exponentials=exponentials, window=window, before=before, edges=edges)
    chosen = columns_of(record, signal=signal, by=by, readback=readback)
    references = reference_times(chosen.time, chosen.values, chosen.drive)
    found: list[EdgeTimes] = []
    skipped: list[str] = []
    for number, at in enumerate(references):
        try:
            each = edge_record(
                chosen.time, chosen.values, references, number,
                levels=fractions, driven=given.driven, window=window, before=before,
            )  # fmt: skip
            measured = given.measured(each, exponentials) if edges in ("both", each.direction) else None
        except InputError as error:
            skipped += [f"The edge at {at:.6g} s was not measured: {problem}." for problem in error.problems]
            continue
        if measured is not None:
            found.append(measured)
    if not found:
        raise InputError(in_few(skipped) or f"edges = {edges}: the signal {chosen.signal} has no such edge")
    return MeasuredTimes(
        signal=chosen.signal,
        unit=chosen.unit,
        levels=fractions,
        rising=given.summary([each for each in found if each.record.direction == "rising"]),
        falling=given.summary([each for each in found if each.record.direction == "falling"]),
        sensor="estimated" if given.estimated else ("declared" if given.sensor else "none"),
        driven=given.driven,
        skipped=tuple(skipped),
    )


def _checked_levels(levels: tuple[float, float]) -> tuple[float, float]:
    if len(levels) != 2 or not 0 < levels[0] < levels[1] < 1:
        shown = ", ".join(f"{each:g}" for each in levels)
        raise InputError(
            f"levels = ({shown}): expected two increasing fractions between 0 and 1, such as (0.1, 0.9)"
        )
    return float(levels[0]), float(levels[1])


def _sensor(sensor: SensorSource) -> Sensor | None:
    if sensor is None or sensor == "estimate" or isinstance(sensor, Sensor):
        return sensor if isinstance(sensor, Sensor) else None
    return read_sensor(sensor)


def _check_numbers(*, exponentials: int, window: float | None, before: float | None, edges: str) -> None:
    problems = []
    if exponentials not in (1, 2, 3, 4):
        problems.append(f"exponentials = {exponentials}: expected a number from 1 to 4")
    problems += [
        f"{name} = {value:g}: expected a positive time in seconds"
        for name, value in (("window", window), ("before", before))
        if value is not None and not 0 < value < math.inf
    ]
    if edges not in ("both", "rising", "falling"):
        problems.append(f"edges = {edges}: expected both, rising or falling")
    if problems:
        raise InputError(problems)


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """How the edges of one record are measured."""

    sensor: Sensor | None
    estimated: bool
    driven: bool

    def measured(self, edge: EdgeRecord, exponentials: int) -> EdgeTimes:
        """Measure one edge."""
        compared = forms(exponentials, sensor=self.sensor is not None or self.estimated)
        fitted = fit_forms(edge, forms=compared, sensor=self.sensor, estimated=self.estimated)
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
            name: reasons[0]
            for name in names
            if (reasons := [each.fitted[name].rejected for each in edges if each.fitted[name].rejected])
        }
        found = DirectionTimes(
            direction=edges[0].record.direction,
            edges=tuple(edges),
            recorded=mean_of([each.recorded for each in edges]),
            without_sensor=self.without_sensor(edges, form),
            form=form,
            criteria=above_lowest(sums),
            rejected=rejected,
            parameters=self.parameters(edges, form),
            exponential=self.parameters(edges, EXPONENTIAL.name),
            sensor_limit=self.limit(edges, form),
            misfit=max(each.fitted[form].misfit for each in edges),
            words=(),
        )
        return replace(found, words=statements(found, sensor=self.sensor, estimated=self.estimated))

    def without_sensor(self, edges: Sequence[EdgeTimes], form: str) -> Interval:
        """Average the time between the levels of the fitted force."""
        if form == INSTANTANEOUS.name:
            others = [each.fitted[EXPONENTIAL.name].between for each in edges]
            uppers = [each.upper for each in others]
            if not np.isfinite(uppers).all():
                return Interval(
                    value=0.0, method="an instantaneous change fits; an exponential has no upper end"
                )
            return Interval(
                value=0.0, lower=0.0, upper=float(np.mean(uppers)), standard_error=math.nan, count=len(edges),
                method="an instantaneous change fits best; upper end from the profile of an exponential",
            )  # fmt: skip
        mean = mean_of([each.fitted[form].between for each in edges])
        return self.with_sensor_error(mean, edges, form)

    def with_sensor_error(self, mean: Interval, edges: Sequence[EdgeTimes], form: str) -> Interval:
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
            each = [fit_forms(one.record, forms=[one.fitted[form].form], sensor=other)[form] for one in edges]
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
        return {name: mean_of([each[name] for each in per_edge]) for name in per_edge[0]}

    def limit(self, edges: Sequence[EdgeTimes], form: str) -> float:
        """Compute the time that an instantaneous change would show through the sensor."""
        seen = [(each.fitted[form].sensor, each.record.fractions) for each in edges]
        times = [
            Sensor(frequency=one[0], quality=one[1]).shortest_time(fractions)
            for one, fractions in seen
            if one is not None
        ]
        return float(np.mean(times)) if times else math.nan


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


def parameters_of(edge: EdgeTimes, form: str, *, driven: bool, estimated: bool) -> dict[str, Interval]:
    """Return the parameters of a form fitted to one edge, each with its interval, by the names of `DirectionTimes`."""
    fitted, found = edge.fitted[form], {}
    estimate, values = fitted.estimate, fitted.estimate.values
    if driven:
        error = math.hypot(estimate.standard_deviations["start"], edge.record.reference_error)
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
    for name in ("stretching", *(("frequency", "quality") if estimated else ())):
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
