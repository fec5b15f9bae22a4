"""A table as CSV: what is said about it as comments, a line of headings, numbers that read back to the last bit."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING

from electrovib.core.diagnostics import comment_lines
from electrovib.data.marks import Form, unsigned

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from electrovib.core.diagnostics import Diagnostic


def csv_text(
    headings: Sequence[object],
    rows: Iterable[Iterable[object]],
    *,
    remarks: Iterable[str] = (),
    diagnostics: Iterable[Diagnostic] = (),
    marked: bool = True,
) -> str:
    """Write a table, `marked` as one that a later run may replace; a cell None stays empty, and empty remarks are omitted."""
    text = io.StringIO()
    said = (" ".join(each.split()) for each in remarks if each)
    text.writelines(f"# {line}\n" for line in ([unsigned(Form.TABLE)] if marked else []) + list(said))
    text.write(comment_lines(diagnostics))
    table = csv.writer(text, lineterminator="\n")
    table.writerow(headings)
    table.writerows([_cell(each) for each in row] for row in rows)
    return text.getvalue()


def _cell(value: object) -> object:
    return "" if value is None else repr(float(value)) if isinstance(value, float) else value
