"""Figures of at most five curves: equal ones share a line, further ones have a figure of their own."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.study.reproduction import Curve, Panel

MOST: Final = 5
"""Curves of one figure."""
_SAME, _SAME_OVER_DECADES = 0.02, 0.1
"""Largest relative difference of curves that share a line: on a linear axis, and on a logarithmic one."""


def few_curves(panel: Panel) -> tuple[Panel, ...]:
    """Split a panel into panels of at most five curves, each beginning with the first curve; equal ones share a line.

    Curves are equal that differ nowhere by more than 2 %, or 10 % on a logarithmic axis.
    """
    same = _SAME_OVER_DECADES if panel.log_y else _SAME
    groups = _groups([curve for curve in panel.curves if curve.kind != "points"], same)
    points = [curve for curve in panel.curves if curve.kind == "points"]
    merged = [replace(group[0], label=_names(group)) for group in groups]
    looks = [{curve.look for curve in group} for group in groups]
    further = range(MOST, len(merged), MOST - 1)
    parts = [
        list(range(min(MOST, len(merged)))),
        *([0, *range(start, min(start + MOST - 1, len(merged)))] for start in further),
    ]
    if len(parts) == 1:
        return (replace(panel, curves=(*merged, *points)),)
    found = []
    for number, part in enumerate(parts, start=1):
        own = set().union(*(looks[index] for index in part))
        curves = (*(merged[index] for index in part), *(curve for curve in points if curve.look in own))
        title = f"{panel.title}, {number} of {len(parts)}"
        found.append(replace(panel, id=f"{panel.id}_{number}", title=title, curves=curves))
    return tuple(found)


def _groups(curves: Sequence[Curve], same: float) -> list[list[Curve]]:
    """Put curves that lie on each other everywhere into one group, in the order of the first of each."""
    groups: list[list[Curve]] = []
    for curve in curves:
        group = next((each for each in groups if _equal(each[0], curve, same)), None)
        if group is None:
            groups.append([curve])
        else:
            group.append(curve)
    return groups


def _equal(one: Curve, other: Curve, same: float) -> bool:
    return bool(
        np.array_equal(one.x, other.x)
        and one.upper is None
        and other.upper is None
        and np.allclose(one.y, other.y, rtol=same, atol=0.0)
    )


def _names(group: Sequence[Curve]) -> str:
    return ",\n".join(curve.label for curve in group)
