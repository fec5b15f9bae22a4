"""The falling edge: what could make the second pulse of the trapezium differ from the first, each as a switch.

The paper says only that on the discharging parts there is a difference between model and measurement, and suspects
the sensor. Each candidate here is the paper's own scenario with one thing changed.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from electrovib.papers.kaczmarek_2006 import FAST, SLOW, rectifying, skin_conductivity
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.solve.scenario import Scenario
from electrovib.solve.simulate import simulate
from electrovib.solve.transfer import Real
from electrovib.study.reproduction import Curve, Panel, Row, Table

RAMP, HOLD = 25e-3, 200e-3
"""Of the trapezium on which the candidates are compared, a choice [s]."""
TRIBOCHARGE = 7e-6
"""Charge on the film as rubbing leaves it: 21 V, of the size of the effective voltage [C/m2]."""
SHOWN: Final = (
    "dispersive skin, palmar men 2 uS",
    "sliding at 30 mm/s",
    "positive pulses weaker",
    "positive pulses stronger",
    "amplifier sinks less than it sources",
    "sensor relaxes",
    "the paper's model",
)
"""Pulses that are drawn."""
AGAINST_HOLD: Final = ("dispersive skin", "sliding at", "the paper's model")
"""Beginnings of the names of candidates whose ratio is drawn against the hold: the linear ones in the attraction."""


@dataclass(frozen=True)
class Candidate:
    """One possible cause.

    Parameters
    ----------
    name : str
        In a few words.
    changes : mapping of str to value
        Dotted path to value, put into the paper's scenario: the switch.
    test : str
        The experiment that would tell it from the others.
    signal : str
        In which signal it shows.
    values : str
        What was taken, and that it is a choice where it is.
    linear : bool
        Whether it answers in proportion to the drive, so that a periodic trapezium of equal halves gives equal
        pulses.
    """

    name: str
    changes: Mapping[str, Any]
    test: str
    values: str
    signal: str = "electrostatic_force"
    linear: bool = True

    def scenario(self, *, ramp: float = RAMP, hold: float = HOLD) -> Scenario:
        """Put the change into the paper's scenario with a ramp and a hold [s]."""
        trapezium = {"drive.rise": ramp, "drive.hold": hold, "drive.fall": ramp}
        return scenarios()["fig6"].replace(trapezium).replace(self.changes)


@dataclass(frozen=True)
class Outcome:
    """What a candidate does to the trapezium.

    Parameters
    ----------
    time, force : ndarray
        s, N; in excess of what there was before the drive.
    ratio : float
        Largest force from the falling ramp on over the largest before.
    decay : float
        Time after the rising ramp until the force has fallen to 1/e of its value there [s]; NaN if it does not.
    """

    time: Real = field(repr=False)
    force: Real = field(repr=False)
    ratio: float
    decay: float


def outcome(candidate: Candidate, *, ramp: float = RAMP, hold: float = HOLD) -> Outcome:
    """Simulate a candidate.

    Parameters
    ----------
    candidate : Candidate
        The cause.
    ramp, hold : float
        Of the trapezium [s].

    Returns
    -------
    Outcome
        Ratio of the pulses and decay in the hold.
    """
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
    below = (time > ramp) & (time <= top) & (np.abs(force) < peak / np.e)
    decay = float(time[below][0] - ramp) if np.any(below) else float("nan")
    return Outcome(time, force, float(np.max(np.abs(force[falls]))) / rising, decay)


def _settled(candidate: Candidate) -> bool:
    """Tell whether the signal has a steady part that was there before the drive: the friction of the load."""
    return candidate.signal != "electrostatic_force"


_CHOICE = "a choice"
_ALL_SKIN: Final = {"stack.stratum_corneum.material.conductivity": 0.0}
"""What conducts in the skin is then the leak alone."""


def _polarity(positive: float, negative: float) -> dict[str, Any]:
    leak = rectifying(skin_conductivity, positive=positive, negative=negative)
    return _ALL_SKIN | {"stack.stratum_corneum.leak": leak}


def _sliding(speed: float, charge: float = 0.0) -> dict[str, Any]:
    return {"motion.speed": speed, "motion.renews_film": True, "stack.insulator.initial_charge": charge}


def _skin(name: str) -> dict[str, Any]:
    return {"stack.stratum_corneum.material": compute.force_skins()[name].material}


_MEMORY_TEST = "vary the hold: the ratio comes back to 1 as a power of it; the periodic trapezium of equal halves is equal"
_SLIDING_TEST = "vary the speed: the plateau of the hold grows in proportion; a finger at rest shows neither"


@functools.cache
def candidates() -> tuple[Candidate, ...]:
    """Give every candidate with its switch, at plausible values."""
    two_taus = f"time constants {SLOW * 1e3:g} and {FAST * 1e3:g} ms by polarity, {_CHOICE}"
    inverted = "invert the drive, 0 to -1000 V: the ratio turns over; no linear cause knows the sign"
    charged = f"{TRIBOCHARGE * 1e6:g} uC/m2 on the film that comes under the finger, {_CHOICE}; 30 mm/s"
    wiped = "neutralise the film before the pass, then do not: only this changes"
    return (
        Candidate("the paper's model", {}, "the reference", "one relaxation time of 7.7 ms"),
        *(
            Candidate(f"dispersive skin, {name}", _skin(name), _MEMORY_TEST, "cited skin, causal law")
            for name in ("palmar men 2 uS", "palmar women 10 uS", "1963 impedance")
        ),
        Candidate(
            "positive pulses weaker",
            _polarity(FAST, SLOW),
            inverted,
            f"{two_taus}, as Kaczmarek 2006",
            linear=False,
        ),
        Candidate(
            "positive pulses stronger",
            _polarity(SLOW, FAST),
            inverted,
            f"{two_taus}, the other sign",
            linear=False,
        ),
        *(
            Candidate(
                f"sliding at {speed * 1e3:g} mm/s",
                _sliding(speed),
                _SLIDING_TEST,
                "fresh film, the paper's 7.7 ms",
            )
            for speed in (0.01, 0.03, 0.1)
        ),
        *(
            Candidate(
                f"sliding over {word} film",
                _sliding(0.03, sign * 10 * TRIBOCHARGE),
                wiped,
                charged.replace("7", "70"),
            )
            for word, sign in (("positive", 1), ("negative", -1))
        ),
        Candidate(
            "charge left on the film, finger at rest",
            {"stack.insulator.initial_charge": -TRIBOCHARGE},
            "discharge the film before touching: only the first milliseconds change",
            f"{-TRIBOCHARGE * 1e6:g} uC/m2 under the finger at the beginning, {_CHOICE}",
        ),
        Candidate(
            "leak that grows with the field",
            _ALL_SKIN
            | {
                "stack.stratum_corneum.leak": {
                    "model": "FieldConduction",
                    "conductivity": skin_conductivity(SLOW),
                    "onset_field": 3e3,
                }
            },
            "vary the voltage: decay and force no longer follow its square",
            f"conductivity doubled at 3 kV/m in the skin, {_CHOICE}",
            linear=False,
        ),
        *_beyond_the_field(),
    )


def _beyond_the_field() -> tuple[Candidate, ...]:
    """Give the candidates that leave the attraction as it is, or the voltage as it was asked for."""
    creeping = {
        "model": "Creep",
        "steady": {"model": "Coulomb", "coefficient": 0.5},
        "relaxations": [{"share": 0.2, "time": tau} for tau in (4e-3, 70e-3, 1.4)],
    }
    sinking = {"source_current": 250e-6, "sink_current": 2e-6, "stray_capacitance": 50e-12}
    rig = {
        "model": "Tribometer",
        "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
        "lateral": {
            "natural_frequency": 500.0,
            "damping_ratio": 0.5,
            "bandwidth": 1e3,
            "creep": {"share": 0.25, "time": 50e-3},
        },
    }
    return (
        Candidate(
            "viscoelastic skin",
            {"friction": creeping},
            "step the friction without a voltage, by load or squeeze film: the same asymmetry",
            f"shares of 0.2 at 4 ms, 70 ms and 1.4 s (times Pawluk and Howe 1999, shares {_CHOICE})",
            signal="lateral_force",
        ),
        Candidate(
            "amplifier sinks less than it sources",
            {"circuit.amplifier": sinking},
            "record the voltage at the plate: its falling ramp is slower than asked for",
            f"250 uA out, 2 uA back, 50 pF of stray capacitance, {_CHOICE}",
            linear=False,
        ),
        Candidate(
            "sensor relaxes",
            {"rig": rig},
            "step the sensor with a weight: the same relaxation without finger and voltage",
            f"a quarter more creeps in with 50 ms, {_CHOICE}: what the paper suspects",
            signal="lateral_force_measured",
        ),
    )


@functools.cache
def outcomes() -> dict[str, Outcome]:
    """Simulate every candidate once."""
    return {candidate.name: outcome(candidate) for candidate in candidates()}


def table() -> Table:
    """Give ratio and decay of every candidate, and the experiment that tells it."""
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
    headings = (
        "candidate",
        "force falling/rising",
        "decay in the hold to 1/e [ms]",
        "explains",
        "values",
        "experiment that would tell",
    )
    caption = (
        f"0 to 1000 V, ramps of {RAMP * 1e3:g} ms, hold {HOLD * 1e3:g} ms. Signal: the attraction, or what rig and"
        " friction make of it, without the friction of the load. A charge that neither leaks nor is carried away would add"
        " an offset to the effective voltage: 5, 10, 20 % of it give 0.82, 0.67, 0.44."
    )
    return Table("The falling edge: every candidate alone", headings, tuple(lines), caption)


def _readings(result: Outcome, base: float) -> str:
    """Say for each reading of the paper's sentence whether this alone makes a difference of a tenth."""
    ramp = abs(result.ratio - 1) > 0.1
    hold = not abs(result.decay / base - 1) <= 0.1
    said = [word for word, true in (("falling ramp", ramp), ("decay in the hold", hold)) if true]
    return " and ".join(said) or "neither"


def panels() -> tuple[Panel, ...]:
    """Give the pulses of some candidates, and the ratio against the hold that tells them apart."""
    return (_pulses(), _against_hold())


def _pulses() -> Panel:
    found = outcomes()
    curves = []
    for name in SHOWN:
        result = found[name]
        rising = np.max(np.abs(result.force[result.time <= RAMP + HOLD]))
        share = result.force / rising
        kind = "dashed" if name == "the paper's model" else "line"
        shown = np.where(share > FLOOR, share, np.nan)
        curves.append(Curve(f"{name} ({result.ratio:.2f})", result.time, shown, kind=kind))
    return Panel(
        "falling_edge",
        "The falling edge: force over its rising peak, one cause at a time",
        "Trapezium of 0 to 1000 V, ramps of 25 ms, hold of 200 ms; in brackets falling over rising peak. Below 1e-3 of the"
        " peak nothing is drawn.",
        ("time", "s"),
        ("force over its rising peak", "1"),
        tuple(curves),
        log_y=True,
    )


FLOOR: Final = 1e-3
HOLDS: Final = (5e-3, 10e-3, 20e-3, 50e-3, 100e-3, 200e-3, 500e-3)


def _against_hold() -> Panel:
    curves = []
    for candidate in candidates():
        if candidate.name.startswith(AGAINST_HOLD):
            ratios = np.array([outcome(candidate, hold=hold).ratio for hold in HOLDS])
            kind = "dashed" if candidate.name == "the paper's model" else "line"
            curves.append(Curve(candidate.name, np.array(HOLDS), ratios, kind=kind))
    ratios_of = {name: outcomes()[name].ratio for name in SHOWN}
    return Panel(
        "falling_edge_hold",
        "Falling over rising force against the hold",
        "One relaxation time forgets in a few of it, a dispersive skin as a power of the hold, and what sliding does stays"
        " whatever the hold. Polarity does not depend on it either, but lies off this figure:"
        f" {ratios_of['positive pulses weaker']:.3g} or {ratios_of['positive pulses stronger']:.2g}.",
        ("hold", "s"),
        ("force falling over rising", "1"),
        tuple(curves),
        log_x=True,
    )


def periodic_asymmetry() -> float:
    """Largest difference between both pulses of a periodic trapezium of equal halves, over linear candidates.

    Notes
    -----
    In the periodic state f(t + T/2) = f(t) exactly for any linear law that holds no constant voltage: v(t + T/2)
    and -v(t) differ by a constant, and the force is even.
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


def rows() -> tuple[Row, ...]:
    """Give the numbers of this page."""
    found = outcomes()
    ratios = {name: result.ratio for name, result in found.items()}
    listed = ", ".join(f"{name} {ratio:.2f}" for name, ratio in ratios.items())
    decays = {name: result.decay * 1e3 for name, result in found.items() if not np.isnan(result.decay)}
    return (
        Row(
            "falling_edge_candidates",
            "force falling over rising, every candidate cause alone",
            None,
            (min(ratios.values()), max(ratios.values())),
            "1",
            "open",
            f"the paper says that there is a difference, not which way nor by how much. {listed}",
        ),
        Row(
            "hold_decay_candidates",
            "decay of the force in the hold to 1/e, every candidate cause alone",
            None,
            (min(decays.values()), max(decays.values())),
            "ms",
            "open",
            "the other reading of the paper's discharging parts. "
            + ", ".join(f"{name} {decay:.3g}" for name, decay in decays.items()),
        ),
        Row(
            "periodic_trapezium",
            "largest difference between both pulses of a periodic trapezium of equal halves, linear causes",
            None,
            periodic_asymmetry(),
            "1",
            "consistent",
            "exactly equal for any linear law: a rig that still sees two different pulses sees polarity, amplifier, sliding"
            " film charge or sensor, and no memory of the skin",
        ),
    )
