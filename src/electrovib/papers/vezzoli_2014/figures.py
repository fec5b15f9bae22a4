"""The paper's figures as data."""

from __future__ import annotations

import numpy as np

from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.physics.skin import time_constant
from electrovib.physics.tabulated import Tabulated
from electrovib.solve.simulate import simulate
from electrovib.study.reproduction import Curve, Panel

SHOWN = ("paper point", "palmar men 2 uS", "palmar men 20 uS", "1963 impedance", "Gabriel wet", "Gabriel dry")
"""Skins drawn one by one; all are in the bands and in the tables."""
FORCE_FLOOR = 1e-7
"""Below it figure 6 draws nothing [N]: a logarithm has no end, a sensor has."""


def panels(own: Tabulated | None) -> tuple[Panel, ...]:
    """Give all figures; `own` is a user's skin, drawn beside the published ones."""
    return (
        figure_2(),
        figure_4(own),
        figure_6(),
        figure_6_ramps(),
        figure_7_skins(own),
        figure_7_thickness(),
    )


def figure_2() -> Panel:
    """Finger held off the plate."""
    trace = simulate(scenarios()["fig2"])
    leak = scenarios()["fig2"].replace(
        {"stack.gap.material": {"model": "Constant", "permittivity": 1.0, "conductivity": 1 / 8.7e8}}
    )
    leaky = simulate(leak)
    held = simulate(scenarios()["fig2_tremor"])
    time = trace.time.values
    return Panel(
        "fig2",
        "Figure 2: finger held 100 um off the plate",
        "Attraction in the gap under a 0 to 1000 V trapezium. A gap that does not conduct keeps the force constant,"
        " as measured; a gap that leaks with 8.7e8 ohm m, the leak that 7.7 ms in contact would need, loses it. A hand"
        " that trembles by a tenth of the gap, 8 times a second, gives oscillations such as the paper remarks. The paper"
        " prints neither gap nor voltage of this figure.",
        ("time", "s"),
        ("electrostatic force", "N"),
        (
            Curve("gap does not conduct", time, trace.electrostatic_force.values),
            Curve("the hand trembles by 10 um", held.time.values, held.electrostatic_force.values),
            Curve("gap leaks, 8.7e8 ohm m", time, leaky.electrostatic_force.values, kind="dashed"),
        ),
    )


def figure_4(own: Tabulated | None) -> Panel:
    """Time constant of the stratum corneum over frequency."""
    frequency = np.geomspace(10.0, 1e6, 201)
    skins = compute.all_skins()
    taus = {
        key: time_constant(skin.material, frequency)
        for key, skin in skins.items()
        if key != "vezzoli_2014/point"
    }
    measured = [taus[key] for key in taus if skins[key].reproduces_force]
    made = [taus[key] for key in taus if not skins[key].reproduces_force]
    curves = [
        Curve("all cited sets", frequency, np.min(measured, axis=0), np.max(measured, axis=0), "band"),
        Curve(
            "constructed, constant phase",
            frequency,
            np.min(made, axis=0),
            np.max(made, axis=0),
            "band",
        ),
    ]
    shown = [key for key in taus if skins[key].name in SHOWN]
    curves += [Curve(skins[key].name, frequency, taus[key]) for key in shown]
    if own is not None:
        rows = own.table()[0]
        curves.append(Curve("your table", rows, time_constant(own, rows), kind="points"))
    ends = np.array([10.0, 1e6])
    curves.append(Curve("7.7 ms, the paper's model", ends, np.full(2, values.TAU_MODEL), kind="dashed"))
    curves.append(Curve("6 ms, measured", ends, np.full(2, values.TAU_MEASURED), kind="dashed"))
    return Panel(
        "fig4",
        "Figure 4: time constant of the stratum corneum over frequency",
        "tau = eps0 eps rho from the cited skin sets. The paper drew it from Yamamoto and Yamamoto 1976, whose table"
        " could not be obtained: none of these curves is that data, and the constructed ones go through the paper's"
        " own point. With a table of your own: electrovib reproduce --skin table.csv.",
        ("frequency", "Hz"),
        ("time constant", "s"),
        tuple(curves),
        log_x=True,
        log_y=True,
    )


def figure_6() -> Panel:
    """Force over time under the trapezium."""
    cases = {
        "static law (1), nothing lost": (scenarios()["fig6_static"], "dashed"),
        "non-dispersive, 7.7 ms": (scenarios()["fig6"], "line"),
        "leaky gap 1 um, cut in the gap": (compute.leaky_gap(1e-6), "line"),
    }
    skins = compute.force_skins()
    for name in SHOWN[1:4]:
        cases[f"dispersive causal, {name}"] = (
            compute.with_skin(scenarios()["fig6"], skins[name].material),
            "line",
        )
    curves = []
    for label, (scenario, kind) in cases.items():
        trace = simulate(scenario)
        force = trace.electrostatic_force.values
        shown = np.where(force >= FORCE_FLOOR, force, np.nan)
        curves.append(Curve(label, trace.time.values, shown, kind=kind))
    low, high = values.FORCE_MEASURED
    time = curves[0].x[[0, -1]]
    curves.insert(0, Curve("measured, 2 to 5 mN", time, np.full(2, low), np.full(2, high), "band"))
    return Panel(
        "fig6",
        "Figure 6: force under a 0 to 1000 V trapezium",
        "The paper prints no ramp; 36 ms is taken, with which law (1) and 7.7 ms give its 2.5 mN. Values below"
        " 0.1 uN are not drawn.",
        ("time", "s"),
        ("electrostatic force", "N"),
        tuple(curves),
        log_y=True,
    )


def figure_6_ramps() -> Panel:
    """Peak force against the ramp the paper does not print."""
    ramps = np.geomspace(1e-4, 0.3, 15)
    low, high = values.FORCE_MEASURED
    curves = [Curve("measured, 2 to 5 mN", ramps[[0, -1]], np.full(2, low), np.full(2, high), "band")]
    for name, scenario in compute.figure_6_cases().items():
        if name in SHOWN or name in compute.LEAKY_GAPS:
            forces = np.array([compute.peak_force(scenario, ramp=float(ramp)) for ramp in ramps])
            kind = "dashed" if name in compute.LEAKY_GAPS else "line"
            curves.append(Curve(name, ramps, forces, kind=kind))
    return Panel(
        "fig6_ramps",
        "Figure 6: which ramp would give the measured force",
        "Peak force of the trapezium against its ramp, over skins under the causal law and over leaky gaps cut in the"
        " gap. Any skin meets 2 to 5 mN at some ramp.",
        ("ramp", "s"),
        ("peak electrostatic force", "N"),
        tuple(curves),
        log_x=True,
        log_y=True,
    )


def figure_7_skins(own: Tabulated | None) -> Panel:
    """Force over frequency on a thin coat, relative to 10 kHz."""
    frequency = np.geomspace(100.0, 1e4, 81)
    curves = []
    for name, skin in compute.force_skins().items():
        if name in SHOWN or name == "palmar women 20 uS":
            force = compute.frequency_force(skin.material, frequency)
            curves.append(Curve(name, frequency, force / force[-1]))
    if own is not None:
        force = compute.frequency_force(own, frequency)
        curves.append(Curve("your table", frequency, force / force[-1], kind="points"))
    return Panel(
        "fig7",
        "Figure 7: mean force over frequency on a thin coat, relative to 10 kHz",
        "Law as printed, tau = (C_i + C_sc) R_sc, coat of 1 um with eps 3.9 (not printed). Some skins rise and"
        " saturate as measured by Meyer, some peak and fall, the set that gives 7.7 ms is flat. Meyer's points are not"
        " drawn: they could not be obtained.",
        ("frequency", "Hz"),
        ("force relative to 10 kHz", "1"),
        tuple(curves),
        log_x=True,
    )


def figure_7_thickness() -> Panel:
    """Force over frequency, band over the thickness of the skin."""
    frequency = np.geomspace(100.0, 1e4, 81)
    material = compute.force_skins()["palmar women 20 uS"].material
    forces = {t: compute.frequency_force(material, frequency, thickness=t) for t in (100e-6, 200e-6, 400e-6)}
    return Panel(
        "fig7_thickness",
        "Figure 7: band over the thickness of the stratum corneum",
        "Mean force under 100 V for 100 to 400 um, palmar women 20 uS. Here law (1) makes thickness matter; cut in the"
        " gap, thickness hardly matters on a thick film.",
        ("frequency", "Hz"),
        ("mean electrostatic force", "N"),
        (
            Curve("100 to 400 um", frequency, forces[400e-6], forces[100e-6], "band"),
            Curve("200 um", frequency, forces[200e-6]),
        ),
        log_x=True,
    )
