"""Answers as pages: one HTML file with every figure, drawn here."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.answer import Drawing, Panel
from electrovib.data.marks import Form, unsigned

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from markupsafe import Markup
    from matplotlib.figure import Figure

    from electrovib.core.answer import Curve, Document, Shown

PANEL_SIZE: Final = (8.2, 4.3)
"""Width and height of a figure of a page [inch]."""


@dataclass(frozen=True)
class PageFigure:
    """A figure in a page: heading, inline SVG, words below."""

    title: str
    svg: Markup
    caption: str


def html(document: Document, *, pictures: Mapping[str, Figure] | None = None) -> str:
    """Write a document as one HTML page that fetches nothing; `pictures` are figures that are drawn already, by their `id`."""
    from electrovib.view import summary
    from electrovib.view.pages import filled

    made = pictures or {}
    figures = [
        on_page(each, figure=made.get(each.id))
        for whole in document.figures
        for each in ((whole,) if whole.id in made else parts(whole))
    ]
    titles = ["", *(each.title for each in figures)]
    return filled(
        "page.html.jinja",
        mark=unsigned(Form.PAGE),
        said=document,
        judged={label: found for label, found in document.judged.items() if found},
        figures=[
            replace(each, title="" if each.title == before else each.title)
            for each, before in zip(figures, titles, strict=False)
        ],
        versions=summary.versions(),
    )


def parts(shown: Shown) -> tuple[Shown, ...]:
    """Split a figure into those that are drawn."""
    return few_curves(shown) if isinstance(shown, Panel) else (shown,)


def on_page(shown: Shown, *, figure: Figure | None = None) -> PageFigure:
    """Put a figure, drawn already or not, into a page, where its title is a heading."""
    from electrovib.view.pages import inline, markup, to_svg

    figure = figure or drawn(shown)
    words = shown.title
    if isinstance(shown, Drawing) and callable(shown.plot):
        words = shown.words or words
    else:
        figure.axes[0].set_title("", loc="left")
    return PageFigure(shown.title, markup(inline(to_svg(figure), name=shown.id, words=words)), shown.caption)


def drawn(shown: Shown) -> Figure:
    """Draw a figure, with its title."""
    from electrovib.view import plots
    from electrovib.view.style import new_figure, style

    if isinstance(shown, Panel):
        figure = new_figure(PANEL_SIZE)
        with style():
            plots.panel(shown, ax=figure.add_subplot())
        return figure
    plot = shown.plot
    if callable(plot):
        figure = new_figure(shown.size or PANEL_SIZE)
        with style():
            plot(figure)
        return figure
    figure = new_figure(shown.size or plots.SIZES[plot](shown.of))
    with style():
        getattr(plots, plot)(shown.of, **shown.options, ax=figure.add_subplot())
    return figure


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
