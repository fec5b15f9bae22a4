"""The result of a check for people and programs: tables of words, CSV, JSON and an HTML page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.diagnostics import warning_lines
from electrovib.core.errors import InputError
from electrovib.data.atomic import check_writable, write_text
from electrovib.data.csv_text import csv_text
from electrovib.data.marks import WRITTEN_BY, Form, unsigned
from electrovib.study.check.result import shown
from electrovib.study.reproduction import Page, Table
from electrovib.view.documents import Document, html

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.study.check import CheckResult, CheckRow
    from electrovib.study.check.series import SeriesResistor

HARDWARE: Final = "no claim of medical safety: only hardware that limits the current protects a person"
"""What a check in a few lines says of its own meaning."""
FORMS: Final = {".csv": Form.TABLE, ".json": Form.CHECK, ".html": Form.PAGE}
"""Suffix to form."""


def check_outcome_file(path: str | Path, *, inputs: Iterable[Path] = (), force: bool = False) -> None:
    """Check before a computation that its result can be written as ``.csv``, ``.json`` or ``.html``."""
    check_writable({Path(path): _form(Path(path))}, inputs=inputs, force=force)


def write_check(result: CheckResult, path: str | Path, *, force: bool = False) -> Path:
    """Write the result of a check as ``.csv``, a row for each limit, comparison and number, ``.json`` or ``.html``."""
    place = Path(path)
    form = _form(place)
    text = {Form.TABLE: as_csv, Form.CHECK: as_json, Form.PAGE: as_html}[form](result)
    write_text(place, text, form, force=force)
    return place


def as_json(result: CheckResult) -> str:
    """Return everything as JSON."""
    return (
        json.dumps({WRITTEN_BY: unsigned(Form.CHECK)} | result.to_dict(), indent=1, ensure_ascii=False) + "\n"
    )


def as_csv(result: CheckResult) -> str:
    """Return a row for each limit, comparison and number, with numbers in SI at 17 digits."""
    rows: list[list[object]] = [
        [kind, row.quantity, row.value, row.limit, row.unit, row.margin, row.state, row.source]
        for kind, some in (("limit", result.rows), ("comparison", result.comparisons))
        for row in some
    ]
    rows += [["number", each.quantity, each.value, "", each.unit, "", "", ""] for each in result.numbers]
    return csv_text(
        ["kind", "quantity", "value", "limit", "unit", "margin", "state", "source"],
        rows,
        remarks=[f"{result.title}: {result.state}"],
        diagnostics=result.diagnostics,
    )


def as_html(result: CheckResult) -> str:
    """Return a page with the tables, the verdict and the notes."""
    document = Document(
        title=f"Check of {result.title}",
        answer=verdict(result),
        diagnostics=result.diagnostics,
        tables=tables_of(result),
        pages=[Page(id="", title="Notes", paragraphs=result.notes)],
    )
    return html(document)


def tables_of(result: CheckResult) -> list[Table]:
    """Lay a result out as tables of words."""

    def row(each: CheckRow, words: dict[str, str]) -> tuple[str, ...]:
        margin = "" if each.margin is None else f"{each.margin:.3g}"
        state = words.get(each.state, each.state)
        return (
            state,
            each.quantity,
            shown(each.value, each.unit),
            "" if each.limit is None else shown(each.limit, each.unit),
            margin,
            each.source,
        )

    headings = ("quantity", "largest", "limit", "limit/value", "source of the limit")
    compared = {"pass": "below", "fail": "above"}
    numbers = tuple((each.quantity, shown(each.value, each.unit)) for each in result.numbers)
    return [
        Table(result.title, ("state", *headings), tuple(row(each, {}) for each in result.rows)),
        Table(
            "Comparison with published currents, which decides nothing",
            ("state", *headings),
            tuple(row(each, compared) for each in result.comparisons),
        ),
        Table("Values without a limit", ("quantity", "value"), numbers),
    ]


def resistor_table(found: SeriesResistor) -> Table:
    """Lay the series resistor out as a table of words."""
    rows = [(name, shown(value, unit), "") for name, value, unit in found.items()]
    rows[0] = (*rows[0][:2], found.voltage_source)
    rows[1] = (*rows[1][:2], found.current_source)
    if not found.present:
        place = [row[0] for row in rows].index("present series resistance")
        rows[place] = (rows[place][0], "none", "circuit.source_resistance of the scenario is 0")
    caption = (
        "The insulator counts as a short circuit and the body as no resistance. The charge behind the resistor flows through"
        " the finger without passing it; the resistor has to withstand the largest voltage and the power permanently."
    )
    return Table(
        "Series resistor between amplifier and plate",
        ("quantity", "value", "source"),
        tuple(rows),
        caption=caption,
    )


def verdict(result: CheckResult) -> str:
    """Return one sentence with the outcome."""
    if result.failed:
        return f"failed: {len(result.failed)} of {len(result.rows)} limits exceeded: " + ", ".join(
            row.quantity for row in result.failed
        )
    unknown = sum(row.state == "unknown" for row in result.rows)
    rest = f", {unknown} not judged" if unknown else ""
    return f"no limit exceeded{rest}"


def check_lines(result: CheckResult, *, more: str = "") -> list[str]:
    """Report the outcome in a few lines: the verdict, the closest limit, what was not compared, warnings, where the rest is."""
    lines = [f"{verdict(result)} ({result.title})"]
    compared = [row for row in result.rows if row.margin is not None]
    if compared:
        row = min(compared, key=lambda row: row.margin or 0.0)
        doubt = ", not judged" if row.state == "unknown" else ""
        lines.append(
            f"closest limit: {row.quantity}, {shown(row.value, row.unit)} of {shown(row.limit, row.unit)}, limit/value"
            f" {row.margin or 0.0:.3g}{doubt}"
        )
    undeclared = [row.quantity for row in result.rows if row.limit is None and row.state == "unknown"]
    if undeclared:
        lines.append(f"not compared: {', '.join(undeclared)}")
    return [*lines, *warning_lines(result.diagnostics, brief=True), f"{HARDWARE} {more}".strip()]


def _form(path: Path) -> Form:
    form = FORMS.get(path.suffix.lower())
    if form is None:
        raise InputError(f"a check is written as {', '.join(FORMS)}, not as '{path.suffix}'.", path=path)
    return form
