"""Equations of a sliding skin with mass and spring, and of a rigid one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
from electrovib.solve.mechanics.stick_slip.skin import Energies, SlidingSkin


@dataclass(frozen=True, kw_only=True)
class CompliantSlidingSkin(SlidingSkin):
    """Skin with mass on a spring and a damper: displacement, speed, deflection, work, heat of damper and of friction.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    mass, stiffness, damping : float
        Mass [kg] and stiffness [N/m], above 0; damping [N s/m].
    """

    mass: float
    stiffness: float
    damping: float
    states: ClassVar[int] = 6

    def rate(self, now: Real, *, speed: float, strength: float, direction: int) -> Real:
        """Return the rate of change of the states [m/s], [m/s2], [m/s], [W], [W], [W]."""
        displacement, over_plate, deflection = now[0], now[1], now[2]
        skin_speed = speed - over_plate
        rate, friction = _friction(self.law, deflection, over_plate, strength, direction)
        hand = self.stiffness * displacement + self.damping * skin_speed
        return np.array(
            [
                skin_speed,
                (hand - friction) / self.mass,
                rate,
                hand * speed,
                self.damping * skin_speed * skin_speed,
                friction * over_plate - self.law.stiffness * deflection * rate,
            ]
        )

    def speed_over_plate(self, now: Real, *, speed: float | Real) -> Real:
        """Return the second state [m/s]; the speed of the bone is not used."""
        del speed
        return np.asarray(now[1])

    def deflection(self, now: Real) -> Real:
        """Return the third state [m]."""
        return np.asarray(now[2])

    def displacement(self, now: Real) -> Real:
        """Return the first state [m]."""
        return np.asarray(now[0])

    def let_go(self, now: Real) -> Real:
        """Return the states with a deflection of 0 [m], whose energy has become heat [J]."""
        heat = now[5] + self.law.stiffness * now[2] ** 2 / 2
        return np.array([now[0], now[1], 0.0, now[3], now[4], heat])

    def scale(self, *, strength: float, speed: float) -> Real:
        """Return the scale of each state for a strength [N] and a speed [m/s]."""
        stretch = strength / self.stiffness
        return np.array([stretch, speed, strength / self.law.stiffness, *[strength * stretch] * 3])

    def settled(self, *, speed: float, strength: float) -> Real:
        """Return the states of sliding at a steady speed [m/s] and strength [N]."""
        deflection, friction = _steady(self.law, speed, strength)
        return np.array([friction / self.stiffness, speed, deflection, 0.0, 0.0, 0.0])

    def natural_speed(self, strength: float) -> float:
        """Return the largest speed of the skin released from its stretch under a strength [N], in m/s."""
        return strength / float(np.sqrt(self.stiffness * self.mass))

    def natural_force(self, speed: float) -> float:
        """Return the largest force of the spring when the skin is stopped from a speed [m/s], in N."""
        return speed * float(np.sqrt(self.stiffness * self.mass))

    def energies(self, now: Real) -> Energies:
        """Return the energies over time [J]."""
        kinetic = self.mass * now[1] ** 2 / 2
        elastic = self.stiffness * now[0] ** 2 / 2
        bristle = self.law.stiffness * now[2] ** 2 / 2
        before = float(kinetic[0] + elastic[0] + bristle[0])
        return Energies(
            work=now[3],
            kinetic=kinetic,
            elastic=elastic,
            bristle=bristle,
            damper=now[4],
            friction=now[5],
            stored_before=before,
        )


@dataclass(frozen=True)
class RigidSlidingSkin(SlidingSkin):
    """Skin that moves with the bone: deflection, work, heat of the friction.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    """

    states: ClassVar[int] = 3

    def rate(self, now: Real, *, speed: float, strength: float, direction: int) -> Real:
        """Return the rate of change of the states [m/s], [W], [W]."""
        rate, friction = _friction(self.law, now[0], speed, strength, direction)
        work = friction * speed
        return np.array([rate, work, work - self.law.stiffness * now[0] * rate])

    def speed_over_plate(self, now: Real, *, speed: float | Real) -> Real:
        """Return the speed of the bone [m/s]."""
        del now
        return np.asarray(speed)

    def deflection(self, now: Real) -> Real:
        """Return the first state [m]."""
        return np.asarray(now[0])

    def displacement(self, now: Real) -> Real:
        """Return a displacement of 0 [m]."""
        return np.zeros_like(now[0])

    def let_go(self, now: Real) -> Real:
        """Return the states with a deflection of 0 [m], whose energy has become heat [J]."""
        return np.array([0.0, now[1], now[2] + self.law.stiffness * now[0] ** 2 / 2])

    def scale(self, *, strength: float, speed: float) -> Real:
        """Return the scale of each state for a strength [N]; the speed [m/s] is not used."""
        del speed
        deflection = strength / self.law.stiffness
        return np.array([deflection, *[strength * deflection] * 2])

    def settled(self, *, speed: float, strength: float) -> Real:
        """Return the states of sliding at a steady speed [m/s] and strength [N]."""
        return np.array([_steady(self.law, speed, strength)[0], 0.0, 0.0])

    def natural_speed(self, strength: float) -> float:
        """Return 1 m/s for any strength [N]: a rigid finger has no speed of its own."""
        del strength
        return 1.0

    def natural_force(self, speed: float) -> float:
        """Return 0 N for any speed [m/s]: a rigid finger has no spring."""
        del speed
        return 0.0

    def energies(self, now: Real) -> Energies:
        """Return the energies over time [J]."""
        bristle, nothing = self.law.stiffness * now[0] ** 2 / 2, np.zeros_like(now[0])
        return Energies(
            work=now[1],
            kinetic=nothing,
            elastic=nothing,
            bristle=bristle,
            damper=nothing,
            friction=now[2],
            stored_before=float(bristle[0]),
        )


def _friction(
    law: BristleFriction, deflection: Any, speed: Any, strength: Any, direction: Any
) -> tuple[Any, Any]:
    """Return the rate of the deflection [m/s] and the force [N], for numbers or arrays."""
    rate = law.deflection_rate(deflection, speed, strength, direction)
    return rate, law.force(deflection, rate, speed)


def _steady(law: BristleFriction, speed: Any, strength: Any) -> tuple[float, float]:
    """Return the deflection [m] and the force [N] of steady sliding; 0 at rest."""
    deflection: Any = np.sign(speed) * law.strength_at(speed, strength) / law.stiffness
    rest: Any = 0.0
    return float(deflection), float(law.force(deflection, rest, speed))
