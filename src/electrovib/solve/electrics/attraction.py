"""Electrostatic attraction from the pressure of a force law and the contact area under load and attraction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.contact import FixedArea
from electrovib.solve.electrics.pressed import pressed
from electrovib.solve.stack.expand import Surroundings

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.section import PhasorSection

PHASES = 32
"""Points per period of the average of a force: exact for a pressure of second degree on a constant area."""


def total_pull(scenario: Scenario, amplitudes: dict[str, Real]) -> Real:
    """Compute the attraction per area of the first contact, that of a second contact in series included."""
    second = Surroundings.of(scenario).second
    total = scenario.force.pressure(**amplitudes)
    if np.any(second):  # a column of many fingers has one for each
        denser = {name: values * second for name, values in amplitudes.items()}
        total = total + scenario.force.pressure(**denser) / second
    return np.asarray(total)


def attraction(scenario: Scenario, pull: Real, times: Real | None = None) -> Real:
    """Compute the force of an attraction per area on the contact area under load and attraction together.

    `pull` (..., n) [Pa], `times` (n,) [s]; returns `force` (..., n) [N].
    """
    contact, load = scenario.contact, scenario.load
    if isinstance(contact, FixedArea):
        return np.asarray(contact.area * pull)
    if times is None:
        forces, pressing = np.asarray(load.normal_force), pull
    else:
        forces, pressing = load.forces(times), np.where(scenario.motion.touches(times), pull, 0.0)
    return np.asarray(pull * contact.outline(pressed(contact, forces, pressing)))


def mean_force(scenario: Scenario, section: PhasorSection, *, amplitude: float) -> Real:
    """Compute the time mean of the attraction under one sine.

    Returns `force` (frequencies,) [N].
    """
    count = PHASES if isinstance(scenario.contact, FixedArea) else 16 * PHASES
    turns = np.exp(2j * np.pi * np.arange(count) / count)[:, None]
    phasor: dict[str, Complex] = scenario.force.amplitudes(section)
    waves = {name: np.real(amplitude * value * turns) for name, value in phasor.items()}
    return np.asarray(np.mean(attraction(scenario, total_pull(scenario, waves)), axis=0))
