"""One scenario, one Trace. The solver follows from what the models declare, never from an option."""

from __future__ import annotations

import contextlib
import functools
import json
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError, nearest
from electrovib.core.model import Model
from electrovib.core.signals import SIGNALS
from electrovib.core.trace import make_trace
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.diagnostics.sampling import sampling
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.expanded import Expanded
from electrovib.solve.stack.expand import behind_amplifier, per_volt_of, phasors
from electrovib.solve.stack.section import PhasorSection

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    import xarray

_MANY: Final = 100_000
"""Times from which on a record takes longer to be written and hashed than a thread to begin."""


def simulate(
    scenario: Source, *, time: Real | None = None, signals: Sequence[str] | None = None
) -> xarray.Dataset:
    """Compute what the drive does to the finger.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Everything, as for `electrovib.load`.
    time : ndarray, shape (n,), optional
        Increasing, >= 0 [s]; by default what the scenario's time grid says.
    signals : sequence of str, optional
        Names of the signals that are wanted, for instance ``["electrostatic_force"]``; by default all that the
        scenario has. The checks are those of the whole solution, whichever are chosen.

    Returns
    -------
    xarray.Dataset
        A Trace: signals over time and over frequency, with solver, reason, errors, lamps and the scenario
        itself in its attributes.

    Raises
    ------
    NotCausalError
        If the force law has no response in time but the drive is not one sine in its steady state.
    InputError
        If the force law does not find the layers it needs, models do not go together, or the scenario does not have a
        signal that is wanted.
    BudgetError
        If it would take more time or memory than `electrovib.budget` allows; told before anything is computed.

    Notes
    -----
    Linear layers: the modes of the stack under voltage drive, those of each layer under current drive, marched
    exactly. A layer with a leak: one nonlinear branch with its error in `step_error`; over frequency the leak
    counts as the conductivity that a vanishing sine sees.
    """
    scenario = read_scenario(scenario)
    _refuse_unknown(signals)
    expanded = Expanded(scenario, None if time is None else np.asarray(time, dtype=float))
    times, frequency = expanded.times, scenario.frequency.frequencies()
    with _beside(len(times), functools.partial(provenance, scenario)) as stated:
        at_frequency = phasors(scenario, frequency)
        record = expanded.at(times, closely=True)
        spoken, errors = expanded.judge(record)
        attributes = stated() | errors | record.how
    variables: dict[str, Any] = {**record.signals, **_over_frequency(scenario, at_frequency)}
    variables = _chosen(variables, signals)
    spoken += sampling(scenario.drive, times)
    attributes["lamps"] = json.dumps([lamp.to_dict() for lamp in spoken])
    coordinates = {
        "time": times,
        "frequency": frequency,
        "layer": np.array(list(expanded.section.layers), dtype=object),
    }
    return make_trace(variables, coordinates, attributes)


def _refuse_unknown(signals: Sequence[str] | None) -> None:
    """Refuse names that are no signals before anything is computed."""
    names = [signals] if isinstance(signals, str) else signals or []
    problems = [
        f"signals = '{name}': no signal.{nearest(name, SIGNALS)}" for name in names if name not in SIGNALS
    ]
    if problems:
        raise InputError(problems)


def _chosen(variables: dict[str, Any], signals: Sequence[str] | None) -> dict[str, Any]:
    """Keep the signals that are wanted."""
    if signals is None:
        return variables
    names = [signals] if isinstance(signals, str) else list(signals)
    absent = [name for name in names if name not in variables]
    if absent:
        raise InputError(
            f"signals = '{name}': this scenario has none.{nearest(name, variables)}" for name in absent
        )
    return {name: variables[name] for name in names}


def provenance(scenario: Scenario) -> dict[str, Any]:
    """Say what was computed, and by which version."""
    return {
        "title": scenario.title,
        "electrovib": _version(),
        "scenario": scenario.to_json(),
        "scenario_hash": scenario.digest(),
        "dropped_samples": _dropped(scenario.drive),
    }


@contextlib.contextmanager
def _beside(count: int, work: Callable[[], dict[str, Any]]) -> Iterator[Callable[[], dict[str, Any]]]:
    """Let a second thread do some work beside a run of very many times; what is handed out waits for its result."""
    if count < _MANY:
        yield work
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(max_workers=1) as pool:
        yield pool.submit(work).result


@functools.cache
def _version() -> str:
    return version("electrovib")


def _dropped(model: Model) -> int:
    """Count the samples that measured drives inside a drive have dropped."""
    inner = [item for _, value in model for item in (value if isinstance(value, tuple) else (value,))]
    return getattr(model, "dropped", 0) + sum(_dropped(each) for each in inner if isinstance(each, Model))


def _over_frequency(scenario: Scenario, section: PhasorSection) -> dict[str, Any]:
    area = scenario.contact_area
    plate = per_volt_of(scenario, section.frequency)
    per_volt = behind_amplifier(scenario, plate)
    section = behind_amplifier(scenario, section)
    variables: dict[str, Any] = {}
    effective = scenario.force.effective_voltage(per_volt)
    if effective is not None:
        variables["effective_voltage_gain"] = (("frequency",), effective)
    layers = per_volt.layers.values()
    gains = np.array([state.field * state.thickness for state in layers])
    permittivities = np.array([state.material.complex_permittivity(section.frequency) for state in layers])
    variables["field_gain"] = (("layer", "frequency"), gains)
    variables["mean_force"] = (
        ("frequency",),
        mean_force(scenario, section, amplitude=scenario.drive.largest()),
    )
    variables["impedance"] = (("frequency",), 1 / (plate.current_density * area))
    variables["permittivity"] = (("layer", "frequency"), permittivities)
    return variables
