"""A gap that is moved or yields: closed forms of constant charge, the general reference, fixed modes, and figure 2."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.diagnostics import diagnostics_of
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.material import Constant
from electrovib.physics.motion import TouchAndLift, TremblingDistance
from electrovib.solve.electrics import steps
from electrovib.solve.electrics.moving_gap import move_gap
from electrovib.solve.electrics.transient import transient
from electrovib.solve.nonlinear.finger import Yielding, follow_finger
from electrovib.solve.stack.keys import DisplacementOf, FieldOf

EPS0 = 8.8541878128e-12
END = 30e-3
EQUAL = 1e-7
"""Of the largest value of each signal, against the general reference; measured 1.2e-8 at most."""
DRY_SKIN = Constant(permittivity=1560.0)
COATING = 90e-6 / 3.35
FIXED = COATING + 200e-6 / 1560
GAP = FieldOf("gap")
TOUCH = TouchAndLift(far=1e-3, near=1e-6, begin=1e-3, approach=10e-3, touch=5e-3, lift=10e-3)
TREMBLE = TremblingDistance(mean=100e-6, amplitude=30e-6, frequency=50)
MOTIONS = {"touch and lift": TOUCH, "tremble": TREMBLE}
ELEMENTS = ("bare", "body", "floating")


@pytest.fixture
def held_finger(finger):
    """Hold a finger at 100 um whose gap can be moved."""
    common = {"gap": 0.0, "height": 100e-6, "moving": "gap"}
    return lambda element="bare", **given: finger(element, **common | given)


@pytest.mark.slow
@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", ["trapezium", "square", "sine"])
def test_general_reference(name, motion, element, held_finger, drive, worst):
    space, times = held_finger(element, charge=1e-5, gap=1e-9).space, np.linspace(0, END, 31)
    moved = move_gap(space, drive(name), times, motion=MOTIONS[motion])
    reference = follow_finger(space, drive(name), times, motion=MOTIONS[motion])
    assert worst(reference.found, moved.found) < EQUAL
    assert moved.errors["step_error"] < EQUAL
    assert f"{moved.steps} steps" in moved.reason


def test_a_pole_of_the_amplifier(held_finger, drive, worst):
    amplifier = Amplifier(gain=2.0, bandwidth=300.0, stray_capacitance=2e-11)
    space, times = held_finger("body", gap=1e-9).space, np.linspace(0, END, 31)
    moved = move_gap(space, drive("square"), times, motion=TREMBLE, amplifier=amplifier)
    reference = follow_finger(space, drive("square"), times, motion=TREMBLE, amplifier=amplifier)
    assert worst(reference.found, moved.found) < EQUAL
    assert np.max(np.abs(moved.found["amplifier_current"] - moved.found["current"])) > 0


def test_the_stated_error_bounds_the_error(monkeypatch, held_finger, drive):
    space, times = held_finger("floating", gap=1e-8).space, np.linspace(0, END, 31)
    exact = move_gap(space, drive("sine"), times, motion=TREMBLE).found[GAP]
    for name, value in {"STEPS": 8, "STEPS_PER_PERIOD": 4, "GROWTH": 4.0, "MOST_HALVINGS": 1}.items():
        monkeypatch.setattr(steps, name, value)
    coarse = move_gap(space, drive("sine"), times, motion=TREMBLE)
    error = np.max(np.abs(coarse.found[GAP] - exact)) / np.max(np.abs(exact))
    assert 1e-9 < error < coarse.errors["step_error"]


@pytest.mark.parametrize("element", ELEMENTS)
def test_a_gap_that_stays_is_that_of_fixed_modes(element, held_finger, drive, worst):
    """A tremor of no size: the exact linear solver."""
    still = TremblingDistance(mean=100e-6, amplitude=0.0, frequency=10)
    held, times = held_finger(element, charge=1e-5, gap=1e-9), np.linspace(0, END, 61)
    expected = transient(held.wanted, drive("square"), times)
    assert worst(expected, move_gap(held.space, drive("square"), times, motion=still).found) < 1e-8


def test_nothing_conducts_closed_form(held_finger, drive):
    """Charge stays: E_g = (V + q T_i/(eps0 eps_i))/(K_inf + g) exactly, and the current is that of dD_1/dt."""
    one, times = drive("trapezium"), np.linspace(0, END, 3001)
    moved = move_gap(held_finger(charge=-3e-5, skin=DRY_SKIN).space, one, times, motion=TOUCH)
    expected = (one.voltage(times) - 3e-5 * 90e-6 / (EPS0 * 3.35)) / (FIXED + TOUCH.gap(times))
    size = np.max(np.abs(expected))
    np.testing.assert_allclose(moved.found[GAP], expected, rtol=0, atol=1e-12 * size)
    assert (moved.steps, moved.errors["step_error"]) == (0, 0.0)
    assert "closed form" in moved.reason
    # D_1 behind the current, by the trapezoidal rule
    current = moved.found["current"] / 1e-4
    brought = np.concatenate([[0.0], np.cumsum((current[1:] + current[:-1]) / 2)]) * times[1]
    held = moved.found[DisplacementOf("insulator")]
    assert np.max(np.abs(brought + held[0] - held)) < 1e-3 * np.max(np.abs(held))


def test_a_charged_plate_that_is_let_go_keeps_its_displacement(held_finger, drive):
    """Behind so large a resistance no charge flows within the motion: D stays from g1 to g2, the voltage rises."""
    element = SeriesElement(resistance=1e10)  # 0.3 s against a motion of 1 ms, after 20 s of charging
    space = held_finger(element, skin=DRY_SKIN, height=1e-6).space
    motion = TouchAndLift(far=2e-6, near=1e-6, begin=10.0, approach=1e-3, touch=1.0, lift=1e-3)
    found = move_gap(space, drive("held"), np.array([0.0, 10.0, 10.001]), motion=motion).found
    before, after = found[DisplacementOf("gap")][1:]
    assert before == pytest.approx(EPS0 * 100 / (FIXED + 2e-6), rel=1e-9)
    assert after == pytest.approx(before, rel=2e-4)  # what flows back through the resistance within 1 ms
    step = (FIXED + 1e-6) / (FIXED + 2e-6)
    assert found["stack_voltage"][2] == pytest.approx(100 * step, rel=2e-4)


def test_a_suspended_finger_keeps_its_force_and_loses_it_by_a_leak(held_finger, drive):
    """Figure 2: a finger held off the plate at a held voltage; law (5) would decay."""
    times, resistivity = np.linspace(0.0, 0.5, 501), 1e9
    motion = TremblingDistance(mean=100e-6, amplitude=10e-6, frequency=8)
    found = move_gap(held_finger().space, drive("held"), times, motion=motion).found
    whole = found[GAP] * (found["gap"] + COATING)
    assert np.all(np.abs(whole[100:] / 100 - 1) < 1e-2)  # the skin's drop has gone after its time constants
    lost = move_gap(held_finger(gap=1 / resistivity).space, drive("held"), times, motion=motion).found[GAP]
    tau = EPS0 * resistivity * (1 + 100e-6 / COATING)  # eps0 rho_g (1 + C_i/C_g): 12 ms
    late = times > 8 * tau
    assert np.max(np.abs(lost[late])) < 0.02 * np.max(found[GAP])
    assert np.mean(found[GAP][late] ** 2) > 0.9 * np.mean(found[GAP][~late] ** 2)


class Spring:
    """A linear spring: 1e9 Pa/m from 10 um on."""

    def pressure(self, gap):
        return 1e9 * (10e-6 - gap)


def test_a_gap_that_yields_ends_in_equilibrium(held_finger, drive):
    """Spring = load + attraction."""
    load, times = 2e3, np.linspace(0, 10e-3, 201)
    motion = Yielding(surface=Spring(), load=lambda _: load, start=8e-6, damping=2e5)
    found = follow_finger(held_finger(skin=DRY_SKIN).space, drive("held"), times, motion=motion).found
    gap, field = found["gap"][-1], found[GAP][-1]
    assert field == pytest.approx(100 / (FIXED + gap), rel=1e-9)
    push = Spring().pressure(gap) - load - EPS0 * field**2 / 2
    assert abs(push) < 1e-6 * load
    assert gap < 8e-6 - 1e-9


def test_a_gap_that_only_creeps_follows_its_closed_form(held_finger, drive):
    """Without voltage: (g - g_end) = (g_0 - g_end) exp(-k t/d)."""
    motion = Yielding(surface=Spring(), load=lambda _: 5e3, start=8e-6, damping=1e6)
    times, space = np.linspace(0, 3e-3, 31), held_finger(skin=DRY_SKIN).space
    gap = follow_finger(space, drive({"model": "Step", "level": 0}), times, motion=motion).found["gap"]
    np.testing.assert_allclose(gap, 5e-6 + 3e-6 * np.exp(-1e3 * times), rtol=1e-8)


def test_field_emission_is_judged_at_the_largest_field_and_a_load_in_touch_is_none_off_the_plate():
    """Touch and lift under 3 kV: the gap field is largest in touch, Paschen's law is nearest in between."""
    touch = {"model": "TouchAndLift", "far": 1e-3, "near": 1e-6, "approach": 0.1, "touch": 0.1, "lift": 0.1}
    points = [{"time": t, "share": s} for t, s in ((0.1, 0), (0.12, 1), (0.18, 1), (0.2, 0))]
    load = {"load.normal_force": 0.5, "load.time_profile": {"model": "Corners", "points": points}}
    changes = {"motion.distance": touch, "drive.high": 3000.0} | load
    scenario = ev.load("vezzoli_2014/fig2_tremor", changes=changes)
    trace = ev.simulate(scenario, time=np.linspace(0, 0.3, 301))
    assert np.max(np.abs(trace.field.sel(layer="gap").values)) > 75e6
    states = {diagnostic.name: diagnostic.state for diagnostic in diagnostics_of(trace)}
    assert states["field emission"] == "warning"
    assert "load off the plate" not in states
