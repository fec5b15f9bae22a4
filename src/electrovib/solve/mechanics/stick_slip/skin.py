"""Right-hand sides of a sliding skin, each with its own slice of the state: on a finger, or rigid."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction


@dataclass(frozen=True)
class Energies:
    """Where the work of the hand has gone since time 0.

    Parameters
    ----------
    work : ndarray, shape (n,)
        Done by the hand [J].
    kinetic, elastic, bristle : ndarray, shape (n,)
        Stored in the skin's motion over the plate, the fingertip and the contact [J].
    damper, friction : ndarray, shape (n,)
        Turned into heat in the fingertip and in the contact [J].
    stored_before : float
        Stored at time 0 [J].
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
        """Largest work that is nowhere, over the largest work or stored energy [1]; 0 where nothing moves."""
        stored = self.kinetic + self.elastic + self.bristle
        missing = self.work - (stored - self.stored_before) - self.damper - self.friction
        size = float(max(np.max(np.abs(self.work)), self.stored_before))
        return float(np.max(np.abs(missing))) / size if size > 0 else 0.0


@dataclass(frozen=True)
class SlidingSkin(ABC):
    """What slides: a slice of the state and its rate.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    """

    law: BristleFriction
    states: ClassVar[int]
    """Length of the slice."""

    @abstractmethod
    def rate(self, now: Real, speed: float, strength: float, direction: int) -> Real:
        """Rate of change of the slice.

        Parameters
        ----------
        now : ndarray, shape (states,)
            The slice.
        speed : float
            Of the bone over the plate [m/s].
        strength : float
            Of the friction [N], above 0.
        direction : int
            Sign of the skin's speed over the plate.

        Returns
        -------
        ndarray, shape (states,)
            Unit of each state per second.
        """

    @abstractmethod
    def speed_over_plate(self, now: Real, speed: float | Real) -> Real:
        """Speed of the skin over the plate.

        Parameters
        ----------
        now : ndarray, shape (states,) or (states, n)
            The slice.
        speed : float or ndarray, shape (n,)
            Of the bone over the plate [m/s].

        Returns
        -------
        ndarray, shape () or (n,)
            m/s.
        """

    @abstractmethod
    def deflection(self, now: Real) -> Real:
        """Deflection of the bristles [m]."""

    @abstractmethod
    def displacement(self, now: Real) -> Real:
        """Displacement of the skin against the bone [m]."""

    def left(self, now: Real, strength: float, direction: int) -> float:
        """Share of the strength that the bristles have left.

        Parameters
        ----------
        now : ndarray, shape (states,)
            The slice.
        strength : float
            N, above 0.
        direction : int
            Sign of the skin's speed over the plate.

        Returns
        -------
        float
            1 where the bristles do not push, 0 at the strength, negative beyond [1].
        """
        return 1 - direction * self.law.stiffness * float(self.deflection(now)) / strength

    @abstractmethod
    def let_go(self, now: Real) -> Real:
        """Slice without deflection [m]: what the bristles held has become heat [J]."""

    @abstractmethod
    def scale(self, strength: float, speed: float) -> Real:
        """Size of each state.

        Parameters
        ----------
        strength, speed : float
            Largest of the friction [N] and of the bone [m/s], above 0.

        Returns
        -------
        ndarray, shape (states,)
            In the unit of each, above 0.
        """

    @abstractmethod
    def settled(self, speed: float, strength: float) -> Real:
        """Slice of steady sliding.

        Parameters
        ----------
        speed, strength : float
            Of the bone [m/s] and of the friction [N].

        Returns
        -------
        ndarray, shape (states,)
            In the unit of each.
        """

    @abstractmethod
    def natural_speed(self, strength: float) -> float:
        """Speed [m/s] that a strength [N] gives where the hand rests."""

    @abstractmethod
    def natural_force(self, speed: float) -> float:
        """Force [N] that a speed [m/s] gives where nothing rubs."""

    @abstractmethod
    def energies(self, now: Real) -> Energies:
        """Energies [J] from the slices over time."""


@dataclass(frozen=True)
class CompliantSlidingSkin(SlidingSkin):
    """Skin with mass on a spring and a damper: displacement, speed, deflection, work, two heats.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    mass, stiffness, damping : float
        kg, N/m, N s/m; the first two above 0.
    """

    mass: float
    stiffness: float
    damping: float
    states: ClassVar[int] = 6

    def rate(self, now: Real, speed: float, strength: float, direction: int) -> Real:
        """Rate of the slice: m/s, m/s2, m/s, W, W, W."""
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

    def speed_over_plate(self, now: Real, speed: float | Real) -> Real:
        """Second state [m/s]; the bone's does not matter."""
        del speed
        return np.asarray(now[1])

    def deflection(self, now: Real) -> Real:
        """Third state [m]."""
        return np.asarray(now[2])

    def displacement(self, now: Real) -> Real:
        """First state [m]."""
        return np.asarray(now[0])

    def let_go(self, now: Real) -> Real:
        """Slice without deflection [m], with its energy in the heat [J]."""
        heat = now[5] + self.law.stiffness * now[2] ** 2 / 2
        return np.array([now[0], now[1], 0.0, now[3], now[4], heat])

    def scale(self, strength: float, speed: float) -> Real:
        """Sizes from strength [N] and speed [m/s]."""
        stretch = strength / self.stiffness
        return np.array([stretch, speed, strength / self.law.stiffness, *[strength * stretch] * 3])

    def settled(self, speed: float, strength: float) -> Real:
        """Slice at a steady speed [m/s] and strength [N]."""
        deflection, friction = _steady(self.law, speed, strength)
        return np.array([friction / self.stiffness, speed, deflection, 0.0, 0.0, 0.0])

    def natural_speed(self, strength: float) -> float:
        """Speed [m/s] of the skin let go from the stretch under a strength [N]."""
        return strength / float(np.sqrt(self.stiffness * self.mass))

    def natural_force(self, speed: float) -> float:
        """Force [N] of the spring when the skin is stopped from a speed [m/s]."""
        return speed * float(np.sqrt(self.stiffness * self.mass))

    def energies(self, now: Real) -> Energies:
        """Energies [J]."""
        kinetic = self.mass * now[1] ** 2 / 2
        elastic = self.stiffness * now[0] ** 2 / 2
        bristle = self.law.stiffness * now[2] ** 2 / 2
        before = float(kinetic[0] + elastic[0] + bristle[0])
        return Energies(now[3], kinetic, elastic, bristle, now[4], now[5], before)


@dataclass(frozen=True)
class RigidSlidingSkin(SlidingSkin):
    """Skin that moves as the bone does: deflection, work, heat of the friction.

    Parameters
    ----------
    law : BristleFriction
        Friction of the contact.
    """

    states: ClassVar[int] = 3

    def rate(self, now: Real, speed: float, strength: float, direction: int) -> Real:
        """Rate of the slice: m/s, W, W."""
        rate, friction = _friction(self.law, now[0], speed, strength, direction)
        work = friction * speed
        return np.array([rate, work, work - self.law.stiffness * now[0] * rate])

    def speed_over_plate(self, now: Real, speed: float | Real) -> Real:
        """Speed of the bone [m/s]."""
        del now
        return np.asarray(speed)

    def deflection(self, now: Real) -> Real:
        """First state [m]."""
        return np.asarray(now[0])

    def displacement(self, now: Real) -> Real:
        """None [m]."""
        return np.zeros_like(now[0])

    def let_go(self, now: Real) -> Real:
        """Slice without deflection [m], with its energy in the heat [J]."""
        return np.array([0.0, now[1], now[2] + self.law.stiffness * now[0] ** 2 / 2])

    def scale(self, strength: float, speed: float) -> Real:
        """Sizes from strength [N]; the speed [m/s] is given."""
        del speed
        deflection = strength / self.law.stiffness
        return np.array([deflection, *[strength * deflection] * 2])

    def settled(self, speed: float, strength: float) -> Real:
        """Slice at a steady speed [m/s] and strength [N]."""
        return np.array([_steady(self.law, speed, strength)[0], 0.0, 0.0])

    def natural_speed(self, strength: float) -> float:
        """Give 1 m/s: without a finger, whatever the strength [N], no speed but the hand's counts."""
        del strength
        return 1.0

    def natural_force(self, speed: float) -> float:
        """Give none [N]: a rigid finger needs no force for its speed [m/s]."""
        del speed
        return 0.0

    def energies(self, now: Real) -> Energies:
        """Energies [J]."""
        bristle, nothing = self.law.stiffness * now[0] ** 2 / 2, np.zeros_like(now[0])
        return Energies(now[1], nothing, nothing, bristle, nothing, now[2], float(bristle[0]))


def _friction(
    law: BristleFriction, deflection: Any, speed: Any, strength: Any, direction: Any
) -> tuple[Any, Any]:
    """Rate of the deflection [m/s] and force [N]; the law takes numbers as it takes arrays."""
    rate = law.deflection_rate(deflection, speed, strength, direction)
    return rate, law.force(deflection, rate, speed)


def _steady(law: BristleFriction, speed: Any, strength: Any) -> tuple[float, float]:
    """Deflection [m] and force [N] of steady sliding; none at rest."""
    deflection: Any = np.sign(speed) * law.strength_at(speed, strength) / law.stiffness
    rest: Any = 0.0
    return float(deflection), float(law.force(deflection, rest, speed))
