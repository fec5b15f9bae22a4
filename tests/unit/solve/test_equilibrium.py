"""Crossings of curves, states of a scenario, a gap that closes altogether, and areas that grow with what presses."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from parallel_plates import equilibria, pull_in_voltage

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.contact import (
    FittedSurface,
    FixedArea,
    GrowingArea,
    LinearSpring,
    PerssonSurface,
    PlateAttraction,
    RoughAttraction,
)
from electrovib.physics.roughness import GaussianGaps, IdleSpots, PullingSpots, mean_pull
from electrovib.scenario import load
from electrovib.solve.electrics.attraction import pressed, pressed_states
from electrovib.solve.equilibrium import equilibrium, hysteresis
from electrovib.solve.equilibrium.states import crossings
from electrovib.solve.simulate import simulate

EPS0 = 8.8541878128e-12
SPRING = {"model": "LinearSpring", "stiffness": 1e9, "free_gap": 1e-5}
SKIN = {"model": "PerssonSurface"} | dict(PerssonSurface.example)
FLOATING = {"model": "Floating", "capacitance": 150e-12}
THIN = {"stack.insulator.thickness": 1e-6}


def line(x):
    return 2 - x, -1.0


def stress(x, *, size=4.0):
    return size / (1 + x) ** 2, -2 * size / (1 + x) ** 3


def test_a_fold_is_reported_once(monkeypatch):
    """2 - x = 4/(1 + x)^2 touches at x = 1, in exact numbers."""
    (found,) = crossings(line, stress, low=0.0, high=2.0)
    assert found.fold
    assert found.place == pytest.approx(1.0, abs=2e-7)  # the root of rounding
    assert crossings(line, lambda x: stress(x, size=4.0 + 1e-9), low=0.0, high=2.0) == ()
    near = crossings(line, lambda x: stress(x, size=4.0 - 1e-9), low=0.0, high=2.0)
    assert [part.fold for part in near] == [False, False]
    # to second order 3/4 (x - 1)^2 = 1e-9/4
    assert near[1].place - near[0].place == pytest.approx(2 * np.sqrt(1e-9 / 3), rel=1e-3)
    monkeypatch.setattr("electrovib.solve.equilibrium.states.MOST_INTERVALS", 10)
    with pytest.raises(ElectrovibError, match="smooth"):
        crossings(line, stress, low=0.0, high=2.0)


def test_crossings_at_ends_and_halves_and_of_waves_are_found_once():
    def parabola(x):
        return (x - 4) ** 2, 2 * (x - 4)

    def places(height, *curves, **given):
        curves = curves or (parabola, lambda x: (height - 4 * x, -4.0))
        return [part.place for part in crossings(*curves, **given)]

    assert places(10, low=0.0, high=4.0) == []  # x^2 - 4 x + 6
    assert places(13, low=0.0, high=4.0) == pytest.approx([1, 3], abs=1e-14)  # x^2 - 4 x + 3
    assert places(13, low=1.0, high=3.0) == [1, 3]
    assert places(13, low=0.0, high=4.0, parts=8) == pytest.approx([1, 3], abs=1e-14)
    # a curve with inflections needs parts
    waves = (lambda x: (np.sin(x), np.cos(x)), lambda x: (0.5 + 0 * x, 0.0))
    turns = np.arange(0, 5) * 2 * np.pi
    expected = np.sort([*(turns + np.pi / 6), *(turns + 5 * np.pi / 6)])
    expected = expected[expected <= 30.0]
    np.testing.assert_allclose(places(0, *waves, low=0.0, high=30.0, parts=64), expected, rtol=1e-14)


def test_states_of_a_spring_under_its_load():
    given = {"surface": LinearSpring(stiffness=1e9, free_gap=1e-5), "electrical_thickness": 1e-6}
    (state,) = equilibria(**given, pressure=2e3, voltage=0.0)
    assert state.gap == pytest.approx(8e-6, rel=1e-14)
    assert state.stable
    (closed,) = equilibria(**given, pressure=2e4, voltage=0.0)
    assert closed.touching
    assert closed.stop == pytest.approx(1e4, rel=1e-12)
    pulled = given | {"pressure": 0.0, "voltage": 100.0}
    assert len(equilibria(**pulled)) == 3
    assert PlateAttraction(0.0, 1e-6).pressure(0.0) == 0
    with pytest.raises(InputError, match="rising"):
        hysteresis([1.0, 1.0], pressure=0, **given)


def test_nothing_pressing_has_no_bound_and_a_relief_flattened_too_far_is_not_followed():
    skin = PerssonSurface(**PerssonSurface.example)
    given = {"surface": skin, "pressure": 0.0, "voltage": 10.0, "electrical_thickness": 1e-6}
    with pytest.raises(InputError, match="nothing presses"):
        equilibria(**given)
    pressed = {"surface": skin, "pressure": 5e3, "electrical_thickness": 0.378e-6}
    with pytest.raises(InputError, match="closes further"):
        hysteresis([100.0, 1e5], spots=PullingSpots(), **pressed)


@pytest.fixture(scope="module")
def scenario():
    """A spring of 10 kPa over film and gap, under 0.1 N and 200 V; nothing but the skin conducts."""
    base = {"contact.surface": SPRING, "drive": {"model": "Step", "level": 200.0}, "load.normal_force": 0.1}
    conducts = {"stack.gap.material.conductivity": 0.0, "stack.stratum_corneum.material.conductivity": 1.8e-4}
    return load("vezzoli_2014/fig6_gap", changes=base | conducts | {"circuit.return_path.resistance": 0.0})


@pytest.mark.parametrize(
    ("path", "blocking"), [({}, ("insulator",)), (FLOATING, ("insulator", "return_path"))]
)
def test_a_scenarios_state_is_where_its_held_force_belongs(scenario, path, blocking):
    """With the gap that was found, the force that `simulate` ends at is the force of the state."""
    if path:
        scenario = scenario.replace({"circuit.return_path": path})
    found = equilibrium(scenario)
    assert (found.blocking, found.voltage) == (blocking, 200)
    assert not found.beyond
    assert found.pressure == pytest.approx(1e3, rel=1e-12)
    ((state,), (force,)) = found.states, found.force
    assert 8e-6 < state.gap < 9e-6
    held = scenario.replace({"stack.gap.thickness": state.gap, "time.duration": 10.0, "time.samples": 11})
    assert float(simulate(held).electrostatic_force[-1]) == pytest.approx(force, rel=1e-9)
    assert 1e9 * (1e-5 - state.gap) * 1e-4 == pytest.approx(0.1 + force, rel=1e-12)
    if not path:
        assert found.electrical_thickness == pytest.approx(90e-6 / 3.35, rel=1e-12)
        leaking = scenario.replace({"circuit.return_path": FLOATING | {"leak": 1e9}})
        assert equilibrium(leaking).force == found.force  # held, the body ends at ground


def growing(exponent):
    table = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": exponent, "surface": SPRING}
    return {"contact": table}


def test_a_growing_area_is_taken_under_the_load(scenario):
    found = equilibrium(scenario.replace(growing(0.5) | {"load.normal_force": 0.125}), voltage=100.0)
    assert found.area == pytest.approx(5e-5, rel=1e-12)
    assert found.pressure == pytest.approx(2.5e3, rel=1e-12)
    with pytest.raises(InputError, match="no contact area"):
        equilibrium(scenario.replace(growing(0.5) | {"load.normal_force": 0.0}))


@pytest.mark.parametrize("voltage", [0.0, 100.0, 1000.0])
@pytest.mark.parametrize("coating", [1e-6, 90e-6])
@pytest.mark.parametrize("path", [{"model": "Grounded"}, FLOATING], ids=["grounded", "floating"])
def test_an_area_that_does_not_grow_is_a_fixed_one(scenario, voltage, coating, path):
    """Exponent 0 by the route of growing areas: every state, stable or not, is that of the fixed area."""
    changes = {"stack.insulator.thickness": coating, "load.normal_force": 0.01, "circuit.return_path": path}
    fixed = scenario.replace(changes)
    one, other = (equilibrium(each, voltage=voltage) for each in (fixed, fixed.replace(growing(0.0))))
    for name in ("stable", "touching"):
        assert [getattr(s, name) for s in one.states] == [getattr(s, name) for s in other.states]
    np.testing.assert_allclose([s.gap for s in other.states], [s.gap for s in one.states], rtol=1e-9)
    np.testing.assert_allclose(other.force, one.force, rtol=1e-9)


def test_what_spots_hold_is_the_same_where_an_area_does_not_grow(scenario):
    fixed = scenario.replace(THIN | {"contact.surface": CORRECTED})
    table = {"contact": growing(0.0)["contact"] | {"surface": CORRECTED}}
    one, other = (
        equilibrium(each, voltage=50.0, spots=PullingSpots()) for each in (fixed, fixed.replace(table))
    )
    np.testing.assert_allclose([s.gap for s in other.states], [s.gap for s in one.states], rtol=1e-6)
    np.testing.assert_allclose(other.force, one.force, rtol=1e-6)
    assert max(abs(state.residual) for state in other.states) < 1e-6 * one.pressure


@pytest.mark.parametrize("exponent", [0.5, 2 / 3, 1.0])
def test_every_state_of_a_growing_area_is_of_load_and_attraction(scenario, exponent):
    coating = scenario.replace(growing(exponent) | THIN | {"load.normal_force": 0.01})
    found = equilibrium(coating, voltage=100.0)
    assert len(found.states) == (3 if exponent < 1 else 1)
    for state, force, area in zip(found.states, found.force, found.areas, strict=True):
        assert area == pytest.approx(coating.contact.gross_area(0.01 + force), rel=1e-9)
        assert (state.repulsion + state.stop) * area == pytest.approx(0.01 + force, rel=1e-9)
        assert abs(state.residual) < 1e-9 * (state.repulsion + state.stop)
    if exponent == 1:
        with pytest.raises(InputError, match="without bound"):
            equilibrium(coating, voltage=300.0)


def test_two_stable_states_are_both_given(scenario):
    found = equilibrium(scenario.replace(THIN | {"load.normal_force": 0.0}), voltage=60.0)
    assert [state.stable for state in found.states] == [True, False, True]
    assert len(found.stable) == 2
    assert found.force[0] > 100 * found.force[2]
    for state, force in zip(found.states, found.force, strict=True):
        assert force == pytest.approx(1e-4 * EPS0 * 60.0**2 / 2 / (1e-6 / 3.35 + state.gap) ** 2, rel=1e-12)


def test_spots_average_over_a_rough_surface(scenario):
    rough = scenario.replace(THIN | {"contact.surface": SKIN, "load.normal_force": 0.5})
    plain, idle, averaged = (
        equilibrium(rough, voltage=100.0, **spots)
        for spots in ({}, {"spots": IdleSpots()}, {"spots": PullingSpots()})
    )
    assert plain.force[-1] < idle.force[-1] < averaged.force[-1]
    given = {"electrical_thickness": averaged.electrical_thickness, "surface": rough.contact.surface}
    attraction = RoughAttraction(voltage=100.0, spots=PullingSpots(), **given)
    assert averaged.force[-1] == pytest.approx(1e-4 * attraction.pressure(averaged.states[-1].gap), rel=1e-12)
    assert not averaged.beyond
    low = rough.replace({"contact.surface.pressure_factor": 0.01})
    held = equilibrium(low, voltage=100.0, spots=PullingSpots())
    assert held.stable
    assert held.beyond  # flat it would be held too
    soft = rough.replace({"contact.surface.modulus": 1e5, "load.normal_force": 0.005})
    with pytest.raises(InputError, match="flattens the surface topography further"):
        equilibrium(soft, voltage=200.0, spots=PullingSpots())


COMMAND = {"model": "Step", "level": 1.0}


@pytest.mark.parametrize("voltage", [1.001e6, -2e9, math.nan])
def test_a_voltage_that_no_plate_has_is_refused(scenario, voltage):
    with pytest.raises(InputError, match="at most 1e"):
        equilibrium(scenario, voltage=voltage)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"contact.surface": None}, r"contact\.surface is not given"),
        ({"stack.gap.material.conductivity": 1e-9}, "stack.gap conducts"),
        ({"stack.insulator.material.conductivity": 1e-9}, "no layer blocks"),
        ({"stack.insulator.initial_charge": 1e-6}, r"stack\.insulator\.initial_charge"),
        ({"circuit.return_path": {"model": "SecondElectrode", "area": 1e-4}}, "one contact"),
        ({"drive": {"model": "CurrentAmplifier", "command": COMMAND, "sense_resistance": 1e5}}, "a current"),
    ],
)
def test_what_has_no_held_state_is_refused(scenario, changes, says):
    with pytest.raises(InputError, match=says):
        equilibrium(scenario.replace(changes))


def test_a_stack_without_a_gap_is_told_to_have_one(scenario):
    content = scenario.to_dict()
    del content["stack"]["gap"]
    with pytest.raises(InputError, match=r"there is no gap .*add \[stack\.gap\]"):
        equilibrium(type(scenario).model_validate(content))


def test_a_pull_in_names_gap_time_voltage_and_remedy(scenario):
    """A spring of 2 kPa over a film of 90 um, pressed with 200 Pa: below its pull-in voltage it stays open."""
    stiffness, free_gap = 1e8, 20e-6
    spring = {"model": "LinearSpring", "stiffness": stiffness, "free_gap": free_gap}
    closing = {
        "contact.surface": spring,
        "contact.closing": {"damping": 1e6},
        "stack.gap.thickness": free_gap,
    }
    skin = {"stack.stratum_corneum.material.conductivity": 1.8e-6}
    base = scenario.replace(closing | skin | {"load.normal_force": 0.02, "time.duration": 0.04})
    with pytest.raises(InputError) as told:
        simulate(base.replace({"drive.level": 1000.0}))
    found = re.search(
        r"contact\.closing: the layer 'gap' closes at ([\d.e-]+) s, under a drive of 1000 V: load and attraction press with"
        r" ([\d.e+]+) Pa, and contact\.surface = LinearSpring supports at most ([\d.e+]+) Pa \(pull-in\)\..* lower drive",
        str(told.value),
    )
    when, pressing, held = map(float, found.groups())
    # the film alone: eps0 (V/K)^2/2 with K = 90 um/3.35, but for skin that has not charged yet, and the load
    assert pressing == pytest.approx(8.854e-12 * (1000 / (90e-6 / 3.35)) ** 2 / 2 + 200, rel=0.02)
    assert held == pytest.approx(stiffness * free_gap, rel=1e-3)
    assert 1e6 * 18e-6 / 6300 < when < 0.04  # no earlier than the largest pressure closes it
    film = {"electrical_thickness": 90e-6 / 3.35, "pressure": 200.0}
    snap = pull_in_voltage(stiffness=stiffness, free_gap=free_gap, **film)
    assert simulate(base.replace({"drive.level": 0.9 * snap})).gap.values.min() > 5e-6


PULL = 8290.0
"""Attraction that gives 0.450 N on the area under a load of 0.2 N alone, and 2.64 N on the area under both [Pa]."""
AREA = {"area": 1e-4, "at_force": 0.5}
CONTACT = GrowingArea(**AREA, exponent=2 / 3)
SOFT = PerssonSurface(modulus=6.7e3, rms_slope=1.0, rms_gap=2e-5, pressure_factor=0.5, decay_factor=0.5)
RELIEF = {"model": "PerssonSurface"} | SOFT.to_dict()
GROWING = {"contact": {"model": "GrowingArea", "surface": RELIEF, "exponent": 2 / 3} | AREA}
TIME = np.array([0.0, 1e-3])


@pytest.fixture(scope="module")
def coating():
    """A coating of 1 um under a gap of 1 um that holds, with the voltage for the attraction above."""
    thin = {"stack.insulator.thickness": 1e-6, "stack.insulator.material.permittivity": 3.9}
    dry = {f"stack.{name}.material.conductivity": 0.0 for name in ("gap", "stratum_corneum")}
    voltage = math.sqrt(2 * PULL / eps0) * (1e-6 / 3.9 + 1e-6 + 200e-6 / 1560)
    drive = {"drive": {"model": "Step", "level": voltage}, "circuit.return_path.resistance": 0.0}
    return load("vezzoli_2014/fig6_gap", changes=thin | dry | drive | GROWING)


def run(scenario, load_of, **changes):
    trace = simulate(scenario.replace({"load.normal_force": load_of} | changes), time=TIME)
    return trace, {diagnostic.name: diagnostic for diagnostic in diagnostics_of(trace)}


def test_more_area_attracts_more(coating):
    """0.450 N with the area under the load alone; with the area that the attraction makes too, 2.64 N."""
    assert PULL * CONTACT.gross_area(0.2) == pytest.approx(0.450, abs=5e-4)
    trace, said = run(coating, 0.2)
    force, area = float(trace.electrostatic_force[-1]), float(trace.gross_contact_area[-1])
    assert force == pytest.approx(2.64, abs=5e-3)
    assert force == pytest.approx(PULL * area, rel=1e-9)
    assert area == pytest.approx(CONTACT.gross_area(0.2 + force), rel=1e-9)
    assert float(trace.lateral_force[-1]) == pytest.approx(0.5 * (0.2 + force), rel=1e-12)
    assert said["contact area"].state == "unknown"
    assert said["contact area"].value == pytest.approx(area / CONTACT.gross_area(0.2), rel=1e-12)
    assert "54.29 mm2 under the full load alone" in said["contact area"].text
    # the real area does not exceed the gross one: at 0.05 N it was 4.45e-5 of 2.15e-5 m2
    trace, _ = run(coating, 0.05)
    assert float(trace.real_contact_area[-1]) < float(trace.gross_contact_area[-1])


def powers(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


@given(load_of=powers(-4, 1), pull=powers(-2, 4), exponent=st.floats(0.1, 0.9))
def test_every_area_is_that_of_the_forces_it_makes(load_of, pull, exponent):
    contact = GrowingArea(**AREA, exponent=exponent, surface=PerssonSurface(**PerssonSurface.example))
    whole = pressed(contact, np.array([load_of]), np.array([pull, -pull]))
    area = contact.outline(whole)
    force = pull * area[0]
    assert load_of + force == pytest.approx(whole[0], rel=1e-9)
    assert pull * contact.gross_area(load_of + force) == pytest.approx(force, rel=1e-9)
    assert 0 < whole[1] < load_of < whole[0]
    assert abs(load_of - pull * area[1] - whole[1]) < 1e-9 * load_of
    assert np.all(contact.real_area(whole) <= area)


@pytest.mark.parametrize("pull", [10.0, 4000.0, 4999.0])
def test_an_area_in_proportion_to_the_force(pull):
    """W = load/(1 - pull/P) below the pressure P = at_force/area that the contact bears on any area."""
    whole = pressed(GrowingArea(**AREA, exponent=1.0), np.array([0.2]), np.array([pull]))
    assert whole[0] == pytest.approx(0.2 / (1 - pull / 5000), rel=1e-9)


def test_an_area_without_bound_is_said(coating):
    with pytest.raises(InputError, match=r"GrowingArea.*8\.29 kPa.*without bound.*contact\.exponent"):
        run(coating, 0.2, **{"contact.exponent": 1.0})
    assert pressed_states(GrowingArea(**AREA, exponent=1.0), load=0.2, pull=5001.0) == ()


def test_nothing_touches_without_a_load_or_beyond_what_a_load_bears():
    assert pressed(CONTACT.replace({"exponent": 0.0}), np.array([0.1]), np.array([-2000.0]))[0] == 0
    whole = pressed(CONTACT, np.array([0.0, 0.2, np.nan, 0.2]), np.array([100.0, np.nan, 1.0, 0.0]))
    np.testing.assert_array_equal(whole, [0.0, np.nan, np.nan, 0.2])
    fixed = pressed(FixedArea(area=1e-4), np.array([0.2]), np.array([1e3, -5e3]))
    np.testing.assert_allclose(fixed, [0.3, -0.3], rtol=1e-15)


def stepped(self, normal_force):
    """Area 1e-5 m2 up to 1 N, then within a few per cent 1e-3 m2."""
    force = np.asarray(normal_force, dtype=float)
    return force / (1e-5 + (1e-3 - 1e-5) / (1 + np.exp(-(force - 1.0) / 0.01)))


def test_of_several_states_the_one_from_the_load_alone_is_taken_and_all_are_told(coating, monkeypatch):
    """0.4 N and 8290 Pa on 1e-5 m2 are 0.4829 N; on 1e-3 m2 8.69 N; between them one that does not last."""
    monkeypatch.setattr(GrowingArea, "mean_pressure", stepped)
    states = pressed_states(CONTACT, load=0.4, pull=PULL)
    assert [stable for _, stable in states] == [True, False, True]
    assert states[0][0] == pytest.approx(0.4 + PULL * 1e-5, rel=1e-9)
    assert 0.9 < states[1][0] < 1.1
    assert states[2][0] == pytest.approx(0.4 + PULL * 1e-3, rel=1e-9)
    trace, said = run(coating, 0.4)
    assert float(trace.electrostatic_force[-1]) == pytest.approx(PULL * 1e-5, rel=1e-9)
    assert said["contact states"].state == "unknown"
    assert "3 states" in said["contact states"].text
    assert "8.29 N" in said["contact states"].text
    assert "contact states" not in run(coating, 0.4, **{"drive.level": 1.0})[1]


def test_where_the_pressure_falls_with_the_force_no_state_is_passed_over(monkeypatch):
    """W = L + c W^1.5 has the roots 1 and 1.3 N for c = 0.3/(1.3^1.5 - 1) and L = 1 - c; the first one lasts."""
    monkeypatch.setattr(
        GrowingArea, "mean_pressure", lambda _, force: 1e4 / np.sqrt(np.asarray(force, float))
    )
    share = 0.3 / (1.3**1.5 - 1)
    states = pressed_states(CONTACT, load=1 - share, pull=share / 1e-4)
    assert [stable for _, stable in states] == [True, False]
    assert [force for force, _ in states] == pytest.approx([1.0, 1.3], rel=1e-9)
    whole = pressed(CONTACT, np.array([1 - share]), np.array([share / 1e-4]))
    assert whole[0] == pytest.approx(1.0, rel=1e-9)


def test_one_sine_over_frequency_is_its_mean_over_time(coating):
    """The mean over the time of the force on the area of each moment."""
    sine = {"drive": {"model": "Sine", "amplitude": 60.0, "frequency": 1e3}, "load.normal_force": 0.2}
    settled = coating.replace(sine | {"time.initial_state": {"model": "PeriodicState"}})
    trace = simulate(settled, time=np.linspace(0, 1e-3, 2001)[:-1])
    over = np.interp(1e3, trace.frequency.values, trace.mean_force.values)
    assert over == pytest.approx(float(trace.electrostatic_force.mean()), rel=1e-6)


def test_a_closing_gap_bears_load_and_attraction_on_the_area_that_both_make(coating):
    closing = {"contact.surface.modulus": 2e7, "contact.closing": {"damping": 1e6}}
    film = {"stack.insulator.thickness": 90e-6, "drive.level": 1000.0, "load.normal_force": 0.2}
    scenario = coating.replace(closing | film)
    trace = simulate(scenario, time=np.array([0.0, 1.0, 3.0]))
    borne = scenario.contact.surface.pressure(trace.gap.values[-1])
    force, area = float(trace.electrostatic_force[-1]), float(trace.gross_contact_area[-1])
    assert force > 0.01
    assert borne * area == pytest.approx(0.2 + force, rel=1e-6)


CORRECTED = {"model": "FittedSurface", "modulus": 2e7, "rms_height": 1e-5, "rms_slope": 0.5}


def test_a_law_of_rough_contact_states_its_error_and_its_local_gaps():
    """The gaps that are printed attract as the state does: the mean over them, by the force law that takes them."""
    changes = {"contact.surface": CORRECTED, "stack.gap.material.conductivity": 0.0, **THIN}
    scenario = load("vezzoli_2014/fig6_gap", changes=changes)
    found = equilibrium(scenario, voltage=50.0, spots=PullingSpots())
    told = {each.name: each for each in found.diagnostics}
    assert (told["real contact"].state, "one gap" in told) == ("ok", False)
    printed = re.search(r"mean_gap = (\S+), rms_gap = (\S+), power = (\S+) }", str(found))
    mean, rms, power = (float(each) for each in printed.groups())
    gaps = GaussianGaps(mean=mean, rms=rms, power=power)
    pull = mean_pull(50.0, electrical_thickness=found.electrical_thickness, gaps=gaps, spots=PullingSpots())
    # five digits are printed
    assert float(pull.total) == pytest.approx(found.stable[-1].attraction, rel=1e-3)
    state = found.stable[-1]
    pressing = state.attraction - FittedSurface.held * float(pull.spots)
    assert state.repulsion == pytest.approx(found.pressure + pressing, rel=1e-4)
    assert abs(state.residual) < 1e-9 * state.repulsion
    assert pull.spots > 0.5 * state.attraction
    alone = equilibrium(scenario, voltage=50.0)
    told = {each.name: each for each in alone.diagnostics}
    assert told["one gap"].state == "warning"
    assert alone.gaps is None
    persson = equilibrium(scenario.replace({"contact.surface": SKIN}), voltage=50.0, spots=PullingSpots())
    assert "PerssonSurface, not corrected: its real contact is 0.55 to 1 (median" in str(persson)
    spring = equilibrium(scenario.replace({"contact.surface": SPRING}), voltage=50.0)
    assert not {"real contact", "one gap"} & {each.name for each in spring.diagnostics}


def test_a_run_states_the_error_of_its_law_of_rough_contact():
    def told(surface, **more):
        changes = {"contact.surface": surface, **more}
        trace = simulate(load("vezzoli_2014/fig6_gap", changes=changes))
        return [each for each in diagnostics_of(trace) if each.name == "real contact"]

    assert [each.state for each in told(CORRECTED)] == ["ok"]
    (outside,) = told(CORRECTED | {"modulus": 1e10})
    assert "real over gross contact area = " in outside.text
    assert [each.state for each in told(SKIN)] == ["warning"]
    assert told(SPRING) == []
    points = [{"time": 0.0, "share": 1e-4}, {"time": 0.02, "share": 1e-4}, {"time": 0.03, "share": 1.0}]
    (light,) = told(CORRECTED, **{"load.time_profile": {"model": "Corners", "points": points}})
    assert light.state == "warning"  # of the smallest share, while the largest one is within
    assert light.text.count("real over gross contact area = ") == 1


@pytest.mark.parametrize(
    ("gain", "saturation", "held"), [(1.0, None, 3.0), (-20.0, None, 60.0), (20.0, 40.0, 40.0)]
)
@pytest.mark.parametrize(
    "drive", [{"model": "Sine", "amplitude": 3.0, "frequency": 7.3e3}, {"model": "Step", "level": -3.0}]
)
def test_the_voltage_held_by_default_is_the_largest_behind_the_amplifier(drive, gain, saturation, held):
    amplifier = {"gain": gain} | ({} if saturation is None else {"saturation": saturation})
    changes = {"contact.surface": SPRING, "drive": drive, "circuit.amplifier": amplifier}
    found = equilibrium(load("bau_2010/sine", changes=changes))
    assert found.voltage == held
    assert found.force == equilibrium(load("bau_2010/sine", changes=changes), voltage=held).force
