"""Skin with a bristle friction under the attraction of a scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.finger import MassSpringDamper
from electrovib.scenario import PeriodicState
from electrovib.solve.mechanics.between import Between
from electrovib.solve.mechanics.lateral import shortest_time
from electrovib.solve.mechanics.stick_slip.quick_sliding import slide_quickly
from electrovib.solve.mechanics.stick_slip.sliding import Slide, sliding

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
    from electrovib.scenario import Scenario


def slide(
    scenario: Scenario, law: BristleFriction, times: Real, force_at: Callable[[Real], Real], corners: Real
) -> tuple[Slide, Callable[[Real], Slide], dict[str, Any]]:
    """Solve the motion of the skin of a scenario over the plate by time stepping.

    `times` (n,) [s].

    A finger that moves at time 0 has always slid steadily; one that begins at rest is not deflected.
    """
    refuse_unslid(scenario)
    motion, finger, name = scenario.motion, scenario.finger, type(law).__name__
    assert motion.speed is not None
    assert finger is None or isinstance(finger, MassSpringDamper)
    skin = {} if finger is None else _skin(finger.at_speed(motion.speed))
    bends = np.array([time for time, _ in motion.time_profile.corners()])
    breaks = np.union1d(bends[bends > 0], corners[corners > 0])
    asked = times if times[0] == 0 else np.append(0.0, times)
    strength = Between(force_at, asked, breaks, shortest=shortest_time(scenario.drive))

    def march(wanted: Real) -> Slide:
        if law.bristles is not None:
            return slide_quickly(law, motion=motion, strength=strength, times=wanted, **skin)
        settled = float(motion.speeds(0.0)) > 0
        return sliding(
            law,
            speed=motion.speeds,
            strength=strength,
            times=wanted,
            breaks=breaks.tolist(),
            touches=motion.touches,
            settled=settled,
            **skin,
        )

    found = march(asked)
    why = (
        f"{name} sticks and slips: skin and bristles as one stiff system, Radau's method of order 5, {found.steps} steps,"
        f" {len(found.events)} events located"
    )
    return (
        found,
        march,
        {
            "friction_solver": why,
            "energy_residual": found.energy_residual,
            "friction_events": len(found.events),
            "mechanics_error": strength.error(),
        },
    )


def refuse_unslid(scenario: Scenario) -> None:
    """Refuse a scenario that cannot be solved with a bristle friction."""
    motion, finger = scenario.motion, scenario.finger
    name = type(scenario.friction).__name__
    if motion.speed is None:
        raise InputError(f"friction = {name} needs motion.speed, for instance motion.speed = '30 mm/s'")
    if isinstance(scenario.time.initial_state, PeriodicState):
        raise InputError(
            f"time.initial_state = PeriodicState: the stick-slip of friction = {name} does not have the period of the drive."
            " Start AtRest and evaluate a late period"
        )
    if finger is not None and not isinstance(finger, MassSpringDamper):
        raise InputError(
            f"finger = {type(finger).__name__}: friction = {name} needs MassSpringDamper, or no finger"
        )


def _skin(finger: MassSpringDamper) -> dict[str, float]:
    return {"mass": finger.mass, "stiffness": finger.stiffness, "damping": finger.damping}
