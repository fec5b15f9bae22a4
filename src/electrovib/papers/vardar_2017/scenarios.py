"""The screen, its drives and skins of one time constant."""

from __future__ import annotations

import functools

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import plutchik_1963
from electrovib.papers.vezzoli_2014 import values
from electrovib.physics.material import Constant
from electrovib.scenario import Scenario, preset
from electrovib.scenario.sources import PresetNote

FREQUENCIES = (15.0, 30.0, 60.0, 120.0, 240.0, 480.0, 1920.0)
"""Fundamental frequencies of the 2016 experiment, abstract [Hz]."""
VOLTAGE = 100.0
"""Peak of the ready-made drives, a choice [V]."""

PRESETS = {
    "sine": PresetNote(
        "thresholds of sine and square",
        "touchscreen, touch panel with a thin coating as on a 3M-type screen (values unverified), perception, waveform",
    ),
    "square": PresetNote(
        "thresholds of sine and square",
        "touchscreen, touch panel with a thin coating as on a 3M-type screen (values unverified), perception, waveform",
    ),
}

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
