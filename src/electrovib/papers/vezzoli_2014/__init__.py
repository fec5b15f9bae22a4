"""E. Vezzoli, M. Amberg, F. Giraud, B. Lemaire-Semail, "Electrovibration modeling analysis", EuroHaptics 2014.

Claims: the attraction of a finger fades after a voltage step and grows with frequency because the stratum
corneum conducts, with electrical values that depend on frequency; charge that has crossed it no longer attracts.
Does not claim: a return path, a ramp time, a coefficient of friction, the skin's permittivity and resistivity at more
than one frequency (its figure 4 shows their product), or the mechanics of finger and sensor. What this leaves open is in
`open_questions`.
"""

from __future__ import annotations

from electrovib.papers.vezzoli_2014.defects import DEFECTS
from electrovib.papers.vezzoli_2014.laws import Vezzoli2014Causal, Vezzoli2014PerFrequency
from electrovib.papers.vezzoli_2014.measured import measurements
from electrovib.papers.vezzoli_2014.reproduction import reproduce
from electrovib.papers.vezzoli_2014.scenarios import PRESETS, scenarios
from electrovib.papers.vezzoli_2014.values import CHECKS, CITATION, CITATIONS, STATUS, materials, skins

__all__ = [
    "CHECKS",
    "CITATION",
    "CITATIONS",
    "DEFECTS",
    "PRESETS",
    "STATUS",
    "Vezzoli2014Causal",
    "Vezzoli2014PerFrequency",
    "materials",
    "measurements",
    "reproduce",
    "scenarios",
    "skins",
]
