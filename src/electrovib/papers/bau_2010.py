"""O. Bau, I. Poupyrev, A. Israr, C. Harrison, "TeslaTouch: electrovibration for touch surfaces", UIST 2010.

Claims: a touch screen without moving parts gives tactile sensations to a sliding finger by electrostatic
friction; three controlled experiments characterise how it is perceived. Does not claim: an equation, a stack,
thresholds (none was read). Its detection thresholds at five frequencies and its difference thresholds are known from
memory only and not used. The difference threshold used here is that of Ryu 2018, 1.21 dB, which was read.
"""

from __future__ import annotations

import math

import numpy as np

from electrovib.papers import mean_attraction, published

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios

DIFFERENCE_THRESHOLD = 1.21
"""Mean difference threshold of the amplitude, abstract of Ryu 2018 [dB]."""


def just_noticeable_ratio() -> float:
    """Return the ratio of two amplitudes that can just be distinguished, 10^(threshold/20)."""
    return math.exp(DIFFERENCE_THRESHOLD / 20 * math.log(10))


def force_change(*, ratio: float) -> float:
    """Return the change of the mean attraction [dB] when the amplitude of the sine is multiplied by a ratio [1]."""
    scenario = scenarios()["sine"]
    force = [float(mean_attraction(scenario, 125.0, amplitude=100.0 * factor)[0]) for factor in (1.0, ratio)]
    return 20 * math.log10(force[1] / force[0])


def just_noticeable_share() -> float:
    """Return the voltage difference that can just be distinguished, over the voltage."""
    return just_noticeable_ratio() - 1


def just_noticeable_force() -> float:
    """Return the change of the mean attraction at that difference [dB]."""
    return force_change(ratio=just_noticeable_ratio())


def order_of_the_force() -> int:
    """Return the order of the drive's harmonic at which the alternating part of the attraction is largest."""
    from electrovib.solve.simulate import simulate

    time = np.arange(256) / 256 / 125.0
    force = simulate(scenarios()["sine"], time=time).electrostatic_force.values
    return int(np.argmax(np.abs(np.fft.rfft(force))[1:])) + 1


CHECKS = PAPER.checks(just_noticeable_share, just_noticeable_force, order_of_the_force)
