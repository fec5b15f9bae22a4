"""The circuit of a scenario: amplifier, layers, finger and body."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError, refuse
from electrovib.core.units import format_quantity
from electrovib.exports.spice.section import Formula, LayerElements, Names, continued, initial, number, remark
from electrovib.physics.drive.parts import Linear, Smooth, Tones
from electrovib.physics.stack import interface_place
from electrovib.scenario import PeriodicState, Scenario
from electrovib.solve.electrics.transient import transient
from electrovib.solve.stack.expand import Surroundings, modes, reductions
from electrovib.solve.stack.modes import merged_terms
from electrovib.solve.stack.prony import Reduction
from electrovib.solve.stack.transfer import INTEGRATING, Transfer

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.drive.parts import Part
    from electrovib.scenario import TimeGrid
    from electrovib.solve.stack.section import ModalSection


@dataclass(kw_only=True)
class BuiltCircuit:
    """The circuit from the amplifier through finger and body to ground, with the elements of the netlist in blocks."""

    scenario: Scenario
    start: Start
    reductions: dict[str, Reduction]
    slabs: dict[str, LayerElements] = field(default_factory=dict)
    all_slabs: list[LayerElements] = field(default_factory=list)
    nodes: list[str] = field(default_factory=lambda: ["drive"])
    blocks: list[list[str]] = field(default_factory=list)
    names: Names = field(default_factory=lambda: Names({"amplitude", "body"}))

    @classmethod
    def of(cls, scenario: Scenario) -> BuiltCircuit:
        """Build the circuit of a scenario."""
        found = reductions(scenario)
        debye = {name: reduction.debye for name, reduction in found.items()}
        built = cls(scenario=scenario, start=Start.of(scenario, debye), reductions=found)
        built._amplifier()
        built._first_contact()
        built._return_path()
        return built

    def sources(self, timing: Timing) -> list[str]:
        """Return the sources of the drive."""
        return drive_sources(self.scenario.drive, timing)

    def _amplifier(self) -> None:
        resistance = self.scenario.circuit.source_resistance
        lines = [remark(f"amplifier: ammeter, resistance {format_quantity(resistance, 'ohm', digits=6)}")]
        if resistance > 0:
            lines += ["V_current drive output DC 0", f"R_source output plate {number(resistance)}"]
            self.nodes.append("output")
        else:
            lines.append("V_current drive plate DC 0")
        self.nodes.append("plate")
        self.blocks.append(lines)

    def _first_contact(self) -> None:
        back, around = self.scenario.circuit.return_path.element(), Surroundings.of(self.scenario)
        goes_on = around.second or back.resistance or back.elastance
        self._contact(1.0, self.start.fields, around.area, last="finger" if goes_on else "0")
        self.slabs = {slab.path: slab for slab in self.all_slabs}

    def _return_path(self) -> None:
        around, path = Surroundings.of(self.scenario), self.scenario.circuit.return_path
        back = path.element()
        self.blocks.append([remark(f"return path: {type(path).__name__}")])
        if back.resistance > 0:
            after = "back" if around.second or back.elastance else "0"
            self.blocks[-1].append(f"R_return {self.nodes[-1]} {after} {number(back.resistance)}")
            self._reach(after)
        if around.second:
            area, last = around.area / around.second, "body" if back.elastance else "0"
            self._contact(-around.second, self.start.second_fields, area, last=last)
        if back.elastance > 0:
            start, node = self.start.body_voltage(), self.nodes[-1]
            lines = [f"C_body {node} 0 {number(1 / back.elastance)}{initial(start)}"]
            if back.rate > 0:
                lines.append(f"R_body_leak {node} 0 {number(back.elastance / back.rate)}")
            self.blocks[-1] += lines

    def _contact(self, share: float, fields: Mapping[str, float], area: float, *, last: str) -> None:
        """Add the layers of a contact up to the node `last`.

        `share` is its current density over that of the first contact. It is negative for a second contact, with
        the same layers in reverse order, whose fields point away from the finger; `fields` are those from rest.
        """
        is_first, layers = share > 0, [*self.scenario.stack.layers.items()]
        for path, layer in layers if is_first else reversed(layers):
            transfer, reduction = self.start.field(path), self.reductions[path]
            own = fields[path] if is_first else -fields[path]
            is_last = path == layers[-1 if is_first else 0][0]
            before, named = self.nodes[-1], f"after_{path}" if is_first else f"second_before_{path}"
            after = last if is_last else self.names.new(named)
            plate, finger = (before, after) if is_first else (after, before)
            relaxed = self.start.lowpassed(transfer, merged_terms(reduction.debye)[0])
            slab = LayerElements(
                path=path, name=self.names.new(path if is_first else f"second_{path}"), plate_side=plate,
                finger_side=finger, layer=layer, reduction=reduction, area=area,
                field=share * self.start.level(transfer) + own, relaxed=tuple(share * each for each in relaxed),
            )  # fmt: skip
            self.all_slabs.append(slab)
            self.blocks.append(slab.elements())
            self._reach(*(branch.node for branch in slab.branches), after)

    def _reach(self, *nodes: str) -> None:
        """Add nodes; the next element begins at the last one."""
        self.nodes += [node for node in nodes if node != "0"]


MOST_TONES = 500
"""Largest number of sines in one formula, each of which is evaluated at every step."""


def drive_sources(drive: Drive, timing: Timing) -> list[str]:
    """Return the sources between the nodes ``drive`` and ``0``, one of them the unit source of the response.

    The only approximation is the edge that replaces a step.
    """
    lines, bottom = [], "0"
    current, parts = drive.quantity == "current", drive.parts()
    for count, part in enumerate(parts, start=1):
        top, below = ("0", "drive") if current else (f"drive_{count}", bottom)
        source = _source(part, timing, label=type(drive).__name__)
        lines += _elements(source, f"drive_{count}", top, below, current=current)
        bottom = f"drive_{count}"
    kind, ends = ("I", "0 drive") if current else ("V", f"drive {bottom}")
    begin = [remark("not part of the circuit: the corner of this source makes the first step short")]
    begin += [f"V_begin begin 0 DC 0 {_pwl([(0.0, 0.0), (timing.edge, 1.0)])}", "R_begin begin 0 1.0"]
    return [*lines, f"{kind}_response {ends} DC 0 AC 1", *begin]


def _elements(source: tuple[str, str], name: str, top: str, below: str, *, current: bool) -> list[str]:
    """Return one source, with the gate that switches it if it has one."""
    text, gate = source
    lines = [continued(f"V_{name}_gate {name}_gate 0 DC 0 {gate}")] if gate else []
    if not text.startswith("="):
        return [*lines, continued(f"{'I' if current else 'V'}_{name} {top} {below} DC 0 {text}")]
    text = text.replace("GATE", f"V({name}_gate)")
    return [*lines, continued(f"B_{name} {top} {below} {'I' if current else 'V'} {text}")]


def _source(part: Part, timing: Timing, *, label: str) -> tuple[str, str]:
    """Return the waveform of an independent source, or '= formula' of a behavioural one, and its gate."""
    if isinstance(part, Linear):
        return _points(part, timing), ""
    gate = _gate(part, timing)
    if isinstance(part, Tones) and len(part.frequencies) == 1 and len(gate) == 1:
        return _sine(part), ""
    text = _smooth(part, label) if isinstance(part, Smooth) else _tones(part, label)
    return f"= GATE*({text})", _pwl(gate)


def _points(part: Linear, timing: Timing) -> str:
    """Return the corners up to the end; a step becomes a short edge around its time, except at time 0."""
    pieces, half = part.until(timing.duration), timing.edge / 2
    rising = np.append((pieces.before[1:] - pieces.after[:-1]) / np.diff(pieces.times), 0.0)
    corners = [(0.0, float(pieces.after[0]))]
    for count, time in enumerate(pieces.times.tolist()[1:], start=1):
        early, late = float(pieces.before[count]), float(pieces.after[count])
        if early == late:
            corners.append((time, late))
        else:
            corners.append((time - half, early - float(rising[count - 1]) * half))
            corners.append((time + half, late + float(rising[count]) * half))
        if time > timing.duration:
            break
    return _pwl(corners)


def _pwl(corners: list[tuple[float, float]]) -> str:
    return f"PWL({'  '.join(f'{number(time)} {number(value)}' for time, value in corners)})"


def _gate(part: Tones | Smooth, timing: Timing) -> list[tuple[float, float]]:
    """Return the corners of the gate of a part, 1 while it is on; at the operating point the part is off."""
    half, corners = timing.edge / 2, [(0.0, 1.0)]
    if part.start > 0:
        corners = [(0.0, 0.0), (part.start - half, 0.0), (part.start + half, 1.0)]
    if part.stop < timing.duration:
        corners += [(part.stop - half, 1.0), (part.stop + half, 0.0)]
    return corners


def _turned(amplitude: complex) -> tuple[float, float]:
    """Return peak value and phase [rad] relative to a sine, the phase rounded near multiples of a quarter turn."""
    phase = math.remainder(math.atan2(amplitude.imag, amplitude.real) + math.pi / 2, 2 * math.pi)
    quarters = round(phase / (math.pi / 2))
    near = quarters * math.pi / 2
    return abs(amplitude), near if abs(phase - near) < 1e-14 else phase


def _sine(part: Tones) -> str:
    size, phase = _turned(complex(part.amplitudes[0]))
    turn = f" 0 0 {number(math.degrees(phase))}" if phase else ""
    return f"SIN(0 {number(size)} {number(part.frequencies[0])}{turn})"


def _tones(part: Tones, label: str) -> str:
    heard = [
        (frequency, *_turned(complex(amplitude)))
        for frequency, amplitude in zip(part.frequencies.tolist(), part.amplitudes, strict=True)
        if amplitude
    ]
    if len(heard) > MOST_TONES:
        raise InputError(
            f"drive = {label}: it is a sum of {len(heard)} sines, more than the {MOST_TONES} allowed in a netlist; lower"
            " drive.depth, or give the voltage as a record, drive.model = Sampled"
        )
    terms = [
        f"{number(size)}*sin({number(2 * math.pi * frequency)}*time{f' + {number(phase)}' if phase else ''})"
        for frequency, size, phase in heard
    ]
    return " + ".join(terms).replace("+ -", "- ") or "0"


def _smooth(part: Smooth, label: str) -> str:
    """Return the formula in the variable `time`."""
    found: Any = None
    with suppress(TypeError, ValueError, AttributeError):
        found = part.formula(cast("Any", Formula("time")))
    if not isinstance(found, Formula):
        raise InputError(
            f"drive = {label}: its formula has more than the arithmetic and elementary functions of a netlist; give the"
            " voltage as a record, drive.model = Sampled"
        )
    return found.text


STEPS = 2000
"""Smallest number of steps in the whole time."""
PER_CYCLE = 300
"""Smallest number of steps in a cycle of the fastest oscillation."""
SHARPNESS = 2e-4
"""Duration of the edge that replaces a step of the drive, over the longest time step."""
FINEST = 1e4
"""Longest time step over the shortest straight piece of the drive; ngspice merges corners 5e-5 of a step apart."""


@dataclass(frozen=True)
class Timing:
    """Duration, longest time step, and duration of the edge that replaces a step of the drive [s]."""

    duration: float
    step: float
    edge: float

    @classmethod
    def of(cls, drive: Drive, grid: TimeGrid) -> Timing:
        """Return the timing of a drive over the time grid of a scenario."""
        duration = float(grid.times(drive)[-1])
        fastest, shortest = drive.highest_frequency, drive.shortest_piece(duration)
        step = duration / max(STEPS, (grid.samples or 0) - 1)
        if fastest > 0:
            step = min(step, 1 / (PER_CYCLE * fastest))
        step = min(step, FINEST * shortest)
        return cls(duration, step, min(SHARPNESS * step, shortest / 4))


APART = 1e-7
"""Relative distance by which a relaxation rate is moved from an equal rate of the stack, to avoid a double pole."""


@dataclass(frozen=True)
class Start:
    """Voltages at time 0: those of the periodic state, or from rest those of initial charge and a step of the drive.

    `section` is the stack in modes for the periodic state, None from rest. From rest there are the `fields`
    of the layers and the `second_fields` of those of a second contact in the direction of the current [V/m],
    the voltage `body` [V], and the displacement `interface` between plate and finger [C/m2].
    """

    scenario: Scenario
    section: ModalSection | None
    fields: Mapping[str, float]
    second_fields: Mapping[str, float]
    body: float
    interface: float

    @classmethod
    def of(cls, scenario: Scenario, debye: Mapping[str, DebyeSum]) -> Start:
        """Compute the voltages at time 0 of a scenario."""
        if not isinstance(scenario.time.initial_state, PeriodicState):
            return cls(scenario, None, *_charged(scenario, debye))
        _check_periodic(scenario)
        none = dict.fromkeys(debye, 0.0)
        return cls(scenario, modes(scenario)[0], none, none, 0.0, 0.0)

    def in_modes(self, signal: Callable[[ModalSection], Transfer]) -> Transfer | None:
        """Return a signal of the stack in modes; None from rest."""
        return None if self.section is None else signal(self.section)

    def field(self, name: str) -> Transfer | None:
        """Return the field of a layer in modes [V/m per volt]; None from rest."""
        return self.in_modes(lambda modes: modes[name].field)

    def interface_charge(self) -> float:
        """Return the displacement at the interface of plate and finger at time 0 [C/m2]."""
        if self.section is None:
            return self.interface
        return self.level(self.section.interface_displacement)

    def level(self, signal: Transfer | None) -> float:
        """Return the value at time 0 of a quantity that is linear in the drive [its unit]; 0 without modes."""
        if signal is None:
            return 0.0
        forced = replace(signal, slope=0.0, free=np.zeros(len(signal.rates)))
        return float(transient({"": forced}, self.scenario.drive, np.zeros(1), settled=True)[""][0])

    def lowpassed(self, signal: Transfer | None, rates: Real) -> list[float]:
        """Return the values at time 0 of a quantity after filters rate/(s + rate), with rates in 1/s [its unit]."""
        if signal is None:
            return [0.0] * len(rates)
        forced = replace(signal, free=np.zeros(len(signal.rates)))
        return [
            self.level(Transfer(rates=np.array([rate]), gains=np.ones(1)) * _kept_clear(forced, rate))
            for rate in rates
        ]

    def body_voltage(self) -> float:
        """Return the voltage of the capacitance of the body at time 0 [V]: the drive less stack and resistance."""
        if self.section is None:
            return self.body
        around = Surroundings.of(self.scenario)
        if self.scenario.drive.quantity == "current":
            rate = np.array([around.element.rate or INTEGRATING])
            return self.level(Transfer(rates=rate, gains=around.element.elastance / rate))
        drop = self.level(self.section.voltage) * (1 + around.second)
        if around.element.resistance:
            drop += around.element.resistance * around.area * self.level(self.section.current_density)
        return float(self.scenario.drive.voltage(0.0)) - drop


def _kept_clear(signal: Transfer, rate: float) -> Transfer:
    """Return a signal in modes whose rates are moved away from a given rate [1/s]."""
    close = np.abs(signal.rates - rate) < APART * rate
    return replace(signal, rates=np.where(close, rate * (1 + APART), signal.rates))


def _check_periodic(scenario: Scenario) -> None:
    layers = scenario.stack.layers.items()
    where = "time.initial_state = PeriodicState: a netlist cannot begin in the periodic state"
    instead = "use AtRest and a longer time.duration"
    problems = [
        f"{where} with stack.{name}.leak, which is not linear; {instead}"
        for name, layer in layers
        if layer.leak
    ]
    problems += [
        f"{where} with stack.{name}.initial_charge, of which only trapped charge remains in that state; {instead}"
        for name, layer in layers
        if layer.initial_charge
    ]
    refuse(problems)


def _charged(
    scenario: Scenario, debye: Mapping[str, DebyeSum]
) -> tuple[dict[str, float], dict[str, float], float, float]:
    """Return the fields of both contacts, the voltage of the body and the displacement at the interface from rest.

    Before time 0 the plate carries the image q of the charges Q_k on the plate's side of each element, so
    that the voltages add up to 0; under a prescribed current it carries none. Without a resistance in series,
    a step of the drive changes the charge at once: q sum T/eps = eps0 v - sum Q_k T_k/eps_k, with both sums
    over all elements in series.
    """
    layers, around, drive = scenario.stack.layers, Surroundings.of(scenario), scenario.drive
    charges = np.cumsum([0.0, *(layer.initial_charge for layer in layers.values())]).tolist()
    held, on_body = (
        dict(zip(layers, charges, strict=False)),
        charges[-1] + around.element.charge / around.area,
    )
    flown = 0.0
    if drive.quantity == "voltage":
        lengths = {name: layer.thickness / debye[name].high for name, layer in layers.items()}
        body = eps0 * around.area * around.element.elastance
        whole = sum(lengths.values()) * (1 + around.second) + body
        jump = eps0 * float(drive.voltage(0.0)) if around.element.resistance == 0 else 0.0
        flown = (jump - sum(held[name] * lengths[name] for name in layers) - on_body * body) / whole
    fields = {name: (held[name] + flown) / (eps0 * debye[name].high) for name in layers}
    second = {name: flown * around.second / (eps0 * debye[name].high) for name in layers}
    interface = charges[interface_place(scenario.stack.roles.values())] + flown
    return fields, second, (on_body + flown) * around.area * around.element.elastance, interface
