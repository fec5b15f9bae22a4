"""What the paper leaves open, and the main results."""

from __future__ import annotations

from typing import Final

from electrovib.core.answer import Page
from electrovib.papers.vezzoli_2014 import values
from electrovib.studies.reproduction import Row

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
    from electrovib.papers.vezzoli_2014.falling_edge import outcomes
    from electrovib.papers.vezzoli_2014.population import predicted

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
