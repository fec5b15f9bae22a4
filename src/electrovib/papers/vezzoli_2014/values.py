"""Numbers of the paper, printed or open, and where its equations or comparisons contradict each other."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from electrovib.core.citation import Check
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import cited_as, defects
from electrovib.papers.palmar_1995 import MEN, WOMEN
from electrovib.physics.material import Constant, ConstantPhase, Material
from electrovib.physics.skin import Skin
from electrovib.physics.stack import Layer

CITATIONS, CITATION = cited_as(__name__)
STATUS = "full text"

AREA = 1e-4
FILM_THICKNESS, FILM_PERMITTIVITY = 90e-6, 3.35
SKIN_THICKNESS, SKIN_PERMITTIVITY = 200e-6, 1560.0
VOLTAGE = 1000.0
TAU_MODEL = 7.7e-3
"""What the paper calculates for Giraud's set-up [s]. It compares this with the decay of a lateral force, and does not state
whether it is the time constant of the voltage, as in its equation (5), or already that of the force."""
DECAY_MEASURED = 6e-3
"""Decay of the lateral force, as measured by Giraud [s]."""
PRINTED_C_I, PRINTED_C_S = 32e-12, 6.9e-9
FORCE_MODEL = 2.5e-3
"""Of the model: figure 6 draws the electrostatic force [N]."""
FORCE_MEASURED = (2e-3, 5e-3)
"""Lateral force: coefficient of friction times attraction [N]."""
FORCE_PAST = 0.1
"""Section 2.1: "around 100 mN" of electrostatic force in the paper's reference 3 [N]."""

CONDUCTIVITY = eps0 * SKIN_PERMITTIVITY / TAU_MODEL
"""Conductivity that 7.7 ms of the voltage would need at eps 1560: computed from the printed time constant, not measured
[S/m]."""
FRICTION = (0.3, 0.6)
"""Coefficient of friction of a finger on dry plastic; the paper prints none: a choice of ours."""
THICKNESSES = (100e-6, 400e-6)
"""Thinnest and thickest stratum corneum of a spread; the paper prints none: a choice of ours [m]."""
RAMP = 36e-3
"""The paper prints no ramp; with 7.7 ms and law (1) this one gives its 2.5 mN [s]."""
COATING_THICKNESS, COATING_PERMITTIVITY = 1e-6, 3.9
"""Of the thin coating of figure 7 the paper states only that C_i is comparable with C_s: a choice of ours."""

FILM = Layer(thickness=FILM_THICKNESS, material=Constant(permittivity=FILM_PERMITTIVITY))
COATING = Layer(
    thickness=COATING_THICKNESS, material=Constant(permittivity=COATING_PERMITTIVITY, substance="silica")
)
POINT = Constant(permittivity=SKIN_PERMITTIVITY, conductivity=CONDUCTIVITY)
"""Skin of the paper's one point."""


def point_layer(source: str) -> tuple[dict[str, Any], str]:
    """Return the stratum corneum of the paper's one point for a preset of another paper, with its source."""
    conductivity = (CONDUCTIVITY, "inverse of the 7.7 ms of vezzoli_2014; a choice")
    material = {"model": "Constant", "permittivity": SKIN_PERMITTIVITY, "conductivity": conductivity}
    return {"thickness": SKIN_THICKNESS, "material": material}, source


def capacitance(*, permittivity: float, thickness: float, area: float) -> float:
    """Capacitance of a slab, equation (3) of the paper: C = eps0 eps A/T."""
    return eps0 * permittivity * area / thickness


def static_force(*, voltage: float, skin_thickness: float = SKIN_THICKNESS) -> float:
    """Static force of the paper's film, equation (1), in N, from volts and metres."""
    electrical = FILM_THICKNESS / FILM_PERMITTIVITY + skin_thickness / SKIN_PERMITTIVITY
    return eps0 * AREA * voltage**2 / (2 * electrical * (skin_thickness + FILM_THICKNESS))


def force_decay(*, tau: float) -> float:
    """Time in which a force falls to 1/e [s], of a voltage that falls as exp(-t/tau): the force is its square."""
    return tau / 2


def voltage_decay(*, decay: float) -> float:
    """Time constant of the voltage [s] behind a force that falls to 1/e in this time [s]."""
    return 2 * decay


def attraction_of(lateral: tuple[float, float]) -> tuple[float, float]:
    """Least and largest attraction [N] behind a range of lateral forces [N], over `FRICTION`."""
    slippery, rough = FRICTION
    return lateral[0] / rough, lateral[1] / slippery


def insulator_capacitance() -> float:
    """C_i of the film [F]."""
    return capacitance(permittivity=FILM_PERMITTIVITY, thickness=FILM_THICKNESS, area=AREA)


def skin_capacitance() -> float:
    """C_s of the stratum corneum [F]."""
    return capacitance(permittivity=SKIN_PERMITTIVITY, thickness=SKIN_THICKNESS, area=AREA)


def surrogate(*, exponent: float) -> ConstantPhase:
    """Constant-phase skin through the point eps 1560, tau 7.7 ms; constructed, and conducts nothing.

    tau(f) = tan(n pi/2)/(2 pi f) equals 7.7 ms where eps' is 1560, with the exponent n of the admittance.
    """
    anchor = math.tan(exponent * math.pi / 2) / (2 * math.pi * TAU_MODEL)
    return ConstantPhase(
        permittivity=SKIN_PERMITTIVITY, reference_frequency=anchor, exponent=exponent, conductivity=0.0
    )


def skins() -> dict[str, Skin]:
    """Return the paper's one point as a constant, and constant-phase skins through it."""
    note = (
        "eps 1560 is printed; the conductivity follows from the printed 7.7 ms, taken as that of the voltage, at a"
        " frequency not printed"
    )
    found = {"point": Skin(name="paper point", material=POINT, status="derived", source=CITATION, note=note)}
    for exponent in (MEN, WOMEN, 0.85):
        found[f"surrogate_{exponent}"] = Skin(
            name=f"constant phase {exponent}",
            material=surrogate(exponent=exponent),
            status="derived",
            source=f"{CITATION}; exponents of palmar skin, doi:10.1007/bf02510531",
            note="constructed through the paper's point, not measured; conducts nothing, so only its tau is shown",
            reproduces_force=False,
        )
    return found


def materials() -> dict[str, Material]:
    """Return the plastic film of figures 2 and 6, and the thin coating chosen here for figure 7."""
    return {"film": FILM.material, "coating": COATING.material}


def _check(
    name: str, expect: float, rtol: float, source: str, compute: Callable[[], float], status: str
) -> Check:
    return Check(name, expect=expect, rtol=rtol, source=source, compute=compute, status=status)


CHECKS = (
    _check("C_s", PRINTED_C_S, 8e-3, "section 3.1, two digits", skin_capacitance, "full text"),
    _check(
        "C_i", PRINTED_C_I, 32e-3, "section 3.1, two digits, truncated", insulator_capacitance, "full text"
    ),
    _check(
        "static force at 1000 V",
        56.55e-3,
        1e-4,
        "equation (1) with the printed inputs, computed apart from this code",
        lambda: static_force(voltage=VOLTAGE),
        "derived",
    ),
)


DEFECTS = defects(__name__)
