"""Figures 6 and 7 for a population of fingers, under law (1) and with the Maxwell stress in the gap.

Forces are in closed form, for many fingers at once; tests compare them with the solvers.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Curve, Panel, Table
from electrovib.core.arrays import Complex, Real
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.core.units import parse_quantity
from electrovib.papers.vezzoli_2014 import compute, values, words
from electrovib.papers.vezzoli_2014.figures import curve, look, measured_range, span
from electrovib.papers.vezzoli_2014.laws import literal_response
from electrovib.papers.vezzoli_2014.values import scenarios
from electrovib.papers.vezzoli_2014.words import panel, row
from electrovib.scenario.space import Space, read_space
from electrovib.scenario.space.shipped import read_shipped
from electrovib.solve.simulate import simulate
from electrovib.studies.reproduction import Row
from electrovib.studies.sensitivity import Indices, sobol

SKIN: Final = "stack.stratum_corneum.thickness"
PERMITTIVITY: Final = "stack.stratum_corneum.material.permittivity"
CONDUCTIVITY: Final = "stack.stratum_corneum.material.conductivity"
EXPONENT: Final = "stack.stratum_corneum.material.exponent"
GAP: Final = "stack.gap.thickness"
LEAK: Final = "stack.gap.material.conductivity"
FRICTION: Final = "friction.coefficient"
ANCHOR: Final = 100.0
"""Frequency of the permittivity of the constant-phase skin of figure 7 [Hz]."""
AMPLITUDE: Final = 100.0
"""Voltage of figure 7, as `compute.frequency_force` takes it [V]."""


def lateral_by_law(at: Mapping[str, Real], *, ramp: float = values.RAMP) -> Real:
    """Compute the lateral force at the end of the rising ramp of figure 6, under law (1) with the causal charge loss.

    `at` has by path, each of shape (n,), thickness, permittivity and conductivity of the stratum corneum, and
    friction, in SI; returns coefficient of friction times attraction (n,) [N].
    """
    skin, film = _skin(at), values.FILM_PERMITTIVITY * eps0 / values.FILM_THICKNESS
    tau = (film + skin) * at[SKIN] / at[CONDUCTIVITY]
    effective = values.VOLTAGE * tau / ramp * -np.expm1(-ramp / tau)
    electrical = values.FILM_THICKNESS / values.FILM_PERMITTIVITY + at[SKIN] / at[PERMITTIVITY]
    length = values.FILM_THICKNESS + at[SKIN]
    return np.asarray(
        at[FRICTION] * eps0 * values.AREA * effective**2 / (2 * electrical * length), dtype=float
    )


def lateral_in_gap(at: Mapping[str, Real], *, ramp: float = values.RAMP) -> Real:
    """Compute the lateral force at the end of the rising ramp of figure 6, with the Maxwell stress in a leaky gap.

    As `lateral_by_law`, with thickness and conductivity of the gap. The step response of the gap voltage is a
    sum of two exponentials, whose rates are the zeros of C_g C_s + C_i (C_g + C_s) times s^2, and so on:
    film, gap and skin in series, without the resistance of the body.
    """
    film, gap, skin = values.FILM_PERMITTIVITY * eps0 / values.FILM_THICKNESS, eps0 / at[GAP], _skin(at)
    leak, loss = at[LEAK] / at[GAP], at[CONDUCTIVITY] / at[SKIN]
    square = gap * skin + film * (skin + gap)
    linear = leak * skin + loss * gap + film * (loss + leak)
    root = np.sqrt(linear**2 - 4 * square * leak * loss)
    fast = (linear + root) / (2 * square)
    slow = leak * loss / (square * fast)
    response = np.zeros_like(fast)
    for rate, other in ((fast, slow), (slow, fast)):
        weight = film * (skin * rate - loss) / (square * (rate - other))
        response += weight * -np.expm1(-rate * ramp) / (rate * ramp)
    field = values.VOLTAGE * response / at[GAP]
    return np.asarray(at[FRICTION] * values.AREA * eps0 * field**2 / 2, dtype=float)


def mean_by_law(at: Mapping[str, Real], frequency: Real) -> Real:
    """Compute the mean attraction of figure 7 over frequency, by the law as printed.

    `at` has by path, each of shape (n,), thickness, permittivity at 100 Hz, exponent and conductivity of a
    constant-phase skin, in SI; `frequency` (m,) [Hz]. Returns the mean attraction (n, m) [N] on 1 cm2 of the
    thin coating under 100 V.
    """
    bound, whole = _dispersive(at, frequency)
    skin = at[SKIN][:, None]
    film = values.COATING_PERMITTIVITY * eps0 / values.COATING_THICKNESS
    gain = np.abs(literal_response(frequency, insulator=film, skin=eps0 * whole / skin))
    electrical = values.COATING_THICKNESS / values.COATING_PERMITTIVITY + skin / bound.real
    length = values.COATING_THICKNESS + skin
    return np.asarray(eps0 * values.AREA * (AMPLITUDE * gain) ** 2 / (4 * electrical * length))


def mean_in_gap(at: Mapping[str, Real], frequency: Real) -> Real:
    """Compute the mean attraction of figure 7 over frequency, with the Maxwell stress in a gap of air that does not conduct.

    As `mean_by_law`, with the thickness of the gap.
    """
    _, whole = _dispersive(at, frequency)
    electrical = values.COATING_THICKNESS / values.COATING_PERMITTIVITY + at[SKIN][:, None] / whole
    field = np.abs(AMPLITUDE / (electrical + at[GAP][:, None]))
    return np.asarray(eps0 * values.AREA * field**2 / 4)


def _skin(at: Mapping[str, Real]) -> Real:
    return np.asarray(eps0 * at[PERMITTIVITY] / at[SKIN])


def _dispersive(at: Mapping[str, Real], frequency: Real) -> tuple[Complex, Complex]:
    """Return the bound and the whole relative permittivity of constant-phase skins, each of shape (n, m)."""
    power = at[EXPONENT][:, None] - 1
    bound = at[PERMITTIVITY][:, None] * (1j * frequency / ANCHOR) ** power / np.cos(power * np.pi / 2)
    whole = bound + at[CONDUCTIVITY][:, None] / (2j * np.pi * frequency * eps0)
    return np.asarray(bound, dtype=complex), np.asarray(whole, dtype=complex)


SEED: Final = 2014
SUBJECTS: Final = 8
"""Of the paper."""
_GROUPS_OF_SUBJECTS: Final = 1000
_DRAWS: Final = 2048
_OF_FIGURE_6: Final = (SKIN, PERMITTIVITY, GAP, FRICTION)
_NOMINAL_GAP: Final = 1e-6
"""Gap at which the leak has the time constant of the skin [m]."""


@dataclass(frozen=True, kw_only=True)
class Predicted:
    """The lateral force of figure 6 over a population, under one law.

    `force` of random fingers (n,) [N], n a multiple of `SUBJECTS`; `indices` are the Sobol indices of the
    inputs of `space`.
    """

    law: str
    space: Space
    force: Real
    indices: Indices

    @property
    def spread(self) -> float:
        """Largest over smallest force of `of_subjects`."""
        smallest, largest = self.of_subjects
        return largest / smallest

    @property
    def central(self) -> tuple[float, float]:
        """Quantiles 5 and 95 % [N]."""
        low, high = np.quantile(self.force, [0.05, 0.95])
        return float(low), float(high)

    @property
    def of_subjects(self) -> tuple[float, float]:
        """Smallest and largest force among as many subjects as the paper has, medians over many such groups [N]."""
        groups = self.force.reshape(-1, SUBJECTS)
        return float(np.median(groups.min(axis=1))), float(np.median(groups.max(axis=1)))

    @property
    def shares(self) -> dict[str, tuple[float, float]]:
        """Name of each input to its first-order and its total index."""
        pairs = zip(self.indices.first.tolist(), self.indices.total.tolist(), strict=True)
        return dict(zip(self.space.inputs, pairs, strict=True))


@functools.cache
def predicted(group: str = "") -> tuple[Predicted, Predicted]:
    """Compute the distributions from one population under law (1) and with the Maxwell stress in the gap.

    `group` is ``dry`` or ``moist`` for these fingers alone; all if empty.
    """
    return (
        _predicted("law (1)", population("fig6", group), lateral_by_law),
        _predicted("Maxwell stress in the gap", population("fig6_gap", group), lateral_in_gap),
    )


def _predicted(law: str, space: Space, function: Callable[[Mapping[str, Real]], Real]) -> Predicted:
    drawn = space.draw(SEED, 0, SUBJECTS * _GROUPS_OF_SUBJECTS)
    return Predicted(
        law=law, space=space, force=function(drawn), indices=sobol(space, function, n=_DRAWS, seed=SEED)
    )


def population(figure: str, group: str = "") -> Space:
    """Return the population `fingers` for a scenario of the paper, at the printed contact area.

    `figure` is ``fig6``, ``fig6_gap`` or ``fig7``; `group` as for `predicted`. A leaky gap has in each group
    of moisture the distribution of time constants that the stratum corneum has, at a permittivity of 1560: a
    choice, because no source gives its resistivity.
    """
    shipped = read_shipped("fingers")
    groups = {
        label: {"share": group["share"], "space": _conductivities(group["space"], leaks=figure == "fig6_gap")}
        for label, group in shipped["groups"]["moisture"].items()
    }
    tables: dict[str, Any] = {
        "space": {path: shipped["space"][path] for path in _OF_FIGURE_6},
        "groups": {} if group else {"moisture": groups},
    }
    if group:
        tables["space"] |= groups[group]["space"]
    if figure == "fig7":
        tables["groups"]["sex"] = shipped["groups"]["sex"]
    return read_space(scenarios()[figure], tables)


def _conductivities(table: Mapping[str, Any], *, leaks: bool) -> dict[str, Any]:
    """Return the conductivity of the stratum corneum in a group, and that of a leaky gap with the same time constants."""
    skin = table[CONDUCTIVITY]
    if not leaks:
        return {CONDUCTIVITY: skin}
    ratio = values.FILM_PERMITTIVITY * _NOMINAL_GAP / values.FILM_THICKNESS  # C_i/C_g
    factor = (1 + ratio) / values.SKIN_PERMITTIVITY
    ends = {name: factor * parse_quantity(skin[name], "S/m") for name in ("low", "high")}
    return {CONDUCTIVITY: skin, LEAK: {"model": "LogUniform", **ends}}


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
def whole_set_up() -> Panel:
    """Return the readings of eight drawn fingers beside the measured range, divided by friction."""
    curves = []
    for label, figure, meaning in _CASES:
        time, attraction = readings(figure)
        there_and_back = [
            time[:: (-1) ** number] for number in range(SUBJECTS)
        ]  # one line: all begin and end at 0
        curves.append(
            curve(
                label,
                np.concatenate(there_and_back),
                np.concatenate([each[:: (-1) ** number] for number, each in enumerate(attraction)]),
                meaning,
            )
        )
    return panel("fig6_set_up", measured_range(time[[0, -1]]), *curves)


_FINGERS: Final = 2000
"""Draws of figure 7."""
_GROUPS: Final = "groups of moisture"
_KINDS: Final = {"": "", ", dry fingers": "dry"}
"""Words after the name of a law to the group of fingers."""
_SHORT: Final = {
    SKIN: "thickness of the stratum corneum",
    PERMITTIVITY: "permittivity of the stratum corneum",
    GAP: "thickness of the gap",
    FRICTION: "coefficient of friction",
    _GROUPS: "resistivities, dry and moist",
    CONDUCTIVITY: "resistivity of the stratum corneum",
    LEAK: "resistivity of the gap",
}


def rows() -> tuple[Row, ...]:
    """Return the range of eight drawn fingers for both laws, and the parts of the variance that two inputs hold."""
    found = []
    for name, each, dry in zip(("law_1", "gap"), predicted(), predicted("dry"), strict=True):
        low, high = (end / 1e-3 for end in each.central)
        told = {"dry": _words(dry), "indices": _indices(each), "of_dry": _indices(dry)}
        found.append(
            row(f"population_{name}", each.of_subjects, subjects=SUBJECTS, low=low, high=high, **told)
        )
    shares = predicted()[0].shares
    pairs = (("thickness", SKIN), ("resistivity", _GROUPS))
    return (*found, *(row(f"variance_{name}", shares[path][0]) for name, path in pairs))


def _words(each: Predicted) -> str:
    low, high = (end / 1e-3 for end in each.of_subjects)
    return f"{low:.2g} to {high:.3g}"


def _indices(each: Predicted) -> str:
    """Write the first-order indices of all inputs, largest first."""
    ordered = sorted(((first, name) for name, (first, _) in each.shares.items()), reverse=True)
    return ", ".join(f"{_SHORT[name]} {first:z.2f}" for first, name in ordered)


def table() -> Table:
    """Return the Sobol indices of every input under both laws."""
    cases = {f"{each.law}{kind}": each for kind, group in _KINDS.items() for each in predicted(group)}
    names = dict.fromkeys(name for each in cases.values() for name in each.space.inputs)
    lines = [
        (_SHORT[name], *(cell for each in cases.values() for cell in _pair(each, name))) for name in names
    ]
    lines.append(("eight subjects [mN]", *(cell for each in cases.values() for cell in (_words(each), ""))))
    heads = [f"{case}: {kind}" for case in cases for kind in ("first-order", "total")]
    return words.table("population", lines, headings=("input", *heads))


def _pair(each: Predicted, name: str) -> tuple[str, str]:
    found = each.shares.get(name)
    return ("", "") if found is None else (f"{found[0]:z.2f}", f"{found[1]:z.2f}")


@functools.cache
def panels() -> tuple[Panel, ...]:
    """Return figure 6 as a distribution and through the whole set-up, and the range of figure 7, under both laws."""
    return _figure_6(), whole_set_up(), _figure_7()


def _figure_6() -> Panel:
    by_law, in_gap = predicted()
    share = (np.arange(len(by_law.force)) + 0.5) / len(by_law.force)
    kept = np.linspace(0, len(share) - 1, 401).astype(int)
    curves = [
        curve(label, np.sort(each.force)[kept], share[kept], meaning)
        for label, each, meaning in (
            ("law (1) of the paper", by_law, "paper point"),
            ("Maxwell stress in a leaky gap", in_gap, "leaky gap"),
        )
    ]
    measured = span("measured, eight subjects", np.array(values.FORCE_MEASURED), 0.0, 1.0)
    return panel("fig6_population", measured, *curves)


def _figure_7() -> Panel:
    frequency = np.geomspace(100.0, 1e4, 41)
    space = population("fig7")
    at = space.draw(SEED, 0, _FINGERS)
    gap = population("fig6_gap").draw(SEED, 0, _FINGERS)[GAP]
    curves = []
    for label, force, meaning in (
        ("law (1) of the paper", mean_by_law(at, frequency), "paper point"),
        ("gap that does not conduct", mean_in_gap(at | {GAP: gap}, frequency), "no conduction"),
    ):
        low, middle, high = np.quantile(force, [0.05, 0.5, 0.95], axis=0)
        band: dict[str, Any] = {"x": frequency, "look": look(meaning)}
        curves += [
            Curve(label=f"{label}, 5 to 95 %", y=low, upper=high, kind="band", **band),
            Curve(label=f"{label}, median", y=middle, **band),
        ]
    return panel("fig7_population", _of_thickness(frequency), *curves)


def _of_thickness(frequency: Real) -> Curve:
    """Return the range of law (1) over the thickness of the stratum corneum alone."""
    material = compute.force_skins()["palmar women 20 uS"].material
    thin, thick = (compute.frequency_force(material, frequency, thickness=t) for t in values.THICKNESSES)
    return span("thickness alone, law (1), palmar women 20 uS", frequency, thick, thin)
