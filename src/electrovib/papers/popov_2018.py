"""V. L. Popov, M. Hess, "Voltage induced friction in a contact of a finger and a touchscreen", 2018.

In full "... with a thin dielectric coating", arXiv:1805.08714; continued by M. Hess, V. L. Popov, "Voltage-induced
friction with application to electrovibration", Lubricants 7, 102 (2019).

Claims: two conductors with a thin dielectric between them are an adhesive contact whose energy of separation
goes as the square of the voltage; with Coulomb's friction the friction force has a closed form. The sequel uses
the analogy with the theories of Johnson, Kendall and Roberts and of Maugis, and the load of a finger.
Does not claim: roughness, a gap apart from the coat, conduction; the closed form and the sequel's table of
parameters could not be read. Only the abstracts were read; the numbers here are derived.
"""

from __future__ import annotations

import math

from electrovib.core.checks import Check
from electrovib.core.constants import eps0

CITATION = (
    "V. L. Popov, M. Hess, Voltage induced friction in a contact of a finger and a touchscreen with a thin dielectric"
    " coating, arXiv:1805.08714 (2018) (abstract); M. Hess, V. L. Popov, Voltage-induced friction with application to"
    " electrovibration, Lubricants 7, 102 (2019), doi:10.3390/lubricants7120102 (abstract)"
)
STATUS = "abstract"
NOT_READ = (
    "the closed-form friction force: candidates, the coefficient times the adhesive load or times the load plus strength"
    " times area, differ by orders of magnitude, so none is offered; area and load of the adhesive sphere are"
)
DEFECTS = (
    "Popov 2018 takes the strength of adhesion on the air side of the interface, eps_r times what the stress inside the"
    " coat would be (673 against 173 kPa for 1 um of 3.9 at 100 V): the choice of a plane again, here that of the gap.",
)


def separation_energy(*, voltage: float, thickness: float, permittivity: float) -> float:
    """Energy that pulling the conductors apart takes, for each area: eps0 eps_r V^2/(2 h).

    Parameters
    ----------
    voltage : float
        V.
    thickness, permittivity : float
        Of the coat [m] and 1.

    Returns
    -------
    float
        J/m2.
    """
    return eps0 * permittivity * voltage**2 / (2 * thickness)


def adhesive_strength(*, voltage: float, thickness: float, permittivity: float) -> float:
    """Stress of the closed contact on its air side, eps0 eps_r^2 V^2/(2 h^2), in Pa; arguments in SI."""
    return eps0 * (permittivity * voltage / thickness) ** 2 / 2


def adhesive_range(*, thickness: float, permittivity: float) -> float:
    """Gap, h/eps_r, over which the attraction falls to a quarter [m]; strength times range is the energy."""
    return thickness / permittivity


def adhesive_load(normal_force: float, *, radius: float, energy: float) -> float:
    """Load under which a sphere without adhesion has the contact area of an adhesive one.

    Parameters
    ----------
    normal_force : float
        N, 0 or more.
    radius : float
        Of the sphere [m], above 0.
    energy : float
        Of separation, for each area [J/m2].

    Returns
    -------
    float
        N.

    Notes
    -----
    Johnson, Kendall and Roberts: F + w + sqrt(2 w F + w^2), w = 3 pi R energy. Smooth, elastic, attraction
    of short range against the sphere's deformation.
    """
    weight = 3 * math.pi * radius * energy
    return normal_force + weight + math.sqrt(2 * weight * normal_force + weight**2)


def contact_area(normal_force: float, *, radius: float, modulus: float, energy: float = 0.0) -> float:
    """Contact area of a smooth elastic sphere on a plate [m2]; E* in `modulus`, load in N, all in SI."""
    load = adhesive_load(normal_force, radius=radius, energy=energy)
    return math.pi * math.pow(3 * radius * load / (4 * modulus), 2 / 3)


_COAT = {"thickness": 1e-6, "permittivity": 3.9}
_FINGER = {"radius": 1e-2, "modulus": 50e3}
_VOLTAGE = 100.0


def _energy() -> float:
    return separation_energy(voltage=_VOLTAGE, **_COAT)


def area_gain(normal_force: float) -> float:
    """Share by which 100 V on 1 um of 3.9 enlarge the contact of a sphere of 1 cm under a load [N]."""
    with_voltage = contact_area(normal_force, energy=_energy(), **_FINGER)
    return with_voltage / contact_area(normal_force, **_FINGER) - 1


def energy_over_strength_and_range() -> float:
    """Energy of separation over strength times range."""
    return _energy() / (adhesive_strength(voltage=_VOLTAGE, **_COAT) * adhesive_range(**_COAT))


_APART = "the abstract's analogy with inputs of a choice, computed apart from this code"


def _gain(load: float, expect: float) -> Check:
    return Check(
        f"growth of the contact of an adhesive sphere at {load:g} N",
        expect=expect,
        rtol=0.6e-3 / expect,  # a tenth of a percent of the area
        source=_APART,
        compute=lambda: area_gain(load),
        status="derived",
    )


CHECKS = (
    Check(
        "energy of separation over strength times range",
        expect=1.0,
        rtol=1e-12,
        source="identity",
        compute=energy_over_strength_and_range,
        status="derived",
    ),
    Check(
        "energy of separation, growth with twice the voltage",
        expect=4.0,
        rtol=1e-12,
        source="abstract: energy quadratic in the voltage",
        compute=lambda: separation_energy(voltage=2 * _VOLTAGE, **_COAT) / _energy(),
        status="abstract",
    ),
    Check(
        "energy of separation, 1 um of 3.9 at 100 V",
        expect=0.1727,
        rtol=5e-4,
        source=_APART,
        compute=_energy,
        status="derived",
    ),
    Check(
        "strength of adhesion, 1 um of 3.9 at 100 V",
        expect=673e3,
        rtol=1e-3,
        source=_APART,
        compute=lambda: adhesive_strength(voltage=_VOLTAGE, **_COAT),
        status="derived",
    ),
    _gain(0.1, 0.455),
    _gain(0.5, 0.185),
    _gain(2.0, 0.089),
)
