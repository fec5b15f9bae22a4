"""The paper's figures as data, in which the same thing has one colour."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Panel
from electrovib.core.arrays import Real
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.physics.skin import time_constant
from electrovib.physics.tabulated import Tabulated
from electrovib.scenario import Scenario
from electrovib.solve.simulate import simulate

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


SHOWN = ("paper point", "palmar men 2 uS", "1963 impedance", "Gabriel wet", "Gabriel dry")
"""Skins drawn one by one; all are in the ranges, in the tables and in the files of the curves."""
OF_FIGURE_6 = ("palmar men 2 uS", "1963 impedance")
"""Dispersive skins drawn in figure 6."""
FORCE_FLOOR = 1e-7
"""Smallest force that figure 6 draws [N]."""
SINGLE_LEAK = "Maxwell stress in the gap, leaky gap 1 um"


def panels(own: Tabulated | None) -> tuple[Panel, ...]:
    """Return all figures; `own` is a user's skin, drawn beside the published ones."""
    return (figure_2(), figure_4(own), figure_6(), figure_6_ramps(), figure_7_skins(own))


def figure_2() -> Panel:
    """Force on a finger held off the plate, over time."""
    trace = simulate(scenarios()["fig2"])
    leak = scenarios()["fig2"].replace(
        {"stack.gap.material": {"model": "Constant", "permittivity": 1.0, "conductivity": 1 / 8.7e8}}
    )
    leaky = simulate(leak)
    held = simulate(scenarios()["fig2_tremor"])
    time = trace.time.values
    return Panel(
        id="fig2",
        title="Figure 2: finger held 100 um off the plate",
        caption="Without conduction in the gap the force stays constant, as measured; a leak of 8.7e8 ohm m, which 7.7 ms would"
        " need, discharges it. Gap and voltage: not printed.",
        x=("time", "s"),
        y=("electrostatic force", "N"),
        curves=(
            curve("gap does not conduct", time, trace.electrostatic_force.values, "no conduction"),
            curve(
                "the same, the hand trembles by 10 um",
                held.time.values,
                held.electrostatic_force.values,
                "trembling hand",
            ),
            curve("gap leaks, 8.7e8 ohm m", time, leaky.electrostatic_force.values, "leaky gap"),
        ),
    )


def _taus_over_frequency() -> list[Curve]:
    """Return the range of the cited skins, that of the constructed ones, and each skin."""
    frequency = np.geomspace(10.0, 1e6, 201)
    skins = {key: skin for key, skin in compute.all_skins().items() if key != "vezzoli_2014/point"}
    taus = {key: time_constant(skin.material, frequency) for key, skin in skins.items()}

    def span(name: str, *, measured: bool) -> Curve:
        found = [taus[key] for key, skin in skins.items() if skin.reproduces_force == measured]
        low, high = np.min(found, axis=0), np.max(found, axis=0)
        return Curve(label=name, x=frequency, y=low, upper=high, kind="band", look=REFERENCE, drawn=measured)

    return [
        span("all cited skins", measured=True),
        span("constructed skins of constant phase", measured=False),
        *(
            curve(
                skin.name,
                frequency,
                taus[key],
                skin.name,
                drawn=skin.name in SHOWN and skin.name != "Gabriel wet",
            )
            for key, skin in skins.items()
        ),
    ]


def figure_4(own: Tabulated | None) -> Panel:
    """Time constant of the stratum corneum over frequency."""
    curves = _taus_over_frequency()
    if own is not None:
        rows = own.table()[0]
        curves.append(curve("your table", rows, time_constant(own, rows), "your table", kind="points"))
    ends = np.array([10.0, 1e6])
    of_voltage, of_force = (np.full(2, reading.tau) for reading in (compute.BY_VOLTAGE, compute.BY_FORCE))
    curves += [
        curve(
            "paper: 7.7 ms, or 15.4 ms if of the force",
            ends,
            of_voltage,
            "paper point",
            upper=of_force,
            kind="band",
        ),
        curve(
            "12 ms: the measured 6 ms, of the force",
            ends,
            np.full(2, compute.MEASURED.tau),
            "paper point",
            kind="dashed",
            drawn=False,
        ),
    ]
    return Panel(
        id="fig4",
        title="Figure 4: time constant of the stratum corneum over frequency",
        caption="tau = eps0 eps rho, the decay of a voltage; a force decays twice as fast. The paper used the table of Yamamoto"
        " and Yamamoto 1976, which could not be obtained: no curve is that data.",
        x=("frequency", "Hz"),
        y=("time constant", "s"),
        curves=tuple(curves),
        log_x=True,
        log_y=True,
    )


def _cases_of_figure_6() -> dict[str, tuple[Scenario, str, str]]:
    """Return the scenarios of figure 6 by their labels, each with its line and what its colour stands for."""
    found = {
        "law (1), no charge lost": (scenarios()["fig6_static"], "dashed", "no conduction"),
        "7.7 ms, not dispersive": (scenarios()["fig6"], "line", "paper point"),
        "15.4 ms, not dispersive": (compute.point(compute.BY_FORCE.tau), "dashed", "paper point"),
        "Maxwell stress in a leaky gap of 1 um": (compute.leaky_gap(1e-6), "line", "leaky gap"),
    }
    for name, skin in compute.force_skins().items():
        if name != "paper point":
            scenario = compute.with_skin(scenarios()["fig6"], skin.material)
            found[f"causal law, {name}"] = (scenario, "line", name)
    return found


def figure_6() -> Panel:
    """Force over time under the trapezoidal pulse."""
    curves = []
    for label, (scenario, kind, meaning) in _cases_of_figure_6().items():
        trace = simulate(scenario)
        drawn = meaning in OF_FIGURE_6 or label in (
            "law (1), no charge lost",
            "7.7 ms, not dispersive",
            "Maxwell stress in a leaky gap of 1 um",
        )
        time, force = trace.time.values, trace.electrostatic_force.values
        curves.append(curve(label, time, force, meaning, kind=kind, drawn=drawn))
    curves.insert(0, measured_range(curves[0].x[[0, -1]]))
    return Panel(
        id="fig6",
        title="Figure 6: force under a trapezoidal pulse of 0 to 1000 V",
        caption=f"Attraction, ramp of 36 ms. {_BAND}",
        x=("time", "s"),
        y=("electrostatic force", "N"),
        curves=tuple(curves),
        log_y=True,
        floor=FORCE_FLOOR,
    )


_BAND = (
    "Range: the measured 2 to 5 mN of lateral force over a coefficient of friction of 0.3 to 0.6, a choice."
)


def measured_range(ends: Real) -> Curve:
    """Return the attraction behind the measured lateral force, from one end of the axis to the other."""
    low, high = values.attraction_of(values.FORCE_MEASURED)
    return Curve(
        label="measured 2 to 5 mN over friction coefficient",
        x=ends,
        y=np.full(2, low),
        upper=np.full(2, high),
        kind="band",
        look=REFERENCE,
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
        drawn = (name in SHOWN and name != "Gabriel wet") or name == SINGLE_LEAK
        curves.append(curve(name, ramps, forces, meaning, drawn=drawn))
    return Panel(
        id="fig6_ramps",
        title="Figure 6: ramp that would give the measured force",
        caption="Range as above. Every skin reaches it with some ramp.",
        x=("ramp", "s"),
        y=("peak electrostatic force", "N"),
        curves=tuple(curves),
        log_x=True,
        log_y=True,
    )


def figure_7_skins(own: Tabulated | None) -> Panel:
    """Force over frequency on a thin coating, relative to 10 kHz."""
    frequency = np.geomspace(100.0, 1e4, 81)
    curves = []
    for name, skin in compute.force_skins().items():
        force = compute.frequency_force(skin.material, frequency)
        curves.append(curve(name, frequency, force / force[-1], name, drawn=name in SHOWN))
    if own is not None:
        force = compute.frequency_force(own, frequency)
        curves.append(curve("your table", frequency, force / force[-1], "your table", kind="points"))
    return Panel(
        id="fig7",
        title="Figure 7: mean force over frequency on a thin coating, relative to 10 kHz",
        caption="Law as printed; coating of 1 um with eps 3.9, not printed. Meyer's points could not be obtained.",
        x=("frequency", "Hz"),
        y=("force relative to 10 kHz", "1"),
        curves=tuple(curves),
        log_x=True,
    )
