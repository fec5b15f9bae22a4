"""The candidate causes as table, figures and rows."""

from __future__ import annotations

import functools
from typing import Final

import numpy as np

from electrovib.core.answer import Curve, Panel, Table
from electrovib.papers.vezzoli_2014.falling_edge.candidates import HOLD, RAMP, candidates
from electrovib.papers.vezzoli_2014.falling_edge.outcomes import (
    Outcome,
    outcome,
    outcomes,
    periodic_asymmetry,
)
from electrovib.papers.vezzoli_2014.looks import look
from electrovib.studies.reproduction import Row

DRAWN: Final = {
    "the paper's model": "paper point",
    "dispersive skin, palmar men 2 uS": "palmar men 2 uS",
    "sliding at 30 mm/s": "sliding",
    "positive pulses weaker": "polarity",
    "sensor relaxes": "sensor",
}
"""Candidates whose pulses are drawn, and what their colours stand for."""
AGAINST_HOLD: Final = {
    "the paper's model": "paper point",
    "dispersive skin, palmar men 2 uS": "palmar men 2 uS",
    "dispersive skin, 1963 impedance": "1963 impedance",
    "sliding at 30 mm/s": "sliding",
    "sliding at 100 mm/s": "sliding",
}
"""Candidates whose ratio is drawn against the hold; the file of the curves has every linear one in the attraction."""
LINEAR: Final = ("dispersive skin", "sliding at", "the paper's model")
"""Beginnings of the names of the linear candidates in the attraction."""


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
    headings = (
        "candidate",
        "force falling/rising",
        "decay in the hold [ms]",
        "changes",
        "values",
        "experiment that would identify it",
    )
    caption = (
        f"Ramps of {RAMP * 1e3:g} ms, hold of {HOLD * 1e3:g} ms; force without the friction of the load. Changes: by more than"
        " a tenth, the falling ramp or the decay in the hold of the paper's model."
    )
    return Table(
        "The falling edge: each candidate cause alone",
        headings,
        tuple(lines),
        caption=caption,
        id="falling_edge_candidates",
        shown=(0, 1, 2, 3),
    )


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
    for name, result in outcomes().items():
        rising = np.max(np.abs(result.force[result.time <= RAMP + HOLD]))
        curves.append(
            Curve(
                label=f"{name} ({result.ratio:.2f})",
                x=result.time,
                y=result.force / rising,
                kind="dashed" if name == "the paper's model" else "line",
                look=look(DRAWN.get(name, "")),
                drawn=name in DRAWN,
            )
        )
    return Panel(
        id="falling_edge",
        title="The falling edge: force over its rising peak, one cause at a time",
        caption=f"0 to 1000 V, ramps of {RAMP * 1e3:g} ms, hold of {HOLD * 1e3:g} ms; in brackets falling over rising peak.",
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
        if candidate.name.startswith(LINEAR):
            ratios = np.array([outcome(candidate, hold=hold).ratio for hold in HOLDS])
            curves.append(
                Curve(
                    label=candidate.name,
                    x=np.array(HOLDS),
                    y=ratios,
                    kind="dashed"
                    if candidate.name in ("the paper's model", "sliding at 100 mm/s")
                    else "line",
                    look=look(AGAINST_HOLD.get(candidate.name, "")),
                    drawn=candidate.name in AGAINST_HOLD,
                )
            )
    return Panel(
        id="falling_edge_hold",
        title="Falling over rising force against the hold",
        caption="With a longer hold the effect of relaxation or a dispersive skin vanishes; those of sliding and polarity stay.",
        x=("hold", "s"),
        y=("force falling over rising", "1"),
        curves=tuple(curves),
        log_x=True,
    )


@functools.cache
def rows() -> tuple[Row, ...]:
    """Return the range of each ratio and decay over the candidates, and the check of equal halves."""
    found = outcomes()
    ratios = [result.ratio for result in found.values()]
    decays = [result.decay * 1e3 for result in found.values() if not np.isnan(result.decay)]
    own = found["the paper's model"].decay * 1e3
    return (
        Row(
            "falling_edge_candidates",
            "force falling over rising, each candidate cause alone",
            None,
            (min(ratios), max(ratios)),
            "1",
            "ours",
            "The paper states that there is a difference, but neither its sign nor its size. Every candidate is in the table of"
            " the falling edge.",
            brief="sign and size of the difference are not printed",
        ),
        Row(
            "hold_decay_candidates",
            "decay of the force in the hold, each candidate cause alone",
            None,
            (min(decays), max(decays)),
            "ms",
            "ours",
            "The other reading of the paper's discharging parts: time to 1/e. The paper's model gives"
            f" {own:.3g} ms, half of the time constant of its voltage, (C_i + C_s) R_s, or twice that if its 7.7 ms is the"
            " decay of the force. Every candidate is in the table of the falling edge.",
            brief=f"{own:.3g} ms by the paper's model",
        ),
        Row(
            "periodic_trapezium",
            "difference of both pulses of a periodic trapezoidal pulse, linear causes",
            None,
            periodic_asymmetry(),
            "1",
            "check",
            "Largest difference over the peak, for equal halves. The two pulses are exactly equal for any linear law. A"
            " difference measured on a rig is therefore due to polarity, the amplifier or a film that slides; neither the"
            " memory of the skin nor a linear relaxation of skin or sensor can cause it.",
            brief="0 for any linear law",
        ),
    )
