"""Comparison of force laws on one stack: static forces, responses, and figures in which a law keeps its colour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.answer import Curve, Panel, as_sentence
from electrovib.core.arrays import Real
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError, NotCausalError, computed_or_refused, in_short
from electrovib.core.mistakes import near_members
from electrovib.core.paths import quantity_at, words_at
from electrovib.core.units import format_quantity
from electrovib.physics.contact import RoughContact
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import SteadyFriction
from electrovib.physics.safety import AIR
from electrovib.physics.time_profile import Steady
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors
from electrovib.studies.check.amplifier import LARGEST, without_its_limits
from electrovib.studies.compare import result
from electrovib.studies.sweep import parse_over

if TYPE_CHECKING:
    import xarray


STEP = 0.05
"""Duration of the step response [s]."""
EARLY = 50e-6
"""Time of the first value of the step response [s], when body and a quick amplifier have charged the stack."""
CHARGED = 0.99
"""Share of the last voltage of the plate below which the amplifier still charges it at the first value; a choice."""


def compare(
    scenario: Source,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    models: Sequence[str] | None = None,
    over: Sequence[str] | Mapping[str, Sequence[float] | Real] = (),
) -> result.Comparison:
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
    The finger is pressed with the full load all the time, whatever `load.time_profile` is. The responses to a step contain
    the limits of an amplifier; static forces are those of the largest voltage that it holds, and means over frequency those
    of a sine that it supplies.

    Examples
    --------
    >>> found = ev.compare("bau_2010/sine", models=["MaxwellStressInGap", "MaxwellStressInInsulator"])
    >>> [f"{each.name}: {1e3 * each.static:.1f} mN" for each in found.entries]
    ['MaxwellStressInGap: 386.5 mN', 'MaxwellStressInInsulator: 99.1 mN']
    """
    given = read_scenario(scenario, changes=set)
    varied, voltage = parse_over(given, over), _voltage(given)
    given = given.replace(_left_out(given))
    cases, left_out = _cases(given, models)
    frequency = given.frequency.frequencies()
    time = np.unique(np.concatenate([[0.0, EARLY], np.geomspace(1e-6, STEP, 400)]))
    found: dict[str, result.Entry] = {}
    if cases:
        found, refused = computed_or_refused(cases, _Bench(given, voltage, frequency, time).entry)
        left_out |= refused
    if not found:
        raise InputError(f"no law can be compared here. {name}: {why}" for name, why in left_out.items())
    entries = sorted(found.values(), key=lambda entry: -entry.static)
    ordered = {entry.name: cases[entry.name] for entry in entries}
    return result.Comparison(
        scenario=given,
        voltage=voltage,
        entries=tuple(entries),
        headline=result.headline(given, entries, voltage=voltage),
        left_out=left_out,
        frequency=frequency,
        time=time,
        tables=result.tables(entries, left_out, given),
        panels=(
            over_frequency(entries, frequency=frequency, voltage=voltage),
            over_time(entries, time=time, voltage=voltage),
            *(over_parameter(given, ordered, path, values=values) for path, values in varied.items()),
        ),
        pages=result.pages(given, entries),
    )


def _voltage(scenario: Scenario) -> float:
    """Return the peak voltage at which laws are compared [V]."""
    named = f"drive = {type(scenario.drive).__name__}"
    if scenario.drive.quantity == "current":
        raise InputError(
            f"{named}: laws are compared at one voltage, and this drive prescribes the current. Take a drive in volts, for"
            " instance Sine"
        )
    voltage = min(scenario.drive.largest(), scenario.circuit.supply.largest_input)
    if voltage == 0:
        raise InputError(f"{named}: it stays at 0 V, where every law gives 0 N; set a voltage")
    return voltage


def _left_out(scenario: Scenario) -> dict[str, Any]:
    """Return changes that leave out what does not enter the attraction and has no periodic state."""
    changes: dict[str, Any] = {}
    if not isinstance(scenario.load.time_profile, Steady):
        changes["load.time_profile"] = {"model": "Steady"}
    if not isinstance(scenario.friction, SteadyFriction):
        changes["friction"] = {"model": "Coulomb", "coefficient": 0.5}  # any: no law reads the friction
    return changes


def _cases(scenario: Scenario, models: Sequence[str] | None) -> tuple[dict[str, Scenario], dict[str, str]]:
    laws = find_members(ForceLaw)
    models = None if models is not None and [*models] == ["all"] else models
    if models is not None and not models:
        raise InputError(f"--models: names no force law. Known: {', '.join(sorted(laws))}.")
    unknown = [name for name in models or () if name not in laws]
    if unknown:
        raise InputError(
            f"--models: '{name}' is not a force law.{near_members(ForceLaw, name)}" for name in unknown
        )
    return computed_or_refused(
        dict.fromkeys(models or laws, scenario), lambda name, own: _under(own, name), reason=in_short
    )


def _under(scenario: Scenario, law: str) -> Scenario:
    """Return a scenario with a law; another one takes the declared gap where a rough contact was solved for its gaps."""
    if law == type(scenario.force).__name__:
        return scenario
    changes: dict[str, Any] = {"force": {"model": law}}
    if isinstance(scenario.contact.surface, RoughContact):
        changes["contact.surface"] = None
    return scenario.replace(changes)


class _Bench:
    """References of all laws on one stack: the Maxwell stress in the gap, and breakdown of its air."""

    def __init__(self, scenario: Scenario, voltage: float, frequency: Real, time: Real) -> None:
        self.voltage, self.frequency, self.time = voltage, frequency, time
        in_gap = _under(scenario, "MaxwellStressInGap")
        self.static = static_force(in_gap, voltage=voltage)
        self.breakdown = air_breaks_down(scenario, voltage=voltage)
        step = _stepped(in_gap, voltage, time, "AtRest")
        self.stack_warnings = _warnings(step)
        self.air_warnings = air_warnings(step)

    def entry(self, name: str, case: Scenario) -> result.Entry:
        """Compute the entry of one law."""
        law = case.force
        static = static_force(case, voltage=self.voltage)
        mean = mean_force(case, phasors(case, self.frequency), amplitude=self.voltage)
        why = result.explain(case, ratio=static / self.static)
        early = late = polarity = np.nan
        try:
            trace = _stepped(case, self.voltage, self.time, "AtRest")
        except NotCausalError:
            step, warnings = np.zeros(0), self.stack_warnings
        else:
            step, warnings = np.asarray(trace.electrostatic_force.values), _warnings(trace)
            at = int(np.searchsorted(self.time, EARLY))
            early, late = float(step[at]), float(step[-1])
            plate = np.abs(trace.get("plate_voltage", trace.drive_voltage).values)
            charging = bool(plate[at] < CHARGED * plate[-1])
            why += f"; {result.in_time(case, early=early, late=late, charging=charging)}"
            polarity = self.polarity(case, step)
        in_the_gap = law.evaluation_surface == "gap"
        if in_the_gap:
            warnings = tuple(dict.fromkeys([*warnings, *self.air_warnings]))
        return result.Entry(
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
        if not result.knows_polarity(case):
            return 1.0
        turned = _stepped(case, -self.voltage, self.time, "AtRest").electrostatic_force.values
        return float(np.trapezoid(step, self.time) / np.trapezoid(turned, self.time))


def _warnings(trace: xarray.Dataset) -> tuple[str, ...]:
    found = (each for each in diagnostics_of(trace) if each.state == "warning")
    return tuple(each.text for each in found if each.name != "discontinuity")


SAME = 0.02
"""Relative difference up to which two curves coincide."""
KINDS = ("line", "dashed", "dotted")
"""Line styles of the first, second and every further of coinciding curves."""


def over_frequency(entries: Sequence[result.Entry], *, frequency: Real, voltage: float) -> Panel:
    """Return the figure of the mean force of each law over frequency, under a sine of the peak `voltage`."""
    curves = [
        Curve(label=entry.name, x=frequency, y=entry.mean, look=look)
        for look, entry in enumerate(entries)
        if np.all(entry.mean > 0)
    ]
    caption = f"Time mean under a sine of {format_quantity(voltage, 'V')}, materials as declared."
    x, y = ("frequency", "Hz"), ("mean electrostatic force", "N")
    return _panel(
        id="force_over_frequency", title="Mean force over frequency", caption=caption, x=x, y=y, curves=curves
    )


def over_time(entries: Sequence[result.Entry], *, time: Real, voltage: float) -> Panel:
    """Return the figure of the response of each law that has one to a step of the height `voltage`."""
    stepped = {look: entry for look, entry in enumerate(entries) if len(entry.step)}
    heights = (np.maximum(entry.step[1:], np.max(entry.step) * 1e-6) for entry in stepped.values())
    curves = [
        Curve(label=entry.name, x=time[1:], y=y, look=look)
        for (look, entry), y in zip(stepped.items(), heights, strict=True)
    ]
    caption = (
        f"After a step to {format_quantity(voltage, 'V')} from rest. The laws differ in time, not only in size: where a"
        " layer conducts, the field moves to the other layers. No value is drawn below a millionth of the largest of its"
        " law."
    )
    x, y = ("time", "s"), ("electrostatic force", "N")
    return _panel(id="force_over_time", title="Step response", caption=caption, x=x, y=y, curves=curves)


def _panel(*, curves: Sequence[Curve], **how: Any) -> Panel:
    return Panel(curves=all_to_be_seen(curves), log_x=True, log_y=True, **how)


def over_parameter(scenario: Scenario, cases: Mapping[str, Scenario], path: str, *, values: Real) -> Panel:
    """Return the figure of the static force of each law over a parameter."""
    quantity = quantity_at(scenario, path)
    curves, marks = [], []
    for look, (name, case) in enumerate(cases.items()):
        changed = [_with(case, path, float(value)) for value in values]
        varied = [(one, min(one.drive.largest(), one.circuit.supply.largest_input)) for one in changed]
        forces = np.array([static_force(one, voltage=voltage) for one, voltage in varied])
        curves.append(Curve(label=name, x=values, y=forces, look=look))
        if case.force.evaluation_surface == "gap":
            broken = np.array([bool(air_breaks_down(one, voltage=voltage)) for one, voltage in varied])
            label = f"{name}: air breaks down"
            if any(broken):
                marks.append(Curve(label=label, x=values[broken], y=forces[broken], kind="points", look=look))
    said = f"At the peak voltage of the drive, nothing conducting. {as_sentence(quantity.doc)}"
    if marks:
        said += " Points: there the air of the gap breaks down, so this force would not be measured."
    return Panel(
        id=f"static_over_{path.replace('.', '_')}",
        title=f"Static force over the {words_at(scenario, path)}",
        caption=said,
        x=(words_at(scenario, path), quantity.unit),
        y=("static electrostatic force", "N"),
        curves=(*all_to_be_seen(curves), *marks),
        log_x=bool(np.min(values) > 0 and np.max(values) / np.min(values) > 20),
        log_y=True,
    )


def _with(case: Scenario, path: str, value: float) -> Scenario:
    if path.startswith(("force.", "contact.surface.")):  # those of one law alone
        try:
            quantity_at(case, path)
        except InputError:
            return case
    return case.replace({path: value})


def all_to_be_seen(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """Draw a curve dashed where it covers another one over at least half of its length, dotted for several."""
    shown: list[Curve] = []
    for curve in curves:
        alike = (np.isclose(curve.y, other.y, rtol=SAME, atol=0.0) for other in shown)
        below = sum(bool(np.mean(each) >= 1 / 2) for each in alike)
        shown.append(replace(curve, kind=KINDS[min(below, len(KINDS) - 1)]))
    return tuple(shown)


def insulating(scenario: Scenario) -> Scenario:
    """Return the same stack without conduction, with its dispersion, behind an amplifier without largest values."""
    changes: dict[str, Any] = {}
    for name, layer in scenario.stack.layers.items():
        if layer.material.conductivity:
            changes[f"stack.{name}.material"] = layer.material.conducting(0.0).to_dict()
        if layer.leak is not None:
            changes[f"stack.{name}.leak"] = None
    return without_its_limits(scenario.replace(changes) if changes else scenario, LARGEST)


def _stepped(scenario: Scenario, voltage: float, time: Real, state: str) -> xarray.Dataset:
    """Simulate a step to a voltage [V], from rest or in the steady state."""
    changes = {"drive": {"model": "Step", "level": voltage}, "time.initial_state": {"model": state}}
    return simulate(scenario.replace(changes), time=time)


def _held(scenario: Scenario, voltage: float) -> xarray.Dataset:
    return _stepped(scenario, voltage, np.array([0.0, 1.0]), "PeriodicState")


def static_force(scenario: Scenario, *, voltage: float) -> float:
    """Compute the steady attraction at a constant voltage without conduction.

    Of a law without a response in time it is twice its mean under a sine of 1 Hz.
    """
    held = insulating(scenario)
    if not scenario.force.causal:
        slow = phasors(held, np.array([1.0]))
        return 2 * float(mean_force(held, slow, amplitude=voltage)[0])
    return float(_held(held, voltage).electrostatic_force[-1])


def air_breaks_down(scenario: Scenario, *, voltage: float) -> str:
    """Return the warnings about the air of the gap at a constant voltage without conduction; empty without one."""
    in_gap = _under(insulating(scenario), "MaxwellStressInGap")
    return "; ".join(air_warnings(_held(in_gap, voltage)))


def air_warnings(trace: xarray.Dataset) -> tuple[str, ...]:
    """Return what a Trace states about breakdown of the air of its gap."""
    return tuple(each.text for each in diagnostics_of(trace) if each.name in AIR and each.state == "warning")
