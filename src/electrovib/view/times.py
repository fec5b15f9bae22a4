"""Measured times as a folder: a page with edges, fits and table, and the numbers as CSV."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.data.marks import Form
from electrovib.recordings.transitions.table import time_rows
from electrovib.study.reproduction import REFERENCE, Curve, Page, Panel, Table
from electrovib.view.documents import Document, html
from electrovib.view.measured import numbers_csv, numbers_table
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from electrovib.recordings.interval import Interval
    from electrovib.recordings.transitions import MeasuredRing, MeasuredRings, MeasuredTimes
    from electrovib.recordings.transitions.times import DirectionTimes

FILES: Final[dict[str, Form]] = {"report.html": Form.PAGE, "times.csv": Form.TABLE}
"""Files of measured times and their forms."""
REFERENCES: Final = (
    "IEEE Std 181-2011, Transitions, Pulses, and Related Waveforms",
    "K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed., Springer, 2002",
)


def times_files(
    found: MeasuredTimes | None, rings: MeasuredRings | None = None, *, source: str = ""
) -> dict[str, str]:
    """Write the texts of the files of `FILES`."""
    rows = time_rows(found, rings)
    directions = () if found is None else found.directions
    signal = next(each.signal for each in (found, *(rings.rings if rings else ())) if each is not None)
    words = tuple(text for each in (found, rings) if each is not None for text in each.words)
    document = Document(
        title=f"{'Oscillations' if found is None else 'Times'} of {signal.replace('_', ' ')}{f' in {source}' if source else ''}",
        answer=_answer(found, rings),
        figures=times_panels(found, rings),
        tables=[
            numbers_table("Times and parameters", rows, first="Edges"),
            *(_criteria(each) for each in directions),
        ],
        pages=[Page("Limits", words)] if words else [],
        references=REFERENCES,
    )
    return {"report.html": html(document), "times.csv": numbers_csv(rows)}


def _answer(found: MeasuredTimes | None, rings: MeasuredRings | None) -> str:
    """State the times of each direction, and the oscillations, in a sentence each."""
    said = [] if found is None else _of_times(found)
    if rings is not None:
        frequency, quality = rings.frequency, rings.quality
        after = f"after {len(rings.rings)} impacts" if len(rings.rings) > 1 else "after the edge or impact"
        said.append(
            f"The signal oscillates {after} with {_interval(frequency, 'Hz')} and a quality factor of {_interval(quality)}."
        )
        said += [words for words in rings.words if words.startswith("Warning")]
    return " ".join(said)


def _of_times(found: MeasuredTimes) -> list[str]:
    shown = " to ".join(f"{100 * each:g} %" for each in found.levels)
    said = []
    for each in found.directions:
        text = f"The {each.direction} edges take {_interval(each.recorded, 's')}"
        text += f" between {shown} as recorded"
        own = each.without_sensor
        if found.sensor != "none":
            if own.value == 0 and math.isfinite(own.upper):
                text += (
                    f" and less than {pretty_quantity(own.upper, 's', digits=3)} with the sensor taken out"
                )
            elif math.isfinite(own.value):
                text += f" and {_interval(own, 's')} with the sensor taken out"
            limit = pretty_quantity(each.sensor_limit, "s", digits=3)
            text += f"; an instantaneous change would show {limit} through this sensor"
        said.append(f"{text}.")
        said += [words for words in each.words if words.startswith("Warning")]
    return said


def _interval(number: Interval, unit: str = "") -> str:
    value, ends = number.texts(unit, digits=3, write=pretty_quantity)
    return f"{value} ({ends})" if ends else f"{value} (no interval)"


def _criteria(found: DirectionTimes) -> Table:
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


_MOST_EDGES: Final = 3
_AFTER: Final = 8.0
"""Length of the drawn section after an edge, in times between the levels as recorded."""


def times_panels(found: MeasuredTimes | None, rings: MeasuredRings | None = None) -> list[Panel]:
    """Make the figures of the first three edges of each direction, with the best form, and of three oscillations."""
    panels = []
    if found is not None:
        words = found.signal.replace("_", " ")
        panels = [_panel(each, words, found.unit, sensor=found.sensor != "none") for each in found.directions]
    if rings is not None:
        panels += [_of_ring(each, number) for number, each in enumerate(rings.rings[:_MOST_EDGES])]
    return panels


def _of_ring(ring: MeasuredRing, number: int) -> Panel:
    return Panel(
        id=f"ring{number or ''}",
        title=f"Oscillation from {ring.reference:.6g} s on",
        caption=f"Points: record, averaged where it is dense. Line: {ring.form}.",
        x=("time after the reference", "s"),
        y=(ring.signal.replace("_", " "), ring.unit),
        curves=(
            Curve(label="record", x=ring.time, y=ring.values, kind="points", look=0),
            Curve(label=ring.form, x=ring.time, y=ring.model, look=1),
        ),
    )


def _panel(found: DirectionTimes, words: str, unit: str, *, sensor: bool) -> Panel:
    curves: list[Curve] = []
    for number, each in enumerate(found.edges[:_MOST_EDGES]):
        fitted, record = each.fitted[found.form], each.record
        reach = record.passages.last + _AFTER * record.passages.time
        part = (record.fit_time > record.passages.first - 2 * record.passages.time) & (
            record.fit_time < reach
        )
        time = record.fit_time[part]
        name = f", edge {number + 1}" if len(found.edges) > 1 else ""
        look = number * (3 if sensor else 2)
        curves.append(
            Curve(label=f"record{name}", x=time, y=record.fit_values[part], kind="points", look=look)
        )
        curves.append(
            Curve(
                label=f"{found.form}{' through the sensor' * sensor}{name}",
                x=time,
                y=fitted.reading[part],
                look=look + 1,
            )
        )
        if sensor:
            values = fitted.estimate.values
            fine = np.linspace(time[0], time[-1], 2000)
            force = (
                fitted.form.columns(fine, values, None)
                if fitted.form.exponentials
                else np.column_stack([fine < values["start"], np.ones_like(fine)])
            )
            curves.append(
                Curve(
                    label=f"force, the sensor taken out{name}",
                    x=fine,
                    y=force @ [values[part] for part in fitted.form.amplitudes],
                    kind="dashed",
                    look=REFERENCE,
                )
            )
    more = f" The first {_MOST_EDGES} of {len(found.edges)} edges." if len(found.edges) > _MOST_EDGES else ""
    return Panel(
        id=f"edges-{found.direction}",
        title=f"{found.direction.capitalize()} edges",
        caption=f"Points: record, averaged where it is dense. Lines: best form of relaxation.{more}",
        x=("time after the edge", "s"),
        y=(words, unit),
        curves=tuple(curves),
    )
