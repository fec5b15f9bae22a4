"""The threshold voltage of a sine over that of a square, as a measurement of the laws of the force."""

from __future__ import annotations

import functools

from electrovib.papers.vardar_2017.thresholds import ON_FORCE, VOLTAGE
from electrovib.scenario import Scenario
from electrovib.studies.evidence.quantities import ComputedQuantity
from electrovib.studies.felt_spectrum import threshold_ratio


@functools.cache
def _ratio(scenario: Scenario) -> float:
    square = {"model": "Square", "high": VOLTAGE, "low": -VOLTAGE, "frequency": scenario.drive.frequency}  # type: ignore[attr-defined]
    return 10 ** (threshold_ratio(scenario, scenario.replace({"drive": square}), ON_FORCE) / 20)


def sine_over_square(scenario: Scenario) -> float:
    """Compute the threshold voltage of the sine of a set-up over that of a square of the same peak and frequency."""
    return _ratio(scenario)


def quantities() -> dict[str, ComputedQuantity]:
    """Return the ratio of the two thresholds."""
    return {
        "sine_over_square": ComputedQuantity(
            title="threshold voltage of a sine over that of a square", unit="1", compute=sine_over_square
        )
    }
