"""The frequency at which a sine and a square voltage are felt alike, as a measurement of the laws of the force."""

from __future__ import annotations

import functools
from typing import Any

from electrovib.papers.vardar_2017.thresholds import ON_FORCE, VOLTAGE, scenarios
from electrovib.scenario import Scenario
from electrovib.studies.evidence import Measurement
from electrovib.studies.felt_spectrum import threshold_ratio


def _one_of(*values: float) -> dict[str, Any]:
    return {
        "model": "Empirical",
        "values": list(values),
        "choice": "not printed; a few values, as each needs two runs",
    }


@functools.cache
def _ratio(scenario: Scenario) -> float:
    square = {"model": "Square", "high": VOLTAGE, "low": -VOLTAGE, "frequency": scenario.drive.frequency}  # type: ignore[attr-defined]
    return 10 ** (threshold_ratio(scenario, scenario.replace({"drive": square}), ON_FORCE) / 20)


def sine_over_square(scenario: Scenario) -> float:
    """Compute the threshold voltage of the sine of a set-up over that of a square of the same peak and frequency."""
    return _ratio(scenario)


def measurements() -> dict[str, Measurement]:
    """Return the ratio of the two thresholds at 60 Hz."""
    skin = {"conductivity": 1.8e-6, "model": "Constant", "permittivity": 1560.0}
    gap = {"thickness": 1e-6, "material": {"model": "Constant", "permittivity": 1.0, "conductivity": 1e-9}}
    stack = {
        **dict(scenarios()["sine"].stack),
        "gap": gap,
        "stratum_corneum": {"thickness": 2e-4, "material": skin},
    }
    ordered = {name: stack[name] for name in ("insulator", "gap", "stratum_corneum")}
    return {
        "alike_at_60Hz": Measurement(
            title="threshold voltage of a sine over that of a square at 60 Hz",
            source="Vardar 2017, abstract",
            scenario=scenarios()["sine"].replace({"stack": ordered, "drive.frequency": 60.0}),
            quantity=sine_over_square,
            unit="1",
            values=(1.0,),
            spread=(0.12,),
            spread_of="a choice",
            group="Koc (Basdogan and Vardar)",
            how="printed",
            status="abstract",
            unknown={
                "stack.stratum_corneum.material.conductivity": _one_of(1.8e-7, 1.8e-6, 1.8e-5),
                "stack.insulator.thickness": _one_of(1e-6, 5e-6),
                "stack.gap.thickness": _one_of(1e-6, 5e-6),
                "stack.gap.material.conductivity": _one_of(1e-12, 1e-9),
            },
            of_model={
                "Persson2018RoughGap": {
                    "stack.gap": None,
                    "force.mean_gap": _one_of(1e-6, 5e-6),
                    "force.rms_gap": _one_of(1e-6, 5e-6),
                }
            },
            note="Printed is that the square is felt at a lower voltage below 60 Hz, eight people: taken as alike at 60 Hz within"
            " 1 dB, a choice, as the fundamentals were an octave apart. The Pacinian weight acts on the force.",
        )
    }
