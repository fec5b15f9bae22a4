"""The compiled march of bristles against the reference, and every part of a sliding finger drawn together with every other."""

import itertools
import json

import numpy as np
import pytest
import scenario_parts as parts

import electrovib as ev
from electrovib.core.budget import budget
from electrovib.core.errors import InputError
from electrovib.physics.friction import Coulomb, Dahl, LuGre
from electrovib.physics.motion import Motion
from electrovib.scenario import load
from electrovib.solve.mechanics import quick_sliding
from electrovib.solve.mechanics.between import Between
from electrovib.solve.mechanics.skin import DAMPER, HEAT, WORK
from electrovib.solve.mechanics.sliding import slide_quickly, sliding
from electrovib.solve.simulate import simulate

COULOMB = Coulomb(coefficient=0.5)
FINGER = {"mass": 1.5e-3, "stiffness": 1000.0, "damping": 0.05}
DAMPED = {"bristle_damping": 0.3, "viscous_damping": 0.05}
LAWS = {
    "LuGre": LuGre(steady=COULOMB, stiffness=1e4, static_ratio=1.5, stribeck_speed=2e-2, **DAMPED),
    "Dahl 0.7": Dahl(steady=COULOMB, stiffness=2e3, exponent=0.7),
    "Dahl 1": Dahl(steady=COULOMB, stiffness=2e3),
    "Dahl 2": Dahl(steady=COULOMB, stiffness=2e3, exponent=2.0),
}
SWIPE = parts.swipe(0.005, 0.01, 0.02, 0.01)
TOUCH = parts.model("TouchAndLift", far=1e-3, near=1e-6, approach=0.01, touch=0.03, lift=0.01)
MOTIONS = {
    "steady": {"speed": 0.03},
    "swipe": {"speed": 0.03, "time_profile": SWIPE},
    "touch": {"speed": 0.03, "distance": TOUCH},
}
TIMES = np.linspace(0, 0.06, 301)
JUMP = 0.0221


def strength(motion):
    """A tone, a jump, and nothing off the plate."""

    def force(time):
        time = np.asarray(time, dtype=float)
        tone = 0.3 * (1 + 0.4 * np.sin(2 * np.pi * 100 * time) + 0.3 * (time >= JUMP))
        return np.where(motion.touches(time), tone, 0.0)

    return force


def both(law, motion, finger):
    corners = np.array(sorted({*motion.breaks(), JUMP}))
    between = Between(strength(motion), TIMES, corners, shortest=5e-3)
    quick = slide_quickly(law, motion=motion, strength=between, times=TIMES, **finger)
    exact = sliding(
        law,
        speed=motion.speeds,
        strength=between,
        times=TIMES,
        breaks=corners[corners > 0].tolist(),
        touches=motion.touches,
        settled=float(motion.speeds(0.0)) > 0,
        tolerance=1e-9,
        **finger,
    )
    return quick, exact


@pytest.mark.slow
@pytest.mark.parametrize("finger", [{}, FINGER], ids=["rigid", "finger"])
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("law", LAWS)
def test_it_slides_as_the_reference_does(law, motion, finger, monkeypatch):
    honest, counts = quick_sliding.follow, []
    monkeypatch.setattr(quick_sliding, "follow", lambda *given: counts.append(honest(*given)) or counts[-1])
    quick, exact = both(LAWS[law], Motion(**MOTIONS[motion]), finger)
    for name in ("lateral_force", "bristle_deflection", "skin_displacement", "skin_speed"):
        one, other = getattr(quick, name), getattr(exact, name)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-6 * parts.largest(other), err_msg=name)
    for energy in (WORK, DAMPER, HEAT):
        one, other = quick.states[energy], exact.states[energy]
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-6 * np.max(exact.states[WORK]))
    assert quick.energy_residual < 1e-6
    ((*_, (steps, evaluations)),) = counts
    assert evaluations < 60 * steps  # Newton's iteration converges as it should
    # before it is lifted, or a skin rings out
    early = [[event for event in slide.events if event[0] < 0.0399] for slide in (quick, exact)]
    assert len(early[0]) == len(early[1])


def test_many_calls_are_one_march(monkeypatch):
    """The march returns now and then, so that it can be interrupted."""
    motion = Motion(speed=0.03)
    between = Between(strength(motion), TIMES, np.array([JUMP]), shortest=5e-3)
    whole = slide_quickly(LAWS["LuGre"], motion=motion, strength=between, times=TIMES, **FINGER)
    honest, calls = quick_sliding.march, []

    def counted(*given):
        calls.append(1)
        return honest(*given)

    monkeypatch.setattr(quick_sliding, "march", counted)
    monkeypatch.setattr(quick_sliding, "STEPS_PER_CALL", 100)
    parts = slide_quickly(LAWS["LuGre"], motion=motion, strength=between, times=TIMES, **FINGER)
    assert len(calls) > 10
    assert parts.events == whole.events
    assert np.array_equal(parts.lateral_force, whole.lateral_force)


@pytest.fixture(scope="module")
def base():
    """A film at 0.5 N, slid over at 5 cm/s."""
    changes = {"force.model": "MaxwellStressInGap", "motion.speed": 0.05}
    return ev.load("vezzoli_2014/fig6_static").replace(changes)


DAHL = parts.model("Dahl", steady=parts.COULOMB, stiffness=500.0)
SINE = parts.sine(500.0, 1000.0)


@pytest.mark.slow
def test_a_second_at_1_khz_is_marched_to_a_millionth(base):
    """Dahl at constant speed is linear, z' = u - u k z/S: its mean is that of the march through three periods."""
    scenario = base.replace({"drive": SINE, "friction": DAHL, "time.duration": 1.0})
    trace = ev.simulate(scenario)
    assert trace.attrs["mechanics_error"] < 1e-6
    assert trace.attrs["energy_residual"] < 1e-6
    time = np.linspace(0, 2.5e-3, 50_001)
    steady = ev.simulate(scenario.replace({"friction": DAHL["steady"]}), time=time).lateral_force.values
    rate = 500.0 * 0.05 / steady
    force, step = np.empty(len(time)), time[1]
    force[0] = steady[0]
    for place in range(len(time) - 1):  # the trapezoidal rule
        pushed = force[place] * (1 - step / 2 * rate[place]) + step * 500.0 * 0.05
        force[place + 1] = pushed / (1 + step / 2 * rate[place + 1])
    found = ev.simulate(scenario, time=time[::1000]).lateral_force.values
    np.testing.assert_allclose(found, force[::1000], rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("finger", [None, parts.FINGER], ids=["rigid", "finger"])
def test_short_pulses_over_a_long_time(base, finger):
    """Pulses of 1 us every 100 s, over 1000 s: the value just before a corner was looked up before the corner before."""
    pulses = parts.model("PulseTrain", high=300.0, width=1e-6, frequency=0.01)
    changes = {"drive": pulses, "friction": DAHL, "time.duration": 1000.0, "finger": finger}
    scenario = base.replace(changes)
    trace = ev.simulate(scenario)
    assert trace.attrs["mechanics_error"] < 1e-6
    assert trace.lateral_force.values[1:] == pytest.approx(0.25, rel=1e-6)
    near = np.array([0.0, 1e-6, 100.0, 100.0 + 5e-7, 100.0 + 1e-6])
    assert np.all(np.diff(ev.simulate(scenario, time=near).lateral_force.values)[2:4] > 0)


def test_more_changes_than_can_be_looked_at_are_refused(base):
    long = base.replace({"drive": parts.sine(500.0, 1e5), "friction": DAHL, "time.duration": 100.0})
    said = r"time\.duration = 100 s: .* changes 2e\+07 times and has 0 corners"
    with budget(time="1 day"), pytest.raises(InputError, match=said):
        ev.simulate(long)
    with pytest.raises(InputError, match="the force on the finger has 1999999 corners"):
        Between(np.cos, np.array([0.0, 100.0]), np.linspace(0, 100, 2_000_001))


# ------------------------------------------------------------------ drawn together


FRICTIONS = (
    parts.COULOMB,
    parts.model("PowerLaw", coefficient=0.6, at_force=1.0, exponent=-0.206),
    parts.lag(500.0),
    parts.lag(500.0, renewal_length=72.5e-6),
    parts.creep(0.3, 5e-3),
    parts.model("Dahl", steady=parts.COULOMB, stiffness=500.0),
    parts.model("Dahl", steady=parts.COULOMB, stiffness=5e4, exponent=0.6),
    parts.model("Dahl", steady=parts.COULOMB, stiffness=5e3, exponent=2.0),
    parts.lugre(1e5, bristle_damping=0.5, viscous_damping=0.1),
    parts.lugre(500.0),
)
FINGERS = (
    {},
    {"finger": parts.FINGER},
    {"finger": parts.FINGER | {"damping": 0.02}},
    {"finger": parts.FINGER | {"mass": 1.5e-3, "growth": {"known_at": 0.05}}},
)
RIGS = ({}, {"rig": parts.tribometer({"natural_frequency": 500.0, "damping_ratio": 0.5, "bandwidth": 1e3})})
SHORT_TOUCH = parts.model("TouchAndLift", far=1e-3, near=1e-6, approach=0.01, touch=0.01, lift=5e-3)
MANY_MOTIONS = (
    {},
    {"speed": 0.05},
    {"speed": 1e-3},
    {"speed": 0.05, "time_profile": parts.swipe(5e-3, 5e-3, 0.01, 5e-3)},
    {"speed": 0.05, "distance": SHORT_TOUCH},
)
DRIVES = (
    parts.sine(500.0, 1000.0),
    parts.model("Chirp", amplitude=300.0, first=10.0, last=2000.0, length=0.03),
    parts.model("PulseTrain", high=300.0, width=1e-6, frequency=200.0),
    parts.model("Burst", amplitude=300.0, frequency=1e4, cycles=20, delay=0.01),
    parts.step(500.0),
)
LOADS = (
    {},
    {"load.time_profile": parts.model("Press", begin=5e-3, rise=5e-3)},
    {"load.time_profile": parts.model("LiftOff", begin=0.02, fall=5e-3)},
)
STATES = ({}, parts.SETTLED)
EVERY = (FRICTIONS, FINGERS, RIGS, MANY_MOTIONS, DRIVES, LOADS, STATES)
REFUSALS = (
    "occurs once",
    "needs motion.speed",
    "does not have the period of the drive",
    "not known beforehand",
    "Both must stay positive",
    "does not repeat",
    "periods of the drive to settle",
)


@pytest.fixture(scope="module")
def bases():
    """The film of Vezzoli et al. 2014; and the same beneath a gap that is moved."""
    vezzoli = load("vezzoli_2014/fig6").replace({"force.model": "MaxwellStressInGap", "time.duration": 0.03})
    layers = vezzoli.stack.to_dict()
    gap = {"thickness": 1e-6, "material": parts.constant(1.0)}
    stack = {"insulator": layers["insulator"], "gap": gap, "stratum_corneum": layers["stratum_corneum"]}
    return vezzoli, vezzoli.replace({"stack": stack})


def drawn(seed, count):
    rng = np.random.default_rng(seed)
    combinations = list(itertools.product(*EVERY))
    chosen = rng.choice(len(combinations), count, replace=False)
    return [combinations[place] for place in chosen.tolist()]


def answer(bases, combination):
    friction, finger, rig, motion, drive, pressed, state = combination
    changes = {"friction": friction, "motion": motion, "drive": drive, "time.samples": 101}
    scenario = bases["distance" in motion].replace(changes | finger | rig | pressed | state)
    try:
        return simulate(scenario)
    except InputError as refusal:
        return str(refusal)


def check(bases, combinations):
    answered = 0
    for combination in combinations:
        trace = answer(bases, combination)
        if isinstance(trace, str):
            assert any(word in trace for word in REFUSALS), f"{trace}: {combination}"
            continue
        answered += 1
        said = json.dumps(combination)
        assert trace.attrs.get("mechanics_error", 0.0) < 5e-3, said
        assert trace.attrs.get("energy_residual", 0.0) < 1e-6, said
        assert np.all(np.isfinite(trace.lateral_force.values) | np.isnan(trace.lateral_force.values)), said
        for name in ("skin_displacement", "skin_speed"):
            assert name not in trace or np.all(np.isfinite(trace[name].values)), said
    return answered


@pytest.mark.parametrize(
    ("seed", "count", "least"), [(3, 12, 4), pytest.param(8, 150, 60, marks=pytest.mark.slow)]
)
def test_combinations(bases, seed, count, least):
    assert check(bases, drawn(seed, count)) >= least
