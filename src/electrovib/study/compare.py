"""Every force law on one stack: how far they are apart, in size and in time, and why."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from electrovib.core.discovery import find_members, papers
from electrovib.core.errors import ElectrovibError, InputError, NotCausalError, nearest
from electrovib.core.paths import quantity_at
from electrovib.core.units import format_quantity
from electrovib.physics.force import ForceLaw
from electrovib.physics.material import Material
from electrovib.solve.expand import mean_force, phasors
from electrovib.solve.scenario import Scenario
from electrovib.solve.simulate import simulate
from electrovib.solve.transfer import Real
from electrovib.study.explain import explain, in_time
from electrovib.study.reproduction import Curve, Page, Panel, Table

STEP = 0.05
"""How long the step response is followed [s]."""
EARLY = 50e-6
"""When it is first read: body and amplifier have charged the stack by then [s]."""


@dataclass(frozen=True)
class Entry:
    """One law on the stack.

    Parameters
    ----------
    name, plane, status : str
        Law, where it cuts the finger free, how its source was read.
    static : float
        Attraction at the peak voltage held for ever when nothing conducts [N].
    ratio : float
        Static attraction over that of the gap plane.
    early, late : float
        Attraction 50 us and 50 ms after a step to the peak voltage [N]; NaN for a law without a response in
        time.
    mean : ndarray, shape (frequencies,)
        Time mean under a sine of the peak voltage [N].
    step : ndarray, shape (times,) or (0,)
        Step response [N].
    why : str
        Where the ratio comes from.
    warnings : tuple of str
        What lies beyond a limit.
    """

    name: str
    plane: str
    status: str
    static: float
    ratio: float
    early: float
    late: float
    mean: Real
    step: Real
    why: str
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class Comparison:
    """All laws on one scenario.

    Parameters
    ----------
    scenario : Scenario
        The stack.
    voltage : float
        Peak voltage at which the laws are compared [V].
    entries : tuple of Entry
        From the largest to the smallest static force.
    left_out : mapping of str to str
        Law to why it is not in the comparison.
    frequency, time : ndarray
        Axes of `mean` and `step`.
    tables, panels, pages
        The same for a report.
    """

    scenario: Scenario
    voltage: float
    entries: tuple[Entry, ...]
    left_out: Mapping[str, str]
    frequency: Real
    time: Real
    tables: tuple[Table, ...]
    panels: tuple[Panel, ...]
    pages: tuple[Page, ...]


def compare(
    scenario: Scenario,
    *,
    models: Sequence[str] | None = None,
    over: Mapping[str, Sequence[float] | Real] | None = None,
) -> Comparison:
    """Run every force law on the same finger and plate.

    Parameters
    ----------
    scenario : Scenario
        Stack, contact, circuit and drive; its own law is one among the others.
    models : sequence of str, optional
        Names of laws; all that need no parameter of their own if absent.
    over : mapping of str to sequence of float, optional
        Dotted path to values in SI, over which the static force is drawn.

    Returns
    -------
    Comparison
        Numbers, figures as data, and words.

    Raises
    ------
    InputError
        For a name that is not a force law, or a drive that prescribes the current.
    """
    if scenario.drive.quantity == "current":
        raise InputError(
            f"drive = {type(scenario.drive).__name__}: laws are compared at one voltage, and this drive prescribes the"
            " current. Take a drive in volts, for instance Sine"
        )
    cases, left_out = _cases(scenario, models)
    voltage = _peak(scenario)
    frequency = scenario.frequency.frequencies()
    time = np.concatenate([[0.0], np.geomspace(1e-6, STEP, 400)])
    reference = static_force(scenario.replace({"force": {"model": "GapPlane"}}), voltage)
    entries = []
    for name, case in cases.items():
        try:
            entries.append(_entry(name, case, voltage, reference, frequency, time))
        except ElectrovibError as error:
            left_out[name] = str(error)
    entries.sort(key=lambda entry: -entry.static)
    panels = [_over_frequency(entries, frequency, voltage), _over_time(entries, time, voltage)]
    ordered = {entry.name: cases[entry.name] for entry in entries}
    panels += [_over_parameter(ordered, path, np.asarray(values)) for path, values in (over or {}).items()]
    return Comparison(
        scenario,
        voltage,
        tuple(entries),
        left_out,
        frequency,
        time,
        _tables(entries, left_out),
        tuple(panels),
        _pages(entries),
    )


def _cases(scenario: Scenario, models: Sequence[str] | None) -> tuple[dict[str, Scenario], dict[str, str]]:
    laws = find_members(ForceLaw)
    unknown = [name for name in models or () if name not in laws]
    if unknown:
        raise InputError(f"--models: '{name}' is not a force law.{nearest(name, laws)}" for name in unknown)
    cases: dict[str, Scenario] = {}
    left_out: dict[str, str] = {}
    for name in models or laws:
        if name == type(scenario.force).__name__:
            cases[name] = scenario
            continue
        try:
            cases[name] = scenario.replace({"force": {"model": name}})
        except InputError as error:
            left_out[name] = "; ".join(error.problems)
    return cases, left_out


def _peak(scenario: Scenario) -> float:
    return float(np.max(np.abs(scenario.drive.voltage(np.linspace(0, scenario.drive.duration, 4001)))))


def insulating(scenario: Scenario) -> Scenario:
    """Give the same stack with nothing that conducts, and dispersion kept."""
    changes: dict[str, Any] = {}
    for name, layer in scenario.stack.layers.items():
        changes |= _without_conduction(layer.material, f"stack.{name}.material")
        if layer.leak is not None:
            changes[f"stack.{name}.leak"] = None
    return scenario.replace(changes) if changes else scenario


def _without_conduction(material: Material, path: str) -> dict[str, Any]:
    return {f"{path}.conductivity": 0.0} if material.conductivity else {}


def static_force(scenario: Scenario, voltage: float) -> float:
    """Attraction at a voltage held for ever when nothing conducts [N].

    Parameters
    ----------
    scenario : Scenario
        Stack, contact and law.
    voltage : float
        V.

    Returns
    -------
    float
        N. For a law of magnitudes, twice its mean under a slow sine.
    """
    held = insulating(scenario)
    changes = {
        "drive": {"model": "Constant", "level": voltage},
        "time.initial_state": {"model": "PeriodicState"},
    }
    if not scenario.force.causal:
        slow = phasors(held, np.array([1.0]))
        return 2 * float(mean_force(held, slow, voltage)[0])
    return float(simulate(held.replace(changes), time=np.array([0.0, 1.0])).electrostatic_force[-1])


def _entry(name: str, case: Scenario, voltage: float, reference: float, frequency: Real, time: Real) -> Entry:
    static = static_force(case, voltage)
    mean = mean_force(case, phasors(case, frequency), voltage)
    try:
        start = case.replace(
            {"drive": {"model": "Constant", "level": voltage}, "time.initial_state": {"model": "AtRest"}}
        )
        trace = simulate(start, time=time)
        step = np.asarray(trace.electrostatic_force.values)
        warnings = [lamp["text"] for lamp in json.loads(trace.attrs["lamps"]) if lamp["state"] == "warning"]
        warnings = [text for text in warnings if "the drive jumps" not in text]
    except NotCausalError:
        step, warnings = np.zeros(0), []
    early, late = (float(np.interp(EARLY, time, step)), float(step[-1])) if len(step) else (np.nan, np.nan)
    law = case.force
    why = explain(case, static / reference)
    if len(step):
        why += "; " + in_time(early, late)
    return Entry(
        name, law.plane, law.status, static, static / reference, early, late, mean, step, why, tuple(warnings)
    )


def _tables(entries: Sequence[Entry], left_out: Mapping[str, str]) -> tuple[Table, ...]:
    def force(value: float) -> str:
        return "no response in time" if np.isnan(value) else format_quantity(value, "N", digits=4)

    rows = tuple(
        (e.name, e.plane, e.status, force(e.static), f"{e.ratio:.4g}", force(e.early), force(e.late), e.why)
        for e in entries
    )
    headings = (
        "law",
        "plane",
        "how read",
        "static",
        "over gap plane",
        "50 us after a step",
        "50 ms after",
        "why",
    )
    found = [Table("Every law on this stack", headings, rows)]
    beyond = {text for entry in entries for text in entry.warnings}
    if beyond:
        found.append(Table("Beyond a limit", ("what",), tuple((text,) for text in sorted(beyond))))
    if left_out:
        lines = tuple((name, why) for name, why in left_out.items())
        found.append(Table("Not in this comparison", ("law", "why"), lines))
    return tuple(found)


def _over_frequency(entries: Sequence[Entry], frequency: Real, voltage: float) -> Panel:
    curves = tuple(Curve(e.name, frequency, e.mean) for e in entries if np.all(e.mean > 0))
    caption = f"Time mean under a sine of {format_quantity(voltage, 'V')}, materials as declared."
    return Panel(
        "force_over_frequency",
        "Mean force over frequency",
        caption,
        ("frequency", "Hz"),
        ("mean electrostatic force", "N"),
        curves,
        log_x=True,
        log_y=True,
    )


def _over_time(entries: Sequence[Entry], time: Real, voltage: float) -> Panel:
    curves = []
    for entry in entries:
        if len(entry.step):
            floor = np.max(entry.step) * 1e-6
            curves.append(Curve(entry.name, time[1:], np.maximum(entry.step[1:], floor)))
    caption = (
        f"After a step to {format_quantity(voltage, 'V')} from rest. The planes differ in time, not only in size: as"
        " the skin conducts, the field leaves it and goes into the insulator and the gap. Values a million times below"
        " a law's largest are drawn there."
    )
    return Panel(
        "force_over_time",
        "Step response",
        caption,
        ("time", "s"),
        ("electrostatic force", "N"),
        tuple(curves),
        log_x=True,
        log_y=True,
    )


def _over_parameter(cases: Mapping[str, Scenario], path: str, values: Real) -> Panel:
    curves = []
    quantity = quantity_at(next(iter(cases.values())), path)
    for name, case in cases.items():
        forces = [
            static_force(case.replace({path: float(value)}), _peak(case.replace({path: float(value)})))
            for value in values
        ]
        curves.append(Curve(name, values, np.array(forces)))
    return Panel(
        f"static_over_{path.replace('.', '_')}",
        f"Static force over {path}",
        f"At the peak voltage of the drive, nothing conducting. {quantity.doc}.",
        (path, quantity.unit),
        ("static electrostatic force", "N"),
        tuple(curves),
        log_x=bool(np.min(values) > 0 and np.max(values) / np.min(values) > 20),
        log_y=True,
    )


def _pages(entries: Sequence[Entry]) -> tuple[Page, ...]:
    largest, smallest = entries[0], entries[-1]
    said = (
        "The static laws are one electric displacement, divided by the permittivity of the plane at which each cuts the"
        " finger free. The finger can separate from the plate only in the gap, so the gap plane is the physical one;"
        f" here the laws differ by a factor {largest.static / smallest.static:.3g}, from {largest.name} to {smallest.name}.",
    )
    disagreements = tuple(text for module in papers().values() for text in getattr(module, "DEFECTS", ()))
    pages = [Page("Why they differ", (*said, *(f"{entry.name}: {entry.why}" for entry in entries)))]
    if disagreements:
        pages.append(Page("Where papers contradict themselves or each other", disagreements))
    return tuple(pages)
