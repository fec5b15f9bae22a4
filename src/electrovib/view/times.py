"""Measured times as a folder: a page with edges, fits and table, and the numbers as CSV."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Page, Panel, Table
from electrovib.data.marks import Form, csv_text
from electrovib.recordings.transitions.ring import ring_rows
from electrovib.recordings.transitions.times import time_rows
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.interval import Interval, NumberRow
    from electrovib.recordings.transitions import MeasuredRing, MeasuredRings, MeasuredTimes
    from electrovib.recordings.transitions.directions import DirectionTimes


REFERENCES: Final = (
    "IEEE Std 181-2011, Transitions, Pulses, and Related Waveforms",
    "K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed., Springer, 2002",
)


@dataclass(frozen=True, kw_only=True, repr=False)
class TimesAnswer(Answer):
    """Times and oscillations of one signal; `source` names the recording."""

    FILES: ClassVar = {"times.csv": Form.TABLE}
    found: MeasuredTimes | None
    rings: MeasuredRings | None = None
    source: str = ""

    @property
    def document(self) -> Document:
        """Times of each direction, oscillations, edges with their fits, and limits."""
        found, rings = self.found, self.rings
        directions = () if found is None else found.directions
        known = [each for each in (found, rings) if each is not None]
        signal = next(each.signal for each in (found, *(rings.rings if rings else ())) if each is not None)
        named = f"{signal.replace('_', ' ')}{f' in {self.source}' if self.source else ''}"
        words = tuple(text for each in known for text in each.words)
        return Document(
            title=f"{'Oscillations' if found is None else 'Times'} of {named}",
            sentences=[_answer(found, rings)],
            figures=times_panels(found, rings),
            tables=[
                numbers_table("Times and parameters", rows_of(found, rings), first="Edges"),
                *(_criteria(each) for each in directions),
            ],
            pages=[Page("Limits", words)] if words else [],
            references=REFERENCES,
        )

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        del name
        return numbers_csv(rows_of(self.found, self.rings))


def rows_of(found: MeasuredTimes | None, rings: MeasuredRings | None) -> list[NumberRow]:
    """List the numbers of a measurement."""
    return [*(time_rows(found) if found else ()), *(ring_rows(rings) if rings else ())]


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
            elif math.isfinite(own.lower):
                text += f" and {_interval(own, 's')} with the sensor taken out"
            limit = pretty_quantity(each.sensor_limit, "s", digits=3)
            text += f"; an instantaneous change would show {limit} through this sensor"
        said.append(f"{text}.")
        said += [words for words in each.words if words.startswith("Warning")]
    return said


def _interval(number: Interval, unit: str = "") -> str:
    value, ends = number.texts(unit, digits=3, write=pretty_quantity)
    return f"{value} ({ends})" if ends else f"{value}{' (no interval)' * (not number.is_bound)}"


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
            Curve(label="record", x=ring.time, y=ring.values, kind="points", look=REFERENCE),
            Curve(label=ring.form, x=ring.time, y=ring.model),
        ),
    )


def _panel(found: DirectionTimes, words: str, unit: str, *, sensor: bool) -> Panel:
    most = _MOST_EDGES - sensor  # each has two lines then
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


def numbers_csv(rows: Sequence[NumberRow]) -> str:
    """Write the table as CSV, in SI units, with full precision."""
    names = ("value", "lower", "upper", "standard_error", "scatter", "count", "method")
    cells = [
        (row.group, row.name, row.unit, *(getattr(row.number, name) for name in names), row.note)
        for row in rows
    ]
    return csv_text(("group", "name", "unit", *names, "note"), cells)


def numbers_table(title: str, rows: Sequence[NumberRow], *, first: str = "") -> Table:
    """Write the table for a page, `first` being the heading of the groups."""
    shown = []
    for row in rows:
        unit, number = row.unit if row.unit != "1" else "", row.number
        value, ends = number.texts(unit, digits=4, write=pretty_quantity)
        if not math.isfinite(number.value) and not number.is_bound:
            value = "none"
        known = math.isfinite(number.scatter)
        scatter = pretty_quantity(number.scatter, unit, digits=4) if known else "none"
        shown.append((row.group, row.name, value, ends or "none", scatter, number.method, row.note))
    headings = (first, "Quantity", "Value", "95 % interval", "Scatter", "Interval from", "Note")
    return Table(title, headings, tuple(shown))
