"""The cases of a sweep as one Dataset, each diagnostic once, with its largest value and the case in which it occurs."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.diagnostics import STATES, Diagnostic
from electrovib.core.paths import quantity_at
from electrovib.core.signals import FORMAT, stamp
from electrovib.solve.quantities.resolve import window
from electrovib.solve.simulate import provenance

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import xarray

    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario


LARGEST: Final = (
    "reduction_error",
    "transfer_error",
    "attraction_error",
    "step_error",
    "quadrature_error",
    "mechanics_error",
    "energy_residual",
    "events",
    "friction_events",
)
"""Attributes of which a sweep keeps the largest."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One case of a sweep.

    `errors` are relative to the largest value of each signal; `how` states solver, reason, errors and events.
    """

    at: Mapping[str, float]
    values: Mapping[str, float]
    errors: Mapping[str, float]
    how: Mapping[str, Any]
    diagnostics: Sequence[Diagnostic]
    record: xarray.Dataset | None = None


def dataset(
    scenario: Scenario,
    axes: Mapping[str, Real],
    cases: Sequence[Case],
    units: Mapping[str, tuple[str, str]],
    *,
    records: bool,
    words: Callable[[Mapping[str, Any]], str],
) -> xarray.Dataset:
    """Assemble the cases of a sweep, with unit and meaning of each quantity, as `electrovib.sweep` returns them."""
    import xarray

    shape = tuple(len(values) for values in axes.values())
    variables: dict[str, Any] = {}
    for name, (unit, meaning) in units.items():
        about: dict[str, Any] = {"units": unit, "long_name": meaning}
        missed = [case.errors[name] for case in cases if name in case.errors]
        if missed:
            about["numerical_error"] = float(np.max(missed))
        values = np.array([case.values[name] for case in cases]).reshape(shape)
        variables[name] = (tuple(axes), values, about)
    coordinates: dict[str, Any] = {}
    for path, values in axes.items():
        quantity = quantity_at(scenario, path)
        coordinates[path] = ((path,), values, {"units": quantity.unit, "long_name": quantity.doc})
    if records:
        more, besides = _records(
            [case.record for case in cases if case.record is not None], tuple(axes), shape
        )
        variables, coordinates = variables | more, coordinates | besides
    attributes = _attributes(scenario, axes, cases, list(units), records=records, words=words)
    return stamp(xarray.Dataset(variables, coordinates, attributes))


def _attributes(
    scenario: Scenario,
    axes: Mapping[str, Real],
    cases: Sequence[Case],
    names: list[str],
    *,
    records: bool,
    words: Callable[[Mapping[str, Any]], str],
) -> dict[str, Any]:
    """Return the swept parameters, the methods and the validity as attributes."""
    checks = over_all([(case.at, case.diagnostics) for case in cases], words=words)
    found = {"format": FORMAT} | provenance(scenario)
    found |= {
        "over": json.dumps({path: values.tolist() for path, values in axes.items()}),
        "quantities": json.dumps(names),
        "taken_over": window(scenario)[1],
        "records": int(records),
        "validity": json.dumps(checks),
    }
    for name in ("solver", "solver_reason"):
        found[name] = "; ".join(dict.fromkeys(str(case.how[name]) for case in cases))
    for name in LARGEST:
        values = [case.how[name] for case in cases if name in case.how]
        if values:
            found[name] = max(values)
    return found


def _records(
    traces: Sequence[xarray.Dataset], paths: tuple[str, ...], shape: tuple[int, ...]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Stack records along ``sample``, each with its own times and NaN after its end."""
    longest, first = max(trace.sizes["time"] for trace in traces), traces[0]
    variables: dict[str, Any] = {}
    for name, variable in first.data_vars.items():
        dims = [str(dim) if dim != "time" else "sample" for dim in variable.dims]
        rows = [_padded(trace[name].values, variable.dims, longest) for trace in traces]
        variables[str(name)] = ((*paths, *dims), np.stack(rows).reshape(shape + rows[0].shape))
    times = np.stack([_padded(trace["time"].values, ("time",), longest) for trace in traces])
    coordinates = {
        name: ((name,), first[name].values) for name in ("frequency", "layer") if name in first.coords
    }
    return variables, {"time": ((*paths, "sample"), times.reshape((*shape, longest))), **coordinates}


def _padded(values: Any, dims: Sequence[Any], longest: int) -> Any:
    """Add NaN at the end of the dimension time."""
    if "time" not in dims:
        return values
    place = list(dims).index("time")
    widths = [(0, longest - values.shape[place] if axis == place else 0) for axis in range(values.ndim)]
    return np.pad(values, widths, constant_values=np.nan)


SAME: Final = 1e-9
"""Relative difference up to which two values count as equal: rounding."""
Judged: TypeAlias = "tuple[Mapping[str, float], Sequence[Diagnostic]]"
"""Values of the swept parameters of a case, and its diagnostics."""


def over_all(cases: Sequence[Judged], *, words: Callable[[Mapping[str, float]], str]) -> list[dict[str, Any]]:
    """Keep of each diagnostic the case with the largest value relative to the limit.

    Each has ``at``, the parameters of that case, and ``cases``, the number in its state; diagnostics of one
    name are identified by their order, and one that was judged in some cases only has two entries.
    """
    found: dict[tuple[str, int], list[tuple[Mapping[str, float], Diagnostic]]] = {}
    for at, diagnostics in cases:
        seen: dict[str, int] = {}
        for diagnostic in diagnostics:
            place = seen[diagnostic.name] = seen.get(diagnostic.name, -1) + 1
            found.setdefault((diagnostic.name, place), []).append((at, diagnostic))
    return [told for group in found.values() for told in _of_one_check(group, len(cases), words)]


def _of_one_check(
    group: Sequence[tuple[Mapping[str, float], Diagnostic]],
    count: int,
    words: Callable[[Mapping[str, float]], str],
) -> list[dict[str, Any]]:
    told = []
    measured = [
        (at, diagnostic)
        for at, diagnostic in group
        if diagnostic.value is not None and diagnostic.limit is not None
    ]
    if measured:
        at, diagnostic = max(measured, key=lambda pair: share_of_limit(pair[1]))
        alike = [other for _, other in measured if other.state == diagnostic.state]
        lowest = min(share_of_limit(other) for _, other in measured)
        if count == 1:
            tail = ""
        elif len(measured) == count and share_of_limit(diagnostic) - lowest <= SAME * abs(
            share_of_limit(diagnostic)
        ):
            tail = f"; the same in all {count} cases"
        else:
            tail = f"; largest at {words(at)}"
            tail += (
                f", {diagnostic.state} in {len(alike)} of {count} cases"
                if diagnostic.state == "warning"
                else ""
            )
        told.append(_as_told(diagnostic, at, len(alike), tail))
    plain = [
        (at, diagnostic) for at, diagnostic in group if diagnostic.value is None or diagnostic.limit is None
    ]
    plain = [pair for pair in plain if not measured or pair[1].state != "ok"]
    if plain:
        worst = max(STATES.index(diagnostic.state) for _, diagnostic in plain)
        alike = [diagnostic for _, diagnostic in plain if STATES.index(diagnostic.state) == worst]
        at, diagnostic = next(pair for pair in plain if STATES.index(pair[1].state) == worst)
        if len(alike) < count:
            tail = f"; in {len(alike)} of {count} cases, the first at {words(at)}"
        else:
            same = len({each.text for each in alike}) == 1
            tail = "" if same else f"; in all cases, this is the one at {words(at)}"
        told.append(_as_told(diagnostic, at, len(alike), tail))
    return told


def _as_told(diagnostic: Diagnostic, at: Mapping[str, float], cases: int, tail: str) -> dict[str, Any]:
    return diagnostic.to_dict() | {"text": diagnostic.text + tail, "at": dict(at), "cases": cases}


def share_of_limit(diagnostic: Diagnostic) -> float:
    """Return value over limit of a diagnostic that has both, dimensionless; minus infinity for NaN."""
    assert diagnostic.value is not None
    assert diagnostic.limit is not None
    if math.isnan(diagnostic.value) or math.isnan(diagnostic.limit):
        return -math.inf
    if diagnostic.limit == 0:
        return math.inf if diagnostic.value > 0 else 0.0
    return diagnostic.value / diagnostic.limit
