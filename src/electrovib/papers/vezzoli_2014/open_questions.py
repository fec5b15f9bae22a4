"""What this paper leaves open, in plain words."""

from __future__ import annotations

from typing import Final

from electrovib.papers.vezzoli_2014 import values
from electrovib.study.reproduction import Page, Row

_PARAGRAPHS: Final = (
    "Circular numbers. The paper prints 7.7 ms and eps 1560, but not the resistivity, nor the frequency of"
    " either. The resistivity of 5.57e5 ohm m one computes from them is 7.7 ms written otherwise, and says"
    " nothing new. The cited skins give {tau_giraud} ms at 100 Hz. In the same way 2.5 mN fixes a"
    " ramp only once skin and plane are chosen: {trapezium_ramp} ms over those here. The curve of"
    " figure 6 is the electrostatic force, so a coefficient of friction is not in it.",
    "One skin does not serve both the 7.7 ms and figure 7. A rise from 100 Hz to 10 kHz needs a time constant"
    " at 100 Hz below about 1.5 ms on a thin coating; the set that gives 7.7 ms is flat there, and constant-phase"
    " skins through the same point fall. Wet and moist skins rise and saturate, but decay within a millisecond.",
    "What the decay identifies. On a thick film the insulator holds 99.5 % of the voltage, and what conducts"
    " in the skin cannot discharge it. If charge leaks from the finger across the interface, the field in the"
    " gap decays with tau = R_gap (C_gap + C_i) = eps0 rho_gap (1 + C_i/C_gap), whatever the skin does, within"
    " 0.5 %. Law (5) is recovered by such a stack with this time constant in place of the skin's; it is not"
    " derived from the skin. 7.7 ms needs rho_gap = 8.7e8 ohm m (1.7e9 if it belongs to the force). A time constant"
    " fitted on a thick film"
    " therefore identifies the interface and not the stratum corneum.",
    "The plane. Law (1) divides an energy by the geometric thickness. The finger separates from the plate in"
    " the gap, where the static force is 10.74 times larger (607.6 against 56.55 mN for a vanishing gap, 27.5"
    " mN for 100 um). The 'around 100 mN' of its reference 3 lie between. That the spread between persons comes from"
    " the thickness of their skin is a property of law (1): from 400 to 100 um, a range of our choice, it rises by a"
    " factor {spread_of_law_1}, the"
    " force in the gap by {spread_of_the_gap} %.",
    "The frequency in the time domain. Putting eps(f) and rho(f) into a formula for a pulse is not causal: the"
    " law as printed answers with {causality_residual} of its peak 1 ms before a 20 ms ramp begins,"
    " for dispersive skins. So it is kept for one sine at a time, and a causal law stands beside it, in which"
    " only direct conduction loses charge. That law stands on the conductivity at zero frequency alone, which"
    " no cited measurement of stratum corneum gives.",
    "The return path. The paper does not say whether the subject was grounded. A floating body of 100 to"
    " 400 pF leaves {return_path_film} of the force on the film, and"
    " {return_path_coating} on a coating of 1 um.",
    "The falling edge. The paper reports a difference on the discharging parts and suspects the sensor. Its sentence"
    " can be read in two ways, and each candidate answers for itself in the table below. Read as the falling ramp:"
    " one relaxation time and a long hold give two equal pulses, so the paper's own model cannot; made causal with a"
    " dispersive skin it gives a smaller second one, {falling_edge_asymmetry} over the skins here"
    " at ramps of 36 ms and a hold of 100 ms, with no new physics; sliding"
    " over fresh film lowers it the more the faster the finger, polarity turns it either way, an amplifier that"
    " sinks less than it sources lowers it; the relaxing sensor that the paper suspects and a viscoelastic skin"
    " hardly move it. Read as the decay during the hold: sliding keeps a plateau of the static force, a dispersive"
    " skin a slow tail, a leak that depends on polarity or field another time constant, and viscoelastic skin and"
    " the sensor their own relaxations.",
    "An experiment that would tell. A periodic trapezoidal pulse of equal halves gives exactly equal pulses under any linear"
    " law without a field held by fresh or charged film (largest difference here {periodic_trapezium} of"
    " the peak): what remains different is then polarity, the amplifier or sliding; a sensor or a skin that relaxes"
    " linearly leaves equal pulses equal. Inverting the drive turns over what knows its sign, which is polarity, the"
    " amplifier and charged film, and nothing else; changing the speed moves sliding and nothing else;"
    " neutralising the film leaves its charge out; recording the voltage at the plate shows the amplifier; a weight"
    " on the sensor shows the sensor.",
    "Figure 2 needs a gap that does not conduct. The lost charge of law (5) has no gap in it and would decay"
    " for a finger held off the plate too; the stack with air between stays constant, as measured.",
)
"""What is left open; the names in braces are those of rows, and of what `page` adds to them."""


def page(rows: tuple[Row, ...]) -> Page:
    """Write the page with the numbers of this run."""
    found = {row.id: row for row in rows}
    numbers = {
        name: f"{row.ours[0]:.3g} to {row.ours[1]:.3g}" if isinstance(row.ours, tuple) else f"{row.ours:.3g}"
        for name, row in found.items()
    }
    numbers["spread_of_law_1"] = f"{_number(found['thickness_spread_law_1']):.2f}"
    numbers["spread_of_the_gap"] = f"{100 * (_number(found['thickness_spread_gap']) - 1):.1f}"
    return Page(
        "What this paper leaves open", tuple(paragraph.format_map(numbers) for paragraph in _PARAGRAPHS)
    )


def findings(rows: tuple[Row, ...]) -> tuple[str, ...]:
    """Say what to take home, with the numbers of this run.

    Parameters
    ----------
    rows : tuple of Row
        Of this reproduction.

    Returns
    -------
    tuple of str
        Three sentences or two each.
    """
    found = {row.id: row for row in rows}
    force, ramp, attraction = (
        _interval(found[name]) for name in ("trapezium_force", "trapezium_ramp", "attraction_measured")
    )
    planes, decays = (found[name].ours for name in ("past_force", "tau_giraud_decay"))
    assert isinstance(planes, tuple)
    assert isinstance(decays, tuple)
    by_voltage, by_force = decays
    return (
        "The paper's two capacitances are reproduced; its force and its time constant cannot be, because it prints no ramp,"
        f" no resistivity and no friction. Over the published skins and two planes its trapezoidal pulse gives {force}"
        " mN of attraction"
        f" with a ramp of {values.RAMP * 1e3:g} ms, and 2.5 mN needs a ramp of {ramp} ms.",
        "Two of its comparisons set unlike things side by side. If its 7.7 ms is the time constant of the voltage, the force"
        " decays in"
        f" {by_voltage:.3g} ms, against 6 ms measured in a lateral force; if it already was the decay of the force,"
        f" {by_force:.2g} against"
        " 6 ms, the voltage decays in 15.4 ms. And its 2.5 mN are attraction, while the measured 2 to 5 mN are lateral force:"
        " divided by"
        f" a coefficient of friction, an attraction of {attraction} mN.",
        "A finger separates from the plate in the gap, and there the static force is"
        f" {planes[1] / planes[0]:.1f} times that of the paper's equation (1). On this film the skin alone cannot discharge the"
        " contact: a force that fades tells of charge that crosses the interface, not of the stratum corneum.",
    )


def _interval(row: Row) -> str:
    ours = row.ours
    return f"{ours[0]:.2g} to {ours[1]:.3g}" if isinstance(ours, tuple) else f"{ours:.3g}"


def _number(row: Row) -> float:
    assert isinstance(row.ours, (int, float))
    return float(row.ours)
