"""Frictions, fingers, rigs, motions, drives and beginnings drawn together: each answers, or says in a sentence why not."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
import scenario_parts as parts

from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.solve.simulate import simulate

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
TOUCH = parts.model("TouchAndLift", far=1e-3, near=1e-6, approach=0.01, touch=0.01, lift=5e-3)
MOTIONS = (
    {},
    {"speed": 0.05},
    {"speed": 1e-3},
    {"speed": 0.05, "time_profile": parts.swipe(5e-3, 5e-3, 0.01, 5e-3)},
    {"speed": 0.05, "distance": TOUCH},
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
EVERY = (FRICTIONS, FINGERS, RIGS, MOTIONS, DRIVES, LOADS, STATES)
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
