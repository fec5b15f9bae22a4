"""Answers as pages: one HTML file with every figure, drawn here."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Drawing, Panel
from electrovib.data.marks import Form, unsigned
from electrovib.view.style import MOST

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from markupsafe import Markup
    from matplotlib.figure import Figure

    from electrovib.core.answer import Curve, Document, Shown

PANEL_SIZE: Final = (8.2, 4.3)
"""Width and height of a figure of a page [inch]."""
BELOW: Final = 1.6
"""What each panel below adds to the height [inch]."""


@dataclass(frozen=True)
class PageFigure:
    """A figure in a page: heading, inline SVG, words below; opened by a click if `folded`."""

    title: str
    svg: Markup
    caption: str
    folded: bool = False


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
        pages=[
            on_page(each, figure=made.get(each.id)) if isinstance(each, (Panel, Drawing)) else each
            for each in document.pages
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
    picture = markup(inline(to_svg(figure), name=shown.id, words=words))
    return PageFigure(shown.title, picture, shown.caption, isinstance(shown, Panel) and shown.folded)


def drawn(shown: Shown) -> Figure:
    """Draw a figure, with its title."""
    from electrovib.view import plots
    from electrovib.view.style import new_figure, style

    if isinstance(shown, Panel):
        parts = (shown, *shown.below)
        figure = new_figure((PANEL_SIZE[0], PANEL_SIZE[1] + BELOW * len(shown.below)))
        heights = [0.5 if shown.below else 1.0, *(1.0 for _ in shown.below)]
        with style():
            axes = figure.subplots(len(parts), sharex=True, squeeze=False, height_ratios=heights)[:, 0]
            for part, ax in zip(parts, axes, strict=True):
                plots.panel(part, ax=ax)
                ax.label_outer()
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


_SAME, _SAME_OVER_DECADES = 0.02, 0.1
"""Largest relative difference of curves that share a line: on a linear axis, and on a logarithmic one."""


def few_curves(panel: Panel) -> tuple[Panel, ...]:
    """Split a panel into panels of at most five things, each beginning with the first thing; equal lines share one.

    Curves of one look are one thing, which stays together. References, and points that are of no line, are in every panel.
    Lines are equal that differ nowhere by more than 2 %, or 10 % on a logarithmic axis.
    """
    shown = [
        replace(each, look=REFERENCE if each.background else at if each.look is None else each.look)
        for at, each in enumerate(curve for curve in panel.curves if curve.drawn)
    ]
    of_lines = {curve.look for curve in shown if curve.kind != "points"} - {REFERENCE}
    of_no_line = (each.look for each in shown if of_lines and each.kind == "points")
    apart = {REFERENCE, *of_no_line} - of_lines
    beside = [each for each in shown if each.look in apart]
    looks = dict.fromkeys(each.look for each in shown if each.look not in apart)
    things = [[curve for curve in shown if curve.look == look] for look in looks]
    found = _merged(things, _SAME_OVER_DECADES if panel.log_y else _SAME)
    further = [[found[0], *found[start : start + MOST - 1]] for start in range(MOST, len(found), MOST - 1)]
    parts = [found[:MOST], *further]
    return tuple(
        replace(
            panel,
            id=f"{panel.id}_{number}" if further else panel.id,
            title=f"{panel.title}, {number} of {len(parts)}" if further else panel.title,
            curves=tuple(sorted(chain(beside, *part), key=_height)),
        )
        for number, part in enumerate(parts, start=1)
    )


def _height(curve: Curve) -> tuple[bool, bool]:
    """Order bands below lines, these below the lines of references, and points on top."""
    return curve.kind == "points", curve.look == REFERENCE and curve.upper is None


def _merged(things: Sequence[list[Curve]], same: float) -> list[list[Curve]]:
    """Put things whose lines lie on each other everywhere into one, under all names, in the order of the first of each."""
    groups: list[list[list[Curve]]] = []
    for thing in things:
        group = next((each for each in groups if _equal(each[0], thing, same)), None)
        if group is None:
            groups.append([thing])
        else:
            group.append(thing)
    names = [",\n".join(thing[0].label for thing in group) for group in groups]
    points = [[curve for thing in group for curve in thing[1:]] for group in groups]
    return [
        [replace(group[0][0], label=name), *more]
        for group, name, more in zip(groups, names, points, strict=True)
    ]


def _equal(one: Sequence[Curve], other: Sequence[Curve], same: float) -> bool:
    """Return whether two things are a line each, with points or without, and the lines are equal."""
    first, second = one[0], other[0]
    return bool(
        all(each.kind == "points" for each in (*one[1:], *other[1:]))
        and all(each.kind != "points" and each.upper is None for each in (first, second))
        and np.array_equal(first.x, second.x)
        and np.allclose(first.y, second.y, rtol=same, atol=0.0)
    )
