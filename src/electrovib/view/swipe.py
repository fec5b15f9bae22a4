"""Reduced swipes as a page: the forces over time with the windows, the numbers and the choices of the zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Page, Panel, Table
from electrovib.data.marks import Form
from electrovib.recordings.swipe.reduce import swipe_rows
from electrovib.view.lines import envelope
from electrovib.view.times import numbers_csv, numbers_table
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
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
            figures=[
                panel
                for number, each in enumerate(swipes, start=1)
                for panel in _panels(
                    each, f" of swipe {number}" if many else "", id=f"swipe{number if many else ''}"
                )
            ],
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


def _panels(swipe: SwipeResult, of: str, *, id: str) -> list[Panel]:  # noqa: A002 - the name of the field
    """Make the figures of a swipe over time: both forces of the record, and their quotient in the window of the averages."""
    time = np.asarray(swipe.trace["time"].values)
    normal, lateral = (
        np.asarray(swipe.trace[f"{name}_force_measured"].values) for name in ("normal", "lateral")
    )
    before, after = swipe.contact
    margin = 0.3 * (after - before)
    near = (time >= before - margin) & (time <= after + margin)
    first, last = swipe.window
    inside = (time >= first) & (time <= last) & (normal != 0)
    shared: dict[str, Any] = {"x": ("time", "s")}
    window = Curve(
        label="window of the averages",
        x=np.array([first, last]),
        y=np.full(2, min(0.0, normal[near].min(), lateral[near].min())),
        upper=np.full(2, max(normal[near].max(), lateral[near].max())),
        kind="band",
        look=REFERENCE,
    )
    forces = (
        _line("normal force", time[near], normal[near], 0),
        _line("lateral force", time[near], lateral[near], 1),
    )
    mean = Curve(
        label="mean force over mean force",
        x=window.x,
        y=np.full(2, swipe.friction.value),
        kind="dashed",
        look=REFERENCE,
    )
    quotient = _line("lateral over normal force", time[inside], np.abs(lateral[inside] / normal[inside]), 2)
    return [
        Panel(
            id=id,
            title=f"Forces{of or ' of the swipe'}",
            caption="Both forces with the zero of the sensors subtracted; grey: the time over which they are averaged.",
            y=("force", "N"),
            curves=(window, *forces),
            **shared,
        ),
        Panel(
            id=f"{id}_friction",
            title=f"Friction{of or ' of the swipe'}",
            caption="The quotient of both forces at each sample of the window, and the friction coefficient of the swipe.",
            y=("coefficient of friction", "1"),
            curves=(quotient, mean),
            **shared,
        ),
    ]


def _line(label: str, time: Real, values: Real, look: int) -> Curve:
    x, y = envelope(time, values)
    return Curve(label=label, x=x, y=y, look=look)


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
