"""The falling edge: causes that could make the second peak of the trapezoidal pulse differ from the first.

The paper states only that on the discharging parts there is a difference between model and measurement, and suspects
the sensor. Each candidate cause, in ``falling_edge.toml``, is the paper's own scenario with one change.
"""

from __future__ import annotations

import functools
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from string import Template
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Panel, Table
from electrovib.core.arrays import Real
from electrovib.papers.kaczmarek_2006 import FAST, SLOW, skin_conductivity
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.compute import panel, row
from electrovib.papers.vezzoli_2014.figures import curve
from electrovib.papers.vezzoli_2014.values import scenarios
from electrovib.scenario import Scenario
from electrovib.solve.simulate import simulate
from electrovib.studies.reproduction import Row

RAMP, HOLD = 25e-3, 200e-3
"""Of the trapezoidal pulse on which the candidates are compared, a choice [s]."""


@dataclass(frozen=True)
class Candidate:
    """One possible cause.

    `changes` are put into the paper's scenario by dotted path; `test` is the experiment that would
    distinguish the cause from the others, `signal` where it appears, `values` what was taken, marked where it
    is a choice. `linear`: its response is linear in the drive, so that a periodic trapezoidal pulse of equal
    halves gives equal pulses. `pulse` and `over_hold` are the colours, by what they stand for, of its pulse and of
    its ratio over the hold; the latter is computed where it is not None, and either is drawn where it is not empty.
    """

    name: str
    changes: Mapping[str, Any]
    test: str
    values: str
    signal: str = "electrostatic_force"
    linear: bool = True
    pulse: str = ""
    over_hold: str | None = None

    def scenario(self, *, ramp: float = RAMP, hold: float = HOLD) -> Scenario:
        """Put the change into the paper's scenario with a ramp and a hold [s]."""
        pulse = {"drive.rise": ramp, "drive.hold": hold, "drive.fall": ramp}
        return scenarios()["fig6"].replace(pulse).replace(self.changes)


@functools.cache
def candidates() -> tuple[Candidate, ...]:
    """Return the paper's model and every candidate at plausible values."""
    text = Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
    numbers = {"fast": skin_conductivity(FAST), "slow": skin_conductivity(SLOW)}
    return tuple(
        Candidate(**each) for each in tomllib.loads(Template(text).substitute(numbers))["candidates"]
    )


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


def table() -> Table:
    """Return ratio and decay of every candidate, and the experiment that would identify it."""
    found = outcomes()
    base = found["the paper's model"].decay
    lines = []
    for candidate in candidates():
        result = found[candidate.name]
        decay = "stays" if np.isnan(result.decay) else f"{result.decay * 1e3:.3g}"
        lines.append(
            (
                candidate.name,
                f"{result.ratio:.2f}",
                decay,
                _readings(result, base),
                candidate.values,
                candidate.test,
            )
        )
    return compute.table("falling_edge_candidates", lines, ramp=RAMP * 1e3, hold=HOLD * 1e3)


def _readings(result: Outcome, base: float) -> str:
    """State for which readings of the paper's sentence this cause alone makes a difference of a tenth."""
    ramp = abs(result.ratio - 1) > 0.1
    hold = not abs(result.decay / base - 1) <= 0.1
    named = [word for word, true in (("ramp", ramp), ("hold", hold)) if true]
    return ", ".join(named)


@functools.cache
def panels() -> tuple[Panel, ...]:
    """Return the pulses of some candidates, and the ratio against the hold, which distinguishes them."""
    return (_pulses(), _against_hold())


def _pulses() -> Panel:
    curves = []
    for candidate in candidates():
        name, result = candidate.name, outcomes()[candidate.name]
        rising = np.max(np.abs(result.force[result.time <= RAMP + HOLD]))
        curves.append(
            curve(
                f"{name} ({result.ratio:.2f})",
                result.time,
                result.force / rising,
                candidate.pulse,
                kind="dashed" if name == "the paper's model" else "line",
                drawn=bool(candidate.pulse),
            )
        )
    return panel("falling_edge", *curves, ramp=RAMP * 1e3, hold=HOLD * 1e3)


HOLDS: Final = (5e-3, 10e-3, 20e-3, 50e-3, 100e-3, 200e-3, 500e-3)


def _against_hold() -> Panel:
    curves = []
    for candidate in candidates():
        if candidate.over_hold is not None:
            ratios = np.array([outcome(candidate, hold=hold).ratio for hold in HOLDS])
            curves.append(
                curve(
                    candidate.name,
                    np.array(HOLDS),
                    ratios,
                    candidate.over_hold,
                    kind="dashed" if candidate.name == "the paper's model" else "line",
                    drawn=bool(candidate.over_hold),
                )
            )
    return panel("falling_edge_hold", *curves)


def causes(reading: str) -> list[str]:
    """Name the causes that alone change the falling ``ramp``, or the decay in the ``hold``, by more than a tenth."""
    found = outcomes()
    base = found["the paper's model"].decay
    return [name for name, each in found.items() if reading in _readings(each, base)]


@functools.cache
def rows() -> tuple[Row, ...]:
    """Return the range of each ratio and decay over the candidates, a finger that slides, and the check of equal halves."""
    found = outcomes()
    sliding = [found[f"sliding at {speed:g} mm/s"].ratio for speed in (10, 30, 100)]
    decays = [result.decay for result in found.values() if not np.isnan(result.decay)]
    own = found["the paper's model"].decay * 1e3
    return (
        row("moving_finger", sliding, fastest=sliding[-1]),
        row("falling_edge_candidates", [result.ratio for result in found.values()]),
        row("hold_decay_candidates", decays, own=own),
        row("periodic_trapezium", periodic_asymmetry()),
    )
