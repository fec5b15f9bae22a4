"""Eight drawn fingers through the whole set-up of figure 6: amplifier with its limit, both force sensors, digitiser."""

from __future__ import annotations

import functools
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Curve, Panel
from electrovib.core.arrays import Real
from electrovib.papers.vezzoli_2014 import values
from electrovib.papers.vezzoli_2014.figures import measured_range
from electrovib.papers.vezzoli_2014.looks import look
from electrovib.papers.vezzoli_2014.population.closed_forms import FRICTION
from electrovib.papers.vezzoli_2014.population.predicted import SEED, SUBJECTS, population
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.solve.simulate import simulate

RATE: Final = 1e3
"""Readings per second, a choice [Hz]."""
SET_UP: Final[dict[str, Any]] = {
    "circuit.amplifier": {"source_current": 250e-6},
    "rig": {
        "model": "Tribometer",
        "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
        "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.05},
        "digitiser": {
            "sampling_rate": RATE,
            "bits": 16,
            "normal_range": 2.0,
            "lateral_range": 1.0,
            "seed": 1,
        },
    },
}
"""The current limit is that of the paper, which prints no number of the sensors and the digitiser: a choice."""
_CASES: Final = (
    ("law (1) of the paper", "fig6", "paper point"),
    ("Maxwell stress in a leaky gap", "fig6_gap", "leaky gap"),
)


def readings(figure: str) -> tuple[Real, Real]:
    """Simulate eight drawn fingers through the whole set-up, in ``fig6`` or ``fig6_gap``.

    Returns `time` (n,) [s] and `attraction` (8, n) [N]: the reading of the lateral force, above that before
    the pulse, over the coefficient of friction.
    """
    base, space = scenarios()[figure].replace(SET_UP), population(figure)
    time = np.arange(0.0, 2 * values.RAMP + 0.14, 1 / RATE)
    drawn = space.draw(SEED, 0, SUBJECTS)
    found = []
    for number in range(SUBJECTS):
        finger = {path: float(each[number]) for path, each in drawn.items()}
        lateral = simulate(base.replace(finger), time=time)["lateral_force_measured"].values
        found.append((lateral - lateral[0]) / finger[FRICTION])
    return time, np.array(found)


@functools.cache
def panel() -> Panel:
    """Return the readings of eight drawn fingers beside the measured range, divided by friction."""
    curves = []
    for label, figure, meaning in _CASES:
        time, attraction = readings(figure)
        there_and_back = [
            time[:: (-1) ** number] for number in range(SUBJECTS)
        ]  # one line: all begin and end at 0
        curves.append(
            Curve(
                label=label,
                x=np.concatenate(there_and_back),
                y=np.concatenate([each[:: (-1) ** number] for number, each in enumerate(attraction)]),
                look=look(meaning),
            )
        )
    return Panel(
        id="fig6_set_up",
        title="Figure 6: drawn fingers, whole set-up",
        caption="",
        x=("time", "s"),
        y=("lateral reading over friction coefficient", "N"),
        curves=(measured_range(time[[0, -1]]), *curves),
    )
