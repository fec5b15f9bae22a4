"""J. Rosell et al., "Skin impedance from 1 Hz to 1 MHz", IEEE Transactions on Biomedical Engineering 35, 649, 1988.

doi:10.1109/10.4599. Resistances of palm and fingertip that other laboratories measured are declared here too, each with its own
group; and how much sliding raises the impedance of a finger on a display.

Claims: the impedance of 1 cm2 of gelled skin at ten sites of thorax, leg and forehead is 10 kohm to 1 Mohm at 1 Hz, 220 ohm at
100 kHz and 120 ohm at 1 MHz, ten people. Does not claim: fingertips, a thickness, the share of the tissue below the skin, which
is most of what is left at 1 MHz.
"""

from __future__ import annotations

import math
from typing import Any

from electrovib.core.citation import Check
from electrovib.papers import cited_as, not_read, shultz_2018
from electrovib.scenario import Scenario
from electrovib.studies.evidence import Measurement, between
from electrovib.studies.evidence.quantities import magnitude, of_skin

CITATIONS, CITATION = cited_as(__name__)
STATUS = "abstract"
NOT_READ = not_read(__name__)

AREA = 1e-4
"""Area that the two impedances are for, printed [m2]."""
PALM = 170e3
"""Resistance of 1 cm2 of palm at its lowest loss of water [ohm]."""

_THICKNESS = "stack.stratum_corneum.thickness"
THIN = {_THICKNESS: between(1.1e-5, 2.3e-5, "stratum corneum of the trunk, 11 to 23 um by biopsy and Raman")}
"""Thickness of the stratum corneum of the trunk and limbs."""
THICK = {_THICKNESS: between(1.5e-4, 4e-4, "palm 173 um (Egawa 2007), a finger pad some 300 um in one image")}
"""Thickness of the stratum corneum of palms and finger pads."""
BODY = {
    "circuit.return_path.resistance": between(
        490.0,
        770.0,
        "",
        source="hand to hand and hand to foot, 55 Hz to 100 kHz, 35 men (ISH 2015)",
        status="abstract",
    )
}
"""Resistance of the body inside."""


def sliding_over_rest(scenario: Scenario) -> float:
    """Compute the impedance of a sliding finger over that of the same finger without a gap."""
    layers = {name: layer for name, layer in scenario.stack.layers.items() if name != "gap"}
    return magnitude(scenario) / magnitude(scenario.replace({"stack": layers}))


def measurements() -> dict[str, Measurement]:
    """Return impedances and resistances of skin, and the rise of the impedance as a finger slides."""
    return {**gelled(), **palm_and_finger(), "sliding": sliding()}


def gelled() -> dict[str, Measurement]:
    """Return the impedance of gelled skin at three frequencies."""
    tissue = {"circuit.return_path.resistance": between(20.0, 300.0, "tissue below the skin, not printed")}
    site: dict[str, Any] = {"source": "Rosell 1988, abstract", "group": "Rosell", "unknown": THIN | tissue}
    return {
        "low": of_skin(
            "impedance of 1 cm2 of gelled skin at 1 Hz",
            {1.0: 1e5},
            spread=(1.5,),
            spread_of="people",
            note="Printed are 10 kohm to 1 Mohm over ten people and sites: the geometric mean, and the deviation of this range.",
            **site,
        ),
        "high": of_skin(
            "impedance of 1 cm2 of gelled skin at high frequencies",
            {1e5: 220.0, 1e6: 120.0},
            spread=(0.2, 0.2),
            spread_of="a choice",
            note="Not fingertips. Most of the 120 ohm is tissue below the skin.",
            **site,
        ),
    }


def palm_and_finger() -> dict[str, Measurement]:
    """Return the resistances of a palm and of a fingertip."""
    return {
        "palm": of_skin(
            "resistance of 1 cm2 of palm at its lowest loss of water",
            PALM,
            source="Human eccrine sweat gland activity and palmar electrical skin resistance (1964), abstract",
            spread=(0.15,),
            spread_of="a choice",
            group="palmar resistance, 1964",
            unknown=THICK
            | BODY
            | {"drive.frequency": between(0.01, 10.0, "not printed; taken as nearly constant current")},
            note="The highest and most stable value of the driest palms; any moisture lowers it.",
        ),
        "fingertip": of_skin(
            "resistance of a fingertip, largest",
            320e3,
            source="electrotactile display, PMC2586184, abstract",
            spread=(0.3,),
            spread_of="a choice",
            on="finger",
            group="electrotactile display, PMC2586184",
            unknown=THICK
            | BODY
            | {
                "contact.area": between(3e-6, 1e-4, "not printed; a pin to a whole pad"),
                "drive.frequency": between(0.01, 10.0, "not printed; the resistive part"),
            },
            note="'Up to': the largest value, not a typical one.",
        ),
    }


def sliding() -> Measurement:
    """Return by how much sliding raises the impedance of a finger on a display."""
    return of_skin(
        "impedance of a sliding finger over that at rest",
        math.sqrt(2 * 11),
        scenario=shultz_2018.scenarios()["sliding"],
        quantity=sliding_over_rest,
        source="Shultz 2018, abstract",
        unit="1",
        spread=(0.55,),
        spread_of="a choice",
        on="finger",
        group="Northwestern (Colgate and Peshkin)",
        unknown=THICK
        | BODY
        | {
            "stack.gap.thickness": between(5e-7, 1e-5, "not printed; of the order of the roughness of skin"),
            "stack.insulator.thickness": between(5e-7, 1e-5, "not printed; coatings of touchscreens"),
            "drive.frequency": between(1e3, 1e5, "not printed; 'high applied frequencies'"),
        },
        note="Printed is a rise of 100 to 1000 %: its geometric mean, and the deviation of this range.",
    )


CHECKS = (
    Check(
        "resistivity of palm if 200 um hold all of its resistance",
        expect=8.5e4,
        rtol=1e-3,
        source="170 kohm of 1 cm2 over 200 um, computed by hand",
        compute=lambda: PALM * AREA / 200e-6,
        status="derived",
    ),
)
