"""Rise and fall times of the edges of a recording, as recorded and with the sensor taken out, and what limits them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal, TypeAlias

import numpy as np

from electrovib.core.answer import Answer, Document
from electrovib.core.budget import one_thread
from electrovib.core.deprecation import former_attribute
from electrovib.core.errors import InputError, refuse
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form
from electrovib.recordings.interval import (
    Interval,
    NumberRow,
    numbers_csv,
    numbers_table,
    stuck,
    with_ends,
)
from electrovib.recordings.recording import at_rail
from electrovib.recordings.transitions.directions import (
    DirectionTimes,
    EdgeTimes,
    GivenEdges,
    criteria_table,
    edges_panel,
)
from electrovib.recordings.transitions.edges import columns_of, edge_record, in_few, reference_times
from electrovib.recordings.transitions.modes import REFERENCES, misfit_note, parameter_row
from electrovib.recordings.transitions.relaxation import (
    Sensor,
    fit_forms,
    forms,
    read_sensor,
)
from electrovib.recordings.transitions.ring import MeasuredRings, ring_rows

if TYPE_CHECKING:
    import xarray

    from electrovib.physics.drive.readback import Readback

SensorSource: TypeAlias = Sensor | str | None
"""A declared sensor, as an object or as text, ``"estimate"``, or none."""


@one_thread(with_scipy=True)
def measure_times(
    record: xarray.Dataset | str | Path,
    *,
    quantity: str | None = None,
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
    quantity : str, optional
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

    A record that ends before the signal has settled, or does not exclude that it never does (a logarithm of time is compared
    too), gives a lower bound of the time and no value.

    With several edges the interval is Student's t over the edges. With one it follows from the noise of this edge alone.
    """
    _check(levels, exponentials, edges, window=window, before=before)
    declared = read_sensor(sensor) if isinstance(sensor, str) and sensor != "estimate" else sensor
    given = GivenEdges(
        sensor=declared if isinstance(declared, Sensor) else None,
        estimated=sensor == "estimate",
        driven=by is not None,
    )
    compared = forms(exponentials, sensor=sensor is not None)
    chosen = columns_of(record, quantity=quantity, by=by, readback=readback)
    references = reference_times(chosen.time, chosen.values, chosen.drive)
    found: list[EdgeTimes] = []
    skipped: list[str] = []
    for number, at in enumerate(references):
        try:
            each = edge_record(
                chosen.time, chosen.values, references, number,
                levels=levels, driven=given.driven, window=window, before=before,
            )  # fmt: skip
            if edges in ("both", each.direction):
                fitted = fit_forms(each, forms=compared, sensor=given.sensor, estimated=given.estimated)
                found.append(EdgeTimes(given=given, record=each, fitted=fitted))
        except InputError as error:
            skipped += [f"The edge at {at:.6g} s was not measured: {problem}." for problem in error.problems]
    railed = float(np.mean(at_rail(chosen.values) | stuck(chosen.values)))
    if not found:
        why = [*([_repeated(railed)] if railed else []), *skipped]
        raise InputError(in_few(why) or f"edges = {edges}: the signal {chosen.signal} has no such edge")
    rising, falling = (
        _of_one_direction(given, [each for each in found if each.record.direction == direction], skipped)
        for direction in ("rising", "falling")
    )
    refuse([text for each in (rising, falling) if each is not None for text in each.impossible])
    return MeasuredTimes(
        signal=chosen.signal,
        unit=chosen.unit,
        levels=(float(levels[0]), float(levels[1])),
        rising=rising,
        falling=falling,
        sensor="estimated" if given.estimated else ("declared" if given.sensor else "none"),
        driven=given.driven,
        skipped=tuple(skipped),
        at_rail=railed,
    )


def _of_one_direction(given: GivenEdges, edges: list[EdgeTimes], skipped: list[str]) -> DirectionTimes | None:
    """Collect the edges that have settled, or all where none has, and tell of the others."""
    settled = [each for each in edges if not each.record.creeps]
    if settled:
        skipped += [
            f"The edge at {each.record.reference:.6g} s was not measured: its record ends before it has settled."
            for each in edges
            if each.record.creeps
        ]
    return DirectionTimes(given=given, edges=tuple(settled or edges)) if edges else None


def _repeated(share: float) -> str:
    return f"{share:.1%} of the samples repeat the end of the range of the sensor, or one reading: it is at a rail or stuck"


def _check(levels: tuple[float, float], exponentials: int, edges: str, **spans: float | None) -> None:
    problems = []
    if len(levels) != 2 or not 0 < levels[0] < levels[1] < 1:
        shown = ", ".join(f"{each:g}" for each in levels)
        problems.append(
            f"levels = ({shown}): expected two increasing fractions between 0 and 1, such as (0.1, 0.9)"
        )
    if exponentials not in (1, 2, 3, 4):
        problems.append(f"exponentials = {exponentials}: expected a number from 1 to 4")
    problems += [
        f"{name} = {value:g}: expected a positive time in seconds"
        for name, value in spans.items()
        if value is not None and not 0 < value < math.inf
    ]
    if edges not in ("both", "rising", "falling"):
        problems.append(f"edges = {edges}: expected both, rising or falling")
    refuse(problems)


@dataclass(frozen=True, kw_only=True, repr=False)
class MeasuredTimes(Answer):
    """Times between levels of the edges of a recorded signal; a direction without edges is None.

    `levels` are fractions of the range between the levels before and after an edge, counted from the lower
    one. `sensor` was ``none``, ``declared`` or ``estimated``; `driven` says whether the edges are those of a
    drive. `skipped` says which edges were not evaluated, and why; `at_rail` is the part of the samples that repeat the end of
    the range of the sensor, or one reading. `rings` are oscillations of the same signal that are shown with them.
    """

    FILES: ClassVar = {"times.csv": Form.TABLE}
    signal: str
    unit: str
    levels: tuple[float, float]
    rising: DirectionTimes | None
    falling: DirectionTimes | None
    sensor: str
    driven: bool
    skipped: tuple[str, ...]
    at_rail: float = 0.0
    rings: MeasuredRings | None = None
    words = former_attribute("words", "document", lambda self: self.remarks)

    @property
    def directions(self) -> tuple[DirectionTimes, ...]:
        """The directions that have edges, rising before falling."""
        return tuple(each for each in (self.rising, self.falling) if each is not None)

    @property
    def document(self) -> Document:
        """Times of each direction, oscillations, edges with their fits, and what limits them."""
        words, sensor = self.signal.replace("_", " "), self.sensor != "none"
        rings = None if self.rings is None else self.rings.document
        return Document(
            title=f"Times of {words}",
            sentences=[
                *(_sentence(self, each) for each in self.directions),
                *(text for text in self.remarks if text.startswith("Warning")),
                *(rings.sentences if rings else ()),
            ],
            numbers=[numbers_table("Times and parameters", self._rows, first="Edges")],
            figures=[
                *(edges_panel(each, words, self.unit, sensor=sensor) for each in self.directions),
                *(rings.figures if rings else ()),
            ],
            tables=[criteria_table(each) for each in self.directions],
            remarks=[
                *(text for text in self.remarks if not text.startswith("Warning")),
                *(rings.remarks if rings else ()),
            ],
            references=REFERENCES,
        )

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        del name
        return numbers_csv(self._rows)

    @property
    def _rows(self) -> list[NumberRow]:
        return [*time_rows(self), *(ring_rows(self.rings) if self.rings else ())]

    @property
    def remarks(self) -> tuple[str, ...]:
        """What limits the times, warnings first, and why other edges were not measured."""
        said = [text for each in self.directions for text in each.remarks]
        if self.at_rail and any(math.isfinite(each.misfit) for each in self.directions):
            said.insert(
                0,
                f"Warning: {_repeated(self.at_rail)}, and times that depend on them have an error of unknown size.",
            )
        return (*said, *in_few(self.skipped))


def _sentence(found: MeasuredTimes, each: DirectionTimes) -> str:
    """State the times of one direction, and what the sensor would show of an instantaneous change."""
    shown = " and ".join(f"{100 * each:g} %" for each in found.levels)
    text = f"The {each.direction} edges take {with_ends(each.recorded, 's')} between {shown} as recorded"
    own = each.without_sensor
    if found.sensor != "none":
        if own.value == 0 and math.isfinite(own.upper):
            text += f" and less than {format_quantity(own.upper, 's', digits=3)} with the sensor taken out"
        elif math.isfinite(own.lower):
            text += f" and {with_ends(own, 's')} with the sensor taken out"
        limit = format_quantity(each.sensor_limit, "s", digits=3)
        text += f"; an instantaneous change would show {limit} through this sensor"
    return f"{text}."


def time_rows(found: MeasuredTimes) -> list[NumberRow]:
    """List the numbers of measured times as rows of a table."""
    shown = "-".join(f"{100 * each:g}" for each in found.levels)
    without = "without the sensor" if found.sensor != "none" else "of the fitted form"
    return [row for each in found.directions for row in _of_direction(each, f"{shown} % time", without)]


def _of_direction(found: DirectionTimes, what: str, without: str) -> list[NumberRow]:
    few = "interpolated between two samples" if found.interpolated else ""
    drifts = "the signal drifts before an edge" if found.drifts else ""
    warning = "; ".join(filter(None, [misfit_note(found.misfit), drifts]))
    limit = Interval(value=found.sensor_limit, method="closed form of the sensor")
    times = [
        (f"{what} as recorded", found.recorded, "; ".join(filter(None, [few, drifts]))),
        (f"{what} {without} ({found.form})", found.without_sensor, warning),
        (f"{what} of an instantaneous change through the sensor", limit, ""),
    ]
    rows = [
        NumberRow(group=found.direction, name=name, unit="s", number=number, note=note)
        for name, number, note in times
        if number is not limit or not math.isnan(limit.value)
    ]
    shown = [(name, each, found.form, warning) for name, each in found.parameters.items()]
    if found.form != "exponential":
        better = f"{found.form} fits better"
        shown += [(name, each, "exponential", better) for name, each in found.exponential.items()]
    return rows + [parameter_row(found.direction, *each) for each in shown]
