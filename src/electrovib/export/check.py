"""Write the result of a check as CSV or JSON."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError
from electrovib.data.atomic import check_writable, write_text
from electrovib.data.marks import WRITTEN_BY, Form, unsigned

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.study.check import CheckResult

FORMS: Final = {".csv": Form.TABLE, ".json": Form.CHECK}
"""Suffix to form."""


def check_check_output(path: str | Path, *, inputs: Iterable[Path] = (), force: bool = False) -> None:
    """Check before a computation that its result can be written.

    Parameters
    ----------
    path : str or Path
        The output: ``.csv`` or ``.json``.
    inputs : iterable of Path
        Files that are read.
    force : bool
        Whether a file that was not written by electrovib may be replaced.

    Raises
    ------
    InputError
        If the suffix is unknown or the file cannot be written.
    """
    check_writable({Path(path): _form(Path(path))}, inputs=inputs, force=force)


def write_check(result: CheckResult, path: str | Path, *, force: bool = False) -> Path:
    """Write the result of a check.

    Parameters
    ----------
    result : CheckResult
        From `electrovib.check`.
    path : str or Path
        The output: ``.csv``, a row for each limit, comparison and number, or ``.json``, everything.
    force : bool
        Whether a file that was not written by electrovib may be replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the suffix is unknown or the file cannot be written.
    """
    place = Path(path)
    form = _form(place)
    text = as_csv(result) if form is Form.TABLE else as_json(result)
    write_text(place, text, form, force=force)
    return place


def as_json(result: CheckResult) -> str:
    """Return everything as JSON."""
    return (
        json.dumps({WRITTEN_BY: unsigned(Form.CHECK)} | result.to_dict(), indent=1, ensure_ascii=False) + "\n"
    )


def as_csv(result: CheckResult) -> str:
    """Return a row for each limit, comparison and number, with numbers in SI at 17 digits."""
    text = io.StringIO()
    text.write(f"# {unsigned(Form.TABLE)}\n# {result.title}: {result.state}\n")
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["kind", "quantity", "value", "limit", "unit", "margin", "state", "source"])
    for kind, rows in (("limit", result.rows), ("comparison", result.comparisons)):
        for row in rows:
            numbers = [_number(row.value), _number(row.limit), row.unit, _number(row.margin)]
            table.writerow([kind, row.quantity, *numbers, row.state, row.source])
    for number in result.numbers:
        table.writerow(["number", number.quantity, _number(number.value), "", number.unit, "", "", ""])
    return text.getvalue()


def _number(value: float | None) -> str:
    return "" if value is None else repr(value)


def _form(path: Path) -> Form:
    form = FORMS.get(path.suffix.lower())
    if form is None:
        raise InputError(f"a check is written as {', '.join(FORMS)}, not as '{path.suffix}'.", path=path)
    return form
