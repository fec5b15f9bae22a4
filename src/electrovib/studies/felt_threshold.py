"""Threshold voltages of drives: over frequency, and of one drive relative to another."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.perception import Perception
from electrovib.studies.felt_spectrum import FEWEST
from electrovib.studies.perceive import felt_level

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

Pair = Callable[[float], "tuple[Scenario, Scenario]"]


@dataclass(frozen=True)
class ThresholdCurves:
    """Threshold voltage of each drive over its fundamental frequency, relative to the lowest of all [dB].

    `voltage` is the peak at threshold [V]; it is empty where the threshold is not calibrated.
    """

    frequency: Real
    level: Mapping[str, Real]
    voltage: Mapping[str, Real]


def threshold_over_frequency(
    scenario: Scenario,
    frequencies: Sequence[float] | Real,
    drives: Mapping[str, Mapping[str, Any]],
    *,
    perception: Perception | None = None,
    samples: int = FEWEST,
) -> ThresholdCurves:
    r"""Compute the threshold voltage of waveforms over their frequency, which replaces that of each table of `drives`.

    The change of the friction has to be proportional to the square of the voltage, which excludes a non-ohmic
    leak and a PowerLaw; a drive of peak V whose felt amplitude is X is then just felt at

    .. math:: V_0 = V \sqrt{X_0/X}
    """
    _proportional(scenario)
    person = perception or getattr(scenario, "perception", None) or Perception()
    places = np.asarray(frequencies, dtype=float)
    at_threshold: dict[str, Real] = {}
    for name, drive in drives.items():
        cases = [scenario.replace({"drive": {**drive, "frequency": float(place)}}) for place in places]
        felt = np.array([felt_level(case, person, samples=samples) for case in cases])
        peaks = np.array([case.drive.largest() for case in cases])
        at_threshold[name] = peaks / np.sqrt(np.maximum(felt, np.finfo(float).tiny))
    lowest = min(float(np.min(row)) for row in at_threshold.values())
    level = {name: 20 * np.log10(row / lowest) for name, row in at_threshold.items()}
    absolute = person.compliance or getattr(scenario, "finger", None)
    voltage: dict[str, Real] = {}
    if person.threshold is not None and absolute is not None:
        voltage = {name: row * np.sqrt(person.threshold) for name, row in at_threshold.items()}
    return ThresholdCurves(places, level, voltage)


def _proportional(scenario: Scenario) -> None:
    """Refuse a scenario whose changes of friction are not proportional to the square of the voltage."""
    leaks = [f"stack.{name}.leak" for name, layer in scenario.stack.layers.items() if layer.leak is not None]
    friction, contact, limited = scenario.friction, scenario.contact, scenario.circuit.supply.is_limited
    bends = friction.deflects or not friction.without_memory().is_linear
    yields = contact.closing is not None or contact.grows
    parts = [*leaks, *["friction"] * bends, *["contact"] * yields, *["circuit.amplifier"] * limited]
    if parts:
        raise InputError(
            f"{parts[0]}: with it the change of the friction is not proportional to the square of the voltage, so one run gives"
            " no threshold; perceive the scenario at several voltages instead"
        )


def threshold_ratio(first: Scenario, second: Scenario, person: Perception, *, samples: int = FEWEST) -> float:
    """Compute the threshold voltage of a drive relative to that of another drive of the same peak [dB]."""
    for each in (first, second):
        _proportional(each)
    felt = [felt_level(scenario, person, samples=samples) for scenario in (second, first)]
    return float(10 * np.log10(felt[0] / felt[1]))


def crossover(pair: Pair, *, low: float, high: float, person: Perception) -> float:
    """Find the lowest frequency [Hz] at which two drives of the same peak voltage have the same threshold voltage.

    The search proceeds by octaves, and two crossings within one are not found. The result is 0 if the second
    drive is not felt at a lower voltage even at `low`, infinite if it is at every octave up to `high`.
    """
    from scipy.optimize import brentq

    def ratio(logarithm: float) -> float:
        return threshold_ratio(*pair(float(np.exp(logarithm))), person)

    octaves = int(np.ceil(np.log2(high / low) * (1 - 1e-12)))
    places = [float(place) for place in np.linspace(np.log(low), np.log(high), octaves + 1)]
    if ratio(places[0]) <= 0:
        return 0.0
    for before, after in itertools.pairwise(places):
        if ratio(after) <= 0:
            return float(np.exp(brentq(ratio, before, after, xtol=1e-3)))
    return float("inf")
