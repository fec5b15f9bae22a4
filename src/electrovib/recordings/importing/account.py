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
    known = np.flatnonzero(np.isfinite(column.values))
    ends = [float(column.values[at]) for at in (known[0], known[-1])] if known.size else [None, None]
    return {
        "name": column.name, "unit": column.unit, "type": str(column.values.dtype), "rows": column.values.size,
        "missing": column.values.size - known.size, "first": ends[0], "last": ends[1],
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
    text += f"{about['first']:.6g} first, {about['last']:.6g} last"
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


def about_file(recorded: Recorded) -> list[Diagnostic]:
    """State which part of a file was read where it holds several, what was not read, and what its reader is not sure of."""
    about, others, found = recorded.attributes, recorded.not_read, []
    if "unsure" in about:
        found.append(Diagnostic("reader", "unknown", f"not sure is {about['unsure']}"))
    if others:
        read = f"read: {about['table']}; " if "table" in about else ""
        named = "; ".join(f"{each.name} ({each.why})" for each in others[:_MOST_NOT_READ])
        more = f"; and {len(others) - _MOST_NOT_READ} more" if len(others) > _MOST_NOT_READ else ""
        found.append(Diagnostic("not read", "unknown", f"{read}not read: {named}{more}"))
    return found
