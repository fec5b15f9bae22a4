"""Candidates of a plate: one objective over another, with the Pareto set."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.view.plots.legends import legend_beside_no_curve
from electrovib.view.style import COLOURS, NEUTRAL, drawing
from electrovib.view.units import label_axis

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from electrovib.study.design.plate import PlateCandidate, PlateDesign

SIZE: Final = (7.2, 4.4)
"""Width and height of the figure [inch]."""
MOST_LIMITS: Final = 2
"""Limits that have a sign of their own; candidates that others forbid share one."""
_WIDE: Final = 30.0
"""Ratio of largest to smallest value from which a scale is logarithmic."""
_SIGNS: Final = ("x", "+", "1")


def trade_off(design: PlateDesign, *, ax: Axes | None = None) -> Axes:
    """Draw the first objective of a design over the second, for every candidate.

    Parameters
    ----------
    design : PlateDesign
        From `electrovib.design_plate`.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI. With one objective it is drawn over the first varied parameter. Candidates without a finite number are
        omitted; a scale is logarithmic where the values span more than a factor of 30.
    """
    first = design.objectives[0]
    across = _across(design)
    points = [(each, _abscissa(each, across[0]), each.values[first.name]) for each in design.candidates]
    known = [point for point in points if math.isfinite(point[1]) and math.isfinite(point[2])]
    with drawing(ax, SIZE) as axes:
        handles, labels = [], []
        for label, colour, sign, chosen in _groups(design):
            kept = {id(each) for each in chosen}
            some = np.array([(x, y) for each, x, y in known if id(each) in kept]).reshape(-1, 2)
            if not len(some):
                continue
            handles += axes.plot(*some.T, linestyle="", marker=sign, markersize=3.5, color=colour, zorder=2)
            labels.append(f"{label}: {len(some)}")
        _front(axes, design, across[0], handles, labels)
        if not known:
            axes.text(0.5, 0.5, "no numbers to draw", transform=axes.transAxes, ha="center", va="center")
        for values, scale in (
            ([x for _, x, _ in known], axes.set_xscale),
            ([y for *_, y in known], axes.set_yscale),
        ):
            if values and min(values) > 0 and max(values) > _WIDE * min(values):
                scale("log")
        label_axis(axes.xaxis, *across[1:])
        label_axis(axes.yaxis, first.name if "." in first.name else first.name.replace("_", " "), first.unit)
        axes.set_title(f"Candidates within and beyond the limits: {len(design.candidates)}")
        if handles:
            legend_beside_no_curve(axes, handles, labels, "")
        return axes


def _across(design: PlateDesign) -> tuple[str, str, str]:
    """Return the name of the abscissa, its words and its unit."""
    if len(design.objectives) > 1:
        second = design.objectives[1]
        words = second.name if "." in second.name else second.name.replace("_", " ")
        return second.name, words, second.unit
    path = next(iter(design.axes), "")
    return path, path or "candidate", design.units.get(path, "1")


def _abscissa(candidate: PlateCandidate, name: str) -> float:
    return float(candidate.values.get(name, candidate.at.get(name, math.nan)))


def _groups(design: PlateDesign) -> list[tuple[str, str, str, Sequence[PlateCandidate]]]:
    """Return label, colour and sign of the candidates by what forbids them; at most four groups."""
    forbidden = [each for each in design.candidates if not each.is_allowed]
    alone = Counter(each.forbidden_by[0] for each in forbidden if len(each.forbidden_by) == 1)
    named = [name for name, _ in alone.most_common(MOST_LIMITS)]
    groups: list[tuple[str, str, str, Sequence[PlateCandidate]]] = []
    rest = [each for each in forbidden if each.forbidden_by not in {(name,) for name in named}]
    if rest:
        words = "forbidden by several or other limits" if named else "forbidden by several limits"
        groups.append((words, "#bdbdbd", _SIGNS[-1], rest))
    for place, name in enumerate(named):
        some = [each for each in forbidden if each.forbidden_by == (name,)]
        groups.append((f"forbidden by {name} alone", (NEUTRAL, COLOURS[3])[place], _SIGNS[place], some))
    groups.append(("within the limits", COLOURS[0], "o", design.allowed))
    return groups


def _front(axes: Axes, design: PlateDesign, across: str, handles: list[Any], labels: list[str]) -> None:
    """Draw the Pareto set as a line, and mark the best candidate."""
    first = design.objectives[0].name
    if len(design.objectives) == 2 and design.pareto:
        points = np.array([(_abscissa(each, across), each.values[first]) for each in design.pareto])
        points = points[np.all(np.isfinite(points), axis=1)]
        points = points[np.argsort(points[:, 0])]
        handles += axes.plot(*points.T, color=COLOURS[1], marker="o", markersize=4, zorder=3)
        labels.append(f"Pareto set: {len(points)}")
    if design.best is not None:
        place = _abscissa(design.best, across), design.best.values[first]
        if all(map(math.isfinite, place)):
            axes.plot(
                *place,
                linestyle="",
                marker="*",
                markersize=13,
                color=COLOURS[1],
                markeredgecolor="#222222",
                zorder=4,
            )
            axes.annotate("best", place, textcoords="offset points", xytext=(-9, 6), ha="right")
