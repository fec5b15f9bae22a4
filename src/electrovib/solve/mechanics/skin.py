"""Equations of a sliding skin and its energies: with mass and spring, or rigid, in contact or lifted off the plate."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction


@dataclass(frozen=True, kw_only=True)
class Energies:
    """Energy balance of a sliding skin since time 0.

    Parameters
    ----------
    work : ndarray, shape (n,)
        Work done by the hand [J].
    kinetic, elastic, bristle : ndarray, shape (n,)
        Energy stored in the motion of the skin over the plate, in the fingertip and in the contact [J].
    damper, friction : ndarray, shape (n,)
        Heat dissipated in the fingertip and in the contact [J].
    stored_before : float
        Energy stored at time 0 [J].
    """

    work: Real
    kinetic: Real
    elastic: Real
    bristle: Real
    damper: Real
    friction: Real
    stored_before: float

    @property
    def residual(self) -> float:
        """Largest error of the energy balance, over the largest work or the initial energy [1]; 0 without motion."""
        stored = self.kinetic + self.elastic + self.bristle
        missing = self.work - (stored - self.stored_before) - self.damper - self.friction
        size = float(max(np.max(np.abs(self.work)), self.stored_before))
        return float(np.max(np.abs(missing))) / size if size > 0 else 0.0


@dataclass(frozen=True)
class SlidingSkin(ABC):
    """A sliding skin: its states and their rates.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    """

    law: BristleFriction
    states: ClassVar[int]
    """Number of states."""

    @property
    def body(self) -> tuple[float, float, float]:
        """Mass [kg], stiffness [N/m] and damping [N s/m] of the skin; all 0 if it moves with the bone."""
        return 0.0, 0.0, 0.0

    @abstractmethod
    def rate(self, now: Real, *, speed: float, strength: float, direction: int) -> Real:
        """Return the rate of change of the states.

        `now` (states,); returns `rate` (states,).
        """

    @abstractmethod
    def speed_over_plate(self, now: Real, *, speed: float | Real) -> Real:
        """Return the speed of the skin over the plate.

        `now` (states,) or (states, n), `speed` of the bone, one or (n,) [m/s].
        """

    @abstractmethod
    def deflection(self, now: Real) -> Real:
        """Return the deflection of the bristles [m]."""

    @abstractmethod
    def displacement(self, now: Real) -> Real:
        """Return the displacement of the skin against the bone [m]."""

    def left(self, now: Real, *, strength: float, direction: int) -> float:
        """Return the share of the strength [N] that the bristles have not reached yet, from the states (states,) [1]."""
        return 1 - direction * self.law.stiffness * float(self.deflection(now)) / strength

    @abstractmethod
    def let_go(self, now: Real) -> Real:
        """Return the states with a deflection of 0 [m], after the energy of the bristles has become heat [J]."""

    @abstractmethod
    def scale(self, *, strength: float, speed: float) -> Real:
        """Return the scale of each state, shape (states,), for a strength [N] and a speed [m/s]."""

    @abstractmethod
    def settled(self, *, speed: float, strength: float) -> Real:
        """Return the states of steady sliding, shape (states,), at a speed [m/s] and a strength [N]."""

    @abstractmethod
    def natural_speed(self, strength: float) -> float:
        """Return the speed scale of a strength [N] where the hand rests, in m/s."""

    @abstractmethod
    def natural_force(self, speed: float) -> float:
        """Return the force scale of a speed [m/s] without friction, in N."""

    @abstractmethod
    def energies(self, now: Real) -> Energies:
        """Return the energies of the states over time [J]."""


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

    @property
    def body(self) -> tuple[float, float, float]:
        """Mass [kg], stiffness [N/m] and damping [N s/m] of the skin."""
        return self.mass, self.stiffness, self.damping

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
