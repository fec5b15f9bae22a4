"""Figures of measured times as data: edges with their fits, and the oscillation after an edge."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.study.reproduction import REFERENCE, Curve, Panel

if TYPE_CHECKING:
    from electrovib.recordings.transitions import MeasuredRing, MeasuredRings, MeasuredTimes
    from electrovib.recordings.transitions.times import DirectionTimes

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
