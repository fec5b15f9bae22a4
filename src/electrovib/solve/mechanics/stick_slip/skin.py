"""Right-hand sides of a sliding skin, each with its own slice of the state: on a finger, or rigid."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction


@dataclass(frozen=True, kw_only=True)
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
    def rate(self, now: Real, *, speed: float, strength: float, direction: int) -> Real:
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
    def speed_over_plate(self, now: Real, *, speed: float | Real) -> Real:
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

    def left(self, now: Real, *, strength: float, direction: int) -> float:
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
    def scale(self, *, strength: float, speed: float) -> Real:
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
    def settled(self, *, speed: float, strength: float) -> Real:
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
