"""The numbers of reduced swipes as rows of a table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.recordings.transitions.estimate import Interval, none
from electrovib.recordings.transitions.table import TimeRow

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.swipe.baseline import Estimate
    from electrovib.recordings.swipe.result import SwipeResult


def swipe_rows(swipes: Sequence[SwipeResult]) -> list[TimeRow]:
    """List the numbers of swipes."""
    rows = []
    for number, swipe in enumerate(swipes, start=1):
        group = f"swipe {number}" if len(swipes) > 1 else "swipe"
        note = "; ".join(text.removeprefix("Warning: ") for text in swipe.words if text.startswith("Warning"))
        for name, unit, found in (
            ("friction", "1", swipe.friction),
            ("normal force", "N", swipe.normal_force),
            ("lateral force", "N", swipe.lateral_force),
        ):
            rows.append(TimeRow(group=group, name=name, unit=unit, number=_interval(found), note=note))
        measured = swipe.distance is not None
        for name, unit, value in (("speed", "m/s", swipe.speed), ("distance", "m", swipe.distance)):
            if value is not None:
                how = "from the position" if measured else "as declared"
                rows.append(TimeRow(group=group, name=name, unit=unit, number=none(value, how)))
    return rows


def _interval(found: Estimate) -> Interval:
    lower, upper = found.interval
    return Interval(
        value=found.value,
        lower=lower,
        upper=upper,
        standard_error=found.standard_error,
        scatter=math.nan,
        method="choices of the zero of the sensors, and scatter within the window",
    )
