"""Laws of one layer, adhesion and rough contact: closed forms, trends, and that nothing is offered which nobody has read."""

import inspect
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.papers import (
    ayyildiz_2018,
    balasubramanian_2025,
    bau_2010,
    ciavarella_2020,
    grigorii_2020,
    popov_2018,
    strong_1970,
)
from electrovib.papers.vezzoli_2014.values import FORCE_MEASURED
from electrovib.physics.roughness import local_pull
from electrovib.solve.simulate import simulate
from electrovib.studies.evidence.files import of_publication

COATING = {"thickness": 1e-6, "permittivity": 3.9}
FILM = {"thickness": 90e-6, "permittivity": 3.35}


@pytest.mark.parametrize(
    ("paper", "words", "own_laws"),
    [
        (ayyildiz_2018, "equations, parameters and forces", set()),
        (popov_2018, "closed-form friction", set()),
        (balasubramanian_2025, "read", set()),
        (ciavarella_2020, "equation not read", {ciavarella_2020.BearingArea}),
    ],
)
def test_an_equation_nobody_has_read_is_not_offered(paper, words, own_laws):
    """No law, scenario or skin, and the reason in words; what is checked is of the abstract or derived."""
    classes = {thing for thing in vars(paper).values() if isinstance(thing, type)}
    assert {thing for thing in classes if thing.__module__ == paper.__name__} == own_laws
    assert not hasattr(paper, "scenarios")
    assert not hasattr(paper, "skins")
    assert words in paper.NOT_READ
    assert {check.status for check in paper.CHECKS} <= {"abstract", "derived"}


def test_no_number_of_memory_is_a_value_of_the_package():
    """Where a form is offered, the number in front of it is the user's; thresholds cited from memory stand nowhere."""
    law = ciavarella_2020.BearingArea
    with pytest.raises(InputError, match="prefactor"):
        read_model(law, {"modulus": 1e7, "rms_height": 1e-5, "rms_slope": 1.0})
    assert all(field.is_required() for field in law.model_fields.values())
    assert law.status == "unverified"
    numbers = {name for name, thing in vars(ciavarella_2020).items() if isinstance(thing, (int, float))}
    assert numbers <= {"eps0"}
    parameters = inspect.signature(balasubramanian_2025.at_speed).parameters
    assert all(parameter.default is inspect.Parameter.empty for parameter in parameters.values())
    text = inspect.getsource(bau_2010)
    assert not any(word in text for word in ("1.16", "270.0", "180.0", "11-25"))
    assert "not read" in bau_2010.NOT_READ


def test_trends_of_rough_contact_can_be_missed(monkeypatch):
    assert ayyildiz_2018.thinner_coatings_pull_more() == 1
    assert ayyildiz_2018.real_contact_grows() == 1
    monkeypatch.setattr(
        ayyildiz_2018, "_pull", lambda _rms, _in_rms, *, coating, voltage=1.0: coating / (1 + voltage)
    )
    assert ayyildiz_2018.thinner_coatings_pull_more() == 0
    assert ayyildiz_2018.real_contact_grows() == 0
    monkeypatch.setattr(ciavarella_2020, "friction_coefficient", lambda pressure, **_: pressure)
    assert ciavarella_2020.decays_to_a_plateau() == 0


def test_friction_without_voltage_is_on_the_plateau():
    load = np.geomspace(1.0, 1e4, 5)
    for pull in (0.0, 1e3):
        found = ciavarella_2020.friction_coefficient(load, pull=pull, modulus=1e7, slope=1.0)
        np.testing.assert_allclose(found, (load + pull) / load, rtol=1e-5)  # p/(E* h') is 1e-3 at most


def test_slopes_from_20_to_100_mm_per_s():
    paper = balasubramanian_2025
    for name, rise in (("cut_off", 1104.0), ("mass", 2.584e-3), ("stiffness", 323.2)):
        slope = paper.SLOPES[name]
        assert paper.change(of=name) == pytest.approx(rise, rel=1e-12)
        found = paper.at_speed(speed=0.13, slope=slope, known_at=0.05, known=500.0)
        assert found == pytest.approx(500.0 + rise, rel=1e-12), "80 mm/s above the known one"


def test_a_difference_threshold_in_volts_and_newtons():
    assert bau_2010.just_noticeable_ratio() == pytest.approx(1.149, abs=5e-4)  # 1.21 dB, three digits
    assert bau_2010.force_change(ratio=2.0) == pytest.approx(40 * np.log10(2), rel=1e-12)
    assert bau_2010.order_of_the_force() == 2
    assert float(simulate(bau_2010.scenarios()["sine"]).electrostatic_force.min()) >= 0


@pytest.mark.parametrize(
    ("voltage", "coating", "energy", "strength", "reach"),
    [(100.0, COATING, 0.1727, 673e3, 0.256e-6), (1000.0, FILM, 0.165, 6.13e3, 26.9e-6)],
)
def test_energy_strength_and_range_of_adhesion(voltage, coating, energy, strength, reach):
    """Three digits; the pull of the coating and a growing gap, summed over the gap, is the energy of separation."""
    found = popov_2018.separation_energy(voltage=voltage, **coating)
    pull, electrical = (
        popov_2018.adhesive_strength(voltage=voltage, **coating),
        popov_2018.adhesive_range(**coating),
    )
    assert (found, pull, electrical) == pytest.approx((energy, strength, reach), rel=2e-3)

    def at(in_ranges):
        return float(local_pull(voltage, electrical_thickness=electrical, gap=in_ranges * electrical))

    assert quad(at, 0, np.inf)[0] * electrical == pytest.approx(found, rel=1e-7)
    assert at(1.0) == pytest.approx(pull / 4, rel=1e-12)


def test_growth_of_an_adhesive_sphere():
    """The same at each modulus; without energy it is that of Hertz."""
    energy = popov_2018.separation_energy(voltage=100.0, **COATING)
    for modulus in (5e3, 5e6):
        sphere = {"normal_force": 0.5, "radius": 1e-2, "modulus": modulus}
        growth = popov_2018.contact_area(**sphere, energy=energy) / popov_2018.contact_area(**sphere)
        assert growth - 1 == pytest.approx(0.185, abs=6e-4)
        assert growth - 1 == pytest.approx(popov_2018.area_gain(normal_force=0.5), rel=1e-12)
        radius = np.sqrt(popov_2018.contact_area(**sphere) / np.pi)
        assert 4 * modulus * radius**3 / (3 * 1e-2) == pytest.approx(0.5, rel=1e-12)
    assert popov_2018.adhesive_load(normal_force=0.3, radius=1e-2, energy=0.0) == 0.3


@given(st.floats(1e-7, 1e-3), st.floats(1, 100), st.floats(1e-6, 1e-3), st.floats(1, 1e4))
def test_the_law_of_strong_is_the_insulator_plane_of_one_layer(thickness, permittivity, area, voltage):
    changes = {
        "drive": {"model": "Step", "level": voltage},
        "stack.insulator.thickness": thickness,
        "stack.insulator.material.permittivity": permittivity,
        "contact.area": area,
    }
    scenario = strong_1970.scenarios()["display"].replace(changes)
    force = simulate(scenario, time=np.array([0.0, 10.0])).electrostatic_force[-1]
    layer = {"thickness": thickness, "permittivity": permittivity}
    unverified = strong_1970.static_force(**layer, area=area, voltage=voltage)
    by_hand = eps0 * permittivity * area * voltage**2 / (2 * thickness**2)
    assert unverified / by_hand == pytest.approx(1.0, rel=1e-12)  # rounding
    # the body's resistance still charges the plate: e^(-10 s/RC), RC at most 1e-3 s
    assert float(force) / unverified == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize(
    "drive",
    [
        {"model": "Sine", "amplitude": 1000.0, "frequency": 100.0},
        {"model": "PulseTrain", "high": -1000.0, "width": 1e-3, "frequency": 100.0},
        {
            "model": "AmplitudeModulation",
            "amplitude": 500.0,
            "carrier": 3000,
            "modulation": 100,
            "depth": 1.0,
        },
    ],
    ids=lambda drive: drive["model"],
)
def test_drives_of_one_peak_pull_alike_at_their_peak(drive):
    scenario = strong_1970.scenarios()["display"].replace({"drive": drive})
    trace = simulate(scenario, time=np.arange(4001) * 1e-5)
    static = strong_1970.attraction("MaxwellStressInInsulator", voltage=1000.0)
    # the peak of a sine of 3 kHz may lie half a sample of 10 us away, 1 - cos(0.1)^2 = 0.9 %
    assert float(trace.electrostatic_force.max()) == pytest.approx(static, rel=1e-2)


def test_the_numbers_of_rauf_2025_are_those_that_its_notes_describe():
    """Exponents of the voltage by a straight line through logarithms, and the slope over the load."""
    found = of_publication("rauf_2025")

    def exponent(name):
        return np.polyfit(np.log(found[name].at), np.log(found[name].values), 1)[0]

    assert f"to the power {exponent('zhang_c'):.1f}" in found["zhang_c"].note
    assert exponent("zhang_a") > 1.2
    assert "not monotonic" in found["zhang_b"].note
    assert not all(np.diff(found["zhang_b"].values) < 0)
    assert exponent("voltage") == pytest.approx(2, abs=0.1)
    load = found["load_300V"]
    assert f"{np.ptp(load.values) / np.ptp(load.at):.2f} N per newton" in found["voltage"].note
    assert found["voltage"].values[-1] == pytest.approx(load.values[0], rel=0.02)
    assert len(found) == 43


@pytest.mark.parametrize(
    ("paper", "name", "used"),
    [
        ("palmar_1995", "exponent_women", (0.8025,)),
        ("palmar_1995", "exponent_men", (0.7545,)),
        ("vezzoli_2014", "swing", (math.sqrt(math.prod(FORCE_MEASURED)),)),
        ("grigorii_2020", "per_current", tuple(map(grigorii_2020.per_current, (0.15, 0.25, 0.5, 1.0, 1.25)))),
    ],
)
def test_laws_and_checks_use_the_numbers_that_the_file_of_the_publication_states(paper, name, used):
    assert of_publication(paper)[name].values == pytest.approx(used, rel=1e-12)
