"""Every number that the paper states beside ours, with what can be concluded from it."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.values import scenarios
from electrovib.physics.drive.edges import Step
from electrovib.solve.electrics.transient import transient
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes
from electrovib.studies.reproduction import Row

CHOSEN: Final[Mapping[str, Any]] = {"inputs": "chosen"}
MILLI: Final = 1e-3
ROUNDING: Final = 1e-12
"""Largest relative difference of an equation from the solved stack that is rounding alone."""


@functools.cache
def rows() -> tuple[Row, ...]:
    """Return all rows, in the order of the paper."""
    return (
        *_static(),
        *_suspended(),
        *_capacitances(),
        *_equations(),
        *compute.decay_rows(),
        _own_reading(),
        *_trapezium(),
        *_figure_7(),
        *_surroundings(),
    )


def _own_reading() -> Row:
    """Return the force of figure 6 by the paper's own equations (1) and (5), without a solver."""
    ramp, tau = values.RAMP, values.TAU_MODEL
    own, by_force = (_by_equations(tau, ramp) / MILLI for tau in (tau, compute.BY_FORCE.tau))
    return Row("own_reading", "peak attraction under the trapezoidal pulse, the paper's own reading: equations (1) and (5),"
        f" {tau / MILLI:g} ms, ramp of {ramp / MILLI:g} ms", values.FORCE_MODEL / MILLI, own, "mN", "open",
        f"The paper prints no ramp: {ramp / MILLI:g} ms is chosen so that its equations give its 2.5 mN with 7.7 ms as the time"
        f" constant of the voltage, so their agreement is no evidence. With 7.7 ms as the decay of the force it gives"
        f" {by_force:.3g} mN.", leads=True, place="section 4, figure 6", **CHOSEN)  # fmt: skip


def _by_equations(tau: float, ramp: float) -> float:
    """Return the attraction [N] at the end of a ramp [s], for a time constant of the effective voltage [s]."""
    effective = tau / ramp * -float(np.expm1(-ramp / tau))  # over the voltage
    return values.static_force(voltage=values.VOLTAGE) * effective**2


def _capacitances() -> tuple[Row, ...]:
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    tau = (film + skin) * values.SKIN_THICKNESS / (values.CONDUCTIVITY * values.AREA)
    ratio = tau / (eps0 * values.SKIN_PERMITTIVITY / values.CONDUCTIVITY)
    with_body, without = (
        compute.peak_force(scenarios()["fig6"].replace(_body(each)), ramp=values.RAMP) for each in (1e3, 0.0)
    )
    return (
        Row("C_i", "capacitance of the insulator", values.PRINTED_C_I / 1e-12, film / 1e-12, "pF", "reproduced",
            "The paper truncates; rounding gives 33.", place="section 3.1, equation (3)"),
        Row("C_sc", "capacitance of the stratum corneum", values.PRINTED_C_S / 1e-9, skin / 1e-9, "nF", "reproduced", "",
            place="section 3.1, equation (3)"),
        Row("capacitance_ratio", "C_sc over C_i", None, skin / film, "1", "consistent", "", "C_sc >> C_i", place="section 3.1",
            agrees=(10.0, np.inf)),
        Row("equation_3", "(C_i + C_sc) R_sc over eps0 eps rho", None, ratio, "1", "consistent",
            "The thick-film form is smaller by C_i/C_sc.", "tau = C_sc R_sc = eps0 eps rho", place="section 3.1, equation (3)",
            agrees=(0.99, 1.01)),
        Row("deeper_tissue", "part of the peak attraction of figure 6 that a body of 1 kohm takes", None,
            1 - with_body / without, "1", "consistent", "The resistance is a choice of ours; the paper prints none.",
            "resistivity of deeper tissue neglected", place="section 3.1", agrees=(-0.01, 0.01), **CHOSEN),
    )  # fmt: skip


def _body(resistance: float) -> dict[str, float]:
    return {"circuit.return_path.resistance": resistance}


def _equations() -> tuple[Row, ...]:
    """Check the equations against the solved stack of film and skin, which does not use them."""
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    tau = (film + skin) * values.SKIN_THICKNESS / (values.CONDUCTIVITY * values.AREA)
    scenario = scenarios()["fig6"].replace(_body(0.0))
    section, _ = modes(scenario)
    effective = scenario.force.effective_voltage(section)
    assert effective is not None
    wanted = {"v_e": effective, "v_sc": section["stratum_corneum"].field * values.SKIN_THICKNESS}
    wanted |= {"D_i": section["insulator"].displacement, "D_s": section["stratum_corneum"].displacement}
    time = np.linspace(0.0, 5 * tau, 501)
    answer = transient(wanted, Step(level=1.0), time)
    faded = np.exp(-time / tau)
    charge = answer["D_s"] * values.AREA
    lost = (answer["D_i"] - answer["D_s"]) * values.AREA
    share = film / (film + skin)
    stepped = simulate(scenario.replace({"drive": {"model": "Step", "level": values.VOLTAGE}}), time=time)
    static = values.static_force(voltage=values.VOLTAGE)
    friction = scenario.to_dict()["friction"]["coefficient"]
    lateral = friction * (scenario.load.normal_force + static * faded**2)
    held = compute.static_force("EffectiveMedium")
    note = "Largest relative difference from the solved stack of two layers after a step of the voltage; 0 is exact."
    found = {
        "1": ("static attraction", held / static - 1, "section 2.2"),
        "2": ("voltage of the stratum corneum", (answer["v_sc"] - share * faded) / share, "section 3.1"),
        "4": ("sum of the voltages", charge * (1 / film + 1 / skin) + lost / film - 1, "section 3.2"),
        "5": ("effective voltage", answer["v_e"] - faded, "section 3.2"),
        "6": ("lateral force", stepped.lateral_force.values / lateral - 1, "section 3.2"),
    }
    left = compute.over_hold(scenario)
    return (
        *(
            Row(f"equation_{number}", f"equation ({number}), {what}", None, float(np.max(np.abs(miss))), "1", "consistent",
                note, f"equation ({number})", place=f"{section}, equation ({number})", agrees=(0.0, ROUNDING))
            for number, (what, miss, section) in found.items()
        ),
        Row("third_configuration", "attraction after a hold of 100 ms over that before it", None, left, "1", "consistent",
            "The hold is a choice of ours.", "no force in the third configuration", place="section 3.2, figure 5",
            agrees=(0.0, 0.01), **CHOSEN),
    )  # fmt: skip


def _static() -> tuple[Row, ...]:
    force = values.static_force(voltage=values.VOLTAGE)
    vanishing, micron = (compute.static_force("MaxwellStressInGap", gap=gap) for gap in (None, 1e-6))
    past = values.FORCE_PAST
    law, gap = (
        compute.static_force(name, skin=values.THICKNESSES[0])
        / compute.static_force(name, skin=values.THICKNESSES[1])
        for name in ("EffectiveMedium", "MaxwellStressInGap")
    )
    thin, thick = (f"{1e6 * thickness:g}" for thickness in values.THICKNESSES)
    chosen = (
        f"{thin} to {thick} um is a choice of ours: the paper refers to its reference 7 and prints no range."
    )
    elsewhere = "Measured in reference 3 of the paper, whose film, voltage and area are not printed."
    smallest, largest = values.FORCE_MEASURED
    return (
        Row("past_force_law_1", "attraction at 1000 V on the printed film, law (1)", past / MILLI, force / MILLI, "mN", "open",
            f"{elsewhere} On the film of figure 6 law (1) gives {past / force:.2g} times less.", place="section 2.1"),
        Row("past_force_gap", "the same, Maxwell stress in gaps of 1 um to a vanishing one", past / MILLI,
            (micron / MILLI, vanishing / MILLI), "mN", "open", f"{elsewhere} On the film of figure 6 a gap of 1 um gives"
            f" {micron / past:.2g} times more and a vanishing one {vanishing / past:.2g} times.", place="section 2.1", **CHOSEN),
        Row("static_force_1000V", "static force of equation (1) at 1000 V", None, force / MILLI, "mN", "check",
            "From the printed inputs; the paper prints no such force.", place="section 2.2, equation (1)"),
        Row("gap_over_law_1", "static force in a vanishing gap over that of equation (1)", None, vanishing / force, "1", "ours",
            "(T_s + T_i)/(T_s/eps_s + T_i/eps_i): equation (1) divides an energy by the geometric thickness; finger and plate"
            " separate in the gap.", place="section 2.2, equation (1)"),
        Row("thickness_spread_law_1", f"law (1): force at {thin} um of skin over {thick} um", None, law,
            "1", "open", f"{chosen} The measured forces differ by a factor of {largest / smallest:g}; in law (1) the difference"
            " comes from the geometric thickness.", "the variability of the stratum corneum can explain that of the force",
            place="section 4", **CHOSEN),
        Row("thickness_spread_gap", f"Maxwell stress in the gap: force at {thin} um of skin over {thick} um", None, gap,
            "1", "ours", f"{chosen} On a thick film the skin's thickness hardly changes the force in the gap.", place="section 4",
            **CHOSEN),
    )  # fmt: skip


def _suspended() -> tuple[Row, ...]:
    off = scenarios()["fig2"]
    leaking = compute.over_hold(off.replace(compute.leaky_air(8.7e8)))
    given: dict[str, Any] = {"place": "section 2.2, figure 2", **CHOSEN}
    return (
        Row("static_constant", "equation (1): force after a hold over that before it", None,
            compute.over_hold(scenarios()["fig6_static"]), "1", "consistent", "Without the body: exactly 1.",
            "a constant force if the voltage is constant", place="section 2.2, equation (1)", agrees=(0.99, 1.01)),
        Row("suspended_force_constant", "figure 2: force after a hold of 1 s over that before it", None,
            compute.over_hold(off), "1", "consistent", "The stack with a gap that does not conduct. Law (5) contains no gap"
            " and would decay. The gap is not printed: 100 um is taken.", "roughly constant force at constant voltage",
            agrees=(0.9, 1.1), **given),
        Row("suspended_oscillation", "figure 2: largest over smallest force in the hold, hand trembling by 10 um in 100 um", None,
            compute.oscillation(), "1", "consistent", "The paper prints neither gap nor tremor.",
            "oscillations due to the hand", agrees=(1.01, np.inf), **given),
        Row("suspended_force_leaky", "figure 2: the same ratio, gap that leaks with 8.7e8 ohm m", None, leaking, "1", "check",
            "With a leak no force would be left: the constant force of figure 2 shows that air between finger and film does not"
            " leak.", **given),
    )  # fmt: skip


def _trapezium() -> tuple[Row, ...]:
    own = {compute.POINT_BY_FORCE, values.skins()["point"].name}
    gaps = [case for case in compute.figure_6() if case.name in compute.LEAKY_GAPS]
    published = [case for case in compute.figure_6() if case.name not in own and case not in gaps]
    slippery, rough = values.FRICTION
    needed = _range(each / MILLI for each in values.attraction_of(values.FORCE_MEASURED))
    printed = values.FORCE_MODEL / MILLI
    ramps = [reading.ramp(values.FORCE_MODEL) / MILLI for reading in (compute.BY_VOLTAGE, compute.BY_FORCE)]
    residuals = [
        compute.causality_residual(skin.material)
        for name, skin in compute.force_skins().items()
        if name.startswith(("palmar", "1963", "Gabriel wet"))
    ]
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    shortest = (
        film * skin / (film + skin) * values.VOLTAGE / scenarios()["fig6"].to_dict()["limits"]["current"]
    )
    return (
        *_under(published, "law_1", "law (1), published skins", "published"),
        *_under(gaps, "gap", "Maxwell stress in leaky gaps of 1 and 5 um", "chosen"),
        Row("attraction_measured", "attraction behind the measured lateral force", printed, needed, "mN", "open",
            "The paper compares its 2.5 mN of attraction with 2 to 5 mN of lateral force, and prints neither load nor coefficient"
            f" of friction: {slippery:g} to {rough:g} is a choice of ours, with which 2.5 mN are {slippery * printed:g} to"
            f" {rough * printed:g} mN of lateral force. With law (1) 2.5 mN need a ramp of {ramps[0]:.3g} ms if 7.7 ms belongs to"
            f" the voltage, {ramps[1]:.3g} ms if it belongs to the force.", place="section 4, figure 6", **CHOSEN),
        Row("causality_residual", "law as printed: share of the peak 1 ms before a ramp of 20 ms", None,
            (min(residuals), max(residuals)), "1", "ours",
            "Real capacitances that depend on frequency are not causal; the paper does not state how it computed its curve.",
            place="section 4, figure 6", inputs="published"),
        Row("shortest_ramp", "shortest ramp that 250 uA allow on the printed film", None, shortest / MILLI, "ms", "ours",
            "Without stray capacitance, which makes it longer.", place="section 4"),
    )  # fmt: skip


def _under(cases: Sequence[compute.TrapeziumForce], name: str, law: str, inputs: str) -> tuple[Row, ...]:
    """Return what follows for figure 6 under one law, over the skins or gaps that are known for it."""
    given: dict[str, Any] = {"place": "section 4, figure 6", "inputs": inputs}
    return (
        Row(f"trapezium_force_{name}", f"peak attraction under the trapezoidal pulse, {law}", values.FORCE_MODEL / MILLI,
            _range(case.force / MILLI for case in cases), "mN", "open",
            "The paper prints no ramp; 36 ms is taken. Each case is in the table by skin.", **given),
        Row(f"trapezium_ramp_{name}", f"ramp that would give 2.5 mN of attraction, {law}", None,
            _range(case.ramp / MILLI for case in cases), "ms", "ours", "Each case is in the table by skin.", **given),
        Row(f"falling_edge_asymmetry_{name}", f"force after the falling edge over that after the rising edge, {law}", None,
            _range(case.edges for case in cases), "1", "open",
            "The paper states only that the discharging parts differ, not how nor by how much: this may mean the ramp or the"
            " hold. One relaxation time gives nearly equal pulses, a dispersive skin a smaller second one.",
            "model and measurement differ on the discharging parts", **given),
    )  # fmt: skip


def _figure_7() -> tuple[Row, ...]:
    shapes = {
        name: shape for name, shape in compute.figure_7().items() if name != values.skins()["point"].name
    }
    agree = [name for name, shape in shapes.items() if shape.words.startswith("consistent")]
    note = (
        f"From 100 Hz to 10 kHz {len(agree)} of {len(shapes)} published skins rise and saturate; each is in the table by skin."
        " The paper prints no insulator, voltage, area or load: a coating of 1 um with eps 3.9 is taken."
    )
    thin, thick = values.THICKNESSES
    frequency = np.geomspace(100.0, 1e4, 21)
    ratios = [
        compute.frequency_force(material, frequency, thickness=thin)
        / compute.frequency_force(material, frequency, thickness=thick)
        for material in (compute.force_skins()[name].material for name in agree)
    ]
    coating = values.capacitance(
        permittivity=values.COATING_PERMITTIVITY, thickness=values.COATING_THICKNESS, area=values.AREA
    )
    given: dict[str, Any] = {"place": "section 4, figure 7", "inputs": "published"}
    stated = "an increasing and a successive saturation"
    return (
        Row("fig7_rise", "figure 7, F(10 kHz)/F(100 Hz), published skins", None, _range(s.rise for s in shapes.values()), "1",
            "open", note, stated, **given),
        Row("fig7_saturation", "figure 7, F(10 kHz)/largest F, published skins", None,
            _range(s.saturation for s in shapes.values()), "1", "open", note, stated, **given),
        Row("fig7_thickness", f"figure 7, force at {1e6 * thin:g} um of skin over {1e6 * thick:g} um, rising skins",
            None, _range(float(each) for ratio in ratios for each in ratio), "1", "open",
            "Law (1) from 100 Hz to 10 kHz. Neither the thicknesses nor the size of the dispersion are printed.",
            "the dispersion is well explained by the variability of the thickness", **given),
        Row("fig7_capacitances", "figure 7, C_i over C_sc", None, coating / values.skin_capacitance(), "1", "open",
            "The coating of 1 um with eps 3.9 is chosen for this; the paper prints none.", "C_i and C_sc comparable",
            place="section 4, figure 7", **CHOSEN),
    )  # fmt: skip


def _surroundings() -> tuple[Row, ...]:
    film = scenarios()["fig6_static"]
    coating = scenarios()["fig7"].replace({"force.model": "EffectiveMedium"})
    what = "force of a floating body of 100 to 400 pF over that of a grounded one, {}"
    return tuple(
        Row(f"return_path_{name}", what.format(words), None,
            _range(compute.floating_factor(scenario, capacitance=each) for each in (100e-12, 400e-12)), "1", "ours",
            "The paper does not state whether the subject was grounded.", place=place, **CHOSEN)
        for name, words, scenario, place in (
            ("film", "film", film, "section 4, figure 6"),
            ("coating", "coating of 1 um", coating, "section 4, figure 7"),
        )
    )  # fmt: skip


def _range(numbers: Iterable[float]) -> tuple[float, float]:
    kept = list(numbers)
    return (min(kept), max(kept))
