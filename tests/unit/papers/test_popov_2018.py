"""An adhesive sphere under a voltage: derived numbers and identities."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from electrovib.papers import popov_2018
from electrovib.physics import adhesion
from electrovib.physics.roughness import local_pull

COATING = {"thickness": 1e-6, "permittivity": 3.9}
FINGER = {"radius": 1e-2, "modulus": 50e3}


def test_it_runs_nothing():
    """An equation nobody has read is not offered: no law, scenario or skin, and the reason in words."""
    for thing in vars(popov_2018).values():
        assert not (isinstance(thing, type) and thing.__module__ == popov_2018.__name__)
    assert not hasattr(popov_2018, "scenarios")
    assert not hasattr(popov_2018, "skins")
    assert "closed-form friction" in popov_2018.NOT_READ
    assert {check.status for check in popov_2018.CHECKS} <= {"abstract", "derived"}


@pytest.mark.parametrize(
    ("voltage", "coating", "energy", "strength", "reach"),
    [
        (100.0, COATING, 0.1727, 673e3, 0.256e-6),
        (1000.0, {"thickness": 90e-6, "permittivity": 3.35}, 0.165, 6.13e3, 26.9e-6),
    ],
)
def test_energy_strength_and_range(voltage, coating, energy, strength, reach):
    found = adhesion.separation_energy(voltage=voltage, **coating)
    assert found == pytest.approx(energy, rel=2e-3)  # three digits
    assert adhesion.adhesive_strength(voltage=voltage, **coating) == pytest.approx(strength, rel=2e-3)
    assert adhesion.adhesive_range(**coating) == pytest.approx(reach, rel=2e-3)
    product = adhesion.adhesive_strength(voltage=voltage, **coating) * adhesion.adhesive_range(**coating)
    assert product == pytest.approx(found, rel=1e-14)


def test_energy_is_that_of_pulling_the_conductors_apart():
    """The pull of the coating and a growing gap, summed over the gap, is the energy of separation."""

    electrical = adhesion.adhesive_range(**COATING)
    in_ranges = quad(
        lambda gap: float(local_pull(100.0, electrical_thickness=electrical, gap=gap * electrical)), 0, np.inf
    )[0]
    work = in_ranges * electrical
    assert work == pytest.approx(adhesion.separation_energy(voltage=100.0, **COATING), rel=1e-7)
    quarter = local_pull(100.0, electrical_thickness=electrical, gap=electrical)
    assert quarter == pytest.approx(adhesion.adhesive_strength(voltage=100.0, **COATING) / 4, rel=1e-12)


@pytest.mark.parametrize(("load", "gain"), [(0.1, 45.5), (0.5, 18.5), (2.0, 8.9)])
def test_growth_of_an_adhesive_sphere(load, gain):
    assert 100 * popov_2018.area_gain(normal_force=load) == pytest.approx(
        gain, abs=0.06
    )  # a tenth of a percent
    energy = adhesion.separation_energy(voltage=100.0, **COATING)
    soft, stiff = (
        adhesion.contact_area(normal_force=load, radius=1e-2, modulus=modulus, energy=energy)
        / adhesion.contact_area(normal_force=load, radius=1e-2, modulus=modulus)
        for modulus in (5e3, 5e6)
    )
    assert soft == pytest.approx(stiff, rel=1e-12)  # whatever the modulus
    assert 100 * (soft - 1) == pytest.approx(gain, abs=0.06)


def test_without_energy_the_sphere_is_that_of_hertz():
    assert adhesion.adhesive_load(normal_force=0.3, radius=1e-2, energy=0.0) == 0.3
    radius = np.sqrt(adhesion.contact_area(normal_force=0.3, **FINGER) / np.pi)
    assert 4 * FINGER["modulus"] * radius**3 / (3 * FINGER["radius"]) == pytest.approx(0.3, rel=1e-12)
