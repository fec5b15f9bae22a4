"""Reduced swipes as results: the forces over time with the windows, the numbers and the choices of the zero."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel, Table
from electrovib.core.deprecation import former_attribute
from electrovib.core.units import format_quantity
from electrovib.data.marks import Form
from electrovib.recordings.interval import Interval, NumberRow, numbers_csv, numbers_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray

    from electrovib.core.arrays import Real


@dataclass(frozen=True, kw_only=True, repr=False)
class SwipeResult(Answer):
    """One swipe, reduced to forces and friction.

    - `normal_force`, `lateral_force`: means over the window [N]; the lateral force is positive in the
      direction of the friction of this swipe.
    - `direction`: 1 if the position increases, else -1; without a position, the sign of the lateral force.
    - `speed`, `distance`: mean speed in the window and sliding distance of the whole slide. Without a
      position the speed is the declared one; None if not known.
    - `remarks`: what was measured and what limits it, warnings first.
    - `trace`: whole record, with the baseline of this swipe subtracted.
    """

    FILES: ClassVar = {"swipes.csv": Form.TABLE}
    normal_force: Interval
    lateral_force: Interval
    friction: Interval
    direction: int
    speed: float | None
    distance: float | None
    contact: tuple[float, float]
    window: tuple[float, float]
    remarks: tuple[str, ...]
    trace: xarray.Dataset
    words = former_attribute("words", "document", lambda self: self.remarks)

    @property
    def document(self) -> Document:
        """Friction and forces, the windows, and the choices of the zero."""
        return Swipes((self,)).document

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        return Swipes((self,)).content(name)

    @property
    def warnings(self) -> list[str]:
        """What makes the numbers doubtful."""
        return [text for text in self.remarks if text.startswith("Warning")]

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and texts for JSON, in SI, without the Trace."""
        return {
            **{name: plain(getattr(self, name)) for name in ("normal_force", "lateral_force", "friction")},
            "direction": self.direction,
            "speed": self.speed,
            "distance": self.distance,
            "contact": list(self.contact),
            "window": list(self.window),
            "words": list(self.remarks),
        }


class Swipes(Answer, tuple[SwipeResult, ...]):
    """All swipes of a recording, in the order of time."""

    __slots__ = ()
    FILES: ClassVar = {"swipes.csv": Form.TABLE}

    @property
    def document(self) -> Document:
        """Friction and forces of each swipe, the windows, and the choices of the zero."""
        many = len(self) > 1
        numbered = list(enumerate(self, start=1))
        return Document(
            title=f"{'Swipes' if many else 'Swipe'} in {Path(self[0].trace.attrs['source']).name}",
            sentences=[text for each in self for text in (_sentence(each), *each.warnings)],
            numbers=[numbers_table("Friction and forces", swipe_rows(self))],
            figures=[
                panel
                for number, each in numbered
                for panel in _panels(
                    each,
                    f" of swipe {number}" if many else " of the swipe",
                    id=f"swipe{number if many else ''}",
                )
            ],
            tables=[_zeros(self)],
            remarks=[
                f"{f'Swipe {number}: ' * many}{text}"
                for number, each in numbered
                for text in each.remarks
                if text not in each.warnings
            ],
        )

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        del name
        return numbers_csv(swipe_rows(self))


def plain(found: Interval) -> dict[str, Any]:
    """Return plain numbers for JSON."""
    return {
        "value": found.value,
        "interval": list(found.ends),
        "baseline_interval": list(found.choice_ends),
        "by_baseline": dict(found.choices),
        "standard_error": found.standard_error,
    }


def swipe_rows(swipes: Sequence[SwipeResult]) -> list[NumberRow]:
    """List the numbers of swipes."""
    rows = []
    for number, swipe in enumerate(swipes, start=1):
        group = f"swipe {number}" if len(swipes) > 1 else "swipe"
        note = "; ".join(text.removeprefix("Warning: ") for text in swipe.warnings)
        how = "from the position" if swipe.distance is not None else "as declared"
        found = [
            ("friction", "1", swipe.friction, note),
            ("normal force", "N", swipe.normal_force, note),
            ("lateral force", "N", swipe.lateral_force, note),
            *(
                (name, unit, Interval(value=value, method=how), "")
                for name, unit, value in (("speed", "m/s", swipe.speed), ("distance", "m", swipe.distance))
                if value is not None
            ),
        ]
        rows += [
            NumberRow(group=group, name=name, unit=unit, number=each, note=note)
            for name, unit, each, note in found
        ]
    return rows


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
    return Curve(label=label, x=time, y=values)


def _sentence(swipe: SwipeResult) -> str:
    lower, upper = swipe.friction.ends
    speed = f" at {format_quantity(swipe.speed, 'm/s', digits=3)}" if swipe.speed else ""
    load = format_quantity(swipe.normal_force.value, "N", digits=3)
    return f"Friction {swipe.friction.value:.3f} ({lower:.3f} to {upper:.3f}) under {load}{speed}."


def _zeros(swipes: Sequence[SwipeResult]) -> Table:
    rows = tuple(
        (
            f"swipe {number}",
            name,
            f"{each.friction.choices[name]:.4g}",
            format_quantity(each.normal_force.choices[name], "N", digits=4),
            format_quantity(each.lateral_force.choices[name], "N", digits=4),
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
