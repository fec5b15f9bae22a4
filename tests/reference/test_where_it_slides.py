"""Friction is there where something slides on something; at rest it is what a spring tells, or it is not known."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from electrovib.core.errors import InputError
from electrovib.physics.motion import HeldOff, Motion, TouchAndLift
from electrovib.scenario import load
from electrovib.solve.mechanics.lateral import not_known, resting
from electrovib.solve.simulate import simulate

COULOMB = {"model": "Coulomb", "coefficient": 0.5}
LAG = {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": 100.0}
CREEP = {"model": "Creep", "steady": COULOMB, "relaxations": [{"share": 0.3, "time": 5e-3}]}
RISING = LAG | {"renewal_length": 1 / 13.8e3}
LUGRE = {
    "model": "LuGre",
    "steady": COULOMB,
    "stiffness": 1e5,
    "static_ratio": 1.0,
    "stribeck_speed": 5e-3,
    "viscous_damping": 0.5,
}
FRICTIONS = {
    "Coulomb": COULOMB,
    "PowerLaw": {"model": "PowerLaw", "coefficient": 0.6, "at_force": 1.0, "exponent": -0.206},
    "FirstOrderLag": LAG,
    "a corner that rises": RISING,
    "Creep": CREEP,
    "LuGre": LUGRE,
    "Dahl": {"model": "Dahl", "steady": COULOMB, "stiffness": 1e5},
}
BRISTLES = ("LuGre", "Dahl")
SWIPE = {"model": "Swipe", "begin": 0.02, "rise": 0.01, "hold": 0.08, "fall": 0.01}
TOUCH = {
    "model": "TouchAndLift",
    "far": 1e-3,
    "near": 1e-6,
    "begin": 0.0,
    "approach": 0.05,
    "touch": 0.08,
    "lift": 0.05,
}
TREMOR = {"model": "TremblingDistance", "mean": 1e-4, "amplitude": 1e-5, "frequency": 8.0}
SPEED = {"speed": 0.03}
MOTIONS = {
    "no speed": {},
    "a speed": SPEED,
    "speed 0": {"speed": 0.0},
    "a swipe that stops": SPEED | {"time_profile": SWIPE},
    "trembling": SPEED | {"distance": TREMOR},
    "held off": SPEED | {"distance": {"model": "HeldOff"}},
    "touch and lift": SPEED | {"distance": TOUCH},
}
FINGER = {"model": "MassSpringDamper", "mass": 1.5e-4, "stiffness": 1e3, "damping": 1.0}
RIG = {
    "model": "Tribometer",
    "normal": {"natural_frequency": 2e3, "damping_ratio": 0.5, "time_constant": 1e4},
    "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.5},
}
TIME = np.linspace(0, 0.2, 201)


@pytest.fixture(scope="module")
def dry():
    """A gap that holds its field: 565 mN at 1000 V."""
    return load("vezzoli_2014/fig6_gap").replace(
        {
            "stack.gap.material.conductivity": 0.0,
            "drive": {"model": "Trapezium", "high": 1000.0, "rise": 0.005, "hold": 0.15, "fall": 0.005},
        }
    )


def diagnostics(trace):
    return {diagnostic["name"]: diagnostic for diagnostic in json.loads(trace.attrs["validity"])}


@pytest.mark.parametrize("finger", [None, FINGER], ids=["rigid", "finger"])
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.slow
def test_every_friction_with_every_motion(dry, friction, motion, finger):
    """Finite where it slides, 0 off the plate, known at rest only by a spring or bristles; the rig says the same."""
    scenario = dry.replace(
        {"friction": FRICTIONS[friction], "motion": MOTIONS[motion], "finger": finger, "rig": RIG}
    )
    if motion == "no speed" and friction in (*BRISTLES, "a corner that rises"):
        with pytest.raises(InputError, match=r"motion\.speed"):
            simulate(scenario, time=TIME)
        return
    trace = simulate(scenario, time=TIME)
    lateral, read = trace.lateral_force.values, trace.lateral_force_measured.values
    moves = scenario.motion
    off, rests = ~moves.touches(TIME), moves.rests(TIME)
    assert np.all(lateral[off] == 0)
    told = friction in BRISTLES or finger is not None
    if told:
        assert np.all(np.isfinite(lateral))
        assert np.all(np.isfinite(read))
    else:
        assert np.all(np.isnan(lateral[rests]))
        assert np.all(np.isnan(read[rests & np.roll(rests, 3)]))  # 3 ms after a stop the sensor has noticed
        assert np.any(np.isfinite(lateral)) == (not np.all(rests))
    if finger is not None:
        assert np.all(np.isfinite(trace.skin_displacement.values))
        assert not off[-1] or abs(trace.skin_displacement.values[-1]) < 1e-9
    known = np.isfinite(lateral) & moves.slides(TIME)
    if np.any(known):
        law = scenario.friction.without_memory()
        whole = 0.5 + trace.electrostatic_force.values
        most = np.max(law.lateral_force(whole, 0 * whole, np.nan * whole)) + 0.02
        assert 0.2 < np.max(lateral[known]) < most
    state = diagnostics(trace).get("friction at rest", {"state": None})["state"]
    assert state == (None if not np.any(rests) else "ok" if told else "unknown")
    if "distance" in MOTIONS[motion]:
        assert diagnostics(trace)["off the plate"]["state"] == "ok"


def test_a_finger_held_off_has_no_friction():
    """Figure 2 reported 250 to 264 mN."""
    trace = simulate(load("vezzoli_2014/fig2"))
    assert isinstance(load("vezzoli_2014/fig2").motion.distance, HeldOff)
    assert float(trace.electrostatic_force.max()) == pytest.approx(27.5e-3, rel=1e-2)
    assert np.all(trace.lateral_force.values == 0)
    assert trace.attrs["solver"] == "transient"  # the gap does not move


def test_held_off_needs_a_gap():
    with pytest.raises(InputError, match=r"HeldOff.*\[stack\.gap\]"):
        load("vezzoli_2014/fig6").replace({"motion.distance": {"model": "HeldOff"}})


def test_attraction_counts_while_a_finger_touches(dry):
    """mu (load + attraction) in touch, 0.42 N where it was 0.25, and nothing before and after."""
    held = dry.replace({"motion.distance": TOUCH, "drive": {"model": "Step", "level": 772.0}, "rig": RIG})
    trace = simulate(held, time=TIME)
    in_touch = (TIME > 0.0495) & (TIME < 0.1295)
    whole = 0.5 + trace.electrostatic_force.values
    np.testing.assert_allclose(trace.lateral_force.values[in_touch], 0.5 * whole[in_touch], rtol=1e-12)
    assert float(trace.lateral_force.values[in_touch].max()) == pytest.approx(0.42, abs=1e-3)
    assert np.all(trace.lateral_force.values[~in_touch] == 0)
    # the sensor under the plate reads the load in touch, and off the plate the load less the pull
    read = trace.normal_force_measured.values - trace.normal_force_measured.values[0]
    late = (TIME > 0.06) & in_touch
    first = 0.5 - float(trace.electrostatic_force[0])
    np.testing.assert_allclose(read[late], 0.5 - first, atol=2e-4)
    before = (TIME > 0.045) & (TIME < 0.0495)
    expected = 0.5 - trace.electrostatic_force.values - first
    np.testing.assert_allclose(read[before], expected[before], atol=5e-3)


def test_a_contact_that_begins_remembers_nothing(dry):
    """Behind a lag the friction of a new touch rises from 0 with its corner."""
    held = dry.replace({"motion.distance": TOUCH, "friction": LAG, "drive": {"model": "Step", "level": 0.0}})
    trace = simulate(held, time=np.linspace(0, 0.2, 2001))
    time = trace.time.values
    expected = np.where(held.motion.touches(time), 0.25 * -np.expm1(-2 * np.pi * 100 * (time - 0.05)), 0.0)
    np.testing.assert_allclose(trace.lateral_force.values, expected, atol=2e-7)


def test_the_second_of_two_contacts_remembers_nothing_of_the_first(dry, monkeypatch):
    """In touch until 20 ms and again from 50 ms on, with a memory of 100 s: the second begins at 0."""
    monkeypatch.setattr(TouchAndLift, "breaks", lambda _: (0.0, 0.02, 0.05, 0.1))
    monkeypatch.setattr(
        TouchAndLift, "touches", lambda _, time: (np.asarray(time) < 0.02) | (np.asarray(time) >= 0.05)
    )
    slow = {"model": "Creep", "steady": COULOMB, "relaxations": [{"share": 0.4, "time": 100.0}]}
    held = dry.replace({"motion.distance": TOUCH, "friction": slow, "drive": {"model": "Step", "level": 0.0}})
    lateral = simulate(held, time=np.array([0.0, 0.01, 0.03, 0.06])).lateral_force.values
    np.testing.assert_allclose(lateral, [0.25, 0.25, 0.0, 0.6 * 0.25 + 0.1 * 1e-4], atol=1e-6)


@pytest.mark.parametrize("count", [3, 600])
def test_at_a_jump_at_the_last_time_the_prompt_share_follows_at_once(dry, count):
    """A creep of 30 % in 5 ms, against the sum over a fine record of what it follows; the record ends with a jump to 1 kV."""
    creep = {"model": "Creep", "steady": COULOMB, "relaxations": [{"share": 0.3, "time": 5e-3}]}
    square = {"model": "Square", "high": 1000.0, "low": 0.0, "frequency": 50.0}
    scenario = dry.replace({"friction": creep, "drive": square, "circuit.return_path.resistance": 0.0})
    fine = np.linspace(0, 0.02, 20_001)
    steady = 0.5 * (0.5 + simulate(scenario, time=fine).electrostatic_force.values)
    weights = np.exp((fine - 0.02) / 5e-3)
    kept = 0.25 * weights[0] + np.trapezoid(steady * weights, fine) / 5e-3
    uneven = (
        0.02 * np.linspace(0, 1, count) ** 1.1
    )  # intervals that all differ are computed another way than few
    trace = simulate(scenario, time=uneven)
    assert float(trace.lateral_force[-1]) == pytest.approx(0.7 * steady[-1] + 0.3 * kept, rel=2e-4)
    assert steady[-1] > 2 * steady[-2]


def test_without_a_speed_it_slides_and_at_speed_0_it_rests(dry):
    sliding, resting_ = (
        simulate(dry.replace({"motion": motion}), time=TIME) for motion in ({}, {"speed": 0.0})
    )
    assert float(sliding.lateral_force.max()) > 0.25
    assert np.all(np.isnan(resting_.lateral_force.values))
    said = diagnostics(resting_)["friction at rest"]
    assert said["state"] == "unknown"
    assert "motion.speed = 0" in said["text"]
    assert "friction at rest" not in diagnostics(sliding)


def test_the_moment_of_a_stop_is_rest_and_that_of_setting_out_is_not():
    motion = Motion(speed=0.03, time_profile=SWIPE)
    times = np.array([-1.0, 0.0, 0.02, 0.05, 0.12, 0.2])
    np.testing.assert_array_equal(motion.slides(times), [False, False, True, True, False, False])
    assert resting(motion) == ((-np.inf, 0.02), (0.12, np.inf))
    assert resting(Motion(speed=0.0)) == ((-np.inf, np.inf),)
    assert resting(Motion()) == resting(Motion(speed=0.0, distance={"model": "HeldOff"})) == ()


@pytest.mark.parametrize("friction", [LAG, RISING, CREEP])
def test_behind_a_memory_nothing_is_known_until_it_has_forgotten(dry, friction):
    """Two friction forces at rest that could have been: what is given must be the same for both."""
    scenario = dry.replace({"friction": friction, "motion": SPEED | {"time_profile": SWIPE}})
    trace = simulate(scenario, time=np.linspace(0, 0.2, 2001))
    time, lateral = trace.time.values, trace.lateral_force.values
    rate = 2 * np.pi * np.where(time < 0.03, 100 + 0.5 * (time - 0.02) / 0.01 * 0.03 * 13.8e3, 100 + 414)
    forgets = {"LAG": 2 * np.pi * 100 * (time - 0.02), "CREEP": (time - 0.02) / 5e-3 + np.log(1 / 0.3)}
    forgets["RISING"] = np.where(
        time < 0.03, rate * (time - 0.02), 2 * np.pi * 307 * 0.01 + rate * (time - 0.03)
    )
    passed = forgets["LAG" if friction is LAG else "CREEP" if friction is CREEP else "RISING"]
    passed = np.where(time < 0.02, -1.0, passed)
    known = (passed >= np.log(1e6) + 1e-3) & (time < 0.12)
    hidden = (passed <= np.log(1e6) - 1e-3) | (time >= 0.12)
    assert np.any(known)
    assert np.all(np.isfinite(lateral[known]))
    assert np.all(np.isnan(lateral[hidden]))
    always = simulate(
        scenario.replace({"motion.time_profile": {"model": "Steady"}}), time=time
    ).lateral_force.values
    if friction is not RISING:
        np.testing.assert_allclose(lateral[known], always[known], rtol=2e-6)


def test_a_sensor_is_not_known_until_it_has_forgotten():
    """Weights of a span of rest in a filter, against the filter's own answer to 1 there and 0 elsewhere."""
    from electrovib.solve.mechanics.filters import filtered, first_order, second_order

    times = np.linspace(0, 0.1, 10001)
    inside = ((times >= 0.02) & (times < 0.03)).astype(float)
    for filter_, exact in (
        (first_order(50.0), True),
        (second_order(natural_frequency=200.0, damping_ratio=0.2), False),
    ):
        answer = np.abs(filtered(filter_, inside, step=times[1], settled=False))
        weight = not_known(filter_, ((0.02, 0.03),), times)
        assert np.all(answer <= weight + 2e-3)
        if exact:
            np.testing.assert_allclose(weight, answer, atol=2e-3)
    always = not_known(first_order(50.0), ((-np.inf, 0.0),), times)
    np.testing.assert_allclose(always, np.exp(-2 * np.pi * 50 * times), rtol=1e-12)


def test_a_digitiser_counts_no_reading_that_is_not_known(dry):
    digitiser = {"sampling_rate": 1e4, "bits": 16, "normal_range": 10.0, "lateral_range": 10.0, "seed": 1}
    rests = dry.replace({"motion": SPEED | {"time_profile": SWIPE}, "rig": RIG | {"digitiser": digitiser}})
    trace = simulate(rests, time=TIME)
    assert np.isnan(trace.lateral_force_measured.values).sum() > 100
    said = diagnostics(trace)["lateral range"]
    assert said["state"] == "ok"
    assert said["text"].startswith("no lateral reading")


def test_the_spring_of_the_skin_tells_the_friction_at_rest(dry):
    """By hand: stretched by the distance until it slides; held after the stop, down to the sliding friction."""
    motion = SPEED | {
        "time_profile": {"model": "Swipe", "begin": 0.01, "rise": 0.01, "hold": 0.03, "fall": 0.01}
    }
    drive = {"model": "Trapezium", "high": 1000.0, "rise": 0.01, "hold": 0.06, "fall": 0.04}
    scenario = dry.replace({"motion": motion, "finger": FINGER, "drive": drive})
    time = np.linspace(0, 0.14, 1401)
    trace = simulate(scenario, time=time)
    strength = 0.5 * (0.5 + trace.electrostatic_force.values)
    distance = np.where(
        time < 0.01, 0.0, np.where(time < 0.02, 0.03 * (time - 0.01) ** 2 / 0.02, 0.03 * (time - 0.015))
    )
    lateral = trace.lateral_force.values
    slips = np.argmax(1e3 * distance >= strength)
    assert 0.02 < time[slips] < 0.05
    np.testing.assert_allclose(lateral[:slips], 1e3 * distance[:slips], atol=1e-6)
    moving = (time >= time[slips]) & (time < 0.06)
    np.testing.assert_allclose(lateral[moving], strength[moving], rtol=1e-5)
    stopped = time >= 0.06
    held = np.minimum(np.minimum.accumulate(strength[stopped]), strength[time < 0.06][-1])
    np.testing.assert_allclose(lateral[stopped], held, rtol=1e-5)
    assert lateral[-1] == pytest.approx(0.25, rel=1e-5)
    assert diagnostics(trace)["friction at rest"]["state"] == "ok"
    assert float(trace.skin_displacement[-1]) == pytest.approx(0.25e-3, rel=1e-3)


def test_sliding_resumes_from_the_force_that_the_skin_has_held(dry):
    """By hand: the spring keeps 0.25 N of the stop while the voltage rises, and the way of the bone adds to it."""
    points = ((0.0, 1.0), (0.03, 1.0), (0.04, 0.0), (0.07, 0.0), (0.08, 1.0))
    profile = {"model": "Corners", "points": [{"time": time, "share": share} for time, share in points]}
    drive = {"model": "Trapezium", "high": 1000.0, "delay": 0.045, "rise": 0.01, "hold": 0.1, "fall": 0.01}
    scenario = dry.replace({"motion": SPEED | {"time_profile": profile}, "finger": FINGER, "drive": drive})
    time = np.linspace(0, 0.12, 1201)
    trace = simulate(scenario, time=time)
    strength = 0.5 * (0.5 + trace.electrostatic_force.values)
    ramp = np.clip(time - 0.07, 0.0, 0.01)
    pulled = 0.25 + 1e3 * (0.03 * ramp**2 / 0.02 + 0.03 * np.maximum(time - 0.08, 0.0))
    slips = np.argmax((time > 0.07) & (pulled >= strength))
    assert 0.08 < time[slips] < 0.09
    expected = np.where(time <= 0.045, 0.25, np.where(np.arange(time.size) < slips, pulled, strength))
    np.testing.assert_allclose(trace.lateral_force.values, expected, rtol=1e-5)


@pytest.mark.slow
def test_a_skin_that_stops_against_its_equation(dry):
    """A second route: scipy's Radau on m w' = k x + c x' - S(t) tanh(w/1 um/s), x' = u - w, of a light skin."""
    light = FINGER | {"mass": 1e-6, "damping": 1e-2}
    motion = SPEED | {
        "time_profile": {"model": "Swipe", "begin": 0.01, "rise": 0.01, "hold": 0.03, "fall": 0.01}
    }
    drive = {"model": "Trapezium", "high": 1000.0, "rise": 0.01, "hold": 0.06, "fall": 0.04}
    scenario = dry.replace({"motion": motion, "finger": light, "drive": drive})
    time = np.linspace(0, 0.14, 281)
    trace = simulate(scenario, time=time)
    strength = 0.5 * (0.5 + trace.electrostatic_force.values)

    def friction(t, over_plate):
        return np.interp(t, time, strength) * np.tanh(over_plate / 1e-6)

    def rate(t, state):
        stretch, over_plate = state
        bone = np.interp(t, [0.01, 0.02, 0.05, 0.06], [0.0, 0.03, 0.03, 0.0])
        hand = 1e3 * stretch + 1e-2 * (bone - over_plate)
        return [bone - over_plate, (hand - friction(t, over_plate)) / 1e-6]

    solved = solve_ivp(
        rate, (0, 0.14), [0.0, 0.0], method="Radau", t_eval=time, rtol=1e-6, atol=1e-10, max_step=1e-3
    )
    expected = friction(time, solved.y[1])
    # the damper adds 0.3 mN while it sticks, and the regularised friction creeps by less than 1 um/s
    assert np.max(np.abs(trace.lateral_force.values - expected)) < 0.005 * np.max(expected)


def test_a_viscous_friction_ends_with_the_contact(dry):
    """LuGre's viscous part off the plate would hold the skin back by 0.5 N s/m times 30 mm/s over 1 kN/m."""
    held = dry.replace({"motion": SPEED | {"distance": TOUCH}, "friction": LUGRE, "finger": FINGER})
    trace = simulate(held, time=TIME)
    off = ~held.motion.touches(TIME)
    assert np.all(trace.lateral_force.values[off] == 0)
    assert np.max(np.abs(trace.skin_displacement.values[off & (TIME < 0.05)])) < 1e-12
    assert trace.attrs["energy_residual"] < 1e-6


def test_what_happens_once_has_no_periodic_state_behind_a_skin(dry):
    sine = {"drive": {"model": "Sine", "amplitude": 100.0, "frequency": 50.0}}
    settled = sine | {"time.initial_state": {"model": "PeriodicState"}, "finger": FINGER}
    still = simulate(dry.replace(settled | {"motion.speed": 0.0}), time=TIME)
    assert np.all(still.lateral_force.values == 0)
    with pytest.raises(InputError, match=r"motion\.time_profile = Swipe occurs once"):
        simulate(dry.replace(settled | {"motion": SPEED | {"time_profile": SWIPE}}), time=TIME)


CONTRIBUTED = """
from electrovib.core.errors import InputError
from electrovib.physics.friction import FollowingFriction, Friction
from electrovib.scenario import load
from electrovib.solve.simulate import simulate

class Forgotten(FollowingFriction):
    'A friction that says nothing of its memory.'

class Slow(FollowingFriction):
    'A friction of which a third follows within 5 ms.'
    def memory(self, speed):
        return ((0.3, 200 + 0 * speed),)

class Other(Friction):
    'A friction of no family.'
    def without_memory(self):
        return load('vezzoli_2014/fig6').friction

steady = {'model': 'Coulomb', 'coefficient': 0.5}
base = load('vezzoli_2014/fig6').replace({'motion.speed': 0.03})
try:
    base.replace({'friction': {'model': 'Forgotten', 'steady': steady}})
except InputError as error:
    print(error)
try:
    simulate(base.replace({'friction': {'model': 'Other'}}))
except InputError as error:
    print(error)
creep = {'model': 'Creep', 'steady': steady, 'relaxations': [{'share': 0.3, 'time': 5e-3}]}
own, ours, none = (simulate(base.replace({'friction': f})).lateral_force.values
                   for f in ({'model': 'Slow', 'steady': steady}, creep, steady))
print(abs(own - ours).max(), abs(own - none).max())
"""


@pytest.mark.slow
def test_the_memory_of_a_contributed_friction_counts():
    """A subclass of FollowingFriction from elsewhere ran as the law that it follows, and nothing said so."""
    said = subprocess.run(
        [sys.executable, "-c", CONTRIBUTED], capture_output=True, text=True, check=True
    ).stdout
    unfinished, other, numbers = said.strip().splitlines()
    assert "Forgotten does not define memory, which FollowingFriction asks" in unfinished
    assert "friction = Other" in other
    assert "FollowingFriction" in other
    differs_from_creep, differs_from_steady = map(float, numbers.split())
    assert differs_from_creep < 1e-12
    assert differs_from_steady > 1e-4


SKIN = """
import math
from electrovib.physics.finger import Finger, MassSpringDamper
from electrovib.scenario import load
from electrovib.solve.simulate import simulate

class Pad(Finger):
    'A skin that gives its resonance, and no mass of its own.'
    def compliance_at_rest(self):
        return 1e-3
    def natural_frequency(self):
        return math.sqrt(1e3 / 1.5e-4) / (2 * math.pi)
    def damping_ratio(self):
        return 1 / (2 * math.sqrt(1e3 * 1.5e-4))
    def compliance(self, frequency):
        return self.compliance_at_rest() * self.resonance().at(frequency)

friction = {'model': 'LuGre', 'steady': {'model': 'Coulomb', 'coefficient': 0.5}, 'stiffness': 5e3,
            'static_ratio': 1.5, 'stribeck_speed': 5e-3}
base = load('vezzoli_2014/fig6').replace({'motion.speed': 0.03, 'friction': friction, 'time.duration': 0.02})
ours = {'model': 'MassSpringDamper', 'mass': 1.5e-4, 'stiffness': 1e3, 'damping': 1.0}
own, shipped = (simulate(base.replace({'finger': each})).skin_displacement.values for each in ({'model': 'Pad'}, ours))
print(abs(own - shipped).max() / abs(shipped).max())
"""


@pytest.mark.slow
def test_a_contributed_skin_sticks_and_slips_as_the_shipped_one():
    said = subprocess.run([sys.executable, "-c", SKIN], capture_output=True, text=True, check=True).stdout
    assert float(said) < 1e-6
