"""Currents through a body that sources state as thresholds, as facts for comparison: none of them is a limit of a set-up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from electrovib.core.citation import UNVERIFIED

SECOND_HAND: Final = "second-hand"
"""Status of a value that was read in a publication which quotes the source."""
NOT_A_CLAIM: Final = (
    "These are comparisons with published currents, not a claim of medical safety: they hold for healthy adults and for the"
    " stated conditions, and say nothing about persons with an implanted device or a heart condition, wet or broken skin,"
    " burns, a fault of the amplifier, or breakdown of the insulator. Only hardware that limits the current protects a person."
)


@dataclass(frozen=True, kw_only=True)
class CurrentThreshold:
    """A current through a body or a finger, as a source states it.

    Parameters
    ----------
    name : str
        What the source calls it.
    value : float
        Current [A].
    statistic : str
        ``"peak"`` or ``"rms"``: the statistic of the current that it is compared with.
    of : str
        Current that is compared: ``"current"``, of the amplifier into plate, stray capacitance and finger, or
        ``"body_current"``, through the finger.
    conditions : str
        Conditions under which the source states it.
    source : str
        Publication.
    status : str
        How the source was read: ``"full text"``, ``"second-hand"`` or ``"unverified"``.
    """

    name: str
    value: float
    statistic: str
    of: str
    conditions: str
    source: str
    status: str


THRESHOLDS: Final = (
    CurrentThreshold(
        name="current limit of the set-up of Vezzoli et al. 2014",
        value=250e-6,
        statistic="peak",
        of="current",
        conditions="safety circuit of the amplifier at 0 to 1000 V",
        source="Vezzoli et al. 2014, section 4",
        status="full text",
    ),
    CurrentThreshold(
        name="IEC 60479-1, upper end of zone AC-1",
        value=0.5e-3,
        statistic="rms",
        of="body_current",
        conditions="15 to 100 Hz; usually no reaction below it",
        source="IEC 479-1 as quoted in a textbook of electrical engineering",
        status=SECOND_HAND,
    ),
    CurrentThreshold(
        name="IEC 60479-1, upper end of zone DC-1",
        value=2e-3,
        statistic="peak",
        of="body_current",
        conditions="direct current; a slight pricking is possible when it is switched",
        source="IEC 60479-1, not read",
        status=UNVERIFIED,
    ),
    CurrentThreshold(
        name="IEC 60479-1, upper end of zone AC-2 at long durations",
        value=5e-3,
        statistic="rms",
        of="body_current",
        conditions="15 to 100 Hz, durations above 10 s; involuntary muscular contractions above it",
        source="IEC 60479-1, not read",
        status=UNVERIFIED,
    ),
)
"""In the order in which they are shown."""
