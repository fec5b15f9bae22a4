"""Real contact under load and attraction together: what its spots hold presses nothing."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.physics.contact import FittedSurface, PerssonSurface
from electrovib.physics.roughness import PullingSpots, mean_pull
from electrovib.solve.electrics.attraction import borne, real_area
from electrovib.solve.population.fingers import TOGETHER, Population

LAW = FittedSurface(modulus=2e6, rms_height=5e-6, rms_slope=0.2)
THICKNESS = 1e-6
SINE = "bau_2010/sine"
SURFACE = {"model": "FittedSurface", "modulus": "20 MPa", "rms_height": "5 um", "rms_slope": 0.3}
SHEAR = {"contact.surface": SURFACE, "friction": {"model": "AdhesiveShear", "shear_strength": 1e6}}


def of_spots(pressure, thickness=THICKNESS):
    pull = mean_pull(1.0, electrical_thickness=thickness, gaps=LAW.gaps(pressure), spots=PullingSpots())
    return float(pull.spots / pull.total)


@pytest.mark.parametrize("load", [1e3, 2e4])
@pytest.mark.parametrize("times", [1e-3, 0.3, 1.0, 3.0])
def test_the_pressure_that_is_borne_is_without_what_the_spots_hold(load, times):
    pull = times * load
    given = np.array([load + pull]), np.array([pull])
    found = float(borne(LAW, *given, electrical_thickness=THICKNESS)[0])
    # linear between 24 pressures in a decade
    assert found == pytest.approx(load + (1 - 0.7 * of_spots(found)) * pull, rel=1e-4)
    assert load < found < load + pull


def test_more_attraction_is_always_borne_and_without_any_the_load():
    attraction = np.array([0.0, *np.geomspace(1.0, 1e7, 200)])
    found = borne(LAW, 5e3 + attraction, attraction, electrical_thickness=THICKNESS)
    assert found[0] == pytest.approx(5e3, rel=1e-12)
    assert np.all(np.diff(found) > 0)
    nothing = np.zeros(2)
    assert np.isnan(borne(LAW, np.array([np.nan, 5e3]), nothing, electrical_thickness=THICKNESS)[0])
    assert borne(LAW, nothing, nothing, electrical_thickness=THICKNESS).tolist() == [0, 0]


def test_a_finger_of_many_bears_what_it_bears_alone():
    pressure, attraction = np.array([[6e3, 9e3], [2e4, 9e4]]), np.array([[1e3, 4e3], [1e4, 8e4]])
    many = borne(LAW, pressure, attraction, electrical_thickness=np.array([[1e-6], [3e-6]]))
    for row, each, part, thickness in zip(many, pressure, attraction, (1e-6, 3e-6), strict=True):
        assert row == pytest.approx(borne(LAW, each, part, electrical_thickness=thickness), rel=1e-13)
    known = ev.load(SINE).replace(SHEAR)
    free = ("stack.insulator.thickness", "load.normal_force", "drive.amplitude")
    population = Population(known, free=free, signals=("lateral_force",))
    assert population.method == TOGETHER
    found = population.signals({free[0]: [5e-7, 2e-6], free[1]: [0.3, 0.6], free[2]: [60.0, 90.0]})
    run = ev.run(known, set={free[0]: 2e-6, free[1]: 0.6, free[2]: 90.0})
    assert found["lateral_force"][1] == pytest.approx(run.lateral_force.values, rel=1e-9)


def test_a_run_has_the_real_contact_of_what_is_borne():
    known = ev.load(SINE).replace(SHEAR | {"drive.amplitude": 80.0})
    run, law, area = ev.run(known), known.contact.surface, known.contact_area
    force = run.electrostatic_force.values
    pressed = borne(law, (0.5 + force) / area, force / area, electrical_thickness=1e-6 / 3.9)
    assert run.real_contact_area.values == pytest.approx(area * law.real_share(pressed), rel=1e-12)
    assert run.lateral_force.values == pytest.approx(1e6 * run.real_contact_area.values, rel=1e-12)
    assert np.all(run.real_contact_area.values < area * law.real_share((0.5 + force) / area))


@pytest.mark.parametrize(
    "changes",
    [
        {"contact.surface": {"model": "LinearSpring", "stiffness": 1e9, "free_gap": 1e-5}},
        {"contact.surface": {"model": "PerssonSurface"} | dict(PerssonSurface.example)},
        {"stack.insulator.material.conductivity": 1e-9},
    ],
)
def test_where_no_spot_holds_anything_the_whole_attraction_presses(changes):
    known = ev.load(SINE).replace(SHEAR | changes)
    load, attraction = np.array([0.5, 0.5]), np.array([0.2, 0.4])
    whole = known.contact.real_area(load + attraction)
    assert real_area(known, load, attraction) == pytest.approx(whole, rel=1e-14)


@pytest.mark.parametrize(("spots", "held"), [("PullingSpots", True), ("IdleSpots", False)])
def test_spots_that_do_not_pull_hold_nothing(spots, held):
    law = {"model": "Persson2018RoughGap", "mean_gap": 1e-5, "rms_gap": 5e-6, "spots": {"model": spots}}
    known = ev.load("vezzoli_2014/fig6").replace(SHEAR | {"force": law})
    load, attraction = np.array([0.5]), np.array([0.4])
    less = real_area(known, load, attraction) < known.contact.real_area(load + attraction) * (1 - 1e-9)
    assert bool(less) is held


@pytest.mark.parametrize("permittivity", [1.0, 3.0])
def test_the_area_grows_under_the_whole_attraction_and_a_filled_gap_counts(permittivity):
    growing = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5, "surface": SURFACE}
    filled = {"stack.gap.material": {"model": "Constant", "permittivity": permittivity}}
    known = ev.load(SINE).replace({"contact": growing, "friction": SHEAR["friction"]} | filled)
    contact, law = known.contact, known.contact.surface
    pressure = contact.mean_pressure(np.array([0.8]))
    pressed = borne(law, pressure, pressure * 0.3 / 0.8, electrical_thickness=permittivity * 1e-6 / 3.9)
    expected = contact.gross_area(0.8) * law.real_share(pressed)
    assert real_area(known, np.array([0.5]), np.array([0.3])) == pytest.approx(expected, rel=1e-12)
