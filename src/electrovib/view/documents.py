"""Answers as pages, figures and files: one HTML page, one file of the numbers, or a folder with all of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Drawing, Panel
from electrovib.core.errors import InputError
from electrovib.core.files import kind_of
from electrovib.data.atomic import check_folder, check_writable, output_path, write_folder, writing
from electrovib.data.marks import Form, unsigned
from electrovib.view.style import MOST

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from markupsafe import Markup
    from matplotlib.figure import Figure

    from electrovib.core.answer import Answer, Curve, Document, Shown

PAGE: Final = "report.html"
"""Name of the page in a folder."""
PANEL_SIZE: Final = (8.2, 4.3)
"""Width and height of a figure of a page [inch]."""
BELOW: Final = 1.6
"""What each panel below adds to the height [inch]."""


def check_answer(
    kind: type[Answer],
    path: str | Path,
    *,
    more: Mapping[str, str | None] | None = None,
    inputs: Iterable[Path] = (),
    force: bool = False,
) -> None:
    """Check, before a long computation, that an answer of this kind can be written; `more` are files of what was asked for."""
    place = output_path(path)
    if _is_file(place):
        check_writable({place: _single(kind.FILES, place, drawn=kind.DRAWN)[1]}, inputs=inputs, force=force)
    else:
        check_folder(place, _forms({**kind.FILES, **(more or {})}), inputs=inputs, force=force)


def save_answer(found: Answer, path: str | Path, *, force: bool = False) -> list[Path]:
    """Write an answer: ``.html``, the suffix of one of its files or of a figure; without a suffix a folder with all.

    All files are written, or none. A figure carries no mark, so only `force` replaces one.
    """
    place = output_path(path)
    if not _is_file(place):
        contents = {PAGE: html(found.document)} | {name: found.content(name) for name in found.files}
        return write_folder(place, contents, _forms(found.files), force=force)
    name, form = _single(found.files, place, drawn=found.DRAWN)
    if name == PAGE:
        content: str | bytes = html(found.document)
    else:
        content = found.content(name) if name else _picture(found.document, place.suffix.lower())
    with writing({place: form}, force=force) as temporary:
        temporary[place].write_bytes(content.encode() if isinstance(content, str) else content)
    return [place]


def _is_file(place: Path) -> bool:
    """Return whether a path names a file: it has the suffix of one, and is not there as a folder."""
    return place.suffix[1:].isalpha() and kind_of(place) != "folder"


def _forms(files: Mapping[str, str | None]) -> dict[str, Form | None]:
    """Return the names of the files of a folder, and their forms."""
    return {PAGE: Form.PAGE} | {name: None if form is None else Form(form) for name, form in files.items()}


def _single(files: Mapping[str, str | None], place: Path, *, drawn: bool) -> tuple[str, Form | None]:
    """Return the name in the folder, empty for a figure, and the form of a file with this suffix."""
    forms = _forms(files)
    suffixes = [Path(name).suffix for name in forms]
    known = {
        suffix: each
        for suffix, each in zip(suffixes, forms.items(), strict=True)
        if suffixes.count(suffix) == 1
    }
    known |= dict.fromkeys((".png", ".svg") if drawn else (), ("", None))
    suffix = {".htm": ".html"}.get(place.suffix.lower(), place.suffix.lower())
    if suffix not in known:
        why = f"this result is written as {', '.join(known)}, or without a suffix as a folder, not as '{place.suffix}'"
        raise InputError(why, path=place)
    return known[suffix]


def _picture(document: Document, suffix: str) -> bytes:
    from electrovib.view.pages import to_png, to_svg

    figure = drawn(document.figures[0])
    return to_png(figure) if suffix == ".png" else to_svg(figure).encode()


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
    parts = [
        few_curves(each) if isinstance(each, Panel) and each.id not in made else (each,)
        for each in document.figures
    ]
    figures = [on_page(each, figure=made.get(each.id)) for some in parts for each in some]
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
            curves=tuple(sorted(chain(beside, *part), key=lambda each: each.kind == "points")),
        )
        for number, part in enumerate(parts, start=1)
    )


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
