"""What a drive and a stream of a texture share: inputs, what the limits allow, and the samples at given positions."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.deprecation import former_value
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity, number_in
from electrovib.physics.limits import unit_of_limit
from electrovib.physics.texture.base import RenderingPlate, Texture
from electrovib.scenario import Scenario, Source, TimeGrid, read_scenario
from electrovib.solve.expanded import Expanded
from electrovib.studies.check import DeclaredLimit, LimitsSource, declared_limits, refuse_unlimited, sampled
from electrovib.studies.design.drive.carrier import carrier_gain
from electrovib.studies.design.limits import Bounds
from electrovib.studies.texture.reading import TextureSource, read_texture
from electrovib.studies.texture.stream import added_friction

_ROUNDED: Final = 1e-9
"""Relative excess that counts as rounding."""


@dataclass(frozen=True, kw_only=True)
class Synthesis:
    """Texture, friction, gain and limits that together determine each sample from position and velocity.

    With a carrier of frequency f, sample n is a(n) sin(2 pi f n/rate), where a^2 times the gain of the force
    at f is the wanted attraction; without a carrier it is a(n). Envelope and carrier depend on the sample and
    on the finger alone, so that the samples are the same in whatever blocks they are computed.
    """

    texture: Texture
    friction: AttractionOfFriction
    hardware: RenderingHardware
    rate: float

    @functools.cached_property
    def ramp_samples(self) -> int:
        """Intervals of a ramp, 1 at least."""
        return max(1, round(self.hardware.ramp * self.rate))

    @np.errstate(over="ignore")
    def forces(self, position: Real, velocity: Real) -> Real:
        """Return the wanted attraction, out of range where it cannot be rendered; NaN where the texture gives none."""
        return self.friction.force(added_friction(self.texture, position, velocity, self.friction.plate))

    def amplitudes(self, forces: Real) -> Real:
        """Return the amplitude of the carrier, or the voltage without one; 0 for forces below 0."""
        hardware = self.hardware
        found = hardware.largest_amplitude * np.sqrt(np.maximum(forces / hardware.largest_force, 0.0))
        largest = hardware.largest_amplitude
        if found.max(initial=0.0) > largest:
            return np.where(found <= largest * (1 + _ROUNDED), np.minimum(found, largest), found)
        return np.asarray(found)

    @np.errstate(invalid="ignore")  # 0 times infinity, which `first_fault` finds
    def rising(self, first: int, amplitudes: Real) -> Real:
        """Return amplitudes from sample `first` on times the ramp at the beginning, which is 0 at sample 0."""
        if first >= self.ramp_samples:
            return amplitudes
        return np.minimum(1.0, np.arange(first, first + len(amplitudes)) / self.ramp_samples) * amplitudes

    def falling(self, since: int, count: int, amplitude: float) -> Real:
        """Return `count` amplitudes of the ramp at the end after `since` of its samples; 0 from its end on."""
        steps = np.arange(since + 1, since + count + 1)
        return amplitude * np.maximum(0.0, 1 - steps / self.ramp_samples)

    def voltages(self, first: int, amplitudes: Real) -> Real:
        """Return the samples of the drive from sample `first` on."""
        carrier = self.hardware.carrier
        if not carrier:
            return amplitudes
        cycles = (
            math.fmod(first * carrier, self.rate) / self.rate
        )  # less than one cycle, however long the drive
        phase = np.arange(len(amplitudes)) * (2 * math.pi * carrier / self.rate) + 2 * math.pi * cycles
        return np.asarray(amplitudes * np.sin(phase) + 0.0)

    @np.errstate(invalid="ignore")  # infinite amplitudes
    def first_fault(self, forces: Real, ramped: Real, before: float) -> tuple[int, str]:
        """Find the first sample at which the texture or a limit is not held, -1 if all are, and what is not held.

        With a carrier of angular frequency w the slope between two samples is at most the root of a'^2 + (w
        a)^2, with the slope a' and the larger amplitude a of both.
        """
        if len(ramped) == 0:
            return -1, ""
        hardware, both = self.hardware, np.concatenate(([before], ramped))
        steps = (both[1:] - both[:-1]) * self.rate
        limits = hardware.largest_force, hardware.largest_slope
        largest_force, largest_slope = (limit * (1 + 2 * _ROUNDED) for limit in limits)
        turning = 2 * math.pi * hardware.carrier
        # one bound for all samples first, which nearly every block meets
        steepest = math.hypot(max(steps.max(), -steps.min()), turning * both.max())
        if steepest <= largest_slope and forces.min() >= 0 and forces.max() <= largest_force:
            return -1, ""
        slopes = np.hypot(steps, turning * np.maximum(both[1:], both[:-1]))
        held = (forces >= 0) & (forces <= largest_force) & (slopes <= largest_slope)
        if held.all():
            return -1, ""
        place = int(np.argmin(held))
        if math.isnan(forces[place]):
            unknown = np.count_nonzero(np.isnan(forces))
            return place, (
                f"the model '{type(self.texture).__name__}' returned NaN or infinity, {unknown} of {len(forces)} values; the"
                " added friction has to be a number of newtons"
            )
        return place, self._why(float(forces[place]), float(slopes[place]))

    def _why(self, force: float, slope: float) -> str:
        hardware, needed = self.hardware, format_quantity(force, "N", digits=4)
        if not force >= 0:
            return (
                "the texture has less friction than the plate itself, and attraction only adds friction; raise the texture or"
                " lower its baseline"
            )
        if force > hardware.largest_force:
            wanted = f"an attraction of {needed}" if math.isfinite(force) else "more"
            return (
                f"the texture needs {wanted}, and the hardware gives {format_quantity(hardware.largest_force, 'N', digits=4)} at"
                f" {format_quantity(hardware.largest_amplitude, 'V', digits=4)}, within {hardware.bound}; reduce the texture, or"
                " take another carrier"
            )
        return (
            f"the voltage changes at {format_quantity(slope, 'V/s', digits=4)}, and the limits of current and slew rate"
            f" allow {format_quantity(hardware.largest_slope, 'V/s', digits=4)}; take wider edges, a slower finger, or a shorter"
            " ramp, which leaves more of them to changes of the amplitude"
        )


Amount: TypeAlias = float | str
"""A number in SI, or text with a unit."""
AllLimits: TypeAlias = "LimitsSource | Sequence[LimitsSource]"
RAMP: Final = 1e-3
"""Duration of a ramp at either end [s], by default; a choice."""
FREQUENCY: Final = 100.0
"""Frequency at which the force of a drive without carrier is taken [Hz]; a choice."""
IN_CYCLE: Final = 64
"""Samples per cycle of the carrier, where no rate is given: straight lines between them lower the force by 0.16 %."""
WITHOUT_CARRIER: Final = 10e3
"""Samples per second without a carrier, where no rate is given [Hz]; a choice."""
FINEST: Final = 0.4
"""Highest carrier over the rate of samples [1]; a choice below the limit of 0.5."""


@dataclass(frozen=True, kw_only=True)
class RenderingSetUp:
    """Scenario and texture as they were read, with the strictest limit of each quantity, that of the amplifier too."""

    scenario: Scenario
    texture: Texture
    declared: Mapping[str, DeclaredLimit]

    @classmethod
    def read(
        cls,
        scenario: Source,
        texture: TextureSource,
        changes: Mapping[str, Any] | None,
        limits: AllLimits,
        what: str,
    ) -> RenderingSetUp:
        """Read the inputs, and refuse them unless the largest voltage and the largest current are declared."""
        found, read = read_scenario(scenario, changes=changes), read_texture(texture)
        refuse_unlimited(declared_limits(found, limits), what=what)
        return cls(scenario=found, texture=read, declared=Bounds.of(found, limits).declared)

    def synthesis(
        self, carrier: Amount | None, ramp: Amount, rate: Amount | None, *, fastest: float
    ) -> Synthesis:
        """Return what determines the samples; without a carrier the force is that at `FREQUENCY`."""
        tone = 0.0 if carrier is None else amount(carrier, "Hz", "carrier", low=1e-3, high=1e7)
        per_second = IN_CYCLE * tone or WITHOUT_CARRIER
        if rate is not None:
            per_second = amount(rate, "Hz", "rate", low=1.0, high=fastest)
        if tone > FINEST * per_second:
            raise InputError(
                f"a carrier may have {FINEST:g} of the rate of {per_second:g} Hz; take a rate of {tone / FINEST:g} Hz or more",
                path="carrier",
                value=f"{tone:g} Hz",
            )
        still = amount(former_value("frequency", FREQUENCY), "Hz", "frequency", low=1e-3, high=1e7)
        edge = max(1, round(amount(ramp, "s", "ramp", low=1e-6, high=10.0) * per_second)) / per_second
        plate = hardware(self.scenario, self.declared, carrier=tone, frequency=still, ramp=edge)
        friction = AttractionOfFriction(self.scenario, plate.largest_force)
        return Synthesis(texture=self.texture, friction=friction, hardware=plate, rate=per_second)


def amount(value: Amount, unit: str, name: str, *, low: float, high: float) -> float:
    """Read a number with a unit within a range."""
    number = number_in(unit, name, value)
    if not (math.isfinite(number) and low <= number <= high):
        raise InputError(f"must lie between {low:g} and {high:g} {unit}", path=name, value=str(value))
    return number


_SHORTEST: Final = 1e-7
_LONGEST: Final = 100.0
_TIMES: Final = 73
"""First and last time after a step from which the current is bounded [s], and their number: 8 in each decade."""


@dataclass(frozen=True, kw_only=True)
class RenderingHardware:
    """Force of the rendered voltage, and what the declared limits allow of it.

    `force_gain` is the mean force over the squared amplitude of the carrier, or over the squared voltage
    without one, when `carrier` is 0 [N/V^2]. `ramp` is the duration between the largest amplitude and 0 V. Up
    to `largest_slope` slew rate and currents stay within their limits; `bound` names the limit of the
    amplitude.
    """

    force_gain: float
    carrier: float
    ramp: float
    largest_amplitude: float
    largest_slope: float
    bound: str

    @property
    def largest_force(self) -> float:
        """Mean force at the largest amplitude [N]."""
        return self.force_gain * self.largest_amplitude**2


@dataclass(frozen=True)
class CurrentBound:
    """Bound of the current of a linear stack from the slope and the size of the voltage.

    The current i of a passive stack of resistances and capacitances after a step of 1 V is positive and
    falls; q is its charge. For a voltage that is 0 before time 0, with slopes up to S and sizes up to V, the
    last t seconds contribute at most S q(t), and everything before them at most 2 V i(t), for every t: |i| <=
    min over t of S q(t) + 2 V i(t).
    """

    charges: Real
    rates: Real

    def plus(self, capacitance: float) -> CurrentBound:
        """Return the bound with a capacitance in parallel [F]."""
        return CurrentBound(self.charges + capacitance, self.rates)

    def current(self, slope: float, voltage: float) -> float:
        """Return the largest current."""
        return float(np.min(slope * self.charges + 2 * voltage * self.rates))

    def slope(self, current: float, voltage: float) -> float:
        """Return the largest slope within a limit of the current; 0 or less if the voltage alone can exceed it."""
        return float(np.max((current - 2 * voltage * self.rates) / self.charges))


def current_bound(scenario: Scenario) -> CurrentBound:
    """Return the bound of the current into the contact, from the response to a voltage that rises linearly.

    Stray capacitance is not in it. The current under v = s t is s q(t) with the charge q(t) that a step of 1
    V has moved. Because i falls, i(t) is at most (q(t) - q(t'))/(t - t') for every earlier t'.
    """
    times = np.concatenate([[0.0], np.geomspace(_SHORTEST, _LONGEST, _TIMES)])
    ramp = sampled(np.array([0.0, _LONGEST]), np.array([0.0, 1.0]))
    circuit = scenario.circuit.model_copy(update={"amplifier": None})
    alone = scenario.model_copy(update={"drive": ramp, "circuit": circuit, "time": TimeGrid()})
    record = Expanded(alone, times, mechanics=False).at(times, wanted={"current"})
    charges = np.maximum.accumulate(np.asarray(record.signals["current"][1]) * _LONGEST)
    rates = np.diff(charges) / np.diff(times)
    return CurrentBound(charges[1:], rates)


def hardware(
    scenario: Scenario,
    declared: Mapping[str, DeclaredLimit],
    *,
    carrier: float,
    frequency: float,
    ramp: float,
) -> RenderingHardware:
    """Return the largest amplitude and slope that the limits allow, and the gain of the force.

    The gain is taken at the carrier, or at `frequency` where the carrier is 0.
    """
    if scenario.drive.quantity != "voltage":
        raise InputError("prescribes a current, and a texture is rendered by a voltage", path="drive")
    found = carrier_gain(scenario, [carrier or frequency])
    gain = float(found.force[0]) * (1.0 if carrier else 2.0)
    if not gain > 0:
        raise InputError(f"this stack gives no force at {carrier or frequency:g} Hz", path="carrier")
    amplifier = scenario.circuit.supply
    factor = abs(amplifier.gain)
    if not factor:
        raise InputError("a gain of 0 renders nothing", path="circuit.amplifier.gain")
    bound = current_bound(scenario)
    currents = {"current": bound.plus(amplifier.stray_capacitance), "body_current": bound}
    steepest = math.hypot(2 * math.pi * carrier, 1 / ramp)  # slope over amplitude, ramp included
    per_amplitude = {name: each.current(steepest, 1.0) for name, each in currents.items()}
    per_amplitude |= {"voltage": 1.0, "slew_rate": steepest}
    limits = {name: limit for name, limit in declared.items() if name in per_amplitude}
    allowed = {name: limit.value / (factor * per_amplitude[name]) for name, limit in limits.items()}
    name = min(allowed, key=lambda each: allowed[each])
    slopes = [
        each.slope(limits[of].value, factor * allowed[name]) for of, each in currents.items() if of in limits
    ]
    if "slew_rate" in limits:
        slopes.append(limits["slew_rate"].value)
    shown = format_quantity(limits[name].value, unit_of_limit(name))
    return RenderingHardware(
        force_gain=gain,
        carrier=carrier,
        ramp=ramp,
        largest_amplitude=allowed[name],
        largest_slope=min(slopes) / factor,
        bound=f"the {name.replace('_', ' ')}, {shown} ({limits[name].source})",
    )


_POINTS: Final = 16_385
"""Points of the table by which a law of friction that is not linear is inverted."""


class AttractionOfFriction:
    """Attraction that adds a given friction force to the plate's own.

    A law that is linear in the attraction is inverted exactly; any other by a table of 16 385 values, linear
    between them. A friction that does not increase with the attraction, or depends on the real contact area,
    is refused.
    """

    def __init__(self, scenario: Scenario, largest_force: float) -> None:
        law, load = scenario.friction.without_memory(), scenario.load.normal_force
        if law.needs_real_area:
            raise InputError(
                f"{type(law).__name__} depends on the real contact area under the attraction, and a texture needs friction as a"
                " function of the force; use friction.model = 'Coulomb' or 'PowerLaw'",
                path="friction",
            )
        self._slope: float | None = None
        nothing = np.full(_POINTS, np.nan)
        forces = np.linspace(0.0, largest_force, _POINTS)
        added = law.lateral_force(np.full(_POINTS, load), forces, nothing)
        added = added - added[0]
        if not np.all(np.diff(added) > 0):
            raise InputError(
                "does not increase with the attraction, so that no texture can be rendered", path="friction"
            )
        self._forces, self._added = forces, added
        if law.is_linear:
            self._slope = float(added[-1]) / largest_force
        self.plate = RenderingPlate(normal_force=load, largest_added_friction=float(added[-1]))

    def force(self, added: Real) -> Real:
        """Return the attraction of an added friction, out of range where no attraction of the hardware causes it."""
        if self._slope is not None:
            return np.asarray(added / self._slope)
        share = added / self._added[-1]
        inside = np.interp(added, self._added, self._forces)
        return np.where((share < 0) | (share > 1), share * self._forces[-1], inside)
