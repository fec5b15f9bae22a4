"""What the abstract states, in one object: thresholds over frequency, their ratio, and where they are equal."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from itertools import chain
from pathlib import Path
from typing import Final

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Page, Panel, Table
from electrovib.core.arrays import Real
from electrovib.core.budget import computed
from electrovib.core.errors import InputError
from electrovib.papers import plutchik_1963
from electrovib.papers.vardar_2017.thresholds import (
    BOTH_CHANNELS,
    CITATION,
    FREQUENCIES,
    NOT_READ,
    ON_DISPLACEMENT,
    ON_FORCE,
    VOLTAGE,
    crossover,
    first_order_skin,
    scenarios,
    sine_over_square,
)
from electrovib.physics.material import Material
from electrovib.physics.perception import MOTION, RYU, NonPacinian, Pacinian
from electrovib.scenario import skins
from electrovib.studies.felt_spectrum import ThresholdCurves, threshold_over_frequency
from electrovib.studies.reproduction import Reproduction, Row, Words

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
KINDS: Final = {"sine": "line", "square": "dashed"}
"""Lines of the drives; that of a square with edges is dotted."""
WORDS: Final = Words(Path(__file__).with_name("words.toml"))
"""Words of rows, figures and the table."""


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
        ("1963 skin", plutchik_1963.skins()["skin"].material),
    ):
        found = curves_of(skin)
        for drive, level in found.level.items():
            is_drawn = drive in KINDS or name == "7.7 ms"
            kind = KINDS.get(drive, "dotted")
            curves.append(
                Curve(label=f"{drive}, {name}", x=found.frequency, y=level, kind=kind, drawn=is_drawn)
            )
    return WORDS.panel("thresholds", *curves)


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
    ]
    curves += [
        Curve(label=f"{tau / 1e-3:g} ms", x=frequency, y=ratios(first_order_skin(time_constant=tau), places))
        for tau in TIME_CONSTANTS
    ]
    return WORDS.panel("ratio", *curves)


def crossovers() -> Panel:
    """Frequency of equal thresholds against the time constant, for each weight and with edges."""
    taus = np.geomspace(TIME_CONSTANTS[0], TIME_CONSTANTS[-1], 7)
    curves = []
    for weight in WEIGHTS:
        points = weight.startswith("both")
        chosen = taus[::2] if points else taus
        found = np.array([crossover_of(time_constant=float(tau), weight=weight) for tau in chosen])
        curves.append(Curve(label=weight, x=chosen, y=found, kind="points" if points else "line"))
    edged = np.array([crossover_of(time_constant=float(tau), edge=EDGE) for tau in taus])
    known = np.isfinite(edged)  # where the edges leave a crossing at all
    curves.append(Curve(label="Pacinian, on the force, edges of 200 us", x=taus[known], y=edged[known]))
    reported = np.full(2, 60.0)
    curves.append(Curve(label="60 Hz, the paper", x=taus[[0, -1]], y=reported, kind="dashed", look=REFERENCE))
    return WORDS.panel("crossover", *curves)


EQUATIONS: Final = {
    "felt": r"$L_c = 20 \lg \sqrt{\sum_k (w_c(f_k) |C(f_k) F_k|)^2}, \quad L = \max_c L_c$",
    "Pacinian": r"$w_P = \frac{2 x^2}{1 + x^4}, \quad x = f/250\,\mathrm{Hz}$",
    "ratio": r"$20 \lg \frac{V_{sine}}{V_{square}} = \frac{L_{square} - L_{sine}}{2}$",
}


def reproduce(*, skin: str | None = None) -> Reproduction:
    """Compute what the abstract states.

    A table of skin is refused: its conduction, on which everything here depends, would be unknown.
    """
    if skin is not None:
        raise InputError(
            f"--skin {skin}: vardar_2017 depends on the conduction of the skin, which a table does not give; use"
            " electrovib run with your scenario"
        )
    *parts, shown, tables = computed(
        [*_numbers(), ("figures", panels), ("table of skins", lambda: [skin_table()])]
    )
    found = tuple(chain(*parts))
    return Reproduction(
        paper="vardar_2017",
        citation=CITATION,
        rows=found,
        panels=shown,
        pages=(
            Page(
                "What is open",
                WORDS.texts(
                    "open",
                    not_read=NOT_READ,
                    pacinian=Pacinian.reference,
                    other=NonPacinian.reference,
                    motion=f"{MOTION[0].upper()}{MOTION[1:]}",
                ),
            ),
        ),
        tables=tables,
        equations=EQUATIONS,
        references=(Pacinian.reference, NonPacinian.reference, RYU),
        title="Vardar et al. 2017: sine and square voltage",
        findings=WORDS.texts("findings", **{row.id: row for row in found}),
    )


def rows() -> tuple[Row, ...]:
    """Return the numbers; the abstract prints one, 60 Hz."""
    return tuple(chain(*computed(_numbers())))


def _numbers() -> list[tuple[str, Callable[[], Iterable[Row]]]]:
    """Return what the numbers are, and what computes them."""
    return [
        ("direction of the thresholds", lambda: [_direction()]),
        ("frequency of the lowest threshold", lambda: [_u_shape()]),
        ("frequencies of equal thresholds", _equal),
        ("effects of edges and weights", _beyond),
    ]


def _direction() -> Row:
    skins = conducting_skins().values()
    found = np.array([ratios(skin, (15.0, 30.0), resistance=BODY) for skin in skins])
    verdict = "consistent" if found.min() > 0 else "open"
    return WORDS.row("direction", found.ravel().tolist(), count=len(found), verdict=verdict)


def _u_shape() -> Row:
    curves = curves_of(first_order_skin(time_constant=7.7e-3))
    sine = curves.level["sine"]
    place = int(np.argmin(sine))
    shaped = 0 < place < len(sine) - 1 and bool(np.all(np.diff(sine[place:]) > 0))
    verdict = "consistent" if shaped else "open"
    return WORDS.row("best_frequency", lowest_of(curves.frequency, sine), verdict=verdict)


def lowest_of(frequency: Real, level: Real) -> float:
    """Frequency [Hz] of the lowest level [dB], by a parabola through it and its neighbours in the logarithm."""
    place = min(max(int(np.argmin(level)), 1), len(level) - 2)
    near = slice(place - 1, place + 2)
    bend, slope, _ = np.polyfit(np.log(frequency[near] / frequency[place]), level[near], 2)
    return float(frequency[place] * np.exp(-slope / (2 * bend)))


def _equal() -> tuple[Row, ...]:
    taus = TIME_CONSTANTS
    over_tau = [crossover_of(time_constant=tau) for tau in taus]
    over_weight = [crossover_of(time_constant=7.7e-3, weight=name) for name in WEIGHTS]
    each_tau = ", ".join(
        f"{tau / 1e-3:g} ms {found:.0f} Hz" for tau, found in zip(taus, over_tau, strict=True)
    )
    each_weight = ", ".join(
        f"{name} {found:.0f} Hz" for name, found in zip(WEIGHTS, over_weight, strict=True)
    )
    return (
        WORDS.row("crossover_tau", over_tau, each=each_tau),
        WORDS.row("crossover_weight", over_weight, each=each_weight),
        WORDS.row("tau_of_60", time_constant_of(60.0)),
    )


def time_constant_of(frequency: float) -> float:
    """Time constant [s] of the first-order skin on which sine and square are equal at a frequency [Hz]."""
    from scipy.optimize import brentq

    def ratio(logarithm: float) -> float:
        return sine_over_square(first_order_skin(time_constant=float(np.exp(logarithm))), frequency=frequency)

    return float(np.exp(brentq(ratio, np.log(1e-3), np.log(100e-3), xtol=1e-4)))


def _beyond() -> tuple[Row, ...]:
    skin = first_order_skin(time_constant=7.7e-3)
    edges = [sine_over_square(skin, frequency=480.0, edge=edge) for edge in (0.0, 20e-6, EDGE)]
    low = {name: sine_over_square(skin, frequency=15.0, person=person) for name, person in WEIGHTS.items()}
    both = sine_over_square(skin, frequency=15.0, person=BOTH_CHANNELS) - low["Pacinian, on the force"]
    ideal, short, long = edges
    return (
        WORDS.row("edges_480", edges, ideal=ideal, short=short, long=long),
        WORDS.row("weights_15", low.values(), both=both),
    )


def skin_table() -> Table:
    """Every skin that conducts: the ratio at four frequencies."""
    places = (15.0, 30.0, 60.0, 480.0)
    lines = tuple(
        (name, *(f"{found:+.1f}" for found in ratios(skin, places, resistance=BODY)))
        for name, skin in conducting_skins().items()
    )
    return WORDS.table("skins", lines)
