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
                    each,
                    f" of swipe {number}" if many else " of the swipe",
                    id=f"swipe{number if many else ''}",
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
    time, normal, lateral = (
        np.asarray(swipe.trace[name].values)
        for name in ("time", "normal_force_measured", "lateral_force_measured")
    )
    margin = 0.3 * (swipe.contact[1] - swipe.contact[0])
    near = (time >= swipe.contact[0] - margin) & (time <= swipe.contact[1] + margin)
    inside = (time >= swipe.window[0]) & (time <= swipe.window[1]) & (normal != 0)
    ends: dict[str, Any] = {"x": np.array(swipe.window), "look": REFERENCE}
    top, mean = (np.full(2, value) for value in (normal[near].max(), swipe.friction.value))
    return [
        Panel(
            id=id,
            title=f"Forces{of}",
            caption="The zero of the sensors is subtracted. Grey: the time over which both are averaged.",
            x=("time", "s"),
            y=("force", "N"),
            curves=(
                Curve(label="averaged", y=0 * top, upper=top, kind="band", **ends),
                _line("normal force", time[near], normal[near]),
                _line("lateral force", time[near], lateral[near]),
            ),
        ),
        Panel(
            id=f"{id}_friction",
            title=f"Friction{of}",
            caption="Lateral over normal force at each sample of the time averaged over, and the friction of the swipe.",
            x=("time", "s"),
            y=("friction", "1"),
            curves=(
                _line("at each sample", time[inside], np.abs(lateral[inside] / normal[inside])),
                Curve(label="of the swipe", y=mean, kind="dashed", **ends),
            ),
        ),
    ]


def _line(label: str, time: Real, values: Real) -> Curve:
    x, y = envelope(time, values)
    return Curve(label=label, x=x, y=y)


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
