"""The page of a reproduced paper, and the parts that other pages share with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from electrovib.study.reproduction import COMPARED
from electrovib.view.units import pretty_unit

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

    from electrovib.study.reproduction import Panel, Reproduction, Row
    from electrovib.view.report_figures import PageFigure

PANEL_SIZE: Final = (8.2, 4.3)
"""Width and height of a figure of a page [inch]."""


def page_of(found: Reproduction, drawings: Mapping[str, str], *, curves: bool = False) -> str:
    """Write the page of a reproduction."""
    from electrovib.view import summary
    from electrovib.view.pages import page

    return page(
        "reproduction.html.jinja",
        judged={"": found.diagnostics},
        title=found.title or f"{found.paper}: the paper, reproduced",
        found=found,
        count=found.count(),
        compared=[_cells(row) for row in found.ordered if row.verdict in COMPARED],
        ours=[_cells(row) for row in found.ordered if row.verdict == "ours"],
        checks=[_cells(row) for row in found.ordered if row.verdict == "check"],
        equations={number: equation(text, number) for number, text in found.equations.items()},
        figures=page_figures(found.panels, drawings, curves=curves),
        tables=[table for table in found.tables if table.on_page],
        versions=summary.versions(),
    )


def page_figures(
    panels: Sequence[Panel], drawings: Mapping[str, str], *, curves: bool = False
) -> list[PageFigure]:
    """Put panels and their SVG into the form of a page; with `curves` those of each figure lie beside it as CSV."""
    from electrovib.view.pages import markup
    from electrovib.view.report_figures import PageFigure
    from electrovib.view.svg import inline

    return [
        PageFigure(
            panel.title,
            markup(inline(drawings[panel.id], name=panel.id, words=panel.title)),
            f"{panel.caption} {_file(panel)}" if curves else panel.caption,
        )
        for panel in panels
    ]


def _file(panel: Panel) -> str:
    """Name the file of the curves, and mark one that has more of them than the figure."""
    more = any(not curve.drawn for curve in panel.curves)
    return f"{'All curves' if more else 'Curves'}: {panel.id}.csv"


def _cells(row: Row) -> dict[str, str]:
    """Write a row for the page, with what the paper states as a number or else in its words."""
    printed = shown(row.paper, row.unit)
    return {
        "verdict": row.verdict,
        "what": row.what,
        "paper": f"in words: {row.stated}" if row.stated and row.paper is None else printed,
        "ours": shown(row.ours, row.unit),
        "note": row.brief or row.note,
    }


def drawn(panel: Panel) -> Figure:
    """Draw one panel, with its title."""
    from electrovib.view import plots
    from electrovib.view.style import new_figure, style

    figure = new_figure(PANEL_SIZE)
    with style():
        plots.panel(panel, ax=figure.add_subplot())
    return figure


def shown(value: float | tuple[float, float] | None, unit: str) -> str:
    """Write a number or an interval in the unit of its row."""
    if value is None:
        return "not printed"
    numbers = value if isinstance(value, tuple) else (value,)
    digits = 3 if isinstance(value, tuple) else 4
    text = " … ".join(f"{number:.{digits}g}" for number in numbers)
    return f"{text} {pretty_unit(unit)}".strip()


def equation(text: str, number: str) -> Any:
    """Draw a formula written in mathtext; one that cannot be drawn is shown as it is written."""
    from electrovib.view.pages import markup
    from electrovib.view.style import new_figure, style
    from electrovib.view.svg import inline, to_svg

    written = (text if "$" in text else f"${text}$").replace(
        r"\frac", r"\dfrac"
    )  # legible in a line of its own
    figure = new_figure((6.0, 1.0))
    try:
        with style():
            figure.text(0, 0.5, written, fontsize=13, math_fontfamily="stix", color="#222222")
        svg = to_svg(figure, tight=True)
    except ValueError:
        return text
    return markup(inline(svg, name=f"equation{number}", words=f"Equation {number}: {text}"))
