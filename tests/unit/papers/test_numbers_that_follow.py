"""Numbers in the files of publications that follow from others: whoever edits one of them is told of the other."""

import math

import numpy as np
import pytest

from electrovib.core.constants import eps0
from electrovib.core.paths import value_at
from electrovib.papers import kaczmarek_2006, meyer_2013, nakamura_2017, plutchik_1963, vezzoli_2014
from electrovib.papers.vezzoli_2014 import values
from electrovib.scenario import load
from electrovib.solve.stack.expand import phasors

FAST, SLOW = kaczmarek_2006.FAST, kaczmarek_2006.SLOW
SKIN, GAP = "stack.stratum_corneum", "stack.gap"


@pytest.mark.parametrize(
    ("scenario", "path", "expected"),
    [
        ("vezzoli_2014/fig6", f"{SKIN}.material.conductivity", eps0 * 1560 / 7.7e-3),
        ("vezzoli_2014/fig6", f"{SKIN}.material.permittivity", values.SKIN_PERMITTIVITY),
        ("vezzoli_2014/fig6", f"{SKIN}.thickness", values.SKIN_THICKNESS),
        ("vezzoli_2014/fig6", "stack.insulator.thickness", values.FILM_THICKNESS),
        ("vezzoli_2014/fig6", "stack.insulator.material.permittivity", values.FILM_PERMITTIVITY),
        ("vezzoli_2014/fig6", "contact.area", values.AREA),
        ("vezzoli_2014/fig6", "drive.high", values.VOLTAGE),
        ("vezzoli_2014/fig6", "drive.rise", values.RAMP),
        ("vezzoli_2014/fig6_gap", f"{GAP}.material.conductivity", 1 / 8.7e8),
        ("vezzoli_2014/fig7", "stack.insulator.thickness", values.COATING_THICKNESS),
        ("vezzoli_2014/fig7", "stack.insulator.material.permittivity", values.COATING_PERMITTIVITY),
        ("aliabbasi_2022/maximum", f"{GAP}.material.conductivity", 1 / 9.13e7),
        ("aliabbasi_2024/chain", f"{GAP}.material.conductivity", 1 / 2e7),
        ("kaczmarek_2006/positive", f"{SKIN}.material.conductivity", kaczmarek_2006.skin_conductivity(SLOW)),
        ("kaczmarek_2006/positive", f"{GAP}.material.conductivity", kaczmarek_2006.gap_conductivity(SLOW)),
        ("kaczmarek_2006/skin_biphasic", f"{SKIN}.leak.conductivity_positive", kaczmarek_2006.skin_conductivity(FAST)),
        ("kaczmarek_2006/gap_negative", f"{GAP}.leak.conductivity_positive", kaczmarek_2006.gap_conductivity(FAST)),
        ("meyer_2013/first_order", f"{SKIN}.material.conductivity",
            meyer_2013.first_order_skin(time_constant=1 / (2 * math.pi * 500)).conductivity),
        ("nakamura_2017/charged", f"{GAP}.initial_charge", nakamura_2017.interface_charge(gap_resistivity=1e12)),
        ("nakamura_2017/rise", f"{SKIN}.material.conductivity", 1 / nakamura_2017.RESISTIVITY),
    ],
)  # fmt: skip
def test_a_number_is_the_one_that_follows_from_others(scenario, path, expected):
    assert value_at(load(scenario), path) == pytest.approx(expected, rel=1e-12)


def test_constant_phase_skins_go_through_the_point_of_the_paper():
    for name, skin in vezzoli_2014.skins().items():
        if name != "point":
            anchor = math.tan(skin.material.exponent * math.pi / 2) / (2 * math.pi * values.TAU_MODEL)
            assert skin.material.reference_frequency == pytest.approx(anchor, rel=1e-12)
            assert skin.material.permittivity == values.SKIN_PERMITTIVITY


def test_the_skin_of_1963_is_a_cole_admittance():
    """G0 (1 + (j w tc)^alpha) of 130.8 kohm, 0.911 ms and 0.783, as of 1 cm2 and 200 um."""
    frequency = np.geomspace(0.1, 1e6, 15)
    admittance = (1 + (2j * np.pi * frequency * 0.911e-3) ** 0.783) / 130.8e3
    found = [1 / plutchik_1963.impedance(each) for each in frequency]
    assert found == pytest.approx(admittance, rel=1e-12)


def test_voltage_and_current_give_one_field_in_the_gap():
    current, voltage = (load(f"kim_2015/{name}") for name in ("current", "voltage"))
    fields = [
        each.drive.amplitude * abs(phasors(each, np.array([25e3]))["gap"].field[0])
        for each in (current, voltage)
    ]
    assert fields[0] == pytest.approx(fields[1], rel=1e-12)
    assert current.drive.amplitude == pytest.approx(math.sqrt(2) * 1e-3, rel=1e-15)
