"""The same experiment at several values of some parameters: a Trace gains a dimension for each."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from electrovib.core.errors import InputError
from electrovib.core.lamps import STATES
from electrovib.core.paths import quantity_at
from electrovib.core.trace import make_trace
from electrovib.core.units import expected, parse_quantity
from electrovib.solve.scenario import Scenario
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    import xarray

Real = NDArray[np.float64]
WORST = (
    "reduction_error",
    "transfer_error",
    "step_error",
    "quadrature_error",
    "mechanics_error",
    "energy_residual",
    "events",
    "friction_events",
)
"""Attributes of which a sweep tells the largest."""
_RANGE = re.compile(r"([^=]+)=(.+):(.+):(\d+)(log)?")
_FORM = "expected PATH=FROM:TO:N or PATH=FROM:TO:Nlog, for instance drive.rise=1ms:100ms:30log"


def parse_over(scenario: Scenario, texts: Sequence[str]) -> dict[str, Real]:
    """Read what ``--over`` says.

    Parameters
    ----------
    scenario : Scenario
        Whose parameters are meant.
    texts : sequence of str
        ``path=from:to:n`` evenly, ``path=from:to:nlog`` evenly in the logarithm; values with units.

    Returns
    -------
    dict of str to ndarray
        Dotted path to values in SI.

    Raises
    ------
    InputError
        Every mistake at once.
    """
    found: dict[str, Real] = {}
    problems: list[str] = []
    for text in texts:
        try:
            path, values = _parse_one(scenario, text)
            if path in found:
                problems.append(f"--over {text}: '{path}' is swept twice")
            found[path] = values
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    return found


def _parse_one(scenario: Scenario, text: str) -> tuple[str, Real]:
    match = _RANGE.fullmatch(text.strip())
    if match is None:
        raise InputError(f"--over {text}: {_FORM}")
    path, count = match[1].strip(), int(match[4])
    quantity = quantity_at(scenario, path)
    if path.startswith(("time.", "frequency.")):
        raise InputError(
            f"--over {path}: the grids of time and frequency are common to all values; use --set"
        )
    if not 2 <= count <= 10**5:
        raise InputError(f"--over {text}: n must be a whole number from 2 to 100000")
    ends = []
    for end in (match[2], match[3]):
        try:
            ends.append(parse_quantity(end, quantity.unit))
        except ValueError:
            raise InputError(f"--over {path}: '{end}': {expected(quantity.unit)}") from None
    if match[5] and min(ends) <= 0:
        raise InputError(f"--over {text}: a logarithmic range needs both ends above 0")
    spacing = np.geomspace if match[5] else np.linspace
    return path, spacing(ends[0], ends[1], count)


def sweep(
    scenario: Scenario,
    over: Mapping[str, Sequence[float] | Real],
    *,
    progress: Callable[[int, int], None] | None = None,
) -> xarray.Dataset:
    """Simulate a scenario at every combination of some parameters' values.

    Parameters
    ----------
    scenario : Scenario
        What stays the same.
    over : mapping of str to sequence of float
        Dotted path to values in SI; several give every combination.
    progress : callable, optional
        Called with how many are done and how many there are.

    Returns
    -------
    xarray.Dataset
        A Trace with one more dimension, named by its path, for each parameter. All share one time grid, as
        long as the longest drive.

    Raises
    ------
    InputError
        For every value out of range.
    """
    axes = {path: np.asarray(values, dtype=float) for path, values in over.items()}
    changes = [
        {path: float(value) for path, value in zip(axes, values, strict=True)}
        for values in itertools.product(*axes.values())
    ]
    scenarios = [scenario.replace(change) for change in changes]
    time = _common_time(scenarios)
    traces = []
    for done, member in enumerate(scenarios):
        if progress is not None:
            progress(done, len(scenarios))
        traces.append(simulate(member, time=time))
    return _stack(scenario, axes, traces)


def _common_time(scenarios: Sequence[Scenario]) -> Real:
    grids = [member.time.times(member.drive) for member in scenarios]
    return max(grids, key=lambda grid: float(grid[-1]))


def _stack(scenario: Scenario, axes: dict[str, Real], traces: Sequence[xarray.Dataset]) -> xarray.Dataset:
    first = traces[0]
    shape = tuple(len(values) for values in axes.values())
    variables = {}
    for name, variable in first.data_vars.items():
        stacked = np.stack([trace[name].values for trace in traces])
        variables[str(name)] = ((*axes, *map(str, variable.dims)), stacked.reshape(shape + variable.shape))
    attributes = dict(first.attrs)
    attributes |= {
        "scenario": scenario.to_json(),
        "scenario_hash": scenario.digest(),
        "over": json.dumps({path: values.tolist() for path, values in axes.items()}),
        "lamps": json.dumps(_worst([json.loads(trace.attrs["lamps"]) for trace in traces])),
    }
    for name in WORST:
        found = [trace.attrs[name] for trace in traces if name in trace.attrs]
        if found:
            attributes[name] = max(found)
    coordinates = {**axes, **{str(name): values.values for name, values in first.coords.items()}}
    trace = make_trace(variables, coordinates, attributes)
    for path in axes:
        quantity = quantity_at(scenario, path)
        trace[path].attrs.update({"units": quantity.unit, "long_name": quantity.doc})
    return trace


def _worst(all_lamps: Sequence[Sequence[dict[str, Any]]]) -> list[dict[str, Any]]:
    """Keep, of each lamp, the worst over the sweep."""
    found: dict[str, dict[str, Any]] = {}
    for lamps in all_lamps:
        for lamp in lamps:
            known = found.get(lamp["name"])
            if known is None or STATES.index(lamp["state"]) > STATES.index(known["state"]):
                found[lamp["name"]] = lamp
    return list(found.values())
