"""The candidates as table, figures and rows."""

from __future__ import annotations

import functools
from typing import Final

import numpy as np

from electrovib.papers.vezzoli_2014.falling_edge.candidates import HOLD, RAMP, candidates
from electrovib.papers.vezzoli_2014.falling_edge.outcomes import (
    Outcome,
    outcome,
    outcomes,
    periodic_asymmetry,
)
from electrovib.study.reproduction import Curve, Panel, Row, Table

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
        "decay of the force in the hold to 1/e [ms]",
        "could explain",
        "values",
        "experiment that would tell",
    )
    caption = (
        f"0 to 1000 V, ramps of {RAMP * 1e3:g} ms, hold {HOLD * 1e3:g} ms. Signal: the attraction, or what rig and"
        " friction make of it, without the friction of the load. Could explain: alone, at these values, it moves the ratio"
        " off 1, or the decay off that of the paper's model, by more than a tenth. A charge that neither leaks nor is"
        " carried away would add an offset to the effective voltage: 5, 10, 20 % of it give 0.82, 0.67, 0.44."
    )
    return Table("The falling edge: every candidate alone", headings, tuple(lines), caption=caption)


def _readings(result: Outcome, base: float) -> str:
    """Say for each reading of the paper's sentence whether this alone makes a difference of a tenth."""
    ramp = abs(result.ratio - 1) > 0.1
    hold = not abs(result.decay / base - 1) <= 0.1
    said = [word for word, true in (("falling ramp", ramp), ("decay in the hold", hold)) if true]
    return " and ".join(said) or "neither"


@functools.cache
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
        curves.append(Curve(label=f"{name} ({result.ratio:.2f})", x=result.time, y=share, kind=kind))
    return Panel(
        id="falling_edge",
        title="The falling edge: force over its rising peak, one cause at a time",
        caption="Trapezium of 0 to 1000 V, ramps of 25 ms, hold of 200 ms; in brackets falling over rising peak. Below 1e-3 of"
        " the peak nothing is drawn.",
        x=("time", "s"),
        y=("force over its rising peak", "1"),
        curves=tuple(curves),
        log_y=True,
        floor=FLOOR,
    )


FLOOR: Final = 1e-3
HOLDS: Final = (5e-3, 10e-3, 20e-3, 50e-3, 100e-3, 200e-3, 500e-3)


def _against_hold() -> Panel:
    curves = []
    for candidate in candidates():
        if candidate.name.startswith(AGAINST_HOLD):
            ratios = np.array([outcome(candidate, hold=hold).ratio for hold in HOLDS])
            kind = "dashed" if candidate.name == "the paper's model" else "line"
            curves.append(Curve(label=candidate.name, x=np.array(HOLDS), y=ratios, kind=kind))
    ratios_of = {name: outcomes()[name].ratio for name in SHOWN}
    return Panel(
        id="falling_edge_hold",
        title="Falling over rising force against the hold",
        caption="One relaxation time forgets in a few of it, a dispersive skin as a power of the hold, and what sliding does"
        " stays whatever the hold. Polarity does not depend on it either, but lies off this figure:"
        f" {ratios_of['positive pulses weaker']:.3g} or {ratios_of['positive pulses stronger']:.2g}.",
        x=("hold", "s"),
        y=("force falling over rising", "1"),
        curves=tuple(curves),
        log_x=True,
    )


@functools.cache
def rows() -> tuple[Row, ...]:
    """Give the numbers of this page."""
    found = outcomes()
    ratios = [result.ratio for result in found.values()]
    decays = [result.decay * 1e3 for result in found.values() if not np.isnan(result.decay)]
    own = found["the paper's model"].decay * 1e3
    return (
        Row(
            "falling_edge_candidates",
            "force falling over rising, every candidate cause alone",
            None,
            (min(ratios), max(ratios)),
            "1",
            "open",
            "the paper says that there is a difference, not which way nor by how much. Each in the table of the falling edge",
        ),
        Row(
            "hold_decay_candidates",
            "decay of the force in the hold to 1/e, every candidate cause alone",
            None,
            (min(decays), max(decays)),
            "ms",
            "open",
            f"the other reading of the paper's discharging parts. The paper's model gives {own:.3g} ms, half of the time constant"
            " of its voltage, (C_i + C_s) R_s; twice that if its 7.7 ms is the decay of the force. Each in the table of the"
            " falling edge",
        ),
        Row(
            "periodic_trapezium",
            "largest difference between both pulses of a periodic trapezoidal pulse of equal halves, linear causes",
            None,
            periodic_asymmetry(),
            "1",
            "check",
            "exactly equal for any linear law: a rig that still sees two different pulses sees polarity, amplifier or"
            " film that slides, and no memory of the skin nor a linear relaxation of skin or sensor",
        ),
    )
