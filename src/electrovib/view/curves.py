"""The curves behind a figure as a table."""

from __future__ import annotations

import csv
import io
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.study.reproduction import Panel


def to_csv(panel: Panel) -> str:
    """Write every curve of a panel, one point a line, in SI.

    Parameters
    ----------
    panel : Panel
        With curves that need not have their places in common.

    Returns
    -------
    str
        Columns: name of the curve, place, value; and the upper edge if the panel has a band. A place without a value
        stays empty. The numbers read back to the last bit, and go on below what the figure draws.
    """
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
