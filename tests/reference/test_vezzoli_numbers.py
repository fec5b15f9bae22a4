"""The numbers of Vezzoli et al. 2014 and of its film under other cut planes, by formula and by simulation."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

EPS0 = 8.8541878128e-12
AREA, VOLTAGE = 1e-4, 1000.0
FILM, FILM_PERMITTIVITY, SKIN, SKIN_PERMITTIVITY = 90e-6, 3.35, 200e-6, 1560.0
FILM_ELECTRICAL, SKIN_ELECTRICAL = FILM / FILM_PERMITTIVITY, SKIN / SKIN_PERMITTIVITY
ELECTRICAL = FILM_ELECTRICAL + SKIN_ELECTRICAL
ROUNDING = 1e-12  # a handful of roundings of formula and modes

# law, gap in um, printed force in mN, half a unit of its last digit
PLANES = [
    ("EffectiveMedium", 0, 56.55, 0.005),
    ("MaxwellStressInGap", 0, 607.6, 0.05),
    ("MaxwellStressInGap", 1, 564.9, 0.05),
    ("MaxwellStressInGap", 5, 432.5, 0.05),
    ("MaxwellStressInGap", 25, 163.8, 0.05),
    ("MaxwellStressInGap", 100, 27.5, 0.05),
    ("MaxwellStressInStratumCorneum", 0, 0.389, 0.0005),
    ("MaxwellStressInInsulator", 0, 181.4, 0.05),
]


def formula(law, gap, *, permittivity=SKIN_PERMITTIVITY):
    """Give the force in N from the bare formula of each plane."""
    electrical = FILM_ELECTRICAL + SKIN / permittivity
    vacuum = EPS0 * AREA * VOLTAGE**2 / 2
    return {
        "EffectiveMedium": vacuum / (electrical * (FILM + SKIN)),
        "MaxwellStressInGap": vacuum / (electrical + gap) ** 2,
        "MaxwellStressInStratumCorneum": vacuum / electrical**2 / permittivity,
        "MaxwellStressInInsulator": vacuum / electrical**2 / FILM_PERMITTIVITY,
    }[law]


def stack(finger, gap):
    layers = {"insulator": finger.film()}
    if gap:
        layers["gap"] = finger.gap(gap)
    return layers | {"stratum_corneum": finger.skin()}


@pytest.mark.parametrize(("law", "gap", "printed", "half_digit"), PLANES)
def test_static_force(finger, law, gap, printed, half_digit):
    gap = gap * 1e-6
    bare = formula(law, gap)
    assert abs(bare * 1e3 - printed) <= half_digit
    scenario = finger.build(drive={"model": "Step", "level": VOLTAGE}, force=law, stack=stack(finger, gap))
    force = simulate(scenario)["electrostatic_force"].values
    # nothing conducts and nothing is in series: the step is the force, at all times
    assert np.max(np.abs(force / bare - 1)) < ROUNDING


def test_the_digits_are_sharp_enough_to_refuse_another_skin():
    assert abs(formula("EffectiveMedium", 0, permittivity=1500) * 1e3 - 56.55) > 0.005
    assert abs(formula("MaxwellStressInStratumCorneum", 0, permittivity=1500) * 1e3 - 0.389) > 0.0005


@pytest.mark.parametrize(
    ("name", "printed", "half_digit"),
    [("insulator", 32.96e-12, 0.005e-12), ("stratum_corneum", 6.906e-9, 0.0005e-9)],
)
def test_capacitance(finger, name, printed, half_digit):
    layer = stack(finger, 0)[name]
    bare = EPS0 * layer["material"]["permittivity"] * AREA / layer["thickness"]
    scenario = finger.build(drive={"model": "Step", "level": 1}, stack={"insulator": layer})
    trace = simulate(scenario)
    angular = 2 * np.pi * trace["frequency"].values
    simulated = 1 / (1j * angular * trace["impedance"].values)
    assert np.max(np.abs(simulated / bare - 1)) < ROUNDING
    assert abs(bare - printed) <= half_digit


def test_planes_are_one_displacement_over_different_permittivities():
    gap_plane = formula("MaxwellStressInGap", 0)
    assert gap_plane / formula("MaxwellStressInInsulator", 0) == pytest.approx(FILM_PERMITTIVITY, rel=1e-14)
    assert gap_plane / formula("MaxwellStressInStratumCorneum", 0) == pytest.approx(
        SKIN_PERMITTIVITY, rel=1e-14
    )
    ratio = gap_plane / formula("EffectiveMedium", 0)
    assert ratio == pytest.approx((FILM + SKIN) / ELECTRICAL, rel=1e-14)
    assert ratio == pytest.approx(10.74, abs=0.005)  # printed with four digits


def test_force_of_a_sine_is_half_in_the_mean(finger):
    drive = {"model": "Sine", "amplitude": VOLTAGE, "frequency": 100}
    scenario = finger.build(drive=drive, stack=stack(finger, 5e-6), settled=True)
    mean = simulate(scenario)["mean_force"].values
    assert np.max(np.abs(mean / formula("MaxwellStressInGap", 5e-6) - 0.5)) < ROUNDING


def test_a_body_resistance_hides_the_step_only_for_its_time_constant(finger):
    scenario = finger.build(
        drive={"model": "Step", "level": VOLTAGE}, stack=stack(finger, 5e-6), resistance=1000.0
    )
    capacitance = EPS0 * AREA / (ELECTRICAL + 5e-6)
    times = np.array([0.0, 0.5, 1, 2, 5]) * 1000.0 * capacitance
    force = simulate(scenario, time=times)["electrostatic_force"].values
    expected = formula("MaxwellStressInGap", 5e-6) * np.expm1(-times / (1000.0 * capacitance)) ** 2
    assert np.max(np.abs(force - expected)) < ROUNDING * expected[-1]


def test_second_electrode_of_half_the_area(finger):
    """In series the smaller contact takes two thirds of the voltage; the finger is pulled at both."""
    path = {"model": "SecondElectrode", "area": AREA / 2, "resistance": 0}
    drive = {"model": "Step", "level": VOLTAGE}
    trace = simulate(finger.build(drive=drive, stack=stack(finger, 5e-6), return_path=path))
    electrical = ELECTRICAL + 5e-6
    first, second = (EPS0 / 2 * (share * VOLTAGE / electrical) ** 2 for share in (1 / 3, 2 / 3))
    expected = AREA * first + AREA / 2 * second
    assert np.max(np.abs(trace["electrostatic_force"].values / expected - 1)) < ROUNDING
    assert np.max(np.abs(trace["stack_voltage"].values / VOLTAGE - 1 / 3)) < ROUNDING


@pytest.mark.parametrize(
    "drive", [{"model": "Step", "level": VOLTAGE}, {"model": "Current", "amplitude": 1e-6}]
)
def test_the_voltage_of_a_stack_below_two_electrodes_is_that_of_its_first_contact(finger, drive):
    """It is the sum of its layers' fields times thicknesses; twice that lies across a second contact of half the area."""
    path = {"model": "SecondElectrode", "area": AREA / 2, "resistance": 0}
    if drive["model"] == "Current":
        drive = {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 100.0}
    trace = simulate(finger.build(drive=drive, stack=stack(finger, 5e-6), return_path=path))
    thickness = np.array([FILM, 5e-6, SKIN])
    across = np.sum(trace["field"].transpose("layer", "time").values * thickness[:, None], axis=0)
    first = trace["stack_voltage"].values
    np.testing.assert_allclose(first, across, atol=1e-9 * np.max(np.abs(first)))
    np.testing.assert_allclose(trace["drive_voltage"].values, 3 * first, atol=1e-9 * np.max(np.abs(first)))
    assert "first contact" in trace["stack_voltage"].attrs["long_name"]


def test_floating_body_divides_the_voltage(finger):
    path = {"model": "Floating", "capacitance": 100e-12, "resistance": 0}
    drive = {"model": "Step", "level": VOLTAGE}
    trace = simulate(finger.build(drive=drive, stack=stack(finger, 0), return_path=path))
    capacitance = EPS0 * AREA / ELECTRICAL
    share = 100e-12 / (100e-12 + capacitance)
    force = trace["electrostatic_force"].values / formula("MaxwellStressInGap", 0)
    assert np.max(np.abs(force / share**2 - 1)) < ROUNDING
    assert share**2 == pytest.approx(0.57, abs=0.005)  # the factor on the film, two digits


def test_surface_charge_cancels_the_voltage(finger):
    """E_g = (V + q T_i/(eps0 eps_i))/(K + g), the charge on the film's face towards the finger."""
    charge = -330e-6
    layers = stack(finger, 5e-6)
    layers["insulator"] |= {"initial_charge": charge}
    scenario = finger.build(drive={"model": "Step", "level": VOLTAGE}, stack=layers)
    trace = simulate(scenario)
    field = trace["field"].sel(layer="gap").values
    expected = (VOLTAGE + charge * FILM_ELECTRICAL / EPS0) / (ELECTRICAL + 5e-6)
    assert abs(VOLTAGE + charge * FILM_ELECTRICAL / EPS0) < 0.01 * VOLTAGE  # -330 uC/m2 cancels 1000 V
    # of the field without charge, because the two parts cancel
    assert np.max(np.abs(field - expected)) < ROUNDING * VOLTAGE / ELECTRICAL
    flux = EPS0 * np.array([FILM_PERMITTIVITY, 1.0, SKIN_PERMITTIVITY])[:, None] * trace["field"].values
    assert np.max(np.abs(flux - trace["displacement"].values)) < ROUNDING * abs(charge)
    assert np.max(np.abs(flux[1] - flux[0] - charge)) < ROUNDING * abs(charge)  # Gauss, towards the finger


def test_phasors_of_the_film_alone_hold_the_whole_voltage(finger):
    scenario = finger.build(
        drive={"model": "Step", "level": 1}, stack={"insulator": finger.film()}, resistance=0
    )
    section = phasors(scenario, np.geomspace(1, 1e6, 7))
    assert np.max(np.abs(section["insulator"].field * FILM - 1)) < 1e-15 * 4
