"""Measured numbers with their intervals, as a table of a page and as CSV."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.data.csv_text import csv_text
from electrovib.study.reproduction import Table
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.interval import NumberRow


def numbers_csv(rows: Sequence[NumberRow]) -> str:
    """Write the table as CSV, in SI units, with full precision."""
    names = ("value", "lower", "upper", "standard_error", "scatter", "count", "method")
    cells = [
        (row.group, row.name, row.unit, *(getattr(row.number, name) for name in names), row.note)
        for row in rows
    ]
    return csv_text(("group", "name", "unit", *names, "note"), cells)


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
