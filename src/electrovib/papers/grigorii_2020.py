"""R. V. Grigorii, J. E. Colgate: friction per current of electroadhesion, and a bare finger, 2020 and 2021.

IEEE Transactions on Haptics, doi:10.1109/TOH.2020.2972350 and doi:10.1109/TOH.2021.3130091. The lateral forces of two
vibrating displays of the same laboratory (Mullenbach 2016, Xu 2019) are declared here too.

Claims: friction per drive current is 0.041 W^-0.63 N/mA with the load W from 0.15 to 1.25 N, R2 0.62; a bare finger without
a drive has a coefficient of 0.34 to 0.45 at 0.53 N. Does not claim: coating, area, carrier frequency, current and the number of
people (the articles were not read, only the authors' public code and one file of data).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from electrovib.core.citation import Check
from electrovib.papers import cited_as, not_read, shultz_2018, veijgen_2013
from electrovib.papers.vezzoli_2014.measured import ROUGH_GAP
from electrovib.scenario import Scenario
from electrovib.studies.evidence import Measurement, between
from electrovib.studies.evidence.quantities import coefficient, steady

CITATIONS, CITATION = cited_as(__name__)
STATUS = "in part"
NOT_READ = not_read(__name__)

GROUP = "Northwestern (Colgate and Peshkin)"
LAW, EXPONENT = 41.0, -0.63
"""Friction per current at 1 N [N/A], and its power of the load [1]."""
LOADS = (0.15, 0.25, 0.5, 1.0, 1.25)
_NOT_PRINTED = "not printed"
FINGER = {
    "friction.coefficient": between(0.3, 1.0, _NOT_PRINTED, model="Uniform"),
    "stack.gap.thickness": between(5e-7, 1e-5, "not printed; of the order of the roughness of skin"),
    "stack.insulator.thickness": between(5e-7, 1e-5, "not printed; coatings of touchscreens"),
}
"""What the publications of this line do not print of a finger on a display."""
DISPLAY = FINGER | {"drive.frequency": between(1e3, 5e4, "not printed; a carrier")}


def per_current(load: float) -> float:
    """Return the friction per current [N/A] at a load [N], the authors' fit."""
    return LAW * math.pow(load, EXPONENT)


def friction_per_current(scenario: Scenario) -> float:
    """Compute the friction that the attraction adds over the amplitude of a sine of current [N/A].

    The area is that under the load; at a given current a larger area lowers the attraction, which then adds little to it.
    """
    from electrovib.solve.electrics.attraction import mean_force
    from electrovib.solve.stack.expand import phasors

    area = scenario.contact.gross_area(scenario.load.normal_force)
    held = scenario.replace({"contact": {"model": "FixedArea", "area": area}})
    current: float = scenario.drive.amplitude  # type: ignore[attr-defined]
    section = phasors(held, np.array([scenario.drive.frequency]))  # type: ignore[attr-defined]
    pull = mean_force(held, section, amplitude=current)[0]
    load, real = np.asarray(scenario.load.normal_force), np.asarray(0.0)
    law = steady(scenario)
    added = law.lateral_force(load, pull, real) - law.lateral_force(load, np.asarray(0.0), real)
    return float(added) / current


def measurements() -> dict[str, Measurement]:
    """Return friction per current over load, a bare finger, and the lateral forces of two vibrating displays."""
    return {"per_current": over_load(), "bare_swipe": bare_swipe(), **vibrating()}


def over_load() -> Measurement:
    """Return the friction per current over the load."""
    return Measurement(
        title="friction per current, over load",
        source="Grigorii 2020, plot label in the authors' public code",
        scenario=shultz_2018.scenarios()["sliding"].replace(
            {"drive": {"model": "CurrentSine", "amplitude": 1e-3, "frequency": 2e4}}
        ),
        quantity=friction_per_current,
        unit="N/A",
        over="load.normal_force",
        at=LOADS,
        values=tuple(per_current(each) for each in LOADS),
        spread=(0.3,) * len(LOADS),
        spread_of="a choice",
        group=GROUP,
        how="data file",
        status="in part",
        judges="contact",
        unknown=DISPLAY
        | {
            "drive.amplitude": between(3e-4, 1e-2, "not printed; some mA"),
            "contact.area": between(5e-5, 2e-4, "not printed; a fingertip"),
        },
        of_model={
            "GrowingArea": {
                "contact.area": between(5e-5, 2e-4, "not printed; a fingertip"),
                "contact.at_force": between(0.4, 0.6, "the load of that area"),
                "contact.exponent": between(0.2, 0.9, "no source; 2/3 is a smooth sphere", model="Uniform"),
            }
        },
        note="Five points of a fit, 0.041 W^-0.63 N/mA, not five measurements: the spread is what its R2 of 0.62 leaves,"
        " a choice. The friction is linear in the current there, while the attraction is its square.",
    )


def bare_swipe() -> Measurement:
    """Return the coefficient of a bare finger without a drive."""
    return Measurement(
        title="coefficient of a bare finger without a drive, one swipe",
        source="Grigorii 2021, public data",
        scenario=veijgen_2013.bare(0.527),
        quantity=coefficient,
        unknown={
            "load.normal_force": between(
                0.523, 0.530, "", model="Uniform", source="Grigorii 2021, public data", status="in part"
            )
        },
        unit="1",
        values=(math.sqrt(0.34 * 0.45),),
        spread=(0.08,),
        spread_of="repeats",
        group=GROUP,
        how="data file",
        status="in part",
        judges="friction",
        note="0.34 to 0.45 within one swipe of one person, whose baseline drifts.",
        of_model=veijgen_2013.LAWS,
    )


def vibrating() -> dict[str, Measurement]:
    """Return the lateral forces of two displays that vibrate along the plate and attract in phase with it."""
    half = "The drive is on for half of each oscillation, so half of the friction that it adds is taken. "
    net: dict[str, Any] = {
        "quantity": "peak lateral_force", "unit": "N", "scale": 0.5, "group": GROUP, "how": "printed", "status": "abstract",
        "spread": (0.15,), "spread_of": "a choice", "unknown": FINGER | {"drive.level": between(50.0, 400.0, "not printed")},
        "of_model": ROUGH_GAP,
    }  # fmt: skip
    held = shultz_2018.scenarios()["sliding"].replace(
        {
            "drive": {"model": "Step", "level": 100.0},
            "load.normal_force": 0.0,
            "time": {"duration": 1e-4, "initial_state": {"model": "AtRest"}},
        }
    )
    return {
        "eshiver": Measurement(
            title="net lateral force, oscillation of 55 Hz along the plate",
            source="Mullenbach 2016 (eShiver), first page",
            scenario=held,
            values=(0.3,),
            on="artificial finger",
            note=f"{half}Voltage and load are not printed, and the coating is a Johnsen-Rahbek one.",
            **net,
        ),
        "ultrashiver": Measurement(
            title="net lateral force, oscillation of some 30 kHz along the plate",
            source="Xu 2019 (UltraShiver), abstract",
            scenario=held,
            values=(0.4,),
            note=f"{half}Voltage, load and coefficient are not printed.",
            **net,
        ),
    }


CHECKS = (
    Check(
        "friction per current at 0.5 N",
        expect=63.0,
        rtol=1e-2,
        source="the formula of the authors' plot label, two digits",
        compute=lambda: per_current(0.5),
        status="derived",
    ),
)
