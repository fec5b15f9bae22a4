"""Figures of a comparison as data; a law has the same colour in all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from electrovib.core.answer import Curve, Panel
from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.core.units import format_quantity
from electrovib.scenario import Scenario
from electrovib.studies.compare.result import Entry
from electrovib.studies.compare.static import air_breaks_down, static_force

SAME = 0.02
"""Relative difference up to which two curves coincide."""
KINDS = ("line", "dashed", "dotted")
"""Line styles of the first, second and every further of coinciding curves."""


def over_frequency(entries: Sequence[Entry], *, frequency: Real, voltage: float) -> Panel:
    """Return the figure of the mean force of each law over frequency, under a sine of the peak `voltage`."""
    curves = [
        Curve(label=entry.name, x=frequency, y=entry.mean, look=look)
        for look, entry in enumerate(entries)
        if np.all(entry.mean > 0)
    ]
    return Panel(
        id="force_over_frequency",
        title="Mean force over frequency",
        caption=f"Time mean under a sine of {format_quantity(voltage, 'V')}, materials as declared.",
        x=("frequency", "Hz"),
        y=("mean electrostatic force", "N"),
        curves=all_to_be_seen(curves),
        log_x=True,
        log_y=True,
    )


def over_time(entries: Sequence[Entry], *, time: Real, voltage: float) -> Panel:
    """Return the figure of the response of each law that has one to a step of the height `voltage`."""
    curves = []
    for look, entry in enumerate(entries):
        if len(entry.step):
            floor = np.max(entry.step) * 1e-6
            curves.append(Curve(label=entry.name, x=time[1:], y=np.maximum(entry.step[1:], floor), look=look))
    caption = (
        f"After a step to {format_quantity(voltage, 'V')} from rest. The laws differ in time, not only in size: where a"
        " layer conducts, the field moves to the other layers. No value is drawn below a millionth of the largest of its"
        " law."
    )
    return Panel(
        id="force_over_time",
        title="Step response",
        caption=caption,
        x=("time", "s"),
        y=("electrostatic force", "N"),
        curves=all_to_be_seen(curves),
        log_x=True,
        log_y=True,
    )


def over_parameter(
    scenario: Scenario, cases: Mapping[str, Scenario], path: str, *, values: Real, highest: float = np.inf
) -> Panel:
    """Return the figure of the static force of each law over a parameter; above `highest` the amplifier saturates [V]."""
    quantity = quantity_at(scenario, path)
    curves, marks = [], []
    for look, (name, case) in enumerate(cases.items()):
        varied = [_with(case, path, float(value)) for value in values]
        voltages = [min(one.drive.largest(), highest) for one in varied]
        forces = np.array(
            [static_force(one, voltage=each) for one, each in zip(varied, voltages, strict=True)]
        )
        curves.append(Curve(label=name, x=values, y=forces, look=look))
        if case.force.evaluation_surface == "gap":
            broken = np.array(
                [bool(air_breaks_down(one, voltage=each)) for one, each in zip(varied, voltages, strict=True)]
            )
            label = f"{name}: air breaks down"
            marks += (
                [Curve(label=label, x=values[broken], y=forces[broken], upper=None, kind="points", look=look)]
                if any(broken)
                else []
            )
    said = f"At the peak voltage of the drive, nothing conducting. {_sentence(quantity.doc)}"
    if marks:
        said += " Points: there the air of the gap breaks down, so this force would not be measured."
    return Panel(
        id=f"static_over_{path.replace('.', '_')}",
        title=f"Static force over {path}",
        caption=said,
        x=(path, quantity.unit),
        y=("static electrostatic force", "N"),
        curves=(*all_to_be_seen(curves), *marks),
        log_x=bool(np.min(values) > 0 and np.max(values) / np.min(values) > 20),
        log_y=True,
    )


def _with(case: Scenario, path: str, value: float) -> Scenario:
    if path.startswith("force."):
        try:
            quantity_at(case, path)
        except InputError:
            return case
    return case.replace({path: value})


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:].rstrip('.')}."


def all_to_be_seen(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """Draw a curve dashed where it covers another one over at least half of its length, dotted for several."""
    shown: list[Curve] = []
    for curve in curves:
        below = sum(_on_each_other(curve, other) for other in shown)
        shown.append(replace(curve, kind=KINDS[min(below, len(KINDS) - 1)]))
    return tuple(shown)


def _on_each_other(one: Curve, other: Curve) -> bool:
    return bool(np.mean(np.isclose(one.y, other.y, rtol=SAME, atol=0.0)) >= 1 / 2)
