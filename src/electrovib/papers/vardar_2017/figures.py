"""The paper's question as data: thresholds over frequency, their ratio, and where they are equal."""

from __future__ import annotations

import functools
from typing import Final

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Panel
from electrovib.core.arrays import Real
from electrovib.papers import plutchik_1963
from electrovib.papers.vardar_2017.scenarios import FREQUENCIES, VOLTAGE, first_order_skin, scenarios
from electrovib.papers.vardar_2017.thresholds import (
    BOTH_CHANNELS,
    ON_DISPLACEMENT,
    ON_FORCE,
    crossover,
    sine_over_square,
)
from electrovib.physics.material import Material
from electrovib.scenario import skins
from electrovib.studies.felt_spectrum import ThresholdCurves, threshold_over_frequency

TIME_CONSTANTS: Final = (1e-3, 3e-3, 7.7e-3, 15e-3, 30e-3)
"""Of skins without dispersion, C_i + C_s times R_s [s]."""
EDGE: Final = 200e-6
"""Of a square that an amplifier could give: a choice [s]."""
BODY: Final = 1000.0
"""As in the ready-made scenarios [ohm]."""
WEIGHTS: Final = {
    "Pacinian, on the force": ON_FORCE,
    "both channels, on the force": BOTH_CHANNELS,
    "Pacinian, on the displacement": ON_DISPLACEMENT,
}
LOOKS: Final = (
    "7.7 ms",
    "1963 skin",
    "1 ms",
    "3 ms",
    "15 ms",
    "30 ms",
    "Pacinian, on the force",
    "both channels, on the force",
    "Pacinian, on the displacement",
    "edges",
)
"""What the colours stand for in all figures, in the order of the palette."""
KINDS: Final = {"sine": "line", "square": "dashed"}
"""Lines of the drives; that of a square with edges is dotted."""
DECIBELS: Final = "1"
"""Unit of an axis whose label contains dB: a plain number."""


def panels() -> tuple[Panel, ...]:
    """Return all figures."""
    return thresholds(), ratio(), crossovers()


@functools.cache
def conducting_skins() -> dict[str, Material]:
    """Every published skin that conducts, by paper and name."""
    return {name: skin.material for name, skin in skins().items() if skin.material.conductivity > 0}


@functools.cache
def ratios(skin: Material, frequencies: tuple[float, ...], *, resistance: float = 0.0) -> Real:
    """Sine over square threshold [dB] at frequencies in Hz, body in ohm, Pacinian weight on the force."""
    return np.array(
        [sine_over_square(skin, frequency=frequency, resistance=resistance) for frequency in frequencies]
    )


@functools.cache
def crossover_of(*, time_constant: float, weight: str = "Pacinian, on the force", edge: float = 0.0) -> float:
    """Frequency of equal thresholds [Hz] of a first-order skin, time constant and edge in s."""
    return crossover(first_order_skin(time_constant=time_constant), edge=edge, person=WEIGHTS[weight])


@functools.cache
def curves_of(skin: Material) -> ThresholdCurves:
    """Threshold of sine, ideal square and square with edges, both channels on the force."""
    square = {"model": "Square", "high": VOLTAGE, "low": -VOLTAGE}
    drives = {
        "sine": {"model": "Sine", "amplitude": VOLTAGE},
        "square": square,
        "square, edges of 200 us": {**square, "edge": EDGE},
    }
    screen = scenarios()["sine"].replace({"stack.stratum_corneum.material": skin})
    places = np.geomspace(FREQUENCIES[0], FREQUENCIES[-1], 19)
    return threshold_over_frequency(screen, places, drives, perception=BOTH_CHANNELS)


def thresholds() -> Panel:
    """Threshold over frequency of sine and square on two skins."""
    curves = []
    for name, skin in (
        ("7.7 ms", first_order_skin(time_constant=7.7e-3)),
        ("1963 skin", plutchik_1963.material()),
    ):
        found = curves_of(skin)
        for drive, level in found.level.items():
            curves.append(
                Curve(
                    label=f"{drive}, {name}",
                    x=found.frequency,
                    y=level,
                    kind=KINDS.get(drive, "dotted"),
                    look=LOOKS.index(name),
                    drawn=drive in KINDS or name == "7.7 ms",
                )
            )
    return Panel(
        id="thresholds",
        title="Threshold voltage of sine and square over frequency",
        caption="In dB above the lowest threshold on that skin: the thresholds in volts were not read, and no threshold of"
        " displacement is calibrated. Both channels, weight on the force. The square has the lower threshold at low frequencies;"
        " with ideal edges its threshold rises at high ones, where the square of the voltage is nearly constant.",
        x=("frequency", "Hz"),
        y=("threshold voltage, dB", DECIBELS),
        curves=tuple(curves),
        log_x=True,
    )


def ratio() -> Panel:
    """Sine over square over frequency: skins of one time constant, and all that conduct."""
    places = (*FREQUENCIES[:-1], 960.0, FREQUENCIES[-1])
    rows = np.array([ratios(skin, places, resistance=BODY) for skin in conducting_skins().values()])
    frequency = np.array(places)
    curves = [
        Curve(
            label="all skins that conduct",
            x=frequency,
            y=rows.min(axis=0),
            upper=rows.max(axis=0),
            kind="band",
            look=REFERENCE,
        ),
        Curve(label="equal", x=frequency, y=np.zeros(len(places)), kind="dashed", look=REFERENCE),
    ]
    curves += [
        Curve(
            label=name,
            x=frequency,
            y=ratios(first_order_skin(time_constant=tau), places),
            look=LOOKS.index(name),
        )
        for name, tau in ((f"{tau / 1e-3:g} ms", tau) for tau in TIME_CONSTANTS)
    ]
    return Panel(
        id="ratio",
        title="Threshold of a sine over that of a square",
        caption="Above 0 the square is felt at a lower voltage, as the paper reports below 60 Hz. Pacinian weight on the force,"
        " ideal edges. Above the frequency of equal thresholds the paper reports similar ones; the model overestimates the"
        " difference.",
        x=("frequency", "Hz"),
        y=("sine over square threshold, dB", DECIBELS),
        curves=tuple(curves),
        log_x=True,
    )


def crossovers() -> Panel:
    """Frequency of equal thresholds against the time constant, for each weight and with edges."""
    taus = np.geomspace(TIME_CONSTANTS[0], TIME_CONSTANTS[-1], 7)
    curves = []
    for weight in WEIGHTS:
        points = weight.startswith("both")
        chosen = taus[::2] if points else taus
        found = np.array([crossover_of(time_constant=float(tau), weight=weight) for tau in chosen])
        kind = "points" if points else "line"
        curves.append(Curve(label=weight, x=chosen, y=found, kind=kind, look=LOOKS.index(weight)))
    edged = np.array([crossover_of(time_constant=float(tau), edge=EDGE) for tau in taus])
    known = np.isfinite(edged)  # where the edges leave a crossing at all
    curves.append(
        Curve(
            label="Pacinian, on the force, edges of 200 us",
            x=taus[known],
            y=edged[known],
            look=LOOKS.index("edges"),
        )
    )
    reported = np.full(2, 60.0)
    curves.append(Curve(label="60 Hz, the paper", x=taus[[0, -1]], y=reported, kind="dashed", look=REFERENCE))
    return Panel(
        id="crossover",
        title="Frequency of equal thresholds against the time constant of the skin",
        caption="Skins without dispersion on the coating. The frequency depends on the skin and little on the weight; nothing"
        " here imposes 60 Hz. A channel for low frequencies changes nothing: its points lie on the first line.",
        x=("time constant", "s"),
        y=("frequency of equal thresholds", "Hz"),
        curves=tuple(curves),
        log_x=True,
        log_y=True,
    )
