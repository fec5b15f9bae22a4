"""The curves behind a figure, and the tables of a page, as CSV."""

from __future__ import annotations

import csv
import io
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.study.reproduction import Panel, Table


def to_csv(panel: Panel) -> str:
    """Write every curve of a panel, drawn or not, one point a line, in SI; numbers read back to the last bit."""
    written = io.StringIO()
    table = csv.writer(written, lineterminator="\n")
    banded = any(curve.upper is not None for curve in panel.curves)
    names = [f"{what} [{unit}]" for what, unit in (panel.x, panel.y)]
    table.writerow(["curve", *names, *([f"{names[1]}, upper edge"] if banded else [])])
    for curve in panel.curves:
        columns = [curve.x, curve.y] + ([] if curve.upper is None else [curve.upper])
        for point in zip(*columns, strict=True):
            numbers = ["" if math.isnan(value) else repr(float(value)) for value in point]
            table.writerow([curve.label, *numbers, *([""] if banded and curve.upper is None else [])])
    return written.getvalue()


def table_to_csv(table: Table) -> str:
    """Write a whole table, with the columns that its page omits."""
    written = io.StringIO()
    csv.writer(written, lineterminator="\n").writerows([table.headings, *table.rows])
    return written.getvalue()
