"""K. A. Kaczmarek and others, "Polarity effect in electrovibration for tactile display", IEEE Trans. Biomed. Eng. 2006.

Claims: people are less sensitive to positive pulses than to negative or biphasic ones, and thresholds of negative
pulses are the steadiest; models of a parallel-plate capacitor do not depend on the polarity; the asymmetric electrical
properties of skin may be the cause. Does not claim: in the abstract, which alone was read, a threshold, a pulse, an
electrode, a law of conduction. The baseline force is EffectiveMedium; that Vezzoli et al. 2014 took it from
this paper is cited from memory, unverified.

Computed here: every law on linear layers gives the same attraction for both polarities, to the last bit, and is
reported as unable to show the effect. With a layer that conducts better for positive fields the result depends on the
surface on which the Maxwell stress is evaluated. Where charge that has crossed the skin no longer attracts, or where the
interface itself rectifies, a positive pulse attracts less while it is on, and more after it, by the charge it leaves
behind. With the Maxwell stress in a gap that does not leak, a skin that conducts more leaves more field to the gap, and
the positive pulse attracts more, by less than 1 % on a film.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import published
from electrovib.papers.vezzoli_2014 import values
from electrovib.physics.drive.edges import Trapezium
from electrovib.scenario import Scenario

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios

FAST, SLOW = 2.5e-3, 7.7e-3
"""Time constants of a layer for positive and for negative fields, in which it conducts better for positive, a choice [s]."""
GAP = 1e-6


def skin_conductivity(tau: float) -> float:
    """Return the conductivity [S/m] for which charge is lost with this time constant [s], (C_i + C_s) R_s."""
    capacitance = values.insulator_capacitance() + values.skin_capacitance()
    return capacitance * values.SKIN_THICKNESS / (values.AREA * tau)


def gap_conductivity(tau: float) -> float:
    """Return the conductivity [S/m] of a gap whose field decays with this time constant [s]: eps0 (1 + C_i/C_g)/tau."""
    return eps0 * (1 + values.FILM_PERMITTIVITY * GAP / values.FILM_THICKNESS) / tau


def rectifying(conductivity: Any, *, positive: float = FAST, negative: float = SLOW) -> dict[str, Any]:
    """Return the leak of a layer with one time constant [s] for each polarity, as the table of a `PolarityConduction`.

    `conductivity` returns the conductivity [S/m] for a time constant [s].
    """
    return {
        "model": "PolarityConduction",
        "conductivity_positive": conductivity(positive),
        "conductivity_negative": conductivity(negative),
    }


def polarity_ratio(scenario: Scenario) -> float:
    """Compute the mean attraction while a trapezoidal pulse is on over that of the same pulse with opposite sign.

    It is exactly 1 only where the response does not depend on the polarity at any time; below 1 the pulse as
    declared attracts less.
    """
    from electrovib.solve.simulate import simulate

    drive = scenario.drive
    assert isinstance(drive, Trapezium)
    turned = scenario.replace({"drive.high": -drive.high, "drive.low": -drive.low})
    trace = simulate(scenario)
    pull, pull_turned = trace.electrostatic_force.values, simulate(turned).electrostatic_force.values
    if np.array_equal(pull, pull_turned):
        return 1.0
    on = trace.time.values <= drive.delay + drive.rise + drive.hold
    return float(np.mean(pull[on]) / np.mean(pull_turned[on]))


def polarity_ratio_of(*, name: str, law: str) -> float:
    """Compute the same for a ready-made scenario under the force law of a name."""
    return polarity_ratio(scenarios()[name].replace({"force": {"model": law}}))


def is_weaker(*, name: str) -> float:
    """Return 1 if the pulse of a ready-made scenario attracts less than one of opposite sign, otherwise 0."""
    return float(polarity_ratio(scenarios()[name]) < 0.99)


def edge_ratio(*, positive: float, negative: float, ramp: float = 20e-3, hold: float = 0.2) -> float:
    """Compute the ratio of the peak attractions on the falling and on the rising edge of a positive trapezoidal pulse.

    `positive` and `negative` are the time constants of the skin's leak [s], `ramp` and `hold` durations [s];
    the law is that of Vezzoli et al. 2014.
    """
    from electrovib.solve.simulate import simulate

    edges = {"model": "Trapezium", "high": values.VOLTAGE, "rise": ramp, "hold": hold, "fall": ramp}
    leak = rectifying(skin_conductivity, positive=positive, negative=negative)
    scenario = scenarios()["skin_positive"].replace(
        {"drive": edges, "stack.stratum_corneum.leak": leak, "circuit.return_path.resistance": 0.0}
    )
    force = simulate(scenario, time=np.array([0.0, ramp, 2 * ramp + hold])).electrostatic_force.values
    return float(force[2] / force[1])


CHECKS = PAPER.checks(polarity_ratio_of, is_weaker, edge_ratio)
