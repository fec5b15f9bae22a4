"""Simulation of one scenario into one Trace; the solver follows from what the models declare, never from an option."""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError, nearest, refuse
from electrovib.core.model import Model
from electrovib.core.own_models import ATTRIBUTE as OWN_MODELS
from electrovib.core.own_models import origins
from electrovib.core.signals import SIGNALS, make_trace
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.diagnostics.assumptions import sampling
from electrovib.solve.electrics.over_frequency import over_frequency
from electrovib.solve.expanded import Expanded
from electrovib.solve.meter import measured
from electrovib.solve.quantities.answer import declared_mean_squares
from electrovib.solve.stack.expand import phasors
from electrovib.solve.stack.keys import FieldOf

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray
    from numpy.typing import NDArray

    from electrovib.core.diagnostics import Diagnostic


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
        If the run would take more time or memory than `electrovib.budget` allows: before any computation as far as
        that can be counted, and as soon as the budget is spent.

    Notes
    -----
    Linear layers are solved exactly in relaxation modes: those of the stack under voltage drive, those of each layer
    under current drive. A layer with a leak is one nonlinear branch, with its error in `step_error`; over frequency
    the leak counts as its conductivity at vanishing amplitude.

    Examples
    --------
    >>> trace = ev.simulate("vezzoli_2014/fig6", signals=["electrostatic_force"])
    >>> f"{1e3 * float(trace.electrostatic_force.max()):.2f} mN"
    '2.56 mN'
    """
    scenario = read_scenario(scenario)
    _refuse_unknown(signals)
    expanded = Expanded(scenario, None if time is None else np.asarray(time, dtype=float))
    with measured():
        origin = provenance(scenario)  # first: the room that it needs is used again
        found = Simulated.of(expanded)
    return found.trace(origin, signals=signals)


@dataclass(frozen=True, eq=False)
class Simulated:
    """Signals and validity of a simulation, before they are a Trace.

    Parameters
    ----------
    variables : mapping
        Name of a signal to its dimensions and array, in SI.
    coordinates : mapping of str to ndarray
        Name of a dimension to its values.
    diagnostics : tuple of Diagnostic
        Statements on the validity.
    attributes : mapping
        Solver, its reason and its errors, as a Trace states them.
    largest_fields : mapping of str to float
        Largest magnitude of the field of each layer, at any time of the run [V/m].

    Notes
    -----
    To make a Trace takes longer than to draw its curves: the page in the browser makes one only where it is asked for.
    """

    variables: Mapping[str, tuple[Sequence[str], Any]]
    coordinates: Mapping[str, NDArray[Any]]
    diagnostics: tuple[Diagnostic, ...]
    attributes: Mapping[str, Any]
    largest_fields: Mapping[str, float]

    @classmethod
    def of(cls, expanded: Expanded) -> Self:
        """Compute everything that a Trace of a scenario states, its provenance apart."""
        scenario, times = expanded.scenario, expanded.times
        frequency = scenario.frequency.frequencies()
        at_frequency = phasors(scenario, frequency)
        record = expanded.at(times, closely=True)
        diagnostics, errors = expanded.judge(record, declared_mean_squares)
        layers = list(expanded.section.layers)
        peaks = record.peaks.peaks() if record.peaks is not None else {}
        return cls(
            variables={**record.signals, **over_frequency(scenario, at_frequency)},
            coordinates={
                "time": times,
                "frequency": frequency,
                "layer": np.array(layers, dtype=object),
            },
            diagnostics=(*diagnostics, *sampling(scenario.drive, times)),
            attributes=errors | record.how,
            largest_fields={name: peaks[FieldOf(name)] for name in layers if FieldOf(name) in peaks},
        )

    def trace(self, origin: Mapping[str, Any], *, signals: Sequence[str] | None = None) -> xarray.Dataset:
        """Make the Trace."""
        validity = json.dumps([each.to_dict() for each in self.diagnostics])
        attributes = {**origin, **self.attributes, "validity": validity}
        return make_trace(_chosen(self.variables, signals), self.coordinates, attributes)


def _refuse_unknown(signals: Sequence[str] | None) -> None:
    """Refuse names that are not signals, before anything is computed."""
    names = [signals] if isinstance(signals, str) else signals or []
    problems = [
        f"signals = '{name}': not a signal.{nearest(name, SIGNALS)}" for name in names if name not in SIGNALS
    ]
    refuse(problems)


def _chosen(variables: Mapping[str, Any], signals: Sequence[str] | None) -> Mapping[str, Any]:
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


def provenance(scenario: Scenario) -> dict[str, Any]:
    """Return what was computed, and by which version."""
    stated = {
        "title": scenario.titled(),
        "electrovib": _version(),
        "scenario": scenario.to_json(),
        "scenario_hash": scenario.digest(),
        "dropped_samples": _dropped(scenario.drive),
    }
    others = origins(scenario)
    return stated | {OWN_MODELS: json.dumps(others)} if others else stated


@functools.cache
def _version() -> str:
    return version("electrovib")


def _dropped(model: Model) -> int:
    """Return the number of samples that were dropped from the measured drives in a drive."""
    inner = [item for _, value in model for item in (value if isinstance(value, tuple) else (value,))]
    return getattr(model, "dropped", 0) + sum(_dropped(each) for each in inner if isinstance(each, Model))
