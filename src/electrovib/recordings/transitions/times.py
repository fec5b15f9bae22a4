"""Rise and fall times of the edges of a recording, as recorded and with the sensor taken out."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from electrovib.core.errors import InputError
from electrovib.recordings.transitions.chosen import columns_of
from electrovib.recordings.transitions.edges import edge_record, reference_times
from electrovib.recordings.transitions.measurement import Measurement
from electrovib.recordings.transitions.result import EdgeTimes, MeasuredTimes
from electrovib.recordings.transitions.sensor import Sensor, read_sensor
from electrovib.recordings.transitions.statements import in_few

if TYPE_CHECKING:
    import xarray

    from electrovib.physics.drive.readback import Readback

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
    given = Measurement(
        levels=_checked_levels(levels),
        sensor=_sensor(sensor),
        estimated=sensor == "estimate",
        driven=by is not None,
    )
    _check_numbers(exponentials=exponentials, window=window, before=before, edges=edges)
    chosen = columns_of(record, signal=signal, by=by, readback=readback)
    references = reference_times(chosen.time, chosen.values, chosen.drive)
    found: list[EdgeTimes] = []
    skipped: list[str] = []
    for number, at in enumerate(references):
        try:
            each = edge_record(
                chosen.time, chosen.values, references, number,
                levels=given.levels, driven=given.driven, window=window, before=before,
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
        levels=given.levels,
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
