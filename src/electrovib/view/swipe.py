"""Reduced swipes as a page: the forces over time with the windows, the numbers and the choices of the zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Page, Panel, Table
from electrovib.data.marks import Form
from electrovib.recordings.swipe.reduce import swipe_rows
from electrovib.view.lines import envelope
from electrovib.view.times import numbers_csv, numbers_table
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.swipe import SwipeResult


@dataclass(frozen=True, kw_only=True, repr=False)
class SwipesAnswer(Answer):
    """Reduced swipes; `source` names the recording."""

    FILES: ClassVar = {"swipes.csv": Form.TABLE}
    swipes: Sequence[SwipeResult]
    source: str = ""

    @property
    def document(self) -> Document:
        """Friction and forces of each swipe, the windows, and the choices of the zero."""
        swipes, many = self.swipes, len(self.swipes) > 1
        return Document(
            title=f"{'Swipes' if many else 'Swipe'}{f' in {self.source}' if self.source else ''}",
            sentences=[" ".join(text for each in swipes for text in _answer(each))],
            figures=[_panel(each, number if many else 0) for number, each in enumerate(swipes, start=1)],
            tables=[numbers_table("Friction and forces", swipe_rows(swipes)), _zeros(swipes)],
            pages=[
                Page(f"Limits of swipe {number}" if many else "Limits", each.words)
                for number, each in enumerate(swipes, start=1)
            ],
        )

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        del name
        return numbers_csv(swipe_rows(self.swipes))


def _panel(swipe: SwipeResult, number: int) -> Panel:
    """Make the figure of a swipe: both forces of the record, with the window over which they are averaged."""
    time = np.asarray(swipe.trace["time"].values)
    before, after = swipe.contact
    margin = 0.3 * (after - before)
    near = (time >= before - margin) & (time <= after + margin)
    window = (time >= swipe.window[0]) & (time <= swipe.window[1])
    curves = []
    for look, name in enumerate(("normal_force_measured", "lateral_force_measured")):
        values, label = np.asarray(swipe.trace[name].values), name.removesuffix("_measured").replace("_", " ")
        x, y = envelope(time[near], values[near])
        curves.append(Curve(label=label, x=x, y=y, look=REFERENCE))
        x, y = envelope(time[window], values[window])
        curves.append(Curve(label=f"{label} in the window", x=x, y=y, look=look))
    return Panel(
        id=f"swipe{number or ''}",
        title=f"Forces of swipe {number}" if number else "Forces of the swipe",
        caption="Grey: the record, with the zero of the sensors subtracted. Colour: the window over which it is averaged.",
        x=("time", "s"),
        y=("force", "N"),
        curves=tuple(curves),
    )


def _answer(swipe: SwipeResult) -> list[str]:
    lower, upper = swipe.friction.ends
    said = [
        f"Friction {swipe.friction.value:.3f} ({lower:.3f} to {upper:.3f}) under"
        f" {pretty_quantity(swipe.normal_force.value, 'N', digits=3)}"
        + (f" at {pretty_quantity(swipe.speed, 'm/s', digits=3)}." if swipe.speed else ".")
    ]
    return said + [text for text in swipe.words if text.startswith("Warning")]


def _zeros(swipes: Sequence[SwipeResult]) -> Table:
    rows = tuple(
        (
            f"swipe {number}",
            name,
            f"{each.friction.choices[name]:.4g}",
            pretty_quantity(each.normal_force.choices[name], "N", digits=4),
            pretty_quantity(each.lateral_force.choices[name], "N", digits=4),
        )
        for number, each in enumerate(swipes, start=1)
        for name in each.friction.choices
    )
    return Table(
        "Choice of the zero",
        ("Swipe", "Zero of the sensors", "Friction", "Normal force", "Lateral force"),
        rows,
        caption="Before or after the contact, their mean, or interpolated in time between them.",
    )
