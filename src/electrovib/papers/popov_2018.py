"""V. L. Popov, M. Hess, "Voltage induced friction in a contact of a finger and a touchscreen", 2018.

In full "... with a thin dielectric coating", arXiv:1805.08714; continued by M. Hess, V. L. Popov, "Voltage-induced
friction with application to electrovibration", Lubricants 7, 102 (2019).

Claims: two conductors with a thin dielectric between them are an adhesive contact whose energy of separation
is proportional to the square of the voltage; with Coulomb's friction the friction force has a closed form. The sequel
uses the analogy with the theories of Johnson, Kendall and Roberts and of Maugis, and the load of a finger.
Does not claim: roughness, a gap apart from the coating, conduction; the closed form and the sequel's table of
parameters were not read. Only the abstracts were read; the numbers here are derived.
"""

from __future__ import annotations

import math

from electrovib.core.constants import eps0
from electrovib.papers import published


def separation_energy(*, voltage: float, thickness: float, permittivity: float) -> float:
    """Energy per area [J/m2] needed to separate the conductors: eps0 eps_r V^2/(2 h).

    `voltage` V [V]; `thickness` h [m] and relative `permittivity` of the coating.
    """
    return eps0 * permittivity * voltage**2 / (2 * thickness)


def adhesive_strength(*, voltage: float, thickness: float, permittivity: float) -> float:
    """Stress [Pa] on the air side of the closed contact: eps0 eps_r^2 V^2/(2 h^2).

    It is eps_r times the stress inside the coating. Arguments as for `separation_energy`.
    """
    return eps0 * (permittivity * voltage / thickness) ** 2 / 2


def adhesive_range(*, thickness: float, permittivity: float) -> float:
    """Gap [m] over which the attraction falls to a quarter: h/eps_r, for a coating of thickness h [m].

    The adhesive strength times this range is the energy of separation.
    """
    return thickness / permittivity


def adhesive_load(*, normal_force: float, radius: float, energy: float) -> float:
    """Load under which a sphere without adhesion has the contact area of an adhesive one.

    Parameters
    ----------
    normal_force : float
        N, 0 or more.
    radius : float
        Of the sphere [m], above 0.
    energy : float
        Energy of separation per area [J/m2].

    Returns
    -------
    load : float
        Normal load [N].

    Notes
    -----
    Johnson, Kendall and Roberts: F + w + sqrt(2 w F + w^2), w = 3 pi R energy. Valid for smooth, elastic bodies whose
    attraction has a short range compared with the deformation of the sphere.
    """
    weight = 3 * math.pi * radius * energy
    return normal_force + weight + math.sqrt(2 * weight * normal_force + weight**2)


def contact_area(*, normal_force: float, radius: float, modulus: float, energy: float = 0.0) -> float:
    """Contact area [m2] of a smooth elastic sphere on a plate: pi (3 R F/(4 E*))^(2/3), F from `adhesive_load`.

    `normal_force` [N], `radius` R [m], `modulus` the effective modulus E* [Pa], `energy` of separation per
    area [J/m2]: 0 for a sphere without adhesion, that of Hertz.
    """
    load = adhesive_load(normal_force=normal_force, radius=radius, energy=energy)
    return math.pi * math.pow(3 * radius * load / (4 * modulus), 2 / 3)


PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared

_COATING = {"thickness": 1e-6, "permittivity": 3.9}
_FINGER = {"radius": 1e-2, "modulus": 50e3}
_VOLTAGE = 100.0


def _energy() -> float:
    return separation_energy(voltage=_VOLTAGE, **_COATING)


def area_gain(*, normal_force: float) -> float:
    """Return the relative growth of the contact of a sphere of 1 cm under a load [N] by 100 V on 1 um of 3.9."""
    with_voltage = contact_area(normal_force=normal_force, energy=_energy(), **_FINGER)
    return with_voltage / contact_area(normal_force=normal_force, **_FINGER) - 1


def energy_over_strength_and_range() -> float:
    """Return the energy of separation over strength times range [1]."""
    return _energy() / (adhesive_strength(voltage=_VOLTAGE, **_COATING) * adhesive_range(**_COATING))


def energy_with_twice_the_voltage() -> float:
    """Return the energy of separation at twice the voltage over that at the voltage."""
    return separation_energy(voltage=2 * _VOLTAGE, **_COATING) / _energy()


CHECKS = PAPER.checks(
    energy_over_strength_and_range,
    energy_with_twice_the_voltage,
    separation_energy,
    adhesive_strength,
    area_gain,
)
