"""An answer as a document: sentences, figures, tables and explanations, written as one page.

A kind of result states what it says as a `Document`; how that looks is decided here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from electrovib.study.reproduction import Panel

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.study.reproduction import Page, Table
    from electrovib.view.report_figures import PageFigure

PANEL_SIZE: Final = (8.2, 4.3)
"""Width and height of a figure of a page [inch]."""


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """A figure that a function draws into Axes; `id` is the name of its elements on the page."""

    id: str
    title: str
    draw: Callable[[Axes], Any]
    caption: str = ""
    size: tuple[float, float] = PANEL_SIZE


Shown: TypeAlias = Panel | Drawing
"""A figure as data, or with its own function."""


@dataclass(frozen=True, kw_only=True)
class Document:
    """What an answer shows: its sentences first, the diagnostics of what it was computed from beside them.

    `note` says what the diagnostics do not cover.
    """

    title: str
    answer: str
    diagnostics: Sequence[Diagnostic] = ()
    note: str = ""
    figures: Sequence[Shown] = ()
    tables: Sequence[Table] = ()
    pages: Sequence[Page] = ()
    references: Sequence[str] = ()


def html(document: Document) -> str:
    """Write a document as one HTML page that fetches nothing."""
    from electrovib.view import summary
    from electrovib.view.pages import page

    return page(
        "comparison.html.jinja",
        judged={"": document.diagnostics},
        judged_note=document.note,
        title=document.title,
        answer=document.answer,
        figures=[on_page(each) for each in document.figures],
        tables=document.tables,
        pages=document.pages,
        references=document.references,
        versions=summary.versions(),
    )


def on_page(shown: Shown, *, figure: Figure | None = None, more: str = "") -> PageFigure:
    """Put a figure, drawn already or not, into a page, where its title is a heading; `more` follows its caption."""
    from electrovib.view.pages import markup
    from electrovib.view.report_figures import PageFigure
    from electrovib.view.svg import inline, to_svg

    figure = figure or drawn(shown)
    figure.axes[0].set_title("", loc="left")
    svg = inline(to_svg(figure), name=shown.id, words=shown.title)
    return PageFigure(shown.title, markup(svg), f"{shown.caption} {more}".strip())


def drawn(shown: Shown) -> Figure:
    """Draw a figure, with its title."""
    from electrovib.view import plots
    from electrovib.view.style import new_figure, style

    figure = new_figure(shown.size if isinstance(shown, Drawing) else PANEL_SIZE)
    with style():
        if isinstance(shown, Drawing):
            shown.draw(figure.add_subplot())
        else:
            plots.panel(shown, ax=figure.add_subplot())
    return figure
