"""Figures 6 and 7 for a population of fingers, under law (1) and with the Maxwell stress in the gap."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Curve, Panel, Table
from electrovib.core.arrays import Real
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.compute import panel, row
from electrovib.papers.vezzoli_2014.figures import curve, look, measured_range, span
from electrovib.papers.vezzoli_2014.values import scenarios
from electrovib.scenario import Scenario
from electrovib.scenario.space import Space, read_space
from electrovib.solve.prepare import prepare
from electrovib.solve.simulate import simulate
from electrovib.studies.population import study
from electrovib.studies.reproduction import Row
from electrovib.studies.sensitivity import InputIndices, sensitivity

SKIN: Final = "stack.stratum_corneum.thickness"
PERMITTIVITY: Final = "stack.stratum_corneum.material.permittivity"
CONDUCTIVITY: Final = "stack.stratum_corneum.material.conductivity"
GAP: Final = "stack.gap.thickness"
LEAK: Final = "stack.gap.material.conductivity"
FRICTION: Final = "friction.coefficient"
SEED: Final = 2014
SUBJECTS: Final = 8
"""Of the paper."""
_GROUPS_OF_SUBJECTS: Final = 1000
_DRAWS: Final = 2048
_OF_FIGURE_6: Final = (SKIN, PERMITTIVITY, GAP, FRICTION)
_NOMINAL_GAP: Final = 1e-6
"""Gap at which the leak has the time constant of the skin [m]."""
FORCE: Final = "swing lateral_force"
"""The lateral force above that of the load."""
_NO_BODY: Final = {"circuit.return_path.resistance": 0.0}


@dataclass(frozen=True, kw_only=True)
class Predicted:
    """The lateral force of figure 6 over a population, under one law.

    `force` of random fingers (n,) [N], n a multiple of `SUBJECTS`; `indices` are the Sobol indices of the inputs.
    """

    law: str
    force: Real
    indices: tuple[InputIndices, ...]

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
        return {each.name: (each.first, each.total) for each in self.indices}


@functools.cache
def predicted(group: str = "") -> tuple[Predicted, Predicted]:
    """Compute the distributions from one population under law (1) and with the Maxwell stress in the gap.

    `group` is ``dry`` or ``moist`` for these fingers alone; all if empty.
    """
    return (
        _predicted("law (1)", "fig6", group),
        _predicted("Maxwell stress in the gap", "fig6_gap", group),
    )


def _predicted(law: str, figure: str, group: str) -> Predicted:
    scenario, space = rising(figure), population(figure, group)
    force = prepare(scenario, free=space.paths, quantity=[FORCE])
    drawn = space.draw(SEED, 0, SUBJECTS * _GROUPS_OF_SUBJECTS)
    found = sensitivity(scenario, space, quantity=FORCE, n=_DRAWS, seed=SEED)
    return Predicted(law=law, force=force(drawn)[FORCE], indices=found.indices)


def rising(figure: str) -> Scenario:
    """Return figure 6 until the end of the rising ramp, without the resistance of the body, which the paper has not."""
    return scenarios()[figure].replace(_NO_BODY | {"time.duration": values.RAMP, "time.samples": 2})


def population(figure: str, group: str = "") -> Space:
    """Return the population `fingers` for a scenario of the paper, at the printed contact area.

    `figure` is ``fig6``, ``fig6_gap`` or ``fig7``; `group` as for `predicted`. A leaky gap has in each group
    of moisture the distribution of time constants that the stratum corneum has, at a permittivity of 1560: a
    choice, because no source gives its resistivity.
    """
    shipped = read_space(scenarios()[figure], "fingers").as_table()
    groups = {
        label: {"share": group["share"], "space": _conductivities(group["space"], leaks=figure == "fig6_gap")}
        for label, group in shipped["groups"]["moisture"].items()
    }
    tables: dict[str, Any] = {
        "space": {path: each for path, each in shipped["space"].items() if path in _OF_FIGURE_6},
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
    ends = {name: factor * skin[name] for name in ("low", "high")}
    return {CONDUCTIVITY: skin, LEAK: {"model": "LogUniform", **ends}}


_STATED: Final[dict[str, Any]] = tomllib.loads(
    Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
)
SET_UP: Final[dict[str, Any]] = _STATED["set_up"]
"""Amplifier, sensors and digitiser."""
RATE: Final[float] = SET_UP["rig"]["digitiser"]["sampling_rate"]
"""Readings per second [Hz]."""
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
_SHORT: Final[dict[str, str]] = _STATED["short"]


def rows() -> tuple[Row, ...]:
    """Return the range of eight drawn fingers for both laws, and the parts of the variance that two inputs hold."""
    found = []
    for name, each, dry in zip(("law_1", "gap"), predicted(), predicted("dry"), strict=True):
        low, high = (end / 1e-3 for end in each.central)
        numbers = {"dry": _words(dry), "indices": _indices(each), "of_dry": _indices(dry)}
        found.append(
            row(f"population_{name}", each.of_subjects, subjects=SUBJECTS, low=low, high=high, **numbers)
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
    names = dict.fromkeys(name for each in cases.values() for name in each.shares)
    lines = [
        (_SHORT[name], *(cell for each in cases.values() for cell in _pair(each, name))) for name in names
    ]
    lines.append(("eight subjects [mN]", *(cell for each in cases.values() for cell in (_words(each), ""))))
    heads = [f"{case}: {kind}" for case in cases for kind in ("first-order", "total")]
    return compute.table("population", lines, headings=("input", *heads))


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
    curves = []
    for label, (scenario, space), meaning in (
        ("law (1) of the paper", over_frequency(), "paper point"),
        ("gap that does not conduct", over_frequency(in_gap=True), "no conduction"),
    ):
        found = study(scenario, space, n=_FINGERS, seed=SEED, quantity="mean_force")
        frequency, (low, middle, high) = found.frequency.values, found["mean_force_percentile"].values
        band: dict[str, Any] = {"x": frequency, "look": look(meaning)}
        curves += [
            Curve(label=f"{label}, 5 to 95 %", y=low, upper=high, kind="band", **band),
            Curve(label=f"{label}, median", y=middle, **band),
        ]
    return panel("fig7_population", _of_thickness(samples=len(frequency)), *curves)


def over_frequency(*, in_gap: bool = False) -> tuple[Scenario, Space]:
    """Return figure 7 by the law as printed, or with the Maxwell stress in a gap of air, and its population."""
    grid = {"frequency.low": 100.0, "frequency.high": 1e4, "frequency.samples": 41}
    scenario, space = scenarios()["fig7"].replace(_NO_BODY | grid), population("fig7")
    if not in_gap:
        return scenario, space
    gap = population("fig6_gap").as_table()["space"][GAP]
    scenario = scenario.replace(
        {"force.model": "MaxwellStressInGap", "stack.gap": {"thickness": _NOMINAL_GAP}}
    )
    table = space.as_table()
    return scenario, read_space(scenario, table | {"space": table["space"] | {GAP: gap}})


def _of_thickness(*, samples: int) -> Curve:
    """Return the range of law (1) over the thickness of the stratum corneum alone."""
    material = compute.force_skins()["palmar women 20 uS"].material
    (frequency, thin), (_, thick) = (
        compute.frequency_force(material, samples=samples, thickness=each) for each in values.THICKNESSES
    )
    return span("thickness alone, law (1), palmar women 20 uS", frequency, thick, thin)
