"""Numbers of the paper, printed or open, and where its equations or comparisons contradict each other."""

from __future__ import annotations

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import published

PAPER = published(__name__)
CITATION, scenarios, skins = PAPER.declared.citation, PAPER.scenarios, PAPER.skins

_ONE, _INTERVAL = PAPER.number, PAPER.interval
AREA, VOLTAGE, RAMP = _ONE("area"), _ONE("voltage"), _ONE("ramp")
FILM_THICKNESS, FILM_PERMITTIVITY = _ONE("film_thickness"), _ONE("film_permittivity")
COATING_THICKNESS, COATING_PERMITTIVITY = _ONE("coating_thickness"), _ONE("coating_permittivity")
SKIN_THICKNESS, SKIN_PERMITTIVITY = _ONE("skin_thickness"), _ONE("skin_permittivity")
TAU_MODEL, DECAY_MEASURED = _ONE("tau"), _ONE("decay")
FORCE_MODEL, FORCE_MEASURED, FORCE_PAST = _ONE("force_model"), _INTERVAL("force_measured"), _ONE("force_past")
FRICTION, THICKNESSES = _INTERVAL("friction"), _INTERVAL("thicknesses")
"""What each of them is stands beside it in the file."""
CONDUCTIVITY = eps0 * SKIN_PERMITTIVITY / TAU_MODEL
"""Conductivity that 7.7 ms of the voltage would need at eps 1560: computed from the printed time constant, not measured
[S/m]."""


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


CHECKS = PAPER.checks(skin_capacitance, insulator_capacitance, static_force)
