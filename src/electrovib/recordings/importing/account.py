"""Account of a file: every column that is read, and everything that is not, with the reason."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic

if TYPE_CHECKING:
    from electrovib.data.recorded import DataColumn, Recorded


MOST_COLUMNS: Final = 60
_MOST_NOT_READ: Final = 20


def account_of(recorded: Recorded) -> dict[str, list[dict[str, Any]]]:
    """Return what is read of a file and what is not, whole, as the attribute ``columns_of_file`` of a Trace holds it."""
    return {
        "read": [_account(each) for each in recorded.channels],
        "not_read": [{"name": each.name, "why": each.why} for each in recorded.not_read],
    }


def _account(column: DataColumn) -> dict[str, Any]:
    """Return name, unit, type and number of rows of a column, and the first and the last of its numbers."""
    values, known = column.values, np.isfinite(column.values)
    missing = values.size - int(np.count_nonzero(known))
    ends = (
        (int(np.argmax(known)), values.size - 1 - int(np.argmax(known[::-1])))
        if missing < values.size
        else ()
    )
    first, last = [float(values[at]) for at in ends] or (None, None)
    return {
        "name": column.name, "unit": column.unit, "type": str(values.dtype), "rows": values.size, "missing": missing,
        "first": first, "last": last,
    }  # fmt: skip


def account_lines(recorded: Recorded, *, whole: bool = False) -> list[str]:
    """Write the account of a file, a line for each column and each thing that is not read; a long one cut unless `whole`."""
    columns = recorded.channels if whole else recorded.channels[:MOST_COLUMNS]
    lines = [f"  {number}  {_line(each, recorded)}" for number, each in enumerate(columns)]
    if more := len(recorded.channels) - len(columns):
        lines.append(f"  and {more} more")
    others = recorded.not_read if whole else recorded.not_read[:_MOST_NOT_READ]
    lines += [f"  not read: {each.name}: {each.why}" for each in others]
    if more := len(recorded.not_read) - len(others):
        lines.append(f"  not read either: {more} more")
    return lines


def _line(column: DataColumn, recorded: Recorded) -> str:
    about = _account(column)
    text = f"{column.name}  [{column.unit or 'unit not stated'}]  {about['rows']} rows of {about['type']}: "
    if about["first"] is None:
        return f"{text}no numbers"
    text += f"{about['first'] + 0.0:.6g} first, {about['last'] + 0.0:.6g} last"
    low, high = np.nanmin(column.values), np.nanmax(column.values)
    text += f", {low:.6g} to {high:.6g}" if {low, high} != {about["first"], about["last"]} else ""
    text += f", {about['missing']} missing" if about["missing"] else ""
    clock = recorded.clocks.get(column.name)
    own = (
        f", with the times of '{clock.time}'"
        if clock and clock.time
        else ", with times of its own"
        if clock
        else ""
    )
    return f"{text}{', the time' if column.name == recorded.time else own}"


def not_read_words(recorded: Recorded) -> list[str]:
    """Return the sentence that names what is not read, the first of many things; none if everything is."""
    others = recorded.not_read
    if not others:
        return []
    read = f"read: {recorded.attributes['table']}; " if "table" in recorded.attributes else ""
    named = "; ".join(f"{each.name} ({each.why})" for each in others[:_MOST_NOT_READ])
    more = f"; and {len(others) - _MOST_NOT_READ} more" if len(others) > _MOST_NOT_READ else ""
    return [f"{read}not read: {named}{more}"]


def about_file(recorded: Recorded) -> list[Diagnostic]:
    """State which part of a file was read where it holds several, what was not read, and what its reader is not sure of."""
    about = recorded.attributes
    unsure = [Diagnostic("reader", "unknown", f"not sure is {about['unsure']}")] if "unsure" in about else []
    return unsure + [Diagnostic("rest of the file", "unknown", text) for text in not_read_words(recorded)]
