"""Comparison of force laws on one stack."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.discovery import find_members
from electrovib.core.errors import ElectrovibError, InputError, NotCausalError
from electrovib.core.mistakes import near_members
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import SteadyFriction
from electrovib.physics.time_profile import Steady
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors
from electrovib.studies.compare.panels import over_frequency, over_parameter, over_time
from electrovib.studies.compare.result import Comparison, Entry, answer, pages, tables
from electrovib.studies.compare.static import air_breaks_down, air_warnings, static_force
from electrovib.studies.explain import explain, in_time, knows_polarity
from electrovib.studies.sweep import parse_over

if TYPE_CHECKING:
    import xarray

STEP = 0.05
"""Duration of the step response [s]."""
EARLY = 50e-6
"""Time of the first value of the step response [s], when body and amplifier have charged the stack."""


def compare(
    scenario: Source,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    models: Sequence[str] | None = None,
    over: Sequence[str] | Mapping[str, Sequence[float] | Real] = (),
) -> Comparison:
    """Run every force law on the same finger and plate, and explain why they differ.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario: ``{"stack.gap": {"thickness": "5 um"}}``.
    models : sequence of str, optional
        Names of laws; all that need no parameter of their own if absent.
    over : sequence of str, or mapping of str to sequence of float
        ``"path=from:to:n"`` or ``"path=from:to:nlog"``: a figure of the static force over this parameter.

    Returns
    -------
    Comparison
        Numbers, figures as data, and explanations; `electrovib.save` writes them as an HTML page.

    Raises
    ------
    InputError
        For a scenario, a law or a range that is not valid.

    Notes
    -----
    The finger is pressed with the full load all the time, whatever `load.time_profile` is. Of an amplifier with limits,
    bandwidth and largest current are left out, because the laws are compared at voltages that are held.
    """
    given = read_scenario(scenario, changes=set)
    axes = over if isinstance(over, Mapping) else parse_over(given, over)
    return _compared(given, models, axes)


def _compared(
    scenario: Scenario, models: Sequence[str] | None, over: Mapping[str, Sequence[float] | Real]
) -> Comparison:
    if scenario.drive.quantity == "current":
        raise InputError(
            f"drive = {type(scenario.drive).__name__}: laws are compared at one voltage, and this drive prescribes the"
            " current. Take a drive in volts, for instance Sine"
        )
    scenario, highest = _without_limits(scenario)
    voltage = min(scenario.drive.largest(), highest)
    if voltage == 0:
        raise InputError(
            f"drive = {type(scenario.drive).__name__}: it stays at 0 V, where every law gives 0 N; set a voltage"
        )
    scenario = scenario.replace(_left_out(scenario))
    cases, left_out = _cases(scenario, models)
    frequency = scenario.frequency.frequencies()
    time = np.concatenate([[0.0], np.geomspace(1e-6, STEP, 400)])
    entries = []
    if cases:
        bench = _Bench(scenario, voltage, frequency, time)
        for name, case in cases.items():
            try:
                entries.append(bench.entry(name, case))
            except ElectrovibError as error:
                left_out[name] = str(error)
    if not entries:
        raise InputError(f"no law can be compared here. {name}: {why}" for name, why in left_out.items())
    entries.sort(key=lambda entry: -entry.static)
    panels = [
        over_frequency(entries, frequency=frequency, voltage=voltage),
        over_time(entries, time=time, voltage=voltage),
    ]
    ordered = {entry.name: cases[entry.name] for entry in entries}
    panels += [
        over_parameter(scenario, ordered, path, values=np.asarray(values), highest=highest)
        for path, values in over.items()
    ]
    return Comparison(
        scenario=scenario,
        voltage=voltage,
        entries=tuple(entries),
        answer=answer(scenario, entries, voltage=voltage),
        left_out=left_out,
        frequency=frequency,
        time=time,
        tables=tables(entries, left_out, scenario),
        panels=tuple(panels),
        pages=pages(scenario, entries),
    )


def _left_out(scenario: Scenario) -> dict[str, Any]:
    """Return changes that leave out what does not enter the attraction and has no periodic state."""
    changes: dict[str, Any] = {}
    if not isinstance(scenario.load.time_profile, Steady):
        changes["load.time_profile"] = {"model": "Steady"}
    if not isinstance(scenario.friction, SteadyFriction):
        changes["friction"] = {"model": "Coulomb", "coefficient": 0.5}  # any: no law reads the friction
    return changes


def _without_limits(scenario: Scenario) -> tuple[Scenario, float]:
    """Replace an amplifier with limits by its gain; return also the highest voltage of the drive that it amplifies [V]."""
    amplifier = scenario.circuit.amplifier
    if amplifier is None or not amplifier.is_limited:
        return scenario, np.inf
    saturation = np.inf if amplifier.saturation is None else amplifier.saturation
    highest = saturation / abs(amplifier.gain) if amplifier.gain else np.inf
    return scenario.replace({"circuit.amplifier": {"gain": amplifier.gain}}), highest


def _cases(scenario: Scenario, models: Sequence[str] | None) -> tuple[dict[str, Scenario], dict[str, str]]:
    laws = find_members(ForceLaw)
    if models is not None and not models:
        raise InputError(f"--models: names no force law. Known: {', '.join(sorted(laws))}.")
    unknown = [name for name in models or () if name not in laws]
    if unknown:
        raise InputError(
            f"--models: '{name}' is not a force law.{near_members(ForceLaw, name)}" for name in unknown
        )
    cases: dict[str, Scenario] = {}
    left_out: dict[str, str] = {}
    for name in models or laws:
        if name == type(scenario.force).__name__:
            cases[name] = scenario
            continue
        try:
            cases[name] = scenario.replace({"force": {"model": name}})
        except InputError as error:
            left_out[name] = "; ".join(each if each.path else each.reason for each in error.problems)
    return cases, left_out


class _Bench:
    """References of all laws on one stack: the Maxwell stress in the gap, and breakdown of its air."""

    def __init__(self, scenario: Scenario, voltage: float, frequency: Real, time: Real) -> None:
        self.voltage, self.frequency, self.time = voltage, frequency, time
        in_gap = scenario.replace({"force": {"model": "MaxwellStressInGap"}})
        self.static = static_force(in_gap, voltage=voltage)
        self.breakdown = air_breaks_down(scenario, voltage=voltage)
        step = self.step(in_gap, voltage)
        self.stack_warnings = _warnings(step)
        self.air_warnings = air_warnings(step)

    def step(self, case: Scenario, voltage: float) -> xarray.Dataset:
        """Simulate a step from rest to a voltage [V]."""
        changes: dict[str, Any] = {"drive": {"model": "Step", "level": voltage}}
        return simulate(case.replace(changes | {"time.initial_state": {"model": "AtRest"}}), time=self.time)

    def entry(self, name: str, case: Scenario) -> Entry:
        """Compute the entry of one law."""
        law = case.force
        static = static_force(case, voltage=self.voltage)
        mean = mean_force(case, phasors(case, self.frequency), amplitude=self.voltage)
        why = explain(case, ratio=static / self.static)
        early = late = polarity = np.nan
        try:
            trace = self.step(case, self.voltage)
        except NotCausalError:
            step, warnings = np.zeros(0), self.stack_warnings
        else:
            step, warnings = np.asarray(trace.electrostatic_force.values), _warnings(trace)
            early, late = float(np.interp(EARLY, self.time, step)), float(step[-1])
            why += f"; {in_time(case, early=early, late=late)}"
            polarity = self.polarity(case, step)
        in_the_gap = law.evaluation_surface == "gap"
        if in_the_gap:
            warnings = tuple(dict.fromkeys([*warnings, *self.air_warnings]))
        return Entry(
            name=name,
            evaluation_surface=law.evaluation_surface,
            status=law.status,
            static=static,
            ratio=static / self.static,
            early=early,
            late=late,
            mean=mean,
            step=step,
            polarity=polarity,
            why=why,
            warnings=warnings,
            breakdown=self.breakdown if in_the_gap else "",
        )

    def polarity(self, case: Scenario, step: Real) -> float:
        """Return the mean attraction of a step over that of a step of the opposite sign, dimensionless."""
        if not knows_polarity(case):
            return 1.0
        turned = self.step(case, -self.voltage).electrostatic_force.values
        return float(np.trapezoid(step, self.time) / np.trapezoid(turned, self.time))


def _warnings(trace: xarray.Dataset) -> tuple[str, ...]:
    return tuple(
        diagnostic["text"]
        for diagnostic in json.loads(trace.attrs["validity"])
        if diagnostic["state"] == "warning" and diagnostic["name"] != "discontinuity"
    )
