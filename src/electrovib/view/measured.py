"""Measured numbers as a folder: a page with figures and tables, and the numbers as CSV."""

from __future__ import annotations

import csv
import io
import math
from typing import TYPE_CHECKING

from electrovib.core.errors import InputError
from electrovib.data.marks import Form, unsigned
from electrovib.study.reproduction import Page, Panel, Table
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from electrovib.recordings.interval import NumberRow


def check_measured_folder(
    folder: Path, files: Mapping[str, Form], inputs: Sequence[Path], *, force: bool
) -> None:
    """Check, before the computation, that the folder can be written."""
    from electrovib.data.atomic import check_writable

    if folder.exists() and not folder.is_dir():
        raise InputError("is a file, where the folder of the results is to be made", path=folder)
    if folder.is_dir():
        check_writable({folder / name: form for name, form in files.items()}, inputs=inputs, force=force)


def write_measured(
    folder: Path, texts: Mapping[str, str], files: Mapping[str, Form], *, force: bool
) -> list[Path]:
    """Write texts into a folder, all files or none."""
    from electrovib.data.atomic import writing

    folder.mkdir(parents=True, exist_ok=True)
    outputs = {folder / name: files[name] for name in texts}
    with writing(outputs, force=force) as temporary:
        for path, text in zip(outputs, texts.values(), strict=True):
            temporary[path].write_text(text, encoding="utf-8")
    return list(outputs)


def numbers_csv(rows: Sequence[NumberRow]) -> str:
    """Write the table as CSV, in SI units, with full precision."""
    text = io.StringIO()
    text.write(f"# {unsigned(Form.TABLE)}\n")
    writer = csv.writer(text, lineterminator="\n")
    names = ("value", "lower", "upper", "standard_error", "scatter", "count", "method")
    writer.writerow(("group", "name", "unit", *names, "note"))
    for row in rows:
        cells = [getattr(row.number, name) for name in names]
        shown = [repr(cell) if isinstance(cell, float) else cell for cell in cells]
        writer.writerow((row.group, row.name, row.unit, *shown, row.note))
    return text.getvalue()


def numbers_table(title: str, rows: Sequence[NumberRow], *, first: str = "") -> Table:
    """Write the table for a page, `first` being the heading of the groups."""
    shown = []
    for row in rows:
        unit, number = row.unit if row.unit != "1" else "", row.number
        value, ends = number.texts(unit, digits=4, write=pretty_quantity)
        if not math.isfinite(number.value):
            value = "none"
        known = math.isfinite(number.scatter)
        scatter = pretty_quantity(number.scatter, unit, digits=4) if known else "none"
        shown.append((row.group, row.name, value, ends or "none", scatter, number.method, row.note))
    headings = (first, "Quantity", "Value", "95 % interval", "Scatter", "Interval from", "Note")
    return Table(title, headings, tuple(shown))


def measured_page(
    *,
    title: str,
    answer: str,
    panels: Sequence[Panel],
    tables: Sequence[Table],
    pages: Sequence[Page],
    references: Sequence[str] = (),
) -> str:
    """Write one page that needs nothing else."""
    from electrovib.view import summary
    from electrovib.view.pages import page
    from electrovib.view.reproduced_page import drawn, page_figures
    from electrovib.view.svg import to_svg

    drawings = {}
    for panel in panels:
        figure = drawn(panel)
        figure.axes[0].set_title("", loc="left")  # on the page it is a heading
        drawings[panel.id] = to_svg(figure)
    return page(
        "comparison.html.jinja",
        judged={},
        title=title,
        answer=answer,
        figures=page_figures(panels, drawings),
        tables=list(tables),
        pages=list(pages),
        references=list(references),
        versions=summary.versions(),
    )
