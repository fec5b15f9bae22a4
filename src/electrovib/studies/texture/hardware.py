"""Largest amplitude of the voltage, and the largest slope, that the declared limits allow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.scenario import TimeGrid
from electrovib.solve.expanded import Expanded
from electrovib.studies.check import sampled
from electrovib.studies.design.gain import carrier_gain

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.studies.check import DeclaredLimit

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
