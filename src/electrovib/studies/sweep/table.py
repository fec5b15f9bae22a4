"""The cases of a sweep as one Dataset."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.paths import quantity_at
from electrovib.core.trace import FORMAT, stamp
from electrovib.solve.quantities.resolve import window
from electrovib.solve.simulate import provenance
from electrovib.studies.sweep.checks import over_all

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
