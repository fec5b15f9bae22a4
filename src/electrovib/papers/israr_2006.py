"""A. Israr, S. Choi, H. Z. Tan: detection threshold of the vibration of a held pen, IROS 2006, 472.

Second-hand, as tabled in a public ledger of values on haptics (github.com/adambickerdike/Stabilisation_Pen), with the
thresholds of other laboratories that it quotes.

Claims: 26 um at 10 Hz, 8.5 um at 20 Hz, 0.06 um at 320 Hz, falling by 13 dB per octave from 10 to 160 Hz; ten people, forced
choice. Does not claim: a finger on a plate; zero to peak or root mean square, which the ledger does not say. The four lowest
thresholds differ fourfold by contact and posture, and from 10 to 20 Hz the tabled values fall by 9.7 dB only.
"""

from __future__ import annotations

import math

import numpy as np

from electrovib.papers import published
from electrovib.scenario import Scenario
from electrovib.studies.evidence.quantities import vibration_threshold

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared


def fall(scenario: Scenario, *, low: float, high: float) -> float:
    """Compute the mean fall of the threshold per octave between two frequencies [dB]; NaN if one of them is not felt."""
    ends = [vibration_threshold(scenario.replace({"drive.frequency": each})) for each in (low, high)]
    return (
        float(20 * np.log10(ends[0] / ends[1]) / math.log2(high / low))
        if math.isfinite(max(ends))
        else math.nan
    )


quantities = PAPER.quantities(fall)


def tabled_fall() -> float:
    """Return the fall of the tabled threshold from 10 to 20 Hz [dB]."""
    from electrovib.studies.evidence.files import of_publication

    low, high, _ = of_publication("israr_2006")["pen"].values
    return 20 * math.log10(low / high)


CHECKS = PAPER.checks(tabled_fall)
