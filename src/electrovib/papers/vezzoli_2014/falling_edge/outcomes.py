"""The trapezoidal pulse under each candidate cause."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field

import numpy as np

from electrovib.core.arrays import Real
from electrovib.papers.vezzoli_2014 import values
from electrovib.papers.vezzoli_2014.falling_edge.candidates import HOLD, RAMP, Candidate, candidates
from electrovib.solve.simulate import simulate


@dataclass(frozen=True)
class Outcome:
    """The trapezoidal pulse under one candidate cause.

    `time` [s] and `force` above its value before the drive [N]; `ratio` of the largest force from the falling
    ramp on to the largest before; `decay` [s] after the rising ramp until the force has fallen to 1/e of its
    value there, NaN if it does not.
    """

    time: Real = field(repr=False)
    force: Real = field(repr=False)
    ratio: float
    decay: float


def outcome(candidate: Candidate, *, ramp: float = RAMP, hold: float = HOLD) -> Outcome:
    """Simulate the trapezoidal pulse, of ramps and a hold [s], under a candidate."""
    scenario = candidate.scenario(ramp=ramp, hold=hold)
    end = 2 * ramp + hold + 0.1
    time = np.unique(np.concatenate([np.linspace(0, end, 3001), [ramp, ramp + hold, 2 * ramp + hold]]))
    trace = simulate(scenario, time=time)
    force = trace[candidate.signal].values - (
        trace[candidate.signal].values[0] if _settled(candidate) else 0.0
    )
    top, falls = ramp + hold, time >= ramp + hold
    rising = float(np.max(np.abs(force[(time > 0) & (time <= top)])))
    peak = float(np.abs(force[time <= top][np.argmin(np.abs(time[time <= top] - ramp))]))
    decay = _decay(time, np.abs(force), start=ramp, end=top, level=peak / math.e)
    return Outcome(time, force, float(np.max(np.abs(force[falls]))) / rising, decay)


def _decay(time: Real, force: Real, *, start: float, end: float, level: float) -> float:
    """Time from the start to where the force falls below a level, between two samples in its logarithm; or NaN."""
    below = np.flatnonzero((time > start) & (time <= end) & (force < level))
    if not len(below):
        return float("nan")
    after = int(below[0])
    near = slice(after - 1, after + 1)
    logarithm = np.log(force[near] / level)
    return float(np.interp(0.0, logarithm[::-1], time[near][::-1])) - start


def _settled(candidate: Candidate) -> bool:
    """Return whether the signal has a steady part before the drive: the friction of the load."""
    return candidate.signal != "electrostatic_force"


@functools.cache
def outcomes() -> dict[str, Outcome]:
    """Simulate every candidate once."""
    return {candidate.name: outcome(candidate) for candidate in candidates()}


@functools.cache
def periodic_asymmetry() -> float:
    """Compute the largest difference of both pulses of a periodic trapezoidal pulse of equal halves, over linear causes [1].

    In the periodic state f(t + T/2) = f(t) exactly for any linear law that holds no constant voltage: v(t +
    T/2) and -v(t) differ by a constant, and the force is even.
    """
    half = 50e-3
    ramp = 10e-3
    worst = 0.0
    for candidate in candidates():
        if candidate.linear and not any(path.startswith(("motion", "rig")) for path in candidate.changes):
            drive = {
                "model": "Trapezium",
                "high": values.VOLTAGE,
                "rise": ramp,
                "hold": half - ramp,
                "fall": ramp,
            }
            settled = {
                "drive": drive | {"repeat": 2 * half},
                "time.initial_state": {"model": "PeriodicState"},
            }
            scenario = candidate.scenario().replace(settled | {"stack.insulator.initial_charge": 0.0})
            time = np.linspace(0.0, 2 * half, 1001)
            force = simulate(scenario, time=time).electrostatic_force.values
            worst = max(worst, float(np.max(np.abs(force[:500] - force[500:1000]))) / float(np.max(force)))
    return worst
