"""Limits that a designed drive has to hold, and how far a drive is from them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.physics.limits import SWITCH_ON, Limits
from electrovib.solve.diagnostics.judge import largest_values, slew_rate
from electrovib.solve.expanded import OF_ELECTRICS, Expanded
from electrovib.study.check import LimitsFrom, declared_limits
from electrovib.study.check.values import checked_values

if TYPE_CHECKING:
    from electrovib.scenario import Scenario
    from electrovib.study.check import DeclaredLimit, LimitsSource


@dataclass(frozen=True)
class Bounds:
    """The strictest declared limits of a design, and the largest voltage that its amplifier aims at, if it has one."""

    declared: dict[str, DeclaredLimit]
    saturation: float | None = None

    @classmethod
    def of(cls, scenario: Scenario, limits: LimitsSource | Sequence[LimitsSource]) -> Bounds:
        """Return the strictest limits of a scenario, of its amplifier and of further places."""
        several = list(limits) if isinstance(limits, Sequence) and not isinstance(limits, str) else [limits]
        amplifier = scenario.circuit.amplifier
        if amplifier is not None and amplifier.is_limited:
            low, high = amplifier.current_limits
            largest = min(-low, high)
            own = Limits(voltage=amplifier.saturation, current=largest if math.isfinite(largest) else None)
            several.append(LimitsFrom("circuit.amplifier", own))
        return cls(declared_limits(scenario, several), None if amplifier is None else amplifier.saturation)

    def value(self, name: str) -> float | None:
        """Return a limit in its unit, by its name in `Limits`; None if it is not declared."""
        limit = self.declared.get(name)
        return None if limit is None else limit.value

    def limits(self) -> Limits:
        """Return those of voltage, current and body current as a model."""
        names = ("voltage", "current", "body_current")
        return Limits(**{name: self.value(name) for name in names})

    def slew(self, scenario: Scenario) -> float | None:
        """Return the largest rate of change of the drive itself [V/s], before the gain of an amplifier; None for no limit."""
        limit, amplifier = self.value("slew_rate"), scenario.circuit.amplifier
        return limit if limit is None or amplifier is None else limit / abs(amplifier.gain)

    def largest_drive(self, scenario: Scenario) -> float:
        """Return the largest voltage of the drive that its amplifier amplifies without saturation [V]; infinite without it."""
        amplifier = scenario.circuit.amplifier
        if amplifier is None or self.saturation is None:
            return math.inf
        return self.saturation / abs(amplifier.gain)

    def overload(self, scenario: Scenario) -> dict[str, float]:
        """Return the largest value of a drive over each declared limit, NaN where it is not known.

        For the energy it is the root of the ratio, so that each is proportional to the drive.
        """
        values = _largest(scenario, rms=any(name.startswith("rms_") for name in self.declared))
        found = {}
        for name, limit in self.declared.items():
            value = values.get(name, math.nan)
            ratio = value / limit.value
            found[name] = math.sqrt(ratio) if name == "stored_energy" else ratio
        return found


def _largest(scenario: Scenario, *, rms: bool) -> dict[str, float]:
    """Return the largest values by the names of their limits, as `checked_values`; root mean squares only if asked for."""
    if rms:
        return checked_values(scenario).largest
    expanded = Expanded(scenario, mechanics=False)
    record = expanded.at(expanded.times, closely=True, wanted=OF_ELECTRICS)
    assert record.peaks is not None
    reached = largest_values(scenario, expanded.section, record.peaks)
    for name in [each for each in reached if each.endswith(SWITCH_ON)]:
        own = name.removesuffix(SWITCH_ON)
        reached[own] = max(reached[own], reached[name])
    return reached | {"slew_rate": slew_rate(scenario, float(expanded.times[-1]))}


def unlimited(scenario: Scenario) -> Scenario:
    """Return a scenario whose amplifier has no limits, which a drive within them does not reach."""
    amplifier = scenario.circuit.amplifier
    if amplifier is None or not amplifier.is_limited:
        return scenario
    free = amplifier.model_copy(update={"saturation": None, "source_current": None, "sink_current": None})
    return scenario.model_copy(update={"circuit": scenario.circuit.model_copy(update={"amplifier": free})})
