"""The result of a fit as a space of parameters, for studies of their uncertainty."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.recordings.fit.misfit import MISFIT

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

    from electrovib.recordings.fit.result import ScenarioFit
    from electrovib.recordings.fit.table import EstimatedParameter


def space_tables(
    rows: Iterable[EstimatedParameter],
    paths: Mapping[str, str],
    *,
    between: Mapping[str, float] | None = None,
) -> dict[str, dict[str, object]]:
    """Write estimates as tables of distributions, as `electrovib.scenario.space.read_space` reads them.

    `paths` maps the name of a row to the path of its parameter, other rows are omitted; `between` is the
    standard deviation of a parameter between sessions, added to that of its mean. A symmetric interval gives
    a normal distribution; one from a profile with two ends above 0 a log-normal one, with the median at the
    estimate and the same 95 % interval. Parameters that the data do not determine, or of a model that does
    not describe them, are omitted.
    """
    found: dict[str, dict[str, object]] = {}
    for row in rows:
        if row.name not in paths or not row.method or row.state in {"not", MISFIT}:
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


def omitted_from_space(
    rows: Iterable[EstimatedParameter], paths: Mapping[str, str], tables: Collection[str]
) -> dict[str, str]:
    """State why parameters of a fit have no distribution in its space."""
    return {
        paths[row.name]: row.note or f"its interval ({row.method or 'none'}) has no two ends above 0"
        for row in rows
        if row.name in paths and paths[row.name] not in tables
    }


def space_correlations(found: ScenarioFit, tables: Collection[str]) -> dict[tuple[str, str], float]:
    """Return the correlation coefficients of the estimates in a space, pair by pair in the order of the unknowns.

    To first order they hold for the logarithms too. A parameter that varies between sessions, is not
    determined or lies on a bound has none.
    """
    names = list(found.estimate.values)
    matrix = found.correlation
    shared = [
        (names.index(each.name), each.path)
        for each in found.unknowns
        if not each.is_offset and not each.session and each.path in tables
    ]
    pairs = {
        (first, second): min(max(matrix[at][other], -1.0), 1.0)
        for number, (at, first) in enumerate(shared)
        for other, second in shared[number + 1 :]
    }
    return {pair: value for pair, value in pairs.items() if math.isfinite(value)}
