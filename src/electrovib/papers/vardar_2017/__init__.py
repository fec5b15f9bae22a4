"""Y. Vardar, B. Guclu, C. Basdogan, "Effect of waveform on tactile perception by electrovibration", 2016 and 2017.

EuroHaptics 2016, doi:10.1007/978-3-319-42321-0_18, and IEEE Transactions on Haptics 10(4), 2017.

Claims: detection thresholds are lower for square than for sine voltages below 60 Hz and similar above, because the
skin converts a slow square voltage into short bursts of force, which the Pacinian channel detects. Does not claim:
the curves of the skin and the thresholds in volts (neither was read). The circuit, a coating in series with a leaky
stratum corneum whose own voltage attracts, is cited from memory, unverified. Here: that circuit, a square law, and a
weight of +-12 dB/octave about 250 Hz on the harmonics of the force, added as powers. It gives the direction for
every skin that conducts; the frequency of equal thresholds follows the skin's time constant (60 Hz is not imposed),
and above it the model predicts too large a difference, because an ideal square voltage has a constant square. The
size depends on the surface on which the Maxwell stress is evaluated: with the stress in a gap that does not leak,
the ready-made screen gives 8 dB instead of 29 at 15 Hz. A detection threshold is one of displacement, so the weight
acts after the mechanics of the finger where they are given; none is shipped, as the corner frequency of the skin is
cited from memory, unverified. `reproduce` shows how little the frequency of equal thresholds depends on it, and how
much on skin and edges.
"""

from __future__ import annotations

from electrovib.papers import published
from electrovib.papers.vardar_2017.reproduction import reproduce as reproduce
from electrovib.papers.vardar_2017.thresholds import FREQUENCIES as FREQUENCIES
from electrovib.papers.vardar_2017.thresholds import crossover as crossover
from electrovib.papers.vardar_2017.thresholds import felt_level as felt_level
from electrovib.papers.vardar_2017.thresholds import first_order_skin as first_order_skin
from electrovib.papers.vardar_2017.thresholds import quantities as quantities
from electrovib.papers.vardar_2017.thresholds import sine_over_square as sine_over_square
from electrovib.papers.vardar_2017.thresholds import weight as weight

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios


def ratio_of(*, time_constant: float, frequency: float) -> float:
    """Return the ratio of the thresholds [dB] on a first-order skin, time constant in s, frequency in Hz."""
    return sine_over_square(first_order_skin(time_constant=time_constant), frequency=frequency)


CHECKS = PAPER.checks(ratio_of)
