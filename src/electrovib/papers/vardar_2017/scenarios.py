"""The screen, its drives and skins of one time constant."""

from __future__ import annotations

import functools
from typing import Any

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import plutchik_1963
from electrovib.papers.vezzoli_2014 import values
from electrovib.physics.material import Constant
from electrovib.scenario import Scenario

FREQUENCIES = (15.0, 30.0, 60.0, 120.0, 240.0, 480.0, 1920.0)
"""Fundamental frequencies of the 2016 experiment, abstract [Hz]."""
VOLTAGE = 100.0
"""Peak of the ready-made drives, a choice [V]."""

CHOICE = "not printed in the abstract; a choice"
COAT = "not printed in the abstract; recalled of 3M-type screens, and the coat of vezzoli_2014"
SKIN = "plutchik_1963: solved from its abstract with 1 cm2 and 200 um assumed; the paper's own curves were not read"


def _screen(title: str, drive: dict[str, Any], sources: dict[str, str]) -> Scenario:
    coat = {"model": "Constant", "permittivity": values.COAT_PERMITTIVITY}
    skin = "stack.stratum_corneum.material"
    return Scenario.model_validate(
        {
            "title": title,
            "drive": drive,
            "force": {"model": "StratumCorneumPlane"},
            "friction": {"model": "Coulomb", "coefficient": 0.5},
            "contact": {"model": "FixedArea", "area": 1e-4},
            "load": {"normal_force": 0.5},
            "circuit": {"return_path": {"model": "Grounded", "resistance": 1000.0}},
            "time": {"initial_state": {"model": "PeriodicState"}},
            "stack": {
                "insulator": {"thickness": values.COAT_THICKNESS, "material": coat},
                "stratum_corneum": {
                    "thickness": plutchik_1963.THICKNESS,
                    "material": plutchik_1963.material(),
                },
            },
            "sources": {
                "drive.frequency": "Vardar 2017, abstract: one of seven",
                "friction.coefficient": CHOICE,
                "contact.area": CHOICE,
                "load.normal_force": CHOICE,
                "circuit.return_path.resistance": CHOICE,
                "stack.insulator.thickness": COAT,
                "stack.insulator.material.permittivity": COAT,
                "stack.stratum_corneum.thickness": "recalled of this line of papers, printed in vezzoli_2014",
                f"{skin}.permittivity": SKIN,
                f"{skin}.reference_frequency": SKIN,
                f"{skin}.exponent": SKIN,
                f"{skin}.conductivity": SKIN,
            }
            | sources,
        }
    )


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Give a sine and a square voltage of one peak and one frequency on one screen."""
    sine = {"model": "Sine", "amplitude": VOLTAGE, "frequency": 30.0}
    square = {"model": "Square", "high": VOLTAGE, "low": -VOLTAGE, "frequency": 30.0}
    return {
        "sine": _screen("Vardar 2017: sine, 30 Hz", sine, {"drive.amplitude": CHOICE}),
        "square": _screen("Vardar 2017: square, 30 Hz", square, {"drive.high": CHOICE, "drive.low": CHOICE}),
    }


def first_order_skin(time_constant: float) -> Constant:
    """Skin without dispersion whose circuit with the coat has this time constant (C_i + C_s) R_s [s]."""
    coat = values.COAT_PERMITTIVITY / values.COAT_THICKNESS
    skin = values.SKIN_PERMITTIVITY / values.SKIN_THICKNESS
    conductivity = eps0 * (coat + skin) * values.SKIN_THICKNESS / time_constant
    return Constant(permittivity=values.SKIN_PERMITTIVITY, conductivity=conductivity)
