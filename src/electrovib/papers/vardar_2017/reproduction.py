"""What the abstract states, in one object: thresholds over frequency, their ratio, and where they are equal."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from itertools import chain
from typing import Any, Final

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
from electrovib.studies.reproduction import Reproduction, Row

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
        ("1963 skin", plutchik_1963.skins()["skin"].material),
    ):
        found = curves_of(skin)
        for drive, level in found.level.items():
            is_drawn = drive in KINDS or name == "7.7 ms"
            kind = KINDS.get(drive, "dotted")
            curves.append(
                Curve(label=f"{drive}, {name}", x=found.frequency, y=level, kind=kind, drawn=is_drawn)
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
    ]
    curves += [
        Curve(label=f"{tau / 1e-3:g} ms", x=frequency, y=ratios(first_order_skin(time_constant=tau), places))
        for tau in TIME_CONSTANTS
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
        curves.append(Curve(label=weight, x=chosen, y=found, kind="points" if points else "line"))
    edged = np.array([crossover_of(time_constant=float(tau), edge=EDGE) for tau in taus])
    known = np.isfinite(edged)  # where the edges leave a crossing at all
    curves.append(Curve(label="Pacinian, on the force, edges of 200 us", x=taus[known], y=edged[known]))
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


EQUATIONS: Final = {
    "felt": r"$L_c = 20 \lg \sqrt{\sum_k (w_c(f_k) |C(f_k) F_k|)^2}, \quad L = \max_c L_c$",
    "Pacinian": r"$w_P = \frac{2 x^2}{1 + x^4}, \quad x = f/250\,\mathrm{Hz}$",
    "ratio": r"$20 \lg \frac{V_{sine}}{V_{square}} = \frac{L_{square} - L_{sine}}{2}$",
}
REPORTED: Final = 60.0
"""Below it the abstract reports lower thresholds for the square [Hz]."""


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
        pages=(_page(),),
        tables=tables,
        equations=EQUATIONS,
        references=(Pacinian.reference, NonPacinian.reference, RYU),
        title="Vardar et al. 2017: sine and square voltage",
        findings=_findings(found),
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
    low, high = float(found.min()), float(found.max())
    return Row("direction", f"sine over square threshold at 15 and 30 Hz, {len(found)} skins that conduct, in dB", None,
        (low, high), "1", "consistent" if low > 0 else "open", "The paper reports the direction, above 0, and no size. The size"
        " is overestimated where the sine lacks a channel for low frequencies.",
        "lower thresholds for square than for sine voltages below 60 Hz",
        place="abstract", inputs="published", agrees=(0.0, np.inf))  # fmt: skip


def _u_shape() -> Row:
    curves = curves_of(first_order_skin(time_constant=7.7e-3))
    sine = curves.level["sine"]
    place = int(np.argmin(sine))
    shaped = 0 < place < len(sine) - 1 and bool(np.all(np.diff(sine[place:]) > 0))
    return Row("best_frequency", "frequency of the lowest threshold of the sine, 7.7 ms", None,
        lowest_of(curves.frequency, sine), "Hz", "consistent" if shaped else "open", "The paper reports a U. The force of a sine"
        " moves at twice its frequency, so the lowest threshold is at half the frequency at which the Pacinian channel is most"
        " sensitive.", "U-shaped thresholds", place="abstract", inputs="constructed", agrees=(0.0, np.inf))  # fmt: skip


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
    given: dict[str, Any] = {"place": "abstract", "inputs": "constructed"}
    return (
        Row("crossover_tau", "frequency of equal thresholds, time constant 30 to 1 ms", REPORTED, (min(over_tau), max(over_tau)),
            "Hz", "open", f"It depends on the skin, whose time constant the abstract does not give: {each_tau}.", **given),
        Row("crossover_weight", "frequency of equal thresholds, 7.7 ms, over three weights", REPORTED,
            (min(over_weight), max(over_weight)), "Hz", "open", f"The skin is not given. {each_weight}. The corner frequency of"
            " the skin in the last, 100 Hz, is a value from memory, unverified.", **given),
        Row("tau_of_60", "time constant with which both are equal at 60 Hz", None, 1e3 * time_constant_of(REPORTED), "ms", "ours",
            "Computed from the model, not from the paper: 60 Hz is no evidence for it. No skin here is fitted to it.", **given),
    )  # fmt: skip


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
    given: dict[str, Any] = {"place": "abstract", "inputs": "constructed"}
    return (
        Row("edges_480", "sine over square threshold at 480 Hz, 7.7 ms, edges of 0 to 200 us, in dB", None,
            (min(edges), max(edges)), "1", "open", f"The paper reports similar thresholds and no edge. 0, 20 and 200 us:"
            f" {edges[0]:.1f}, {edges[1]:.1f}, {edges[2]:.1f} dB.", "similar thresholds", **given),
        Row("weights_15", "sine over square threshold at 15 Hz, 7.7 ms, over three weights, in dB", None,
            (min(low.values()), max(low.values())), "1", "ours", "The size in the paper was not read. The non-Pacinian channel"
            f" detects the sine, and changes this by {both:.1f} dB.", **given),
    )  # fmt: skip


def skin_table() -> Table:
    """Every skin that conducts: the ratio at four frequencies."""
    places = (15.0, 30.0, 60.0, 480.0)
    lines = tuple(
        (name, *(f"{found:+.1f}" for found in ratios(skin, places, resistance=BODY)))
        for name, skin in conducting_skins().items()
    )
    return Table(
        "Sine over square threshold on every skin that conducts, in dB",
        ("skin", "15 Hz", "30 Hz", "60 Hz", "480 Hz"),
        lines,
        caption="Pacinian weight on the force, ideal edges, body of 1 kohm. Skins that do not conduct lose no charge and"
        " reverse the direction; they are omitted.",
    )


def _findings(rows: tuple[Row, ...]) -> tuple[str, ...]:
    """State the main results with the numbers of this run."""
    found = {row.id: row.ours for row in rows}
    direction, taus, weights, edges = (
        found[name] for name in ("direction", "crossover_tau", "crossover_weight", "edges_480")
    )
    assert isinstance(direction, tuple)
    assert isinstance(taus, tuple)
    assert isinstance(weights, tuple)
    assert isinstance(edges, tuple)
    return (
        "The direction follows from the circuit: at 15 and 30 Hz every skin here that conducts needs more voltage for the sine"
        f" than for the square, by {direction[0]:.2g} to {direction[1]:.2g} dB. The abstract prints no such number.",
        f"The frequency of equal thresholds depends on the skin: it rises from {taus[0]:.0f} to {taus[1]:.0f} Hz with time"
        f" constants from 30 to 1 ms, but only from {weights[0]:.0f} to {weights[1]:.0f} Hz with the weight of the channels."
        f" 60 Hz would need {found['tau_of_60']:.2g} ms, which nothing here confirms.",
        "Above that frequency ideal edges overestimate the difference, because an ideal square voltage has a constant square:"
        f" {edges[0]:.1f} dB at 480 Hz, and {edges[1]:.1f} dB with edges of 200 us, where the paper reports similar thresholds.",
    )


def _page() -> Page:
    return Page(
        "What is open",
        (
            NOT_READ,
            "60 Hz is not imposed on the model: the frequency of equal thresholds follows the time constant of the skin on the"
            " coating, and depends little on the weight of the channels.",
            "Above it the square is less perceptible than the sine in the model, by more than the paper's 'similar', because an"
            " ideal square voltage has a constant square. Edges of 200 us remove most of this difference.",
            f"The weights: {Pacinian.reference}. {NonPacinian.reference}.",
            f"All thresholds are relative: no threshold of displacement is calibrated. {MOTION[0].upper()}{MOTION[1:]}.",
        ),
    )
