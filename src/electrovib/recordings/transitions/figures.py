"""Edges and oscillations as figures, and the forms of relaxation that were compared as a table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Panel, Table

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.transitions.directions import DirectionTimes
    from electrovib.recordings.transitions.ring import MeasuredRing

REFERENCES: Final = (
    "IEEE Std 181-2011, Transitions, Pulses, and Related Waveforms",
    "K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed., Springer, 2002",
)
MOST_FIGURES: Final = 3
"""Most edges or oscillations that are drawn."""
_AFTER: Final = 8.0
"""Length of the drawn section after an edge, in times between the levels as recorded."""


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


def ring_panel(ring: MeasuredRing, number: int) -> Panel:
    """Make the figure of one oscillation with its best form."""
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
