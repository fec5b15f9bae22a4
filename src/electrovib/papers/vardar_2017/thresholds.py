"""The paper's citation, its screen, and thresholds of the screen's drives by the shared formulas of `studies`."""

from __future__ import annotations

import functools
from typing import Final

from numpy.typing import ArrayLike

from electrovib.core.arrays import Real
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import cited_as, not_read, plutchik_1963, preset_notes
from electrovib.papers.vezzoli_2014 import values
from electrovib.physics.material import Constant, Material
from electrovib.physics.perception import UNVERIFIED_CORNER, ElasticViscousSkin, Pacinian, Perception
from electrovib.scenario import Scenario, preset
from electrovib.studies import felt_spectrum

CITATIONS, CITATION = cited_as(__name__)
STATUS = "abstract"
NOT_READ = not_read(__name__)


FREQUENCIES = (15.0, 30.0, 60.0, 120.0, 240.0, 480.0, 1920.0)
"""Fundamental frequencies of the 2016 experiment, abstract [Hz]."""
VOLTAGE = 100.0
"""Peak of the ready-made drives, a choice [V]."""

PRESETS = preset_notes(__name__)

CHOICE = "not printed in the abstract; a choice"
COATING = "not printed in the abstract; as of 3M-type screens (cited from memory, unverified), and the coating of vezzoli_2014"
SKIN = "plutchik_1963: solved from its abstract with 1 cm2 and 200 um assumed; the paper's own curves were not read"


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Return a sine and a square voltage of one peak and one frequency on one screen."""
    fundamental = (30.0, "Vardar 2017, abstract: one of seven")
    screen = {
        "force.model": "MaxwellStressInStratumCorneum",
        "time.initial_state.model": "PeriodicState",
        "stack.insulator": (values.COATING, COATING),
        "stack.stratum_corneum": (plutchik_1963.layer(), SKIN),
        "stack.stratum_corneum.thickness": (
            plutchik_1963.THICKNESS,
            "used by these authors (cited from memory, unverified), printed in vezzoli_2014",
        ),
    }
    sine = {"model": "Sine", "amplitude": VOLTAGE, "frequency": fundamental}
    square = {"model": "Square", "high": VOLTAGE, "low": -VOLTAGE, "frequency": fundamental}
    return {
        name: preset(
            title=f"Vardar 2017: {name}, 30 Hz",
            unchanged=CHOICE,
            changes={**screen, "drive": (drive, CHOICE)},
        )
        for name, drive in (("sine", sine), ("square", square))
    }


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
