"""The result of a fit as a space of parameters, for studies of their uncertainty."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from electrovib.recordings.fit.table import EstimatedParameter


def space_tables(
    rows: Iterable[EstimatedParameter],
    paths: Mapping[str, str],
    *,
    between: Mapping[str, float] | None = None,
) -> dict[str, dict[str, object]]:
    """Write estimates as tables of distributions, as `electrovib.scenario.space.read_space` reads them.

    Parameters
    ----------
    rows : iterable of EstimatedParameter
        The table of a fit.
    paths : mapping of str to str
        Name of a row to the dotted path of its parameter; other rows are omitted.
    between : mapping of str to float, optional
        Path to the standard deviation of a parameter between sessions, in SI, which is added to that of its mean.

    Returns
    -------
    tables : dict of str to dict
        Path to a normal distribution where the interval is symmetric, and to a log-normal one, with the median at the
        estimate and the same 95 % interval, for an interval from a profile with two ends above 0. Parameters that the data
        do not determine are omitted. Correlations are not part of a space.
    """
    found: dict[str, dict[str, object]] = {}
    for row in rows:
        if row.name not in paths or not row.method or row.state == "not":
            continue
        if row.method == "profile":
            if 0 < row.lower < row.value < row.upper < math.inf:
                factor = math.exp((math.log(row.upper) - math.log(row.lower)) / (2 * 1.959964))
                found[paths[row.name]] = {"model": "LogNormal", "median": row.value, "factor": factor}
            continue
        deviation = math.hypot(row.deviation, (between or {}).get(paths[row.name], 0.0))
        table: dict[str, object] = {"model": "Normal", "mean": row.value, "deviation": deviation}
        if row.value > 0:
            table["low"] = 0.0
        found[paths[row.name]] = table
    return found
