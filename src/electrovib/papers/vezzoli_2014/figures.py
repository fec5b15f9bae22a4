"""The paper's figures as data, in which the same thing has one colour."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.answer import REFERENCE, Curve, Panel, Shown
from electrovib.core.arrays import Real
from electrovib.papers.vezzoli_2014 import compute, drawings, values
from electrovib.papers.vezzoli_2014.compute import panel
from electrovib.papers.vezzoli_2014.values import scenarios
from electrovib.physics.material.tabulated import Tabulated
from electrovib.physics.skin import time_constant
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    import xarray

MEANINGS: Final = (
    "paper point",
    "palmar men 2 uS",
    "1963 impedance",
    "Gabriel dry",
    "leaky gap",
    "Gabriel wet",
    "no conduction",
    "your table",
    "trembling hand",
    "sliding",
    "polarity",
    "sensor",
)
"""In the order of the palette."""
NOT_DRAWN: Final = len(MEANINGS)


def look(meaning: str) -> int:
    """Return the place of a meaning in the palette; that after the last for curves that are never drawn."""
    return MEANINGS.index(meaning) if meaning in MEANINGS else NOT_DRAWN


def curve(label: str, x: Real, y: Real, meaning: str, **more: Any) -> Curve:
    """Return a curve in the colour of what it stands for."""
    return Curve(label=label, x=x, y=y, look=look(meaning), **more)


PUBLISHED: Final = "published skins"
MOIST: Final = ("palmar women 20 uS", "palmar men 20 uS")
"""Besides Gabriel's wet skin those whose force of figure 7 rises and saturates."""
SHOWN = ("paper point", "palmar men 2 uS", "1963 impedance", "Gabriel dry")
"""Skins drawn one by one; all are in the tables and in the files of the curves."""
FORCE_FLOOR = 1e-7
"""Smallest force that figure 6 draws over decades [N]."""
SINGLE_LEAK = "Maxwell stress in the gap, leaky gap 1 um"


def panels(own: Tabulated | None) -> tuple[Shown, ...]:
    """Return the figures as printed, then further ones; `own` is a user's skin, drawn beside the published ones."""
    drawn, four, six, seven = drawings.panels(), figure_4(own), figure_6(), figure_7(own)
    relative = {
        "y": ("force relative to 10 kHz", "1"),
        "caption": "Law as printed: every skin with its shape.",
    }
    further = (
        by_skin(four, "Figure 4: skins one by one", caption="Each published skin with its name."),
        figure_6_over_decades(six),
        figure_6_ramps(),
        by_skin(seven, "Figure 7: skins one by one, relative to 10 kHz", relative=True, **relative),
    )
    printed = (drawn[1], figure_2(), drawn[3], four, drawn[5], six, seven)
    return (*printed, *(replace(each, folded=True) for each in further))


def behind(label: str, x: Real, y: Real, words: str = PUBLISHED) -> Curve:
    """Return a curve of the background, which `words` name in the legend."""
    return Curve(label=label, x=x, y=y, look=REFERENCE, background=words)


def span(label: str, x: Real, low: ArrayLike, high: ArrayLike) -> Curve:
    """Return a range over an axis, or a bar at one place of it."""
    lower, upper = (np.broadcast_to(np.asarray(each, dtype=float), x.shape) for each in (low, high))
    return Curve(label=label, x=x, y=lower, upper=upper, kind="band", look=REFERENCE)


def by_skin(whole: Panel, title: str, *, relative: bool = False, **changes: Any) -> Panel:
    """Return a panel without its ranges, in which the skins of the background have names, if wanted over their last value."""
    named = [
        curve(each.label, each.x, each.y, each.label, drawn=each.label in SHOWN) if each.background else each
        for each in whole.curves
        if each.upper is None
    ]
    curves = [replace(each, y=each.y / each.y[-1]) for each in named] if relative else named
    return replace(whole, id=f"{whole.id}_by_skin", title=title, curves=tuple(curves), **changes)


def voltage(trace: xarray.Dataset) -> Curve:
    """Return the voltage of the drive over time."""
    return Curve(label="voltage", x=trace.time.values, y=trace.drive_voltage.values, look=REFERENCE)


def figure_2() -> Panel:
    """Force on a finger held off the plate, over time."""
    trace = simulate(scenarios()["fig2"])
    leaky = simulate(scenarios()["fig2"].replace(compute.leaky_air(8.7e8)))
    held = simulate(scenarios()["fig2_tremor"])
    forces = [
        curve(label, found.time.values, found.electrostatic_force.values, meaning, kind=kind)
        for label, found, meaning, kind in (
            ("gap does not conduct", trace, "no conduction", "bold"),
            ("the same, the hand trembles by 10 um", held, "trembling hand", "line"),
            ("gap leaks, 8.7e8 ohm m", leaky, "leaky gap", "dashed"),
        )
    ]
    return panel("fig2", voltage(trace), below=(panel("fig2_force", *forces),))


def figure_4(own: Tabulated | None) -> Panel:
    """Time constant of the stratum corneum over frequency."""
    frequency, ends = np.geomspace(10.0, 1e6, 201), np.array([10.0, 1e6])
    skins = {key: skin for key, skin in compute.all_skins().items() if key != "vezzoli_2014/point"}
    taus = {skin.name: time_constant(skin.material, frequency) for skin in skins.values()}
    published = [skin.name for skin in skins.values() if skin.reproduces_force]
    constructed = [tau for name, tau in taus.items() if name not in published]
    curves = [
        *(behind(name, frequency, taus[name]) for name in published),
        span(
            "constructed through 7.7 ms, constant phase",
            frequency,
            np.min(constructed, axis=0),
            np.max(constructed, axis=0),
        ),
        *(
            curve(label, ends, np.full(2, reading.tau), "paper point", kind="bold", drawn=drawn)
            for label, reading, drawn in (
                ("paper: 7.7 ms", compute.BY_VOLTAGE, True),
                ("paper: 15.4 ms, if 7.7 ms is of the force", compute.BY_FORCE, False),
            )
        ),
    ]
    if own is not None:
        rows = own.table()[0]
        curves.append(curve("your table", rows, time_constant(own, rows), "your table", kind="points"))
    return panel("fig4", *curves)


def figure_6() -> Panel:
    """Voltage, attraction and lateral force over time under the trapezoidal pulse, as printed."""
    paper = scenarios()["fig6"]
    traces = {
        name: simulate(compute.with_skin(paper, skin.material))
        for name, skin in compute.force_skins().items()
    }
    time = traces["paper point"].time.values
    friction, end = paper.to_dict()["friction"]["coefficient"], 1.03 * time[-1:]

    def forces(name: str, factor: float, *beside: Curve) -> Panel:
        own = {skin: factor * each.electrostatic_force.values for skin, each in traces.items()}
        reading = curve(
            "the paper's reading, 7.7 ms", time, own.pop("paper point"), "paper point", kind="bold"
        )
        skins = (behind(skin, time, force) for skin, force in own.items())
        return panel(name, reading, *skins, *beside)

    printed = Curve(label="printed: 2.5 mN", x=end, y=np.array([values.FORCE_MODEL]), look=REFERENCE)
    lateral = span("measured, 2 to 5 mN, eight people", end, *values.FORCE_MEASURED)
    below = (forces("fig6_force", 1.0, printed), forces("fig6_lateral", friction, lateral))
    return panel("fig6", voltage(traces["paper point"]), below=below, friction=friction)


def figure_6_over_decades(whole: Panel) -> Panel:
    """Force over time under the trapezoidal pulse, by skin and law."""
    others = {
        "law (1), no charge lost": (scenarios()["fig6_static"], "dashed", "no conduction"),
        "15.4 ms, not dispersive": (compute.point(compute.BY_FORCE.tau), "dotted", "paper point"),
        "Maxwell stress in a leaky gap of 1 um": (compute.leaky_gap(1e-6), "line", "leaky gap"),
    }
    named = by_skin(whole.below[0], "Figure 6 over decades, by law and skin")
    time = named.curves[0].x
    laws = (
        curve(label, time, simulate(scenario).electrostatic_force.values, meaning, kind=kind, drawn=kind != "dotted")
        for label, (scenario, kind, meaning) in others.items()
    )  # fmt: skip
    skins = (replace(each, drawn=each.drawn and each.label != "Gabriel dry") for each in named.curves[:-1])
    curves = (measured_range(time[[0, -1]]), *laws, *skins)
    caption = f"Attraction, ramp of 36 ms. {_BAND}"
    return replace(
        named, id="fig6_over_decades", caption=caption, curves=curves, log_y=True, floor=FORCE_FLOOR
    )


_BAND = (
    "Range: the measured 2 to 5 mN of lateral force over a coefficient of friction of 0.3 to 0.6, a choice."
)


def measured_range(ends: Real) -> Curve:
    """Return the attraction behind the measured lateral force, from one end of the axis to the other."""
    return span(
        "measured 2 to 5 mN over friction coefficient", ends, *values.attraction_of(values.FORCE_MEASURED)
    )


def figure_6_ramps() -> Panel:
    """Peak force against the ramp, which the paper does not print."""
    ramps = np.geomspace(1e-4, 0.3, 15)
    curves = [measured_range(ramps[[0, -1]])]
    for name, scenario in compute.figure_6_cases().items():
        forces = np.array([compute.peak_force(scenario, ramp=float(ramp)) for ramp in ramps])
        meaning = (
            "leaky gap" if name in compute.LEAKY_GAPS else "paper point" if name.startswith("paper") else name
        )
        drawn = name in (*SHOWN, SINGLE_LEAK)
        curves.append(curve(name, ramps, forces, meaning, drawn=drawn))
    return panel("fig6_ramps", *curves)


_ALONG: Final = 81
"""Frequencies of figure 7."""


def figure_7(own: Tabulated | None) -> Panel:
    """Mean force over frequency on a thin coating, the skins that rise and saturate before the others."""
    forces = {}
    for name, skin in compute.force_skins().items():
        frequency, forces[name] = compute.frequency_force(skin.material, samples=_ALONG)
    low, high = (forces.pop(name) for name in MOIST)
    moist = span("palmar 20 uS, women to men", frequency, low, high)
    curves = [
        curve("Gabriel wet", frequency, forces.pop("Gabriel wet"), "Gabriel wet", kind="bold"),
        replace(moist, look=look("palmar men 2 uS")),
        *(behind(name, frequency, force, "other published skins, and the paper's point") for name, force in forces.items()),
    ]  # fmt: skip
    if own is not None:
        _, force = compute.frequency_force(own, samples=_ALONG)
        curves.append(curve("your table", frequency, force, "your table", kind="points"))
    return panel("fig7", *curves)
