"""The paper's figures as data."""

from __future__ import annotations

import numpy as np

from electrovib.core.arrays import Real
from electrovib.papers.vezzoli_2014 import compute, decay, values
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
        id="fig2",
        title="Figure 2: finger held 100 um off the plate",
        caption="Attraction in the gap under a 0 to 1000 V trapezoidal pulse. A gap that does not conduct keeps the force"
        " constant,"
        " as measured; a gap that leaks with 8.7e8 ohm m, the leak that 7.7 ms in contact would need, loses it. A hand"
        " that trembles by a tenth of the gap, 8 times a second, gives oscillations such as the paper remarks. The paper"
        " prints neither gap nor voltage of this figure.",
        x=("time", "s"),
        y=("electrostatic force", "N"),
        curves=(
            Curve(label="gap does not conduct", x=time, y=trace.electrostatic_force.values),
            Curve(label="the hand trembles by 10 um", x=held.time.values, y=held.electrostatic_force.values),
            Curve(label="gap leaks, 8.7e8 ohm m", x=time, y=leaky.electrostatic_force.values, kind="dashed"),
        ),
    )


def _taus_over_frequency() -> list[Curve]:
    """Give the span of the cited skins, that of the constructed ones, and some of them one by one."""
    frequency = np.geomspace(10.0, 1e6, 201)
    skins = {key: skin for key, skin in compute.all_skins().items() if key != "vezzoli_2014/point"}
    taus = {key: time_constant(skin.material, frequency) for key, skin in skins.items()}

    def span(name: str, *, measured: bool) -> Curve:
        found = [taus[key] for key, skin in skins.items() if skin.reproduces_force == measured]
        return Curve(
            label=name, x=frequency, y=np.min(found, axis=0), upper=np.max(found, axis=0), kind="band"
        )

    return [
        span("all cited sets", measured=True),
        span("constructed, constant phase", measured=False),
        *(
            Curve(label=skin.name, x=frequency, y=taus[key])
            for key, skin in skins.items()
            if skin.name in SHOWN
        ),
    ]


def figure_4(own: Tabulated | None) -> Panel:
    """Time constant of the stratum corneum over frequency."""
    curves = _taus_over_frequency()
    if own is not None:
        rows = own.table()[0]
        curves.append(Curve(label="your table", x=rows, y=time_constant(own, rows), kind="points"))
    ends = np.array([10.0, 1e6])
    readings = {
        "7.7 ms: the paper's, if of the voltage": decay.BY_VOLTAGE,
        "15.4 ms: the paper's 7.7 ms, if of the force": decay.BY_FORCE,
        "12 ms: the measured 6 ms, of the force": decay.MEASURED,
    }
    curves += [
        Curve(label=words, x=ends, y=np.full(2, reading.tau), kind="dashed")
        for words, reading in readings.items()
    ]
    return Panel(
        id="fig4",
        title="Figure 4: time constant of the stratum corneum over frequency",
        caption="tau = eps0 eps rho from the cited skin sets: the decay of a voltage. A force decays twice as fast, so the"
        " measured 6 ms of a lateral force stand here as 12 ms, and the paper's 7.7 ms as 7.7 or 15.4 ms. The paper drew it from"
        " Yamamoto and Yamamoto 1976, whose table"
        " could not be obtained: none of these curves is that data, and the constructed ones go through the paper's"
        " own point. With a table of your own: electrovib reproduce --skin table.csv.",
        x=("frequency", "Hz"),
        y=("time constant", "s"),
        curves=tuple(curves),
        log_x=True,
        log_y=True,
    )


def figure_6() -> Panel:
    """Force over time under the trapezoidal pulse."""
    cases = {
        "static law (1), nothing lost": (scenarios()["fig6_static"], "dashed"),
        "non-dispersive, 7.7 ms": (scenarios()["fig6"], "line"),
        "non-dispersive, 15.4 ms": (compute.point(decay.BY_FORCE.tau), "line"),
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
        curves.append(Curve(label=label, x=trace.time.values, y=trace.electrostatic_force.values, kind=kind))
    curves.insert(0, _measured(curves[0].x[[0, -1]]))
    return Panel(
        id="fig6",
        title="Figure 6: force under a 0 to 1000 V trapezium",
        caption="The paper prints no ramp; 36 ms is taken, with which law (1) and 7.7 ms of the voltage give its 2.5 mN. The"
        f" force drawn is the attraction. {_BAND} Values below 0.1 uN are not drawn.",
        x=("time", "s"),
        y=("electrostatic force", "N"),
        curves=tuple(curves),
        log_y=True,
        floor=FORCE_FLOOR,
    )


_BAND = (
    "The paper measured 2 to 5 mN of lateral force: divided by a coefficient of friction of 0.3 to 0.6, a choice, an"
    " attraction of 3.3 to 17 mN."
)


def _measured(ends: Real) -> Curve:
    """Draw the attraction behind the measured lateral force, from one end of the axis to the other."""
    low, high = values.attraction_of(values.FORCE_MEASURED)
    return Curve(
        label="measured 2 to 5 mN over friction",
        x=ends,
        y=np.full(2, low),
        upper=np.full(2, high),
        kind="band",
    )


def figure_6_ramps() -> Panel:
    """Peak force against the ramp the paper does not print."""
    ramps = np.geomspace(1e-4, 0.3, 15)
    curves = [_measured(ramps[[0, -1]])]
    for name, scenario in compute.figure_6_cases().items():
        if name in SHOWN or name in compute.LEAKY_GAPS or name == compute.POINT_BY_FORCE:
            forces = np.array([compute.peak_force(scenario, ramp=float(ramp)) for ramp in ramps])
            kind = "dashed" if name in compute.LEAKY_GAPS else "line"
            curves.append(Curve(label=name, x=ramps, y=forces, kind=kind))
    return Panel(
        id="fig6_ramps",
        title="Figure 6: which ramp would give the measured force",
        caption="Peak attraction of the trapezoidal pulse against its ramp, over skins under the causal law and over leaky"
        " gaps cut in"
        f" the gap. {_BAND} Any skin meets it at some ramp.",
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
        if name in SHOWN or name == "palmar women 20 uS":
            force = compute.frequency_force(skin.material, frequency)
            curves.append(Curve(label=name, x=frequency, y=force / force[-1]))
    if own is not None:
        force = compute.frequency_force(own, frequency)
        curves.append(Curve(label="your table", x=frequency, y=force / force[-1], kind="points"))
    return Panel(
        id="fig7",
        title="Figure 7: mean force over frequency on a thin coating, relative to 10 kHz",
        caption="Law as printed, tau = (C_i + C_sc) R_sc, coating of 1 um with eps 3.9 (not printed). Some skins rise and"
        " saturate as measured by Meyer, some peak and fall, the set that gives 7.7 ms is flat. Meyer's points are not"
        " drawn: they could not be obtained.",
        x=("frequency", "Hz"),
        y=("force relative to 10 kHz", "1"),
        curves=tuple(curves),
        log_x=True,
    )


def figure_7_thickness() -> Panel:
    """Force over frequency, band over the thickness of the skin."""
    frequency = np.geomspace(100.0, 1e4, 81)
    material = compute.force_skins()["palmar women 20 uS"].material
    thin, thick = values.THICKNESSES
    forces = {
        t: compute.frequency_force(material, frequency, thickness=t)
        for t in (thin, values.SKIN_THICKNESS, thick)
    }
    return Panel(
        id="fig7_thickness",
        title="Figure 7: band over the thickness of the stratum corneum",
        caption="Mean force under 100 V for 100 to 400 um (a choice of ours: the paper prints no range), palmar women 20 uS. Here"
        " law (1) makes thickness matter; cut in the"
        " gap, thickness hardly matters on a thick film.",
        x=("frequency", "Hz"),
        y=("mean electrostatic force", "N"),
        curves=(
            Curve(label="100 to 400 um", x=frequency, y=forces[thick], upper=forces[thin], kind="band"),
            Curve(label="200 um", x=frequency, y=forces[values.SKIN_THICKNESS]),
        ),
        log_x=True,
    )
