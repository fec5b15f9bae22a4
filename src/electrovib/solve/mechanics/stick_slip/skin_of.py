"""Sliding skin of a friction law and a fingertip, in contact and lifted off the plate."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.mechanics.stick_slip.kinds import CompliantSlidingSkin, RigidSlidingSkin
from electrovib.solve.mechanics.stick_slip.skin import SlidingSkin

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction


OverTime: TypeAlias = "Callable[[float | Real], float | Real]"
"""A quantity at times [s], one or many; at a discontinuity the value after it."""


def _always(time: float | Real) -> Any:
    return np.ones(np.shape(time), dtype=bool)


class Lifted:
    """Friction law of a finger off the plate: all its forces are 0.

    Parameters
    ----------
    law : BristleFriction
        Friction in contact.
    """

    def __init__(self, law: BristleFriction) -> None:
        self.stiffness = law.stiffness

    def strength_at(self, speed: Any, strength: Any) -> Any:
        """Return a strength of 0 N for any speed [m/s] and strength [N]."""
        return 0 * (speed + strength)

    def deflection_rate(self, deflection: Any, speed: Any, strength: Any, direction: Any) -> Any:
        """Return a rate of 0 m/s for any deflection [m], speed [m/s], strength [N] and direction."""
        return 0 * (deflection + speed + strength + direction)

    def force(self, deflection: Any, rate: Any, speed: Any) -> Any:
        """Return a force of 0 N for any deflection [m], rate [m/s] and speed [m/s]."""
        return 0 * (deflection + rate + speed)


def lifted(skin: SlidingSkin) -> SlidingSkin:
    """Return the same skin without friction."""
    return replace(skin, law=Lifted(skin.law))  # type: ignore[arg-type]


def skin_of(
    law: BristleFriction, *, mass: float | None, stiffness: float | None, damping: float | None
) -> SlidingSkin:
    """Return the skin of a finger, or a rigid one."""
    if mass is None and stiffness is None and damping is None:
        return RigidSlidingSkin(law)
    if mass is None or stiffness is None or damping is None:
        raise InputError("finger: needs mass, stiffness and damping, or none of them for a rigid finger")
    if not mass > 0:
        raise InputError(
            f"finger.mass = {mass:.6g} kg: it must be above 0, because the speed of the skin is a state; omit the finger for"
            " a rigid one"
        )
    if not (stiffness > 0 and damping >= 0):
        raise InputError(
            f"finger: stiffness = {stiffness:.6g} N/m must be above 0, and damping = {damping:.6g} N s/m must not be negative"
        )
    return CompliantSlidingSkin(law, mass=mass, stiffness=stiffness, damping=damping)
