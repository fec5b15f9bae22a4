"""What a drive and a stream of a texture share: inputs, the attraction for an added friction, and what the limits allow."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity, parse_quantity
from electrovib.physics.texture.base import RenderingPlate
from electrovib.scenario import Source, TimeGrid, read_scenario
from electrovib.solve.expanded import Expanded
from electrovib.studies.check import LimitsSource, declared_limits, refuse_unlimited, sampled
from electrovib.studies.design.gain import carrier_gain
from electrovib.studies.texture.reading import read_texture
from electrovib.studies.texture.synthesis import Synthesis

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.texture.base import Texture
    from electrovib.scenario import Scenario
    from electrovib.studies.check import DeclaredLimit
    from electrovib.studies.texture.reading import TextureSource


Amount: TypeAlias = float | str
"""A number in SI, or text with a unit."""
AllLimits: TypeAlias = "LimitsSource | Sequence[LimitsSource]"
RAMP: Final = 1e-3
"""Duration of a ramp at either end [s], by default; a choice."""
FREQUENCY: Final = 100.0
"""Frequency at which the force of a drive without carrier is taken [Hz], by default; a choice."""
FINEST: Final = 0.4
"""Highest carrier over the rate of samples [1]; a choice below the limit of 0.5."""


@dataclass(frozen=True, kw_only=True)
class RenderingSetUp:
    """Scenario and texture as they were read, with the strictest declared limit of each quantity."""

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
        declared = declared_limits(found, limits)
        refuse_unlimited(declared, what=what)
        return cls(scenario=found, texture=read, declared=declared)

    def synthesis(self, *, carrier: float, frequency: float, ramp: float, rate: float) -> Synthesis:
        """Return what determines the samples; `carrier` is 0 without one, and the force is then taken at `frequency`."""
        if carrier > FINEST * rate:
            raise InputError(
                f"a carrier may have {FINEST:g} of the rate of {rate:g} Hz; take a rate of {carrier / FINEST:g} Hz or more",
                path="carrier",
                value=f"{carrier:g} Hz",
            )
        ramp = max(1, round(ramp * rate)) / rate
        plate = hardware(self.scenario, self.declared, carrier=carrier, frequency=frequency, ramp=ramp)
        friction = AttractionOfFriction(self.scenario, plate.largest_force)
        return Synthesis(texture=self.texture, friction=friction, hardware=plate, rate=rate)


def amount(value: Amount, unit: str, name: str, *, low: float, high: float) -> float:
    """Read a number with a unit within a range."""
    try:
        number = parse_quantity(value, unit) if isinstance(value, str) else float(value)
    except (TypeError, ValueError) as error:
        raise InputError(str(error), path=name, value=str(value)) from None
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
        raise InputError(
            "this stack gives no force at this frequency", path="carrier" if carrier else "frequency"
        )
    amplifier = scenario.circuit.supply
    factor = abs(amplifier.gain)
    if not factor:
        raise InputError("a gain of 0 renders nothing", path="circuit.amplifier.gain")
    voltages, currents = _limits(scenario, declared)
    bound = current_bound(scenario)
    whole = bound.plus(amplifier.stray_capacitance)
    steepest = math.hypot(2 * math.pi * carrier, 1 / ramp)  # slope over amplitude, ramp included
    allowed = [(limit / factor, words) for limit, words in voltages]
    bounds = [(limit, whole if through == "current" else bound, words) for limit, through, words in currents]
    allowed += [(limit / (factor * each.current(steepest, 1.0)), words) for limit, each, words in bounds]
    if "slew_rate" in declared:
        fastest = declared["slew_rate"]
        allowed.append((fastest.value / (factor * steepest), f"the slew rate, {_shown(fastest, 'V/s')}"))
    largest, words = min(allowed)
    slopes = [each.slope(limit, factor * largest) / factor for limit, each, _ in bounds]
    if "slew_rate" in declared:
        slopes.append(declared["slew_rate"].value / factor)
    return RenderingHardware(
        force_gain=gain,
        carrier=carrier,
        ramp=ramp,
        largest_amplitude=largest,
        largest_slope=min(slopes),
        bound=words,
    )


def _limits(
    scenario: Scenario, declared: Mapping[str, DeclaredLimit]
) -> tuple[list[tuple[float, str]], list[tuple[float, str, str]]]:
    """Return limits of the plate voltage [V], and of currents [A] with what they limit; those of the amplifier too."""
    voltages = [(declared["voltage"].value, f"the voltage, {_shown(declared['voltage'], 'V')}")]
    currents = [
        (declared[name].value, name, f"the {name.replace('_', ' ')}, {_shown(declared[name], 'A')}")
        for name in ("current", "body_current")
        if name in declared
    ]
    amplifier = scenario.circuit.supply
    if amplifier.saturation is not None:
        shown = format_quantity(amplifier.saturation, "V")
        voltages.append((amplifier.saturation, f"the saturation of the amplifier, {shown}"))
    if np.isfinite(amplifier.current_limits[1]):
        least = float(min(abs(each) for each in amplifier.current_limits))
        currents.append(
            (least, "current", f"the current limit of the amplifier, {format_quantity(least, 'A')}")
        )
    return voltages, currents


def _shown(limit: DeclaredLimit, unit: str) -> str:
    return f"{format_quantity(limit.value, unit)} ({limit.source})"


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
