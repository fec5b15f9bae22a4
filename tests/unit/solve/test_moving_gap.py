"""A gap that is moved: closed forms of constant charge, the general reference, fixed modes, and figure 2."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.conduction import FieldConduction
from electrovib.physics.drive.base import Drive
from electrovib.physics.material import Constant, Debye
from electrovib.physics.motion import TouchAndLift, TremblingDistance
from electrovib.physics.stack import Layer
from electrovib.scenario import load
from electrovib.solve.electrics import steps
from electrovib.solve.electrics.moving_gap import move_gap
from electrovib.solve.electrics.transient import transient
from electrovib.solve.nonlinear.electrics import Electrics
from electrovib.solve.nonlinear.finger import FingerOnSurface, Yielding, follow_finger
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.keys import DisplacementOf, FieldOf
from electrovib.solve.stack.layer_states import stack_states
from electrovib.solve.stack.section import modal_section

EPS0 = 8.8541878128e-12
AREA = 1e-4
END = 30e-3
EQUAL = 1e-7
"""Of the largest value of each signal, against the general reference; measured 1.2e-8 at most."""
SKIN = Debye(permittivity_high=300, strength=1200, relaxation_time=2e-3, conductivity=3e-6)
DRIVES = {
    "trapezium": {"model": "Trapezium", "high": 100, "rise": 10e-3, "hold": 10e-3, "fall": 10e-3},
    "square": {"model": "Square", "high": 50, "low": -20, "frequency": 50},
    "sine": {"model": "Sine", "amplitude": 100, "frequency": 60},
}
HELD = {"model": "Step", "level": 100}
MOTIONS = {
    "touch and lift": TouchAndLift(far=1e-3, near=1e-6, begin=1e-3, approach=10e-3, touch=5e-3, lift=10e-3),
    "tremble": TremblingDistance(mean=100e-6, amplitude=30e-6, frequency=50),
}
ELEMENTS = {
    "bare": SeriesElement(),
    "body": SeriesElement(resistance=1e3),
    "floating": SeriesElement(resistance=1e5, elastance=1e10, rate=5.0),
}


def held_finger(*, charge=0.0, gap=0.0, skin=SKIN, element="bare", leak=None, moving="gap"):
    air = Constant(permittivity=1.0, conductivity=gap)
    film = Layer(thickness=90e-6, material=Constant(permittivity=3.35), initial_charge=charge)
    layers = {
        "insulator": film,
        "gap": Layer(thickness=100e-6, material=air, leak=leak),
        "stratum_corneum": Layer(thickness=200e-6, material=skin),
    }
    debye = {name: layer.material.debye() for name, layer in layers.items()}
    space = stack_states(layers, debye, area=AREA, element=ELEMENTS[element], moving=moving)
    return space, layers, debye


def worst(expected, found):
    return max(
        np.max(np.abs(found[name] - row)) / np.max(np.abs(row))
        for name, row in expected.items()
        if np.any(row)
    )


@pytest.mark.slow
@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", DRIVES)
def test_general_reference(name, motion, element):
    space, *_ = held_finger(charge=1e-5, gap=1e-9, element=element)
    drive, times = read_model(Drive, DRIVES[name]), np.linspace(0, END, 31)
    moved = move_gap(space, drive, times, motion=MOTIONS[motion])
    reference = follow_finger(space, drive, times, motion=MOTIONS[motion])
    assert worst(reference.found, moved.found) < EQUAL
    assert moved.errors["step_error"] < EQUAL
    assert f"{moved.steps} steps" in moved.reason


def test_the_stated_error_bounds_the_error(monkeypatch):
    space, *_ = held_finger(gap=1e-8, element="floating")
    drive, times = read_model(Drive, DRIVES["sine"]), np.linspace(0, END, 31)
    exact = move_gap(space, drive, times, motion=MOTIONS["tremble"]).found[FieldOf("gap")]
    monkeypatch.setattr("electrovib.solve.electrics.steps.STEPS", 8)
    monkeypatch.setattr("electrovib.solve.electrics.steps.STEPS_PER_PERIOD", 4)
    monkeypatch.setattr("electrovib.solve.electrics.steps.GROWTH", 4.0)
    monkeypatch.setattr(steps, "MOST_HALVINGS", 1)
    coarse = move_gap(space, drive, times, motion=MOTIONS["tremble"])
    error = np.max(np.abs(coarse.found[FieldOf("gap")] - exact)) / np.max(np.abs(exact))
    assert 1e-9 < error < coarse.errors["step_error"]


def test_a_gap_that_stays_is_that_of_fixed_modes():
    """A tremor of no size: the exact linear solver."""
    still = TremblingDistance(mean=100e-6, amplitude=0.0, frequency=10)
    drive, times = read_model(Drive, DRIVES["square"]), np.linspace(0, END, 61)
    for element, around in ELEMENTS.items():
        space, layers, debye = held_finger(charge=1e-5, gap=1e-9, element=element)
        section = modal_section(layers, debye, area=AREA, element=around, second=0.0)
        wanted = {FieldOf(name): section[name].field for name in layers}
        wanted["current"] = section.current_density * AREA
        expected = transient(wanted, drive, times)
        assert worst(expected, move_gap(space, drive, times, motion=still).found) < 1e-8


def test_nothing_conducts_closed_form():
    """Charge stays: E_g = (V + q T_i/(eps0 eps_i))/(K_inf + g) exactly, and the current is that of dD_1/dt."""
    skin = Constant(permittivity=1560.0)
    space, *_ = held_finger(charge=-3e-5, skin=skin)
    drive, times = read_model(Drive, DRIVES["trapezium"]), np.linspace(0, END, 3001)
    motion = MOTIONS["touch and lift"]
    moved = move_gap(space, drive, times, motion=motion)
    fixed = 90e-6 / 3.35 + 200e-6 / 1560
    gap = motion.gap(times)
    expected = (drive.voltage(times) - 3e-5 * 90e-6 / (EPS0 * 3.35)) / (fixed + gap)
    np.testing.assert_allclose(
        moved.found[FieldOf("gap")], expected, rtol=0, atol=1e-12 * np.max(np.abs(expected))
    )
    assert (moved.steps, moved.errors["step_error"]) == (0, 0.0)
    assert "closed form" in moved.reason
    # D_1 behind the current, by the trapezoidal rule
    current = moved.found["current"] / AREA
    brought = np.concatenate([[0.0], np.cumsum((current[1:] + current[:-1]) / 2)]) * times[1]
    held = moved.found[DisplacementOf("insulator")]
    assert np.max(np.abs(brought + held[0] - held)) < 1e-3 * np.max(np.abs(held))


def test_a_charged_plate_that_is_let_go_keeps_its_displacement():
    """Behind so large a resistance no charge flows within the motion: D stays from g1 to g2, the voltage rises."""
    skin = Constant(permittivity=1560.0)
    film = Layer(thickness=90e-6, material=Constant(permittivity=3.35))
    layers = {
        "insulator": film,
        "gap": Layer(thickness=1e-6, initial_charge=0.0),
        "stratum_corneum": Layer(thickness=200e-6, material=skin),
    }
    debye = {name: layer.material.debye() for name, layer in layers.items()}
    element = SeriesElement(resistance=1e10)  # 0.3 s against a motion of 1 ms, after 20 s of charging
    space = stack_states(layers, debye, area=AREA, element=element, moving="gap")
    motion = TouchAndLift(far=2e-6, near=1e-6, begin=10.0, approach=1e-3, touch=1.0, lift=1e-3)
    times = np.array([0.0, 10.0, 10.001])
    found = move_gap(space, read_model(Drive, HELD), times, motion=motion).found
    before, after = found[DisplacementOf("gap")][1:]
    fixed = 90e-6 / 3.35 + 200e-6 / 1560
    assert before == pytest.approx(EPS0 * 100 / (fixed + 2e-6), rel=1e-9)
    assert after == pytest.approx(before, rel=2e-4)  # what flows back through the resistance within 1 ms
    step = (fixed + 1e-6) / (fixed + 2e-6)
    assert found["stack_voltage"][2] == pytest.approx(100 * step, rel=2e-4)


def test_a_suspended_finger_keeps_its_force_and_loses_it_by_a_leak():
    """Figure 2: a finger held off the plate at a held voltage; law (5) would decay."""
    times = np.linspace(0.0, 0.5, 501)
    drive = read_model(Drive, HELD)
    motion = TremblingDistance(mean=100e-6, amplitude=10e-6, frequency=8)
    dry, *_ = held_finger(gap=0.0)
    found = move_gap(dry, drive, times, motion=motion).found
    fixed = 90e-6 / 3.35
    whole = found[FieldOf("gap")] * (found["gap"] + fixed)
    assert np.all(np.abs(whole[100:] / 100 - 1) < 1e-2)  # the skin's drop has gone after its time constants
    resistivity = 1e9
    leaky, *_ = held_finger(gap=1 / resistivity)
    lost = move_gap(leaky, drive, times, motion=motion).found
    tau = EPS0 * resistivity * (1 + 100e-6 / fixed)  # eps0 rho_g (1 + C_i/C_g): 12 ms
    late = times > 8 * tau
    assert np.max(np.abs(lost[FieldOf("gap")][late])) < 0.02 * np.max(found[FieldOf("gap")])
    assert np.mean(found[FieldOf("gap")][late] ** 2) > 0.9 * np.mean(found[FieldOf("gap")][~late] ** 2)


def test_from_far_to_touch_and_back_without_leak():
    """The force comes back along its own path: nothing is left behind."""
    motion = TouchAndLift(far=1e-3, near=1e-6, approach=10e-3, touch=5e-3, lift=10e-3)
    times = np.linspace(0, 25e-3, 251)
    space, *_ = held_finger(skin=Constant(permittivity=1560.0))
    field = move_gap(space, read_model(Drive, HELD), times, motion=motion).found[FieldOf("gap")]
    np.testing.assert_allclose(field, field[::-1], rtol=1e-9)
    assert field[125] > 30 * field[0]


def test_a_pole_of_the_amplifier():
    amplifier = Amplifier(gain=2.0, bandwidth=300.0, stray_capacitance=2e-11)
    space, *_ = held_finger(gap=1e-9, element="body")
    drive, times = read_model(Drive, DRIVES["square"]), np.linspace(0, END, 31)
    moved = move_gap(space, drive, times, motion=MOTIONS["tremble"], amplifier=amplifier)
    reference = follow_finger(space, drive, times, motion=MOTIONS["tremble"], amplifier=amplifier)
    assert worst(reference.found, moved.found) < EQUAL
    assert np.max(np.abs(moved.found["amplifier_current"] - moved.found["current"])) > 0


def test_refusals():
    drive, times = read_model(Drive, HELD), np.linspace(0, END, 3)
    leak = FieldConduction(conductivity=1e-9, onset_field=1e6)
    leaky, *_ = held_finger(leak=leak)
    still, *_ = held_finger(moving=None)
    space, layers, debye = held_finger()
    with pytest.raises(InputError, match="general solver"):
        move_gap(leaky, drive, times, motion=MOTIONS["tremble"])
    with pytest.raises(InputError, match="general solver"):
        move_gap(space, drive, times, motion=MOTIONS["tremble"], amplifier=Amplifier(source_current=1e-6))
    with pytest.raises(InputError, match=r"add a table stack\.gap"):
        move_gap(still, drive, times, motion=MOTIONS["tremble"])
    current = read_model(Drive, {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 100})
    with pytest.raises(InputError, match="prescribed current"):
        move_gap(space, current, times, motion=MOTIONS["tremble"])
    with pytest.raises(InputError, match=r"add a table stack\.cushion"):
        stack_states(layers, debye, area=AREA, element=ELEMENTS["bare"], moving="cushion")
    with pytest.raises(InputError, match="moves nothing else"):
        follow_finger(still, drive, times, motion=MOTIONS["tremble"])
    with pytest.raises(InputError, match="nothing slows the gap down"):
        Yielding(surface=Spring(), load=lambda _: 1e3, start=1e-6)


class Spring:
    """A linear spring: 1e9 Pa/m from 10 um on."""

    def pressure(self, gap):
        return 1e9 * (10e-6 - gap)


@pytest.mark.parametrize("mass", [0.0, 1.0])
def test_a_gap_that_yields_ends_in_equilibrium(mass):
    """Spring = load + attraction; a spring with a mass rings at its frequency before."""
    load = 2e3
    motion = Yielding(surface=Spring(), load=lambda _: load, start=8e-6, damping=2e5, mass=mass)
    space, *_ = held_finger(skin=Constant(permittivity=1560.0))
    times = np.linspace(0, 10e-3, 201)
    found = follow_finger(space, read_model(Drive, HELD), times, motion=motion).found
    gap, field = found["gap"][-1], found[FieldOf("gap")][-1]
    fixed = 90e-6 / 3.35 + 200e-6 / 1560
    assert field == pytest.approx(100 / (fixed + gap), rel=1e-9)
    push = Spring().pressure(gap) - load - EPS0 * field**2 / 2
    assert abs(push) < 1e-6 * load if mass == 0.0 else abs(push) < 1e-3 * load
    assert gap < 8e-6 - 1e-9


@pytest.mark.parametrize("mass", [0.0, 1.0])
@pytest.mark.parametrize("together", [None, lambda time, pull: 1e3 * (1 + time) + pull**2 / 1e3])
def test_several_times_of_a_gap_that_yields_are_one_after_the_other(mass, together):
    more = {"damping": 2e5, "mass": mass, "together": together}
    motion = Yielding(surface=Spring(), load=lambda time: 1e3 + 1e5 * time, start=8e-6, **more)
    space, *_ = held_finger(skin=Constant(permittivity=1560.0))
    system = FingerOnSurface(Electrics(space, read_model(Drive, HELD), end=END), motion)
    state, mode = system.begin()
    state, times = system.jump(state, time=0.0), np.array([1e-3, 2e-3, 5e-3])
    states = state[:, None] + np.outer(system.scale, [0.0, 0.01, -0.02])
    for asked in (system.rate, system.switches):
        one = [asked(now, mode, time=time) for now, time in zip(states.T, times.tolist(), strict=True)]
        found = asked(states, mode, time=times)
        np.testing.assert_allclose(found, np.transpose(one), rtol=1e-12, atol=0)
        assert np.all(np.ptp(found[-1:], axis=1) > 0)
    if mass:
        np.testing.assert_array_equal(system.rate(states, mode, time=times)[-2], states[-1])


def test_a_gap_that_only_creeps_follows_its_closed_form():
    """Without voltage: (g - g_end) = (g_0 - g_end) exp(-k t/d)."""
    motion = Yielding(surface=Spring(), load=lambda _: 5e3, start=8e-6, damping=1e6)
    space, *_ = held_finger(skin=Constant(permittivity=1560.0))
    times = np.linspace(0, 3e-3, 31)
    drive = read_model(Drive, {"model": "Step", "level": 0})
    gap = follow_finger(space, drive, times, motion=motion).found["gap"]
    np.testing.assert_allclose(gap, 5e-6 + 3e-6 * np.exp(-1e3 * times), rtol=1e-8)


def test_the_diagnostic_of_field_emission_sees_the_largest_field():
    """Touch and lift under 1 kV: the gap field is largest in touch, Paschen's law is nearest in between."""
    touch = {"model": "TouchAndLift", "far": 1e-3, "near": 1e-6, "approach": 0.1, "touch": 0.1, "lift": 0.1}
    scenario = load("vezzoli_2014/fig2_tremor").replace({"motion.distance": touch, "drive.high": 3000.0})
    trace = simulate(scenario, time=np.linspace(0, 0.3, 301))
    assert np.max(np.abs(trace.field.sel(layer="gap").values)) > 75e6
    diagnostics = {
        diagnostic["name"]: diagnostic["state"] for diagnostic in json.loads(trace.attrs["validity"])
    }
    assert diagnostics["field emission"] == "warning"


@pytest.mark.parametrize(("load_of", "said"), [(0.0, False), (0.5, True)])
def test_a_load_while_the_finger_is_off_the_plate_is_said(load_of, said):
    scenario = load("vezzoli_2014/fig2_tremor").replace({"load.normal_force": load_of})
    trace = simulate(scenario, time=np.linspace(0, 0.1, 11))
    assert ("load off the plate" in trace.attrs["validity"]) == said


def test_a_load_in_touch_alone_is_not():
    touch = {"model": "TouchAndLift", "far": 1e-3, "near": 1e-6, "approach": 0.1, "touch": 0.1, "lift": 0.1}
    points = [{"time": t, "share": s} for t, s in ((0.1, 0), (0.12, 1), (0.18, 1), (0.2, 0))]
    load_in_touch = {"load.normal_force": 0.5, "load.time_profile": {"model": "Corners", "points": points}}
    scenario = load("vezzoli_2014/fig2_tremor").replace({"motion.distance": touch} | load_in_touch)
    assert "load off the plate" not in simulate(scenario, time=np.linspace(0, 0.3, 31)).attrs["validity"]
