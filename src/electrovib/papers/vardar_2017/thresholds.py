"""The paper's citation, its screen, and thresholds of the screen's drives by the shared formulas of `studies`."""

from __future__ import annotations

import functools
from typing import Final

from numpy.typing import ArrayLike

from electrovib.core.arrays import Real
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import published
from electrovib.papers.vezzoli_2014 import values
from electrovib.physics.material import Constant, Material
from electrovib.physics.perception import UNVERIFIED_CORNER, ElasticViscousSkin, Pacinian, Perception
from electrovib.scenario import Scenario
from electrovib.studies import felt_spectrum

PAPER = published(__name__)
CITATION, NOT_READ, scenarios = PAPER.declared.citation, PAPER.declared.not_read, PAPER.scenarios

FREQUENCIES = (15.0, 30.0, 60.0, 120.0, 240.0, 480.0, 1920.0)
"""Fundamental frequencies of the 2016 experiment, abstract [Hz]."""
VOLTAGE = 100.0
"""Peak of the ready-made drives, a choice [V]."""


def first_order_skin(*, time_constant: float) -> Constant:
    """Skin without dispersion whose circuit with the coating has this time constant (C_i + C_s) R_s [s]."""
    coating = values.COATING_PERMITTIVITY / values.COATING_THICKNESS
    skin = values.SKIN_PERMITTIVITY / values.SKIN_THICKNESS
    conductivity = eps0 * (coating + skin) * values.SKIN_THICKNESS / time_constant
    return Constant(permittivity=values.SKIN_PERMITTIVITY, conductivity=conductivity)


ON_FORCE: Final = Perception(channels=(Pacinian(),))
"""The Pacinian weight on the force: what the numbers computed apart from this code take."""
BOTH_CHANNELS: Final = Perception()
"""Both channels, on the force."""
ON_DISPLACEMENT: Final = Perception(
    channels=(Pacinian(),), compliance=ElasticViscousSkin(stiffness=1000.0, corner=UNVERIFIED_CORNER)
)
"""The Pacinian weight after a skin with a corner frequency cited from memory, unverified; its stiffness cancels in a ratio."""


def weight(frequency: ArrayLike) -> Real:
    """Return the sensitivity of the Pacinian channel [1] at a frequency [Hz], 2 x^2/(1 + x^4) with x = f/250 Hz."""
    return Pacinian().weight(frequency)


def felt_level(scenario: Scenario, person: Perception = ON_FORCE) -> float:
    """Return the attraction in the periodic state, weighted by the deciding channel [N]; with a skin, displacement [m]."""
    return felt_spectrum.felt_level(scenario.replace({"friction.coefficient": 1.0}), person)


def pair(
    skin: Material, *, frequency: float, edge: float = 0.0, resistance: float = 0.0
) -> tuple[Scenario, Scenario]:
    """Return sine and square of one peak [V] on a skin; frequency in Hz, edge in s, resistance of the body in ohm."""
    common = {
        "drive.frequency": frequency,
        "stack.stratum_corneum.material": skin,
        "circuit.return_path.resistance": resistance,
    }
    sine = scenarios()["sine"].replace(common)
    return sine, scenarios()["square"].replace({**common, "drive.edge": edge})


def sine_over_square(
    skin: Material,
    *,
    frequency: float,
    edge: float = 0.0,
    resistance: float = 0.0,
    person: Perception = ON_FORCE,
) -> float:
    """Threshold voltage of a sine over that of a square, both given as peaks [dB].

    Above 0 the square is felt at a lower voltage. The level grows as the square of the voltage. `frequency`
    is the fundamental [Hz], `edge` the time that an edge of the square takes [s], `resistance` that of the
    body [ohm].
    """
    drives = pair(skin, frequency=frequency, edge=edge, resistance=resistance)
    return felt_spectrum.threshold_ratio(*drives, person)


def crossover(skin: Material, *, edge: float = 0.0, person: Perception = ON_FORCE) -> float:
    """Lowest frequency of equal thresholds [Hz].

    It is infinite if the square is felt at a lower voltage up to 1920 Hz, and 0 if nowhere above 15 Hz.
    """
    low, high = FREQUENCIES[0], FREQUENCIES[-1]
    return felt_spectrum.crossover(
        lambda frequency: pair(skin, frequency=frequency, edge=edge), low=low, high=high, person=person
    )


@functools.cache
def voltage_ratio(scenario: Scenario) -> float:
    """Compute the threshold voltage of the sine of a set-up over that of a square of the same peak and frequency."""
    square = {"model": "Square", "high": VOLTAGE, "low": -VOLTAGE, "frequency": scenario.drive.frequency}  # type: ignore[attr-defined]
    return 10 ** (felt_spectrum.threshold_ratio(scenario, scenario.replace({"drive": square}), ON_FORCE) / 20)


quantities = PAPER.quantities(voltage_ratio)
