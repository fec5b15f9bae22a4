"""Recognition of the column of the times of a text, and of one that numbers its rows."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.data.readers.layout import Layout
    from electrovib.data.readers.recorded import DataColumn

_COUNTS: Final = frozenset(
    {"sequence", "index", "nr", "no", "pt", "point", "points", "point #", "sample", "samples", "#", "n"}
)
_TIMES: Final = re.compile(
    r"(elapsed |trigger )?time\b.*|t|zeit|x-axis|x[_ ]?value|x|seconds?|source", re.IGNORECASE
)
FREQUENCY: Final = re.compile(r"freq|hz|hertz|omega", re.IGNORECASE)


def counts(values: Real) -> bool:
    """Return whether a column numbers the samples."""
    return bool(np.array_equal(values, np.arange(values.size) + values[0]) and values[0] in (0, 1))


def is_index(layout: Layout, first: DataColumn) -> bool:
    """Return whether the first column numbers the rows: by its heading, or it counts and it alone has no heading."""
    if {first.name.lower().rstrip("."), first.unit.lower()} & _COUNTS:
        return True
    return counts(first.values) and not layout.names[0] and all(layout.names[1:])


def keeps_step(channel: DataColumn, step: float) -> bool:
    """Return whether a column increases by the time step that the preamble states, within 1 % of it on average."""
    values = channel.values
    even = (values.size - 1) * step
    return bool(np.isfinite(values).all() and abs(values[-1] - values[0] - even) <= 0.01 * abs(even))


def is_time(channel: DataColumn, step: float | None, *, first: bool) -> bool:
    """Return whether a column is the time: by name and unit, and the first column also by its rise."""
    rises = bool(np.isfinite(channel.values).all() and (np.diff(channel.values) >= 0).all())
    named = bool(_TIMES.fullmatch(channel.name))
    if channel.unit in ("s", "ms", "us", "ns"):
        return (rises and (first or named)) or (first and named)
    if not rises or channel.unit or channel.values[0] == channel.values[-1]:
        return False
    if first and step is not None and keeps_step(channel, step):
        return True
    return (
        named and not (channel.name.lower() == "x" and not first)
        if not first
        else (named or channel.name.startswith("column "))
    )
