"""E. Vezzoli, M. Amberg, F. Giraud, B. Lemaire-Semail, "Electrovibration modeling analysis", EuroHaptics 2014.

Claims: the attraction of a finger fades after a voltage step and grows with frequency because the stratum
corneum conducts, with electrical values that depend on frequency; charge that has crossed it no longer attracts.
Does not claim: a return path, a ramp time, a coefficient of friction, the skin's permittivity and resistivity at more
than one frequency (its figure 4 shows their product), or the mechanics of finger and sensor. What this leaves open is in
`numbers`.
"""

from __future__ import annotations

from electrovib.papers import published
from electrovib.papers.vezzoli_2014.laws import Vezzoli2014Causal as Vezzoli2014Causal
from electrovib.papers.vezzoli_2014.laws import Vezzoli2014PerFrequency as Vezzoli2014PerFrequency
from electrovib.papers.vezzoli_2014.reproduction import reproduce as reproduce
from electrovib.papers.vezzoli_2014.values import CHECKS as CHECKS

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios, skins, materials = PAPER.scenarios, PAPER.skins, PAPER.materials
