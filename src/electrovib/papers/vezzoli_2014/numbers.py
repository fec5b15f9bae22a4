"""Every number that the paper states beside ours, with what can be concluded from it."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import by_skin, compute, decay, values
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.physics.drive.edges import Step
from electrovib.solve.electrics.transient import transient
from electrovib.solve.stack.expand import modes
from electrovib.studies.reproduction import Row, verdict_over


@functools.cache
def rows() -> tuple[Row, ...]:
    """Return all rows, in the order of the paper."""
    return (
        _own_reading(),
        *_capacitances(),
        *_equations(),
        *_static(),
        *decay.rows(),
        *_suspended(),
        *_trapezium(),
        *_figure_7(),
        *_surroundings(),
    )


def _own_reading() -> Row:
    """Return the force of figure 6 by the paper's own equations (1) and (5), without a solver."""
    ramp, tau = values.RAMP, values.TAU_MODEL
    own, by_force = (_by_equations(tau, ramp) / 1e-3 for tau in (tau, decay.BY_FORCE.tau))
    return Row("own_reading", "peak attraction under the trapezoidal pulse, the paper's own reading: equations (1) and (5),"
        f" {tau / 1e-3:g} ms, ramp of {ramp / 1e-3:g} ms", values.FORCE_MODEL / 1e-3, own, "mN", "open",
        f"The paper prints no ramp: {ramp / 1e-3:g} ms is chosen so that its equations give its 2.5 mN with 7.7 ms as the time"
        f" constant of the voltage, so their agreement is no evidence. With 7.7 ms as the decay of the force it gives"
        f" {by_force:.3g} mN.", brief="ramp not printed; 36 ms is chosen for it", leads=True)  # fmt: skip


def _by_equations(tau: float, ramp: float) -> float:
    """Return the attraction [N] at the end of a ramp [s], for a time constant of the effective voltage [s]."""
    effective = tau / ramp * -float(np.expm1(-ramp / tau))  # over the voltage
    return values.static_force(voltage=values.VOLTAGE) * effective**2


def _capacitances() -> tuple[Row, ...]:
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    return (
        Row("C_i", "capacitance of the insulator", 32.0, film / 1e-12, "pF", "reproduced",
            "The paper truncates 32.96; rounding gives 33.", brief="truncated in the paper"),
        Row("C_sc", "capacitance of the stratum corneum", 6.9, skin / 1e-9, "nF", "reproduced", ""),
        Row("capacitance_ratio", "C_sc over C_i", None, skin / film, "1", "consistent",
            "Hence tau = C_sc R_sc is within 0.5 % of (C_i + C_sc) R_sc on this film.", "C_sc >> C_i", brief="large"),
    )  # fmt: skip


def _equations() -> tuple[Row, ...]:
    """Check equations (2) to (5) against the solved stack of film and skin, which does not use them."""
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    resistance = values.SKIN_THICKNESS / (values.CONDUCTIVITY * values.AREA)
    tau = (film + skin) * resistance
    scenario = scenarios()["fig6"].replace({"circuit.return_path.resistance": 0.0})
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
    residual_2 = np.max(np.abs(answer["v_sc"] - film / (film + skin) * faded)) / (film / (film + skin))
    residual_4 = np.max(np.abs(charge * (1 / film + 1 / skin) + lost / film - 1))
    residual_5 = np.max(np.abs(answer["v_e"] - faded))
    ratio = tau / (eps0 * values.SKIN_PERMITTIVITY / values.CONDUCTIVITY)
    note = "Largest difference from the solved stack of two layers after a step of 1 V; 0 is exact."
    same = "residual"
    return (
        Row("equation_2", "equation (2), voltage of the stratum corneum", None, float(residual_2), "1", "check", note,
            brief=same),
        Row("equation_3", "exact tau over that of equation (3)", None, float(ratio), "1", "check",
            "The thick-film form is smaller by C_i/C_sc.", brief="1 + C_i/C_sc"),
        Row("equation_4", "equation (4), sum of the voltages", None, float(residual_4), "1", "check", note, brief=same),
        Row("equation_5", "equation (5), effective voltage", None, float(residual_5), "1", "check", note, brief=same),
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
    elsewhere = "film and voltage of its reference 3 are not printed"
    thin, thick = (f"{1e6 * thickness:g}" for thickness in values.THICKNESSES)
    chosen = (
        f"{thin} to {thick} um is a choice of ours: the paper refers to its reference 7 and prints no range."
    )
    return (
        Row("past_force_law_1", "attraction at 1000 V on the printed film, law (1)", past / 1e-3, force / 1e-3, "mN", "open",
            "Section 2.1 states 'around 100 mN', measured in reference 3 of the paper, without film, voltage or area. Law (1)"
            f" gives {past / force:.2g} times less on the film of figure 6.", brief=elsewhere),
        Row("past_force_gap", "the same, Maxwell stress in gaps of 1 um to a vanishing one", past / 1e-3,
            (micron / 1e-3, vanishing / 1e-3), "mN", "open",
            f"The same measurement. A gap of 1 um gives {micron / past:.2g} times more and a vanishing one"
            f" {vanishing / past:.2g} times, on the film of figure 6.", brief=elsewhere),
        Row("static_force_1000V", "static force of equation (1) at 1000 V", None, force / 1e-3, "mN", "check",
            f"From the printed inputs; the paper prints no such force. The Maxwell stress in the gap gives"
            f" {vanishing / 1e-3:.4g} mN, {vanishing / force:.4g} times more.", brief="from the printed inputs"),
        Row("thickness_spread_law_1", f"law (1): force at {thin} um of skin over {thick} um", None, law,
            "1", "open", f"{chosen} The measured forces differ by a factor of 2.5; in law (1) the difference comes from the"
            " geometric thickness.", "skin thickness can explain the spread of 2 to 5 mN", brief="thicknesses not printed"),
        Row("thickness_spread_gap", "the same, Maxwell stress in the gap", None, gap, "1", "ours",
            f"{chosen} On a thick film the skin's thickness hardly changes the force in the gap: that the spread between"
            " persons comes from thickness follows from law (1), not from the field.", brief="hardly depends on the skin"),
    )  # fmt: skip


def _suspended() -> tuple[Row, ...]:
    constant, leaking = (
        compute.suspended_constancy(conductivity=0.0),
        compute.suspended_constancy(conductivity=1 / 8.7e8),
    )
    what = "figure 2: force after a hold of 1 s over that before it"
    return (
        Row("suspended_force_constant", what, None, constant, "1", "consistent",
            "The stack with a gap that does not conduct. Law (5) contains no gap and would decay. The gap is not printed: 100 um"
            " is taken.", "roughly constant force at constant voltage", brief="gap of 100 um, not printed"),
        Row("suspended_force_leaky", "figure 2: the same ratio, gap that leaks with 8.7e8 ohm m", None, leaking, "1", "check",
            "With a leak no force would be left: the constant force of figure 2 shows that air between finger and film does not"
            " leak.", brief="a leak would leave no force"),
    )  # fmt: skip


def _trapezium() -> tuple[Row, ...]:
    slippery, rough = values.FRICTION
    friction = f"a coefficient of friction of {slippery:g} to {rough:g}, a choice of ours"
    needed = _range(each / 1e-3 for each in values.attraction_of(values.FORCE_MEASURED))
    ramps = [reading.ramp(values.FORCE_MODEL) / 1e-3 for reading in (decay.BY_VOLTAGE, decay.BY_FORCE)]
    residuals = [
        compute.causality_residual(skin.material)
        for name, skin in compute.force_skins().items()
        if name.startswith(("palmar", "1963", "Gabriel wet"))
    ]
    return (
        *_under(by_skin.cited(), "law_1", "law (1), cited skins"),
        *_under(by_skin.leaky(), "gap", "Maxwell stress in leaky gaps of 1 and 5 um"),
        Row("attraction_measured", "attraction behind the measured lateral force", None, needed, "mN", "ours",
            f"The measured 2 to 5 mN divided by {friction}. The paper compares its 2.5 mN of attraction with the lateral force:"
            f" as lateral force they are {slippery * 2.5:g} to {rough * 2.5:g} mN. With law (1) 2.5 mN need a ramp of"
            f" {ramps[0]:.3g} ms if 7.7 ms belongs to the voltage, {ramps[1]:.3g} ms if it belongs to the force.",
            brief="with the same friction"),
        Row("causality_residual", "law as printed: share of the peak 1 ms before a ramp of 20 ms", None,
            (min(residuals), max(residuals)), "1", "ours",
            "Real capacitances that depend on frequency are not causal; the paper does not state how it computed its curve.",
            brief="computation in time not printed"),
    )  # fmt: skip


def _under(cases: Sequence[by_skin.TrapeziumForce], name: str, law: str) -> tuple[Row, ...]:
    """Return what follows for figure 6 under one law, over the skins or gaps that are known for it."""
    slippery, rough = values.FRICTION
    printed, measured = values.FORCE_MODEL / 1e-3, _range(each / 1e-3 for each in values.FORCE_MEASURED)
    force = _range(case.force / 1e-3 for case in cases)
    lateral = (slippery * force[0], rough * force[1])
    return (
        Row(f"trapezium_force_{name}", f"peak attraction under the trapezoidal pulse, {law}", printed, force, "mN",
            verdict_over(printed, force), "The paper prints no ramp; 36 ms is taken. Each case is in the table by skin.",
            brief="ramp not printed, 36 ms taken"),
        Row(f"trapezium_force_measured_{name}", f"peak lateral force under the pulse, measured; {law}", measured, lateral, "mN",
            verdict_over(measured, lateral), f"Here, the attraction of {law} times a coefficient of friction of {slippery:g} to"
            f" {rough:g}, a choice of ours; the paper prints neither ramp nor friction.",
            brief=f"friction not printed, {slippery:g} to {rough:g} taken"),
        Row(f"trapezium_ramp_{name}", f"ramp that would give 2.5 mN of attraction, {law}", None,
            _range(case.ramp / 1e-3 for case in cases), "ms", "ours", "Not printed; each case is in the table by skin.",
            brief="not printed"),
        Row(f"falling_edge_asymmetry_{name}", f"force after the falling edge over that after the rising edge, {law}", None,
            _range(case.edges for case in cases), "1", "open",
            "The paper states only that the discharging parts differ, not how nor by how much: this may mean the ramp or the"
            " hold. One relaxation time gives nearly equal pulses, a dispersive skin a smaller second one.",
            "model and measurement differ on the discharging parts", brief="size of the difference not printed"),
    )  # fmt: skip


def _figure_7() -> tuple[Row, ...]:
    shapes = by_skin.figure_7().values()
    stated = "increases, then saturates"
    agree = sum(shape.words.startswith("consistent") for shape in shapes)
    note = (
        f"The paper states 'an increasing and a successive saturation' from 100 Hz to 10 kHz. {agree} of {len(shapes)} skins rise"
        " and saturate; each in the table by skin. The paper prints no insulator, voltage, area or load: a coating of 1 um with"
        " eps 3.9 is taken."
    )
    some = f"{agree} of {len(shapes)} skins do both"
    return (
        Row("fig7_rise", "figure 7, F(10 kHz)/F(100 Hz)", None, _range(s.rise for s in shapes), "1", "open", note, stated,
            brief=some),
        Row("fig7_saturation", "figure 7, F(10 kHz)/largest F", None, _range(s.saturation for s in shapes), "1", "open",
            note, stated, brief=some),
    )  # fmt: skip


def _surroundings() -> tuple[Row, ...]:
    film, coating = (
        scenarios()["fig6_static"],
        scenarios()["fig7"].replace({"force.model": "EffectiveMedium"}),
    )
    found = []
    what = "force of a floating body of 100 to 400 pF over that of a grounded one, film"
    for name, scenario in (("film", film), ("coating", coating)):
        factors = tuple(
            compute.floating_factor(scenario, capacitance=capacitance) for capacitance in (100e-12, 400e-12)
        )
        found.append(
            Row(
                f"return_path_{name}",
                what if name == "film" else "the same, coating of 1 um",
                None,
                (min(factors), max(factors)),
                "1",
                "ours",
                "The paper does not state whether the subject was grounded.",
                brief="grounding not printed",
            )
        )
    return tuple(found)


def _range(numbers: Iterable[float]) -> tuple[float, float]:
    kept = list(numbers)
    return (min(kept), max(kept))
