"""O. Bau, I. Poupyrev, A. Israr, C. Harrison, "TeslaTouch: electrovibration for touch surfaces", UIST 2010.

Claims: a touch screen without moving parts gives tactile sensations to a sliding finger by electrostatic
friction; three controlled experiments characterise how it is perceived. Does not claim: an equation, a stack,
thresholds (none was read). Its detection thresholds at five frequencies and its difference thresholds are known from
memory only and not used. The difference threshold used here is that of Ryu 2018, 1.21 dB, which was read.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from electrovib.core.citation import derived
from electrovib.papers import cited_as, not_read, preset_notes
from electrovib.papers.vezzoli_2014 import values
from electrovib.scenario import AIR, Scenario, preset

CITATIONS, CITATION = cited_as(__name__)
STATUS = "abstract"
PRESETS = preset_notes(__name__)
NOT_READ = not_read(__name__)

DIFFERENCE_THRESHOLD = 1.21
"""Mean difference threshold of the amplitude, abstract of Ryu 2018 [dB]."""
CHOICE = "not printed in the abstract; a choice"
COATING = "not printed in the abstract; a thin coating, as in vezzoli_2014 for its figure 7"
SKIN = "not printed in the abstract; the skin of vezzoli_2014, section 3.1"


def just_noticeable_ratio() -> float:
    """Return the ratio of two amplitudes that can just be distinguished, 10^(threshold/20)."""
    return math.exp(DIFFERENCE_THRESHOLD / 20 * math.log(10))


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Return one sine on a coated screen, with the Maxwell stress evaluated in the gap."""
    gap = (3e-6, "not printed in the abstract; of the order of skin roughness")
    sine = preset(
        title="Bau 2010: a sine on a coated touch screen",
        unchanged=CHOICE,
        changes={
            "drive": ({"model": "Sine", "amplitude": 100.0, "frequency": 125.0}, CHOICE),
            "time.initial_state.model": "PeriodicState",
            "stack": {
                "insulator": (values.COATING, COATING),
                "gap": {"thickness": gap, "material": AIR},
                "stratum_corneum": values.point_layer(SKIN),
            },
        },
    )
    return {"sine": sine}


def force_change(*, ratio: float) -> float:
    """Return the change of the mean attraction [dB] when the amplitude of the sine is multiplied by a ratio [1]."""
    from electrovib.solve.electrics.attraction import mean_force
    from electrovib.solve.stack.expand import phasors

    scenario = scenarios()["sine"]
    section = phasors(scenario, np.array([125.0]))
    force = [float(mean_force(scenario, section, amplitude=100.0 * factor)[0]) for factor in (1.0, ratio)]
    return 20 * math.log10(force[1] / force[0])


def order_of_the_force() -> int:
    """Return the order of the drive's harmonic at which the alternating part of the attraction is largest."""
    from electrovib.solve.simulate import simulate

    time = np.arange(256) / 256 / 125.0
    force = simulate(scenarios()["sine"], time=time).electrostatic_force.values
    return int(np.argmax(np.abs(np.fft.rfft(force))[1:])) + 1


CHECKS = (
    derived(
        "voltage difference that can just be distinguished, as a share",
        expect=0.149,
        rtol=4e-3,
        source="Ryu 2018, abstract: 1.21 dB, three digits",
        compute=lambda: just_noticeable_ratio() - 1,
    ),
    derived(
        "change of the attraction at that voltage, in dB",
        expect=2.42,
        rtol=4e-3,
        source="twice the 1.21 dB of Ryu 2018, abstract: the force is a square",
        compute=lambda: force_change(ratio=just_noticeable_ratio()),
    ),
    derived(
        "frequency of the force over that of the drive",
        expect=2.0,
        rtol=1e-9,
        source="the attraction is proportional to the square of the voltage, whatever its sign",
        compute=order_of_the_force,
    ),
)
