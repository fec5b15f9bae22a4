"""Signals that are proportional to a parameter of the friction, or independent of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.physics.friction import FollowingFriction, SteadyFriction
from electrovib.solve.mechanics.unknown import resting

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

BEHIND_FRICTION: Final = frozenset(
    {"lateral_force", "lateral_force_measured", "skin_displacement", "skin_speed"}
)
"""Signals that are linear in the friction of steady sliding, without a digitiser."""
INDEPENDENT: Final = frozenset(
    {
        "electrostatic_force",
        "current",
        "stack_voltage",
        "effective_voltage",
        "interface_field",
        "capacitance",
        "impedance",
    }
)
"""Signals that are independent of the friction."""


def proportional_to_friction(scenario: Scenario, path: str) -> frozenset[str]:
    """Return the signals that are proportional to a parameter of the friction.

    The friction behind a memory, the motion of the skin and the readings of a sensor are linear filters of
    the friction of steady sliding.
    """
    friction, rig = scenario.friction, scenario.rig
    if not isinstance(friction, (SteadyFriction, FollowingFriction)):
        return frozenset()
    steady = "friction" if isinstance(friction, SteadyFriction) else "friction.steady"
    parent, _, name = path.rpartition(".")
    if parent != steady or name not in friction.without_memory().proportional_to:
        return frozenset()
    if scenario.moisture is not None or scenario.motion.distance is not None or resting(scenario.motion):
        return frozenset()
    return frozenset() if rig is not None and rig.digitiser is not None else BEHIND_FRICTION
