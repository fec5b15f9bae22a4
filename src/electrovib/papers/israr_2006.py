"""A. Israr, S. Choi, H. Z. Tan: detection threshold of the vibration of a held pen, IROS 2006, 472.

Second-hand, as tabled in a public ledger of values on haptics (github.com/adambickerdike/Stabilisation_Pen), with the
thresholds of other laboratories that it quotes.

Claims: 26 um at 10 Hz, 8.5 um at 20 Hz, 0.06 um at 320 Hz, falling by 13 dB per octave from 10 to 160 Hz; ten people, forced
choice. Does not claim: a finger on a plate; zero to peak or root mean square, which the ledger does not say. The four lowest
thresholds differ fourfold by contact and posture, and from 10 to 20 Hz the tabled values fall by 9.7 dB only.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

from electrovib.core.citation import Check
from electrovib.papers import cited_as, not_read, shultz_2018
from electrovib.scenario import Scenario
from electrovib.studies.evidence import Measurement, between
from electrovib.studies.evidence.quantities import vibration_threshold

CITATIONS, CITATION = cited_as(__name__)
STATUS = "second-hand"
NOT_READ = not_read(__name__)

PEN = {10.0: 26e-6, 20.0: 8.5e-6, 320.0: 0.06e-6}
"""Threshold [m] over frequency [Hz]."""

SHARED = (
    "Likely cause: all channels have one threshold here, so that the non-Pacinian one, flat at low frequencies, hides the fall of"
    " the Pacinian one, and its plateau cannot lie higher. A threshold of each channel of one person, by masking, would decide."
)


def person() -> Scenario:
    """Return a set-up whose person has a threshold, with a sine of one frequency."""
    known = {"threshold": 1e-7, "threshold_uncertainty": 6.0}
    return shultz_2018.scenarios()["sliding"].replace({"perception": known, "drive.frequency": 250.0})


def fall(scenario: Scenario, *, low: float, high: float) -> float:
    """Compute the mean fall of the threshold per octave between two frequencies [dB]; NaN if one of them is not felt."""
    ends = [vibration_threshold(scenario.replace({"drive.frequency": each})) for each in (low, high)]
    return (
        float(20 * np.log10(ends[0] / ends[1]) / math.log2(high / low))
        if math.isfinite(max(ends))
        else math.nan
    )


def measurements() -> dict[str, Measurement]:
    """Return thresholds of vibration over frequency, and how they fall with it."""
    lowest = {
        "perception.threshold": between(1e-8, 1e-6, "the lowest thresholds differ by contact and posture")
    }
    best = {
        "perception.channels.0.best_frequency": between(
            250.0, 300.0, "", model="Uniform", source="review of the channels, abstract", status="abstract"
        ),
        "perception.channels.0.order_below": between(
            1.5, 2.5, "2 is the default, an assumption", model="Uniform"
        ),
    }
    tan = "Bolanowski 1988, quoted by Tan 1994, as tabled in the public ledger"

    def threshold(
        group: str, title: str, source: str, values: dict[float, float], **more: Any
    ) -> Measurement:
        known: dict[str, Any] = {
            "quantity": vibration_threshold, "unit": "m", "scenario": person(), "how": "quoted by others",
            "status": "second-hand", "on": "hand", "judges": "perception.channels.0", "unknown": lowest,
            "of_model": {"Pacinian": best}, "spread": (0.3,) * len(values), "spread_of": "a choice",
            "note": "Not said whether zero to peak; the spread between people is not tabled.",
        }  # fmt: skip
        return Measurement(
            title=title, source=source, group=group, values=tuple(values.values()),
            **{"over": "drive.frequency", "at": tuple(values)} | known | more,
        )  # fmt: skip

    israr, bolanowski = "Israr, Choi and Tan (Purdue)", "Bolanowski (Syracuse)"
    pen = "Israr 2006, as tabled in the public ledger"
    slope: dict[str, Any] = {"unit": "1", "over": "", "at": (), "spread": (0.1,)}
    return {
        "pen": threshold(israr, "threshold of a held pen over frequency", pen, PEN, cause=SHARED),
        "pen_slope": threshold(
            israr, "fall of the threshold of a held pen per octave, in dB", pen, {0.0: 13.0},
            quantity=functools.partial(fall, low=10.0, high=160.0), **slope,
            note="Of 10 to 160 Hz. The tabled values at 10 and 20 Hz give 9.7 dB.", cause=SHARED,
        ),
        "cylinder": threshold(
            "Brisben", "threshold of a grasped cylinder", "Brisben 1999, quoted by Israr 2006", {150.0: 0.03e-6},
            note="The whole hand, tangential; forces of 0.05 to 1 N have no effect.",
        ),
        "thenar": threshold(
            bolanowski, "threshold of the thenar", "Bolanowski 1988, quoted by Israr 2006", {300.0: 0.13e-6},
            note="With a surround, normal to the skin.",
        ),
        "thenar_slope": threshold(
            bolanowski, "fall of the threshold of the Pacinian channel per octave, in dB", tan, {0.0: 12.0},
            quantity=functools.partial(fall, low=30.0, high=300.0), **slope,
            note="Of 30 to 300 Hz.", scenario=person().replace({"perception.channels": [{"model": "Pacinian"}]}),
        ),
        "thenar_plateau": threshold(
            bolanowski, "threshold of the non-Pacinian channels below 30 Hz", tan, {25.0: 25e-6},
            note="28 dB re 1 um, for frequencies below 30 Hz, taken at 25 Hz.",
            cause=SHARED,
        ),
    }  # fmt: skip


CHECKS = (
    Check(
        "fall of the tabled threshold from 10 to 20 Hz in dB",
        expect=9.71,
        rtol=1e-3,
        source="20 lg(26/8.5), computed by hand",
        compute=lambda: 20 * math.log10(PEN[10.0] / PEN[20.0]),
        status="derived",
    ),
)
