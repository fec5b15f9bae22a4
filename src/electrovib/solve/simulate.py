"""One scenario, one Trace. The solver follows from what the models declare, never from an option."""

from __future__ import annotations

import functools
import json
import math
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.trace import make_trace
from electrovib.solve.diagnostics import diagnostics
from electrovib.solve.electrical import electrical
from electrovib.solve.expand import behind_amplifier, mean_force, modes, per_volt_of, phasors
from electrovib.solve.known import known_band, memory_lamps, worst_of
from electrovib.solve.mechanical import mechanical
from electrovib.solve.memory import answer_errors
from electrovib.solve.scenario import Scenario
from electrovib.solve.section import ModalSection, PhasorSection
from electrovib.solve.transfer import Real

if TYPE_CHECKING:
    import xarray

    from electrovib.physics.force import ForceLaw


def simulate(scenario: Scenario, *, time: Real | None = None) -> xarray.Dataset:
    """Compute what the drive does to the finger.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    time : ndarray, shape (n,), optional
        Increasing, >= 0 [s]; by default what the scenario's time grid says.

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
        If the force law does not find the layers it needs, or models do not go together.

    Notes
    -----
    Linear layers: the modes of the stack under voltage drive, those of each layer under current drive, marched
    exactly. A layer with a leak: one nonlinear branch with its error in `step_error`; over frequency the leak
    counts as the conductivity that a vanishing sine sees.
    """
    times = scenario.time.times(scenario.drive) if time is None else np.asarray(time, dtype=float)
    frequency = scenario.frequency.frequencies()
    at_frequency = phasors(scenario, frequency)
    section, reduction_error = modes(scenario, times)
    attributes = _provenance(scenario)
    attributes["reduction_error"] = reduction_error
    answer = electrical(scenario, section, times)
    known = known_band(scenario)
    errors = answer_errors(scenario, section, answer, times, known=known) if reduction_error else {}
    bare = phasors(scenario, frequency, leaks=False)
    if scenario.force.causal:
        over_frequency = _transfer_error(scenario.force, section, bare, known)
        attributes["transfer_error"] = max(over_frequency, worst_of(errors))
    moved = mechanical(
        scenario, times, answer, functools.partial(electrical, scenario, section, force_alone=True)
    )
    attributes |= answer.choice | moved.how
    variables: dict[str, Any] = {
        **answer.signals(section),
        **moved.signals,
        **_over_frequency(scenario, at_frequency),
    }
    spoken = [
        *diagnostics(scenario, section, answer, times, variables),
        *memory_lamps(scenario, errors, times, known=known, solver=answer.choice["solver"]),
        *moved.lamps,
        *scenario.force.lamps_over_frequency(bare),
    ]
    attributes["lamps"] = json.dumps([lamp.to_dict() for lamp in spoken])
    coordinates = {
        "time": times,
        "frequency": frequency,
        "layer": np.array(list(section.layers), dtype=object),
    }
    return make_trace(variables, coordinates, attributes)


def _provenance(scenario: Scenario) -> dict[str, Any]:
    return {
        "title": scenario.title,
        "electrovib": version("electrovib"),
        "scenario": scenario.to_json(),
        "scenario_hash": scenario.digest(),
        "dropped_samples": getattr(scenario.drive, "dropped", 0),
    }


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
    variables["mean_force"] = (("frequency",), mean_force(scenario, section, scenario.drive.largest()))
    variables["impedance"] = (("frequency",), 1 / (plate.current_density * area))
    variables["permittivity"] = (("layer", "frequency"), permittivities)
    return variables


def _transfer_error(
    law: ForceLaw, section: ModalSection, exact: PhasorSection, known: tuple[float, float]
) -> float:
    """Largest error of the law's amplitudes after reduction, against their largest magnitude, where known."""
    reduced, declared = law.amplitudes(section), law.amplitudes(exact)
    inside = (exact.frequency >= known[0]) & (exact.frequency <= known[1])
    if not np.any(inside):
        return math.nan
    errors = []
    for name, value in declared.items():
        scale = float(np.max(np.abs(value)))
        difference = reduced[name].at(exact.frequency[inside]) - value[inside]
        errors.append(float(np.max(np.abs(difference))) / (scale or 1.0))
    return max(errors)
