"""Area, pull and load of a contact that grows are those of one equilibrium."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import InputError
from electrovib.physics.contact import FixedArea, GrowingArea, PerssonSurface
from electrovib.scenario import load
from electrovib.solve.electrics.attraction import pressed, pressed_states
from electrovib.solve.simulate import simulate

PULL = 8290.0
"""Attraction that gives 0.450 N on the area under a load of 0.2 N alone, and 2.64 N on the area under both [Pa]."""
AREA = {"area": 1e-4, "at_force": 0.5}
CONTACT = GrowingArea(**AREA, exponent=2 / 3)
SKIN = PerssonSurface(modulus=6.7e3, rms_slope=1.0, rms_gap=2e-5, pressure_factor=0.5, decay_factor=0.5)
RELIEF = {"model": "PerssonSurface"} | SKIN.to_dict()
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
