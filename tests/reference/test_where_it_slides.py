"""Friction is there where something slides on something; at rest it is what a spring tells, or it is not known."""

import subprocess
import sys

import numpy as np
import pytest
import scenario_parts as parts
from scipy.integrate import solve_ivp

from electrovib.core.errors import InputError
from electrovib.physics.motion import HeldOff, Motion, TouchAndLift
from electrovib.scenario import load
from electrovib.solve.mechanics.filters import first_order, march_through, second_order
from electrovib.solve.mechanics.lateral import not_known, resting
from electrovib.solve.simulate import simulate

LAG, CREEP = parts.lag(100.0), parts.creep(0.3, 5e-3)
RISING = parts.lag(100.0, renewal_length=1 / 13.8e3)
LUGRE = parts.lugre(1e5, static_ratio=1.0, viscous_damping=0.5)
FRICTIONS = {
    "Coulomb": parts.COULOMB,
    "PowerLaw": parts.model("PowerLaw", coefficient=0.6, at_force=1.0, exponent=-0.206),
    "FirstOrderLag": LAG,
    "a corner that rises": RISING,
    "Creep": CREEP,
    "LuGre": LUGRE,
    "Dahl": parts.model("Dahl", steady=parts.COULOMB, stiffness=1e5),
}
BRISTLES = ("LuGre", "Dahl")
SWIPE = parts.swipe(0.02, 0.01, 0.08, 0.01)
TOUCH = parts.model("TouchAndLift", far=1e-3, near=1e-6, begin=0.0, approach=0.05, touch=0.08, lift=0.05)
TREMOR = parts.model("TremblingDistance", mean=1e-4, amplitude=1e-5, frequency=8.0)
SPEED = {"speed": 0.03}
SWIPED = SPEED | {"time_profile": SWIPE}
MOTIONS = {
    "no speed": {},
    "a speed": SPEED,
    "speed 0": {"speed": 0.0},
    "a swipe that stops": SWIPED,
    "trembling": SPEED | {"distance": TREMOR},
    "held off": SPEED | {"distance": parts.model("HeldOff")},
    "touch and lift": SPEED | {"distance": TOUCH},
}
RIG = parts.tribometer({"natural_frequency": 500.0, "damping_ratio": 0.5})
TIME = np.linspace(0, 0.2, 201)


@pytest.fixture(scope="module")
def dry():
    """A gap that holds its field: 565 mN at 1000 V."""
    changes = {"stack.gap.material.conductivity": 0.0, "drive": parts.trapezium(1000.0, 0.005, 0.15, 0.005)}
    return load("vezzoli_2014/fig6_gap").replace(changes)


def strength_of(trace):
    return 0.5 * (0.5 + trace.electrostatic_force.values)


@pytest.mark.parametrize("finger", [None, parts.FINGER], ids=["rigid", "finger"])
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.slow
def test_every_friction_with_every_motion(dry, friction, motion, finger):
    """Finite where it slides, 0 off the plate, known at rest only by a spring or bristles; the rig says the same."""
    changes = {"friction": FRICTIONS[friction], "motion": MOTIONS[motion], "finger": finger, "rig": RIG}
    scenario = dry.replace(changes)
    if motion == "no speed" and friction in (*BRISTLES, "a corner that rises"):
        with pytest.raises(InputError, match=r"motion\.speed"):
            simulate(scenario, time=TIME)
        return
    trace = simulate(scenario, time=TIME)
    lateral, read = trace.lateral_force.values, trace.lateral_force_measured.values
    off, rests = ~scenario.motion.touches(TIME), scenario.motion.rests(TIME)
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
    known = np.isfinite(lateral) & scenario.motion.slides(TIME)
    if np.any(known):
        whole = 0.5 + trace.electrostatic_force.values
        steady = scenario.friction.without_memory().lateral_force(whole, 0 * whole, np.nan * whole)
        assert 0.2 < np.max(lateral[known]) < np.max(steady) + 0.02
    said = parts.diagnostics(trace)
    state = said.get("friction at rest", {"state": None})["state"]
    assert state == (None if not np.any(rests) else "ok" if told else "unknown")
    if "distance" in MOTIONS[motion]:
        assert said["off the plate"]["state"] == "ok"


def test_a_finger_held_off_has_no_friction():
    """Figure 2 reported 250 to 264 mN."""
    scenario = load("vezzoli_2014/fig2")
    trace = simulate(scenario)
    assert isinstance(scenario.motion.distance, HeldOff)
    assert float(trace.electrostatic_force.max()) == pytest.approx(27.5e-3, rel=1e-2)
    assert np.all(trace.lateral_force.values == 0)
    assert trace.attrs["solver"] == "transient"  # the gap does not move
    with pytest.raises(InputError, match=r"HeldOff.*\[stack\.gap\]"):
        load("vezzoli_2014/fig6").replace({"motion.distance": parts.model("HeldOff")})


def test_attraction_counts_while_a_finger_touches(dry):
    """mu (load + attraction) in touch, 0.42 N where it was 0.25, and nothing before and after."""
    trace = simulate(
        dry.replace({"motion.distance": TOUCH, "drive": parts.step(772.0), "rig": RIG}), time=TIME
    )
    in_touch = (TIME > 0.0495) & (TIME < 0.1295)
    lateral, pull = trace.lateral_force.values, trace.electrostatic_force.values
    np.testing.assert_allclose(lateral[in_touch], strength_of(trace)[in_touch], rtol=1e-12)
    assert lateral[in_touch].max() == pytest.approx(0.42, abs=1e-3)
    assert np.all(lateral[~in_touch] == 0)
    # the sensor under the plate reads the load in touch, and off the plate the load less the pull
    read = trace.normal_force_measured.values - trace.normal_force_measured.values[0]
    np.testing.assert_allclose(read[(TIME > 0.06) & in_touch], pull[0], atol=2e-4)
    before = (TIME > 0.045) & (TIME < 0.0495)
    np.testing.assert_allclose(read[before], (pull[0] - pull)[before], atol=5e-3)


def test_a_contact_that_begins_remembers_nothing(dry, monkeypatch):
    """Behind a lag the friction of a new touch rises from 0 with its corner; and so after a first one, see below."""
    held = dry.replace({"motion.distance": TOUCH, "friction": LAG, "drive": parts.step(0.0)})
    trace = simulate(held, time=np.linspace(0, 0.2, 2001))
    time = trace.time.values
    expected = np.where(held.motion.touches(time), 0.25 * -np.expm1(-2 * np.pi * 100 * (time - 0.05)), 0.0)
    np.testing.assert_allclose(trace.lateral_force.values, expected, atol=2e-7)
    # in touch until 20 ms and again from 50 ms on, with a memory of 100 s: the second begins at 0
    monkeypatch.setattr(TouchAndLift, "breaks", lambda _: (0.0, 0.02, 0.05, 0.1))
    monkeypatch.setattr(
        TouchAndLift, "touches", lambda _, time: (np.asarray(time) < 0.02) | (np.asarray(time) >= 0.05)
    )
    twice = held.replace({"friction": parts.creep(0.4, 100.0)})
    lateral = simulate(twice, time=np.array([0.0, 0.01, 0.03, 0.06])).lateral_force.values
    np.testing.assert_allclose(lateral, [0.25, 0.25, 0.0, 0.6 * 0.25 + 0.1 * 1e-4], atol=1e-6)


@pytest.mark.parametrize("count", [3, 600])
def test_at_a_jump_at_the_last_time_the_prompt_share_follows_at_once(dry, count):
    """A creep of 30 % in 5 ms, against the sum over a fine record of what it follows; the record ends with a jump to 1 kV."""
    changes = {
        "friction": CREEP,
        "drive": parts.square(1000.0, 50.0, low=0.0),
        "circuit.return_path.resistance": 0.0,
    }
    scenario = dry.replace(changes)
    fine = np.linspace(0, 0.02, 20_001)
    steady = strength_of(simulate(scenario, time=fine))
    weights = np.exp((fine - 0.02) / 5e-3)
    kept = 0.25 * weights[0] + np.trapezoid(steady * weights, fine) / 5e-3
    # intervals that all differ are computed another way than few
    trace = simulate(scenario, time=0.02 * np.linspace(0, 1, count) ** 1.1)
    assert float(trace.lateral_force[-1]) == pytest.approx(0.7 * steady[-1] + 0.3 * kept, rel=2e-4)
    assert steady[-1] > 2 * steady[-2]


def test_where_a_motion_slides_and_where_it_rests(dry):
    sliding, still = (simulate(dry.replace({"motion": motion}), time=TIME) for motion in ({}, {"speed": 0.0}))
    assert float(sliding.lateral_force.max()) > 0.25
    assert "friction at rest" not in parts.diagnostics(sliding)
    assert np.all(np.isnan(still.lateral_force.values))
    said = parts.diagnostics(still)["friction at rest"]
    assert said["state"] == "unknown"
    assert "motion.speed = 0" in said["text"]
    # the moment of a stop is rest, and that of setting out is not
    motion = Motion(**SWIPED)
    times = np.array([-1.0, 0.0, 0.02, 0.05, 0.12, 0.2])
    np.testing.assert_array_equal(motion.slides(times), [False, False, True, True, False, False])
    assert resting(motion) == ((-np.inf, 0.02), (0.12, np.inf))
    assert resting(Motion(speed=0.0)) == ((-np.inf, np.inf),)
    assert resting(Motion()) == resting(Motion(speed=0.0, distance=parts.model("HeldOff"))) == ()


@pytest.mark.parametrize("friction", [LAG, RISING, CREEP], ids=["lag", "rising", "creep"])
def test_behind_a_memory_nothing_is_known_until_it_has_forgotten(dry, friction):
    """Two friction forces at rest that could have been: what is given must be the same for both."""
    scenario = dry.replace({"friction": friction, "motion": SWIPED})
    trace = simulate(scenario, time=np.linspace(0, 0.2, 2001))
    time, lateral = trace.time.values, trace.lateral_force.values
    since = time - 0.02
    if friction is LAG:
        passed = 2 * np.pi * 100 * since
    elif friction is CREEP:
        passed = since / 5e-3 + np.log(1 / 0.3)
    else:  # it sets out within 10 ms, and the corner rises from 100 to 514 Hz
        rate = 2 * np.pi * np.where(time < 0.03, 100 + 0.5 * since / 0.01 * 414, 514)
        passed = np.where(time < 0.03, rate * since, 2 * np.pi * 307 * 0.01 + rate * (time - 0.03))
    passed = np.where(time < 0.02, -1.0, passed)
    known = (passed >= np.log(1e6) + 1e-3) & (time < 0.12)
    hidden = (passed <= np.log(1e6) - 1e-3) | (time >= 0.12)
    assert np.any(known)
    assert np.all(np.isfinite(lateral[known]))
    assert np.all(np.isnan(lateral[hidden]))
    if friction is not RISING:
        steady = simulate(scenario.replace({"motion.time_profile": parts.model("Steady")}), time=time)
        np.testing.assert_allclose(lateral[known], steady.lateral_force.values[known], rtol=2e-6)


def test_a_sensor_is_not_known_until_it_has_forgotten(dry):
    """Weights of a span of rest in a filter, against the filter's own answer to 1 there and 0 elsewhere."""
    times = np.linspace(0, 0.1, 10001)
    inside = ((times >= 0.02) & (times < 0.03)).astype(float)
    low_pass, ringing = first_order(50.0), second_order(natural_frequency=200.0, damping_ratio=0.2)
    for filter_ in (low_pass, ringing):
        state = filter_.state(0.0)
        answer = np.abs(march_through(filter_, inside[:-1], inside[1:], steps=times[1], state=state))
        weight = not_known(filter_, ((0.02, 0.03),), times)
        assert np.all(answer <= weight + 2e-3)
        if filter_ is low_pass:
            np.testing.assert_allclose(weight, answer, atol=2e-3)
    always = not_known(low_pass, ((-np.inf, 0.0),), times)
    np.testing.assert_allclose(always, np.exp(-2 * np.pi * 50 * times), rtol=1e-12)
    # and a digitiser counts no reading that is not known
    digitiser = {"sampling_rate": 1e4, "bits": 16, "normal_range": 10.0, "lateral_range": 10.0, "seed": 1}
    trace = simulate(dry.replace({"motion": SWIPED, "rig": RIG | {"digitiser": digitiser}}), time=TIME)
    assert np.isnan(trace.lateral_force_measured.values).sum() > 100
    said = parts.diagnostics(trace)["lateral range"]
    assert said["state"] == "ok"
    assert said["text"].startswith("no lateral reading")


STOPS = {
    "motion": SPEED | {"time_profile": parts.swipe(0.01, 0.01, 0.03, 0.01)},
    "finger": parts.FINGER,
    "drive": parts.trapezium(1000.0, 0.01, 0.06, 0.04),
}


def test_the_spring_of_the_skin_tells_the_friction_at_rest(dry):
    """By hand: stretched by the distance until it slides; held after the stop, down to the sliding friction."""
    time = np.linspace(0, 0.14, 1401)
    trace = simulate(dry.replace(STOPS), time=time)
    strength, lateral = strength_of(trace), trace.lateral_force.values
    ramp = np.clip(time - 0.01, 0.0, 0.01)
    distance = 0.03 * ramp**2 / 0.02 + 0.03 * np.maximum(time - 0.02, 0.0)
    slips = np.argmax(1e3 * distance >= strength)
    assert 0.02 < time[slips] < 0.05
    np.testing.assert_allclose(lateral[:slips], 1e3 * distance[:slips], atol=1e-6)
    moving, stopped = (time >= time[slips]) & (time < 0.06), time >= 0.06
    np.testing.assert_allclose(lateral[moving], strength[moving], rtol=1e-5)
    held = np.minimum(np.minimum.accumulate(strength[stopped]), strength[~stopped][-1])
    np.testing.assert_allclose(lateral[stopped], held, rtol=1e-5)
    assert lateral[-1] == pytest.approx(0.25, rel=1e-5)
    assert parts.diagnostics(trace)["friction at rest"]["state"] == "ok"
    assert float(trace.skin_displacement[-1]) == pytest.approx(0.25e-3, rel=1e-3)


def test_sliding_resumes_from_the_force_that_the_skin_has_held(dry):
    """By hand: the spring keeps 0.25 N of the stop while the voltage rises, and the way of the bone adds to it."""
    points = ((0.0, 1.0), (0.03, 1.0), (0.04, 0.0), (0.07, 0.0), (0.08, 1.0))
    profile = parts.model("Corners", points=[{"time": time, "share": share} for time, share in points])
    drive = parts.trapezium(1000.0, 0.01, 0.1, 0.01, delay=0.045)
    changes = {"motion": SPEED | {"time_profile": profile}, "finger": parts.FINGER, "drive": drive}
    time = np.linspace(0, 0.12, 1201)
    trace = simulate(dry.replace(changes), time=time)
    strength, ramp = strength_of(trace), np.clip(time - 0.07, 0.0, 0.01)
    pulled = 0.25 + 1e3 * (0.03 * ramp**2 / 0.02 + 0.03 * np.maximum(time - 0.08, 0.0))
    slips = np.argmax((time > 0.07) & (pulled >= strength))
    assert 0.08 < time[slips] < 0.09
    expected = np.where(time <= 0.045, 0.25, np.where(np.arange(time.size) < slips, pulled, strength))
    np.testing.assert_allclose(trace.lateral_force.values, expected, rtol=1e-5)


@pytest.mark.slow
def test_a_skin_that_stops_against_its_equation(dry):
    """A second route: scipy's Radau on m w' = k x + c x' - S(t) tanh(w/1 um/s), x' = u - w, of a light skin."""
    time = np.linspace(0, 0.14, 281)
    trace = simulate(
        dry.replace(STOPS | {"finger": parts.FINGER | {"mass": 1e-6, "damping": 1e-2}}), time=time
    )
    strength = strength_of(trace)

    def friction(t, over_plate):
        return np.interp(t, time, strength) * np.tanh(over_plate / 1e-6)

    def rate(t, state):
        stretch, over_plate = state
        bone = np.interp(t, [0.01, 0.02, 0.05, 0.06], [0.0, 0.03, 0.03, 0.0])
        hand = 1e3 * stretch + 1e-2 * (bone - over_plate)
        return [bone - over_plate, (hand - friction(t, over_plate)) / 1e-6]

    bounds = {"rtol": 1e-6, "atol": 1e-10, "max_step": 1e-3}
    solved = solve_ivp(rate, (0, 0.14), [0.0, 0.0], method="Radau", t_eval=time, **bounds)
    expected = friction(time, solved.y[1])
    # the damper adds 0.3 mN while it sticks, and the regularised friction creeps by less than 1 um/s
    assert parts.largest(trace.lateral_force.values - expected) < 0.005 * np.max(expected)


def test_a_viscous_friction_ends_with_the_contact(dry):
    """LuGre's viscous part off the plate would hold the skin back by 0.5 N s/m times 30 mm/s over 1 kN/m."""
    held = dry.replace({"motion": SPEED | {"distance": TOUCH}, "friction": LUGRE, "finger": parts.FINGER})
    trace = simulate(held, time=TIME)
    off = ~held.motion.touches(TIME)
    assert np.all(trace.lateral_force.values[off] == 0)
    assert parts.largest(trace.skin_displacement.values[off & (TIME < 0.05)]) < 1e-12
    assert trace.attrs["energy_residual"] < 1e-6


def test_what_happens_once_has_no_periodic_state_behind_a_skin(dry):
    settled = dry.replace({"drive": parts.sine(100.0, 50.0), "finger": parts.FINGER} | parts.SETTLED)
    assert np.all(simulate(settled.replace({"motion.speed": 0.0}), time=TIME).lateral_force.values == 0)
    with pytest.raises(InputError, match=r"motion\.time_profile = Swipe occurs once"):
        simulate(settled.replace({"motion": SWIPED}))


CONTRIBUTED = """
import math
from electrovib.core.errors import InputError
from electrovib.physics.finger import Finger
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

steady = {'model': 'Coulomb', 'coefficient': 0.5}
base = load('vezzoli_2014/fig6').replace({'motion.speed': 0.03})
for friction in {'model': 'Forgotten', 'steady': steady}, {'model': 'Other'}:
    try:
        simulate(base.replace({'friction': friction}))
    except InputError as error:
        print(error)
creep = {'model': 'Creep', 'steady': steady, 'relaxations': [{'share': 0.3, 'time': 5e-3}]}
own, ours, none = (simulate(base.replace({'friction': f})).lateral_force.values
                   for f in ({'model': 'Slow', 'steady': steady}, creep, steady))
lugre = {'model': 'LuGre', 'steady': steady, 'stiffness': 5e3, 'static_ratio': 1.5, 'stribeck_speed': 5e-3}
base = base.replace({'friction': lugre, 'time.duration': 0.02})
finger = {'model': 'MassSpringDamper', 'mass': 1.5e-4, 'stiffness': 1e3, 'damping': 1.0}
pad, shipped = (simulate(base.replace({'finger': f})).skin_displacement.values for f in ({'model': 'Pad'}, finger))
print(abs(own - ours).max(), abs(own - none).max(), abs(pad - shipped).max() / abs(shipped).max())
"""


@pytest.mark.slow
def test_a_contributed_friction_and_skin_act_as_the_shipped_ones():
    """A subclass of FollowingFriction from elsewhere ran as the law that it follows, and nothing said so."""
    run = [sys.executable, "-c", CONTRIBUTED]
    said = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    unfinished, other, numbers = said.strip().splitlines()
    assert "Forgotten does not define memory, which FollowingFriction asks" in unfinished
    assert "friction = Other" in other
    assert "FollowingFriction" in other
    from_creep, from_steady, from_shipped_skin = map(float, numbers.split())
    assert from_creep < 1e-12
    assert from_steady > 1e-4
    assert from_shipped_skin < 1e-6
