"""Adhesion of a smooth sphere to a coating under a voltage, by analogy with that of surfaces.

Two conductors with a coating between them attract like an adhesive contact whose energy of separation is proportional to
the square of the voltage; contact area and load of the sphere then follow Johnson, Kendall and Roberts. The closed-form
friction force of the papers that use the analogy was not read and is not implemented.
"""

from __future__ import annotations

import math

from electrovib.core.constants import eps0


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
