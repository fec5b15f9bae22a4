"""Measured numbers with their intervals, as a table of a page and as CSV."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.data.csv_text import csv_text
from electrovib.study.reproduction import Table
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.transitions.table import TimeRow


def numbers_csv(rows: Sequence[TimeRow]) -> str:
    """Write the table as CSV, in SI units, with full precision."""
    names = ("value", "lower", "upper", "standard_error", "scatter", "count", "method")
    cells = [
        (row.group, row.name, row.unit, *(getattr(row.number, name) for name in names), row.note)
        for row in rows
    ]
    return csv_text(("group", "name", "unit", *names, "note"), cells)


def numbers_table(title: str, rows: Sequence[TimeRow], *, first: str = "") -> Table:
    """Write the table for a page, `first` being the heading of the groups."""
    shown = []
    for row in rows:
        value, lower, upper, scatter = (
            pretty_quantity(getattr(row.number, name), row.unit if row.unit != "1" else "", digits=4)
            if math.isfinite(getattr(row.number, name))
            else "none"
            for name in ("value", "lower", "upper", "scatter")
        )
        interval = f"{lower} to {upper}" if upper != "none" else "none"
        shown.append((row.group, row.name, value, interval, scatter, row.number.method, row.note))
    headings = (first, "Quantity", "Value", "95 % interval", "Scatter", "Interval from", "Note")
    return Table(title, headings, tuple(shown))
