"""Simulation of one scenario into one Trace; the solver follows from what the models declare, never from an option."""

from __future__ import annotations

import functools
import json
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError, nearest
from electrovib.core.signals import SIGNALS
from electrovib.core.trace import make_trace
from electrovib.scenario import Source, read_scenario
from electrovib.solve.diagnostics.sampling import sampling
from electrovib.solve.electrics.over_frequency import over_frequency
from electrovib.solve.expanded import Expanded
from electrovib.solve.provenance import beside, provenance
from electrovib.solve.quantities.answer import declared_mean_squares
from electrovib.solve.stack.expand import phasors

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray


def simulate(
    scenario: Source, *, time: Real | None = None, signals: Sequence[str] | None = None
) -> xarray.Dataset:
    """Compute the response of stack, finger and sensors to the drive.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Experiment, as for `electrovib.load`.
    time : ndarray, shape (n,), optional
        Output times, increasing, >= 0 [s]; by default those of the scenario's time grid.
    signals : sequence of str, optional
        Names of the signals to return, for instance ``["electrostatic_force"]``; by default all that the scenario
        has. The diagnostics are those of the whole solution, whichever are chosen.

    Returns
    -------
    xarray.Dataset
        A Trace: signals over time and over frequency, with solver, reason, errors, diagnostics and the scenario
        itself in its attributes.

    Raises
    ------
    NotCausalError
        If the force law has no response in time and the drive is not a single sine in its steady state.
    InputError
        If the force law does not find the layers it needs, models cannot be combined, or the scenario does not have a
        requested signal.
    BudgetError
        If the run would take more time or memory than `electrovib.budget` allows; raised before any computation.

    Notes
    -----
    Linear layers are solved exactly in relaxation modes: those of the stack under voltage drive, those of each layer
    under current drive. A layer with a leak is one nonlinear branch, with its error in `step_error`; over frequency
    the leak counts as its conductivity at vanishing amplitude.
    """
    scenario = read_scenario(scenario)
    _refuse_unknown(signals)
    expanded = Expanded(scenario, None if time is None else np.asarray(time, dtype=float))
    times, frequency = expanded.times, scenario.frequency.frequencies()
    with beside(len(times), functools.partial(provenance, scenario)) as stated:
        at_frequency = phasors(scenario, frequency)
        record = expanded.at(times, closely=True)
        diagnostics, errors = expanded.judge(record, declared_mean_squares)
        attributes = stated() | errors | record.how
    variables: dict[str, Any] = {**record.signals, **over_frequency(scenario, at_frequency)}
    variables = _chosen(variables, signals)
    diagnostics += sampling(scenario.drive, times)
    attributes["validity"] = json.dumps([each.to_dict() for each in diagnostics])
    coordinates = {
        "time": times,
        "frequency": frequency,
        "layer": np.array(list(expanded.section.layers), dtype=object),
    }
    return make_trace(variables, coordinates, attributes)


def _refuse_unknown(signals: Sequence[str] | None) -> None:
    """Refuse names that are not signals, before anything is computed."""
    names = [signals] if isinstance(signals, str) else signals or []
    problems = [
        f"signals = '{name}': not a signal.{nearest(name, SIGNALS)}" for name in names if name not in SIGNALS
    ]
    if problems:
        raise InputError(problems)


def _chosen(variables: dict[str, Any], signals: Sequence[str] | None) -> dict[str, Any]:
    """Return the signals that were requested."""
    if signals is None:
        return variables
    names = [signals] if isinstance(signals, str) else list(signals)
    absent = [name for name in names if name not in variables]
    if absent:
        raise InputError(
            f"signals = '{name}': this scenario does not have this signal.{nearest(name, variables)}"
            for name in absent
        )
    return {name: variables[name] for name in names}
