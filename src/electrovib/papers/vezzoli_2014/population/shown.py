"""Rows, table and figures of the predicted population."""

from __future__ import annotations

import functools
from typing import Any, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Panel, Table
from electrovib.core.arrays import Real
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.looks import look
from electrovib.papers.vezzoli_2014.population import closed_forms as forms
from electrovib.papers.vezzoli_2014.population import set_up
from electrovib.papers.vezzoli_2014.population.predicted import (
    SEED,
    SUBJECTS,
    Predicted,
    population,
    predicted,
)
from electrovib.studies.reproduction import Row, verdict_over

_FINGERS: Final = 2000
"""Draws of figure 7."""
_GROUPS: Final = "groups of moisture"
_KINDS: Final = {"": "", ", dry fingers": "dry"}
"""Words after the name of a law to the group of fingers."""
_SHORT: Final = {
    forms.SKIN: "thickness of the stratum corneum",
    forms.PERMITTIVITY: "permittivity of the stratum corneum",
    forms.GAP: "thickness of the gap",
    forms.FRICTION: "coefficient of friction",
    _GROUPS: "resistivities, dry and moist",
    forms.CONDUCTIVITY: "resistivity of the stratum corneum",
    forms.LEAK: "resistivity of the gap",
}


def rows() -> tuple[Row, ...]:
    """Return the range of eight drawn fingers, with the part of the variance that each input holds, for both laws."""
    found = []
    measured = (values.FORCE_MEASURED[0] / 1e-3, values.FORCE_MEASURED[1] / 1e-3)
    names = ("law_1", "eight drawn fingers, law (1)"), ("gap", "the same, Maxwell stress in a leaky gap")
    for (name, short), each, dry in zip(names, predicted(), predicted("dry"), strict=True):
        (low, high), ours = each.central, _millinewtons(each)
        thickness, resistivity = each.shares[forms.SKIN][0], each.shares[_GROUPS][0]
        found.append(
            Row(f"population_{name}", short, measured, ours, "mN", verdict_over(measured, ours),
                f"{each.law}: smallest and largest lateral force of {SUBJECTS} fingers drawn from the population 'fingers',"
                f" medians over many such groups, at 1 cm2 and a ramp of 36 ms; 5 to 95 % of all fingers lie between"
                f" {low / 1e-3:.2g} and {high / 1e-3:.3g} mN, and dry fingers alone give {_words(dry)} mN. First-order Sobol"
                f" indices: {_indices(each)}; of dry fingers alone: {_indices(dry)}. Skins, gaps and frictions of the eight"
                " subjects are not printed, nor is the ramp.",
                brief=f"variance: thickness {100 * thickness:.0f} %, resistivity {100 * resistivity:.0f} %"),
        )  # fmt: skip
    return tuple(found)


def _millinewtons(each: Predicted) -> tuple[float, float]:
    low, high = each.of_subjects
    return low / 1e-3, high / 1e-3


def _words(each: Predicted) -> str:
    low, high = _millinewtons(each)
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
    ranges = [
        f"{each.of_subjects[0] / 1e-3:.2g} to {each.of_subjects[1] / 1e-3:.3g}" for each in cases.values()
    ]
    lines.append(("eight subjects [mN]", *(cell for shown in ranges for cell in (shown, ""))))
    heads = [f"{case}: {kind}" for case in cases for kind in ("first-order", "total")]
    caption = (
        "Parts of the variance of the lateral force at the end of a ramp of 36 ms over the population 'fingers' (source and"
        " status of each distribution: docs/populations.md). A leaky gap has the time constants of the stratum corneum: a choice."
    )
    return Table(
        "What the spread of figure 6 is due to",
        ("input", *heads),
        tuple(lines),
        caption=caption,
        id="population",
        on_page=False,
    )


def _pair(each: Predicted, name: str) -> tuple[str, str]:
    found = each.shares.get(name)
    return ("", "") if found is None else (f"{found[0]:z.2f}", f"{found[1]:z.2f}")


@functools.cache
def panels() -> tuple[Panel, ...]:
    """Return figure 6 as a distribution and through the whole set-up, and the range of figure 7, under both laws."""
    return _figure_6(), set_up.panel(), _figure_7()


def _figure_6() -> Panel:
    by_law, in_gap = predicted()
    share = (np.arange(len(by_law.force)) + 0.5) / len(by_law.force)
    kept = np.linspace(0, len(share) - 1, 401).astype(int)
    low, high = values.FORCE_MEASURED
    curves = [
        Curve(label=label, x=np.sort(each.force)[kept], y=share[kept], look=look(meaning))
        for label, each, meaning in (
            ("law (1) of the paper", by_law, "paper point"),
            ("Maxwell stress in a leaky gap", in_gap, "leaky gap"),
        )
    ]
    measured = Curve(
        label="measured, eight subjects",
        x=np.array([low, high]),
        y=np.zeros(2),
        upper=np.ones(2),
        kind="band",
        look=REFERENCE,
    )
    return Panel(
        id="fig6_population",
        title="Figure 6 over fingers",
        caption="",
        x=("lateral force", "N"),
        y=("share of fingers below", "1"),
        curves=(measured, *curves),
        log_x=True,
    )


def _figure_7() -> Panel:
    frequency = np.geomspace(100.0, 1e4, 41)
    space = population("fig7")
    at = space.draw(SEED, 0, _FINGERS)
    gap = population("fig6_gap").draw(SEED, 0, _FINGERS)[forms.GAP]
    curves = []
    for label, force, meaning in (
        ("law (1) of the paper", forms.mean_by_law(at, frequency), "paper point"),
        ("gap that does not conduct", forms.mean_in_gap(at | {forms.GAP: gap}, frequency), "no conduction"),
    ):
        low, middle, high = np.quantile(force, [0.05, 0.5, 0.95], axis=0)
        band: dict[str, Any] = {"x": frequency, "look": look(meaning)}
        curves += [
            Curve(label=f"{label}, 5 to 95 %", y=low, upper=high, kind="band", **band),
            Curve(label=f"{label}, median", y=middle, **band),
        ]
    return Panel(
        id="fig7_population",
        title="Figure 7 over fingers",
        caption="Grey: thickness alone.",
        x=("frequency", "Hz"),
        y=("mean electrostatic force", "N"),
        curves=(_of_thickness(frequency), *curves),
        log_x=True,
        log_y=True,
    )


def _of_thickness(frequency: Real) -> Curve:
    """Return the range of law (1) over the thickness of the stratum corneum alone."""
    material = compute.force_skins()["palmar women 20 uS"].material
    thin, thick = (compute.frequency_force(material, frequency, thickness=t) for t in values.THICKNESSES)
    return Curve(
        label="thickness alone, law (1), palmar women 20 uS",
        x=frequency,
        y=thick,
        upper=thin,
        kind="band",
        look=REFERENCE,
    )
