"""Every number that the paper states beside ours, with what can be concluded from it; what is left open; main results."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from electrovib.core.answer import Page
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.falling_edge import outcomes
from electrovib.papers.vezzoli_2014.population import predicted
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
        *compute.decay_rows(),
        *_suspended(),
        *_trapezium(),
        *_figure_7(),
        *_surroundings(),
    )


def _own_reading() -> Row:
    """Return the force of figure 6 by the paper's own equations (1) and (5), without a solver."""
    ramp, tau = values.RAMP, values.TAU_MODEL
    own, by_force = (_by_equations(tau, ramp) / 1e-3 for tau in (tau, compute.BY_FORCE.tau))
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
        Row("thickness_spread_gap", f"Maxwell stress in the gap: force at {thin} um of skin over {thick} um", None, gap,
            "1", "ours", f"{chosen} On a thick film the skin's thickness hardly changes the force in the gap: that the"
            " spread between persons comes from thickness follows from law (1).", brief="hardly depends on the skin"),
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
    own = {compute.POINT_BY_FORCE, values.skins()["point"].name}
    gaps = [case for case in compute.figure_6() if case.name in compute.LEAKY_GAPS]
    cited = [case for case in compute.figure_6() if case.name not in own and case not in gaps]
    slippery, rough = values.FRICTION
    friction = f"a coefficient of friction of {slippery:g} to {rough:g}, a choice of ours"
    needed = _range(each / 1e-3 for each in values.attraction_of(values.FORCE_MEASURED))
    ramps = [reading.ramp(values.FORCE_MODEL) / 1e-3 for reading in (compute.BY_VOLTAGE, compute.BY_FORCE)]
    residuals = [
        compute.causality_residual(skin.material)
        for name, skin in compute.force_skins().items()
        if name.startswith(("palmar", "1963", "Gabriel wet"))
    ]
    return (
        *_under(cited, "law_1", "law (1), cited skins"),
        *_under(gaps, "gap", "Maxwell stress in leaky gaps of 1 and 5 um"),
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


def _under(cases: Sequence[compute.TrapeziumForce], name: str, law: str) -> tuple[Row, ...]:
    """Return what follows for figure 6 under one law, over the skins or gaps that are known for it."""
    printed, force = values.FORCE_MODEL / 1e-3, _range(case.force / 1e-3 for case in cases)
    return (
        Row(f"trapezium_force_{name}", f"peak attraction under the trapezoidal pulse, {law}", printed, force, "mN",
            verdict_over(printed, force), "The paper prints no ramp; 36 ms is taken. Each case is in the table by skin.",
            brief="ramp not printed, 36 ms taken"),
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
    shapes = compute.figure_7().values()
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


_PARAGRAPHS: Final = (
    "Circular numbers. The paper prints 7.7 ms and eps 1560, but neither the resistivity nor the frequency of either value. The"
    " resistivity of 5.57e5 ohm m that follows from them contains no further information. The cited skins give {tau_giraud} ms"
    " at 100 Hz. Likewise, 2.5 mN determines a ramp only once a skin, or a leaky gap, is chosen: {trapezium_ramp_law_1} ms over"
    " the cited skins under law (1), {trapezium_ramp_gap} ms in leaky gaps. The curve of figure 6 is the"
    " electrostatic force, so it contains no coefficient of friction.",
    "No single skin gives both 7.7 ms and figure 7. A rise from 100 Hz to 10 kHz on a thin coating needs a time constant below"
    " about 1.5 ms at 100 Hz. The set that gives 7.7 ms is flat there, and skins of constant phase through the same point fall."
    " Wet and moist skins rise and saturate, but their force decays within a millisecond.",
    "Voltage or force. The paper compares its 7.7 ms with a lateral force that decays in 6 ms. If 7.7 ms is the time constant of"
    " the voltage, the decays are 3.85 and 6 ms as forces, 7.7 and 12 ms as voltages; if it is already the decay of the force,"
    " they are 7.7 and 6 ms as forces, 15.4 and 12 ms as voltages. With one relaxation time every ramp, resistivity and leak is"
    " proportional to it; a dispersive skin has no single one. Lateral forces are divided by a coefficient of friction of"
    " {friction}, a choice of ours, as the paper prints none.",
    "What the decay identifies. On a thick film the insulator holds 99.5 % of the voltage, and conduction in the skin cannot"
    " discharge it. If charge leaks from the finger across the interface, the field in the gap decays with tau = R_gap (C_gap +"
    " C_i) = eps0 rho_gap (1 + C_i/C_gap), independent of the skin within 0.5 %. Such a stack gives law (5) with this time"
    " constant in place of the skin's; the law does not follow from the skin. 7.7 ms needs rho_gap = 8.7e8 ohm m (1.7e9 if it"
    " belongs to the force). A time constant fitted on a thick film therefore identifies the interface and not the stratum"
    " corneum.",
    "The surface on which the Maxwell stress is evaluated. Law (1) divides an energy by the geometric thickness. Finger and plate"
    " separate in the gap, where the static force is 10.74 times larger (607.6 compared with 56.55 mN for a vanishing gap, 27.5"
    " mN for 100 um). The 'around 100 mN' of its reference 3 lie between. That the spread between persons comes from the"
    " thickness of their skin is a property of law (1): from 400 to 100 um, a range of our choice, its force rises by a factor"
    " of {spread_of_law_1}, the force in the gap by {spread_of_the_gap} %.",
    "The spread between subjects. Eight fingers drawn from the population 'fingers' give {population_law_1} mN of lateral force"
    " under law (1) and {population_gap} mN with the Maxwell stress in a leaky gap, for a ramp of 36 ms; measured are 2 to 5 mN."
    " Under both laws the resistivities of dry and moist fingers hold most of the variance and the thickness of the stratum"
    " corneum next to none of it (population.csv); of dry fingers alone it holds {thickness_of_dry} % under law (1). The"
    " distributions of the resistivities are of low confidence, and that of a leaky gap is a choice: it has the time constants of"
    " the stratum corneum.",
    "Dispersion in the time domain. A formula for a pulse that contains eps(f) and rho(f) is not causal: for dispersive skins the"
    " law as printed gives {causality_residual} of its peak 1 ms before a ramp of 20 ms begins. It is therefore used for one"
    " sine at a time, beside a causal law in which only direct conduction loses charge. That law depends on the conductivity at"
    " zero frequency alone, which no cited measurement of stratum corneum gives.",
    "The return path. The paper does not state whether the subject was grounded. A floating body of 100 to 400 pF reduces the"
    " force to {return_path_film} of its value on the film, and to {return_path_coating} on a coating of 1 um.",
    "The falling edge. The paper reports a difference on the discharging parts and suspects the sensor. Its sentence has two"
    " readings; the table lists each candidate cause alone. If the falling ramp is meant: one relaxation time and a long hold"
    " give two equal pulses, so the paper's own model shows no difference. Made causal with a dispersive skin it gives a smaller"
    " second pulse, {falling_edge_asymmetry_law_1} over the skins here at ramps of 36 ms and a hold of 100 ms, without further"
    " physics. Sliding over fresh film reduces it, the more the faster the finger; polarity increases or reduces it; an"
    " amplifier that sinks less than it sources reduces it; the relaxing sensor that the paper suspects and a viscoelastic skin"
    " hardly change it. If the decay during the hold is meant: sliding keeps a plateau of the static force, a dispersive skin a"
    " slow tail; a leak that depends on polarity or field gives another time constant; viscoelastic skin and sensor add their"
    " own relaxations. A charge that neither leaks nor is carried away would add an offset to the effective voltage: 5, 10 and"
    " 20 % of it give ratios of 0.82, 0.67 and 0.44.",
    "An experiment that would decide. A periodic trapezoidal pulse of equal halves gives exactly equal pulses under any linear"
    " law without a field of fresh or charged film (largest difference here {periodic_trapezium} of the peak). A difference that"
    " remains is due to polarity, the amplifier or sliding; a sensor or a skin that relaxes linearly leaves equal pulses equal."
    " Inverting the drive inverts the effects that depend on its sign: polarity, the amplifier and charged film. Changing the"
    " speed changes only the effect of sliding. Neutralising the film removes its charge; recording the voltage at the plate"
    " shows the amplifier; a weight on the sensor shows the sensor.",
    "Figure 2 needs a gap that does not conduct. The lost charge of law (5) involves no gap and would decay for a finger held off"
    " the plate too; the stack with air between finger and film keeps its force, as measured. The leak of 8.7e8 ohm m in the"
    " figure is the one that 7.7 ms in contact would need. A hand that trembles by a tenth of the gap, 8 times a second, gives"
    " oscillations such as those that the paper mentions.",
    "The other figures. Figure 4: the measured 6 ms of a lateral force correspond to 12 ms of a voltage, the paper's 7.7 ms to"
    " 7.7 or 15.4 ms; the constructed skins pass through the paper's own point. Figure 6: a ramp of 36 ms gives 2.5 mN with law"
    " (1) and 7.7 ms of the voltage; the measured 2 to 5 mN of lateral force correspond to an attraction of 3.3 to 17 mN; values"
    " below 0.1 uN are not drawn. Figure 7: tau = (C_i + C_sc) R_sc; some skins rise and saturate as measured by Meyer, some"
    " have a maximum, the set that gives 7.7 ms is flat. The falling edge: values below 1e-3 of the peak are not drawn; with"
    " polarity the ratio of the pulses is {polarity}, whatever the hold.",
)
"""Explanations in full; the names in braces are those of rows, and of what `page` adds to them."""
_BRIEF: Final = (
    "Circular numbers: 5.57e5 ohm m follows from 7.7 ms and eps 1560, and 2.5 mN determines a ramp only once a skin is chosen.",
    "No single skin gives both 7.7 ms and figure 7: skins that rise and saturate lose their force within a millisecond.",
    "The decay identifies the interface: on this film a force fades only if charge crosses the interface, with tau = eps0 rho_gap"
    " (1 + C_i/C_gap), which does not contain the skin. 7.7 ms needs rho_gap = 8.7e8 ohm m.",
    "Dispersion: with eps(f) and rho(f) the law as printed responds before the pulse begins. It is used for one sine at a time,"
    " beside a causal law.",
    "The falling edge: the paper suspects the sensor. A dispersive skin in its own model already gives a smaller second pulse.",
    "An experiment that would decide: under a periodic trapezoidal pulse of equal halves only polarity, the amplifier or sliding"
    " makes the two pulses differ; inverting the drive, changing the speed and recording the plate voltage separate these.",
    "Figure 2 needs a gap that does not conduct; law (5) would decay.",
)
"""Explanations on the page."""


def page(rows: tuple[Row, ...]) -> Page:
    """Write the explanations with the numbers of this run, in full and shortened."""
    found = {row.id: row for row in rows}
    numbers = {
        name: f"{row.ours[0]:.3g} to {row.ours[1]:.3g}" if isinstance(row.ours, tuple) else f"{row.ours:.3g}"
        for name, row in found.items()
    }
    numbers["spread_of_law_1"] = f"{_number(found['thickness_spread_law_1']):.2f}"
    numbers["spread_of_the_gap"] = f"{100 * (_number(found['thickness_spread_gap']) - 1):.1f}"
    numbers["friction"] = "{:g} to {:g}".format(*values.FRICTION)
    of_dry = predicted("dry")[0].shares["stack.stratum_corneum.thickness"][0]
    numbers["thickness_of_dry"] = f"{100 * of_dry:.0f}"
    weaker, stronger = (outcomes()[f"positive pulses {word}"].ratio for word in ("weaker", "stronger"))
    numbers["polarity"] = f"{weaker:.3g} or {stronger:.2g}"
    return Page(
        "What the paper leaves open",
        tuple(paragraph.format_map(numbers) for paragraph in _PARAGRAPHS),
        id="open_questions",
        brief=_BRIEF,
    )


def findings(rows: tuple[Row, ...]) -> tuple[str, ...]:
    """State the main results with the numbers of this run."""
    found = {row.id: row for row in rows}
    eight, skins, decay, attraction = (
        _interval(found[name])
        for name in ("population_law_1", "tau_giraud", "tau_giraud_measured", "attraction_measured")
    )
    static, decays = (found[name].ours for name in ("past_force_gap", "tau_giraud_decay"))
    assert isinstance(static, tuple)
    assert isinstance(decays, tuple)
    by_voltage, by_force = decays
    return (
        "Published skins disagree with the paper under its own law (1): eight fingers drawn from them feel"
        f" {eight} mN of lateral force at a ramp of {values.RAMP * 1e3:g} ms, and 2 to 5 mN were measured; the time constants"
        f" are {skins} ms, and it calculates 7.7 ms; the force decays in {decay} ms, and 6 ms were measured. Both capacitances"
        " are reproduced.",
        f"Two comparisons involve different quantities. A force decays twice as fast as its voltage: in {by_voltage:.3g} ms if"
        f" 7.7 ms is of the voltage ({by_force:.2g} ms if of the force), compared with 6 ms measured. And 2.5 mN is an"
        f" attraction, while the measured 2 to 5 mN are lateral force, an attraction of {attraction} mN.",
        "Finger and plate separate in the gap, where the static force is"
        f" {static[1] / _number(found['past_force_law_1']):.1f} times that of equation (1). On this film a force that fades"
        " shows charge crossing the interface, not the conduction of the stratum corneum.",
    )


def _interval(row: Row) -> str:
    ours = row.ours
    return f"{ours[0]:.2g} to {ours[1]:.3g}" if isinstance(ours, tuple) else f"{ours:.3g}"


def _number(row: Row) -> float:
    assert isinstance(row.ours, (int, float))
    return float(row.ours)
