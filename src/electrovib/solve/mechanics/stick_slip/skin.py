"""Interface of the equations of a sliding skin, and its energies."""

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

    @abstractmethod
    def rate(self, now: Real, *, speed: float, strength: float, direction: int) -> Real:
        """Return the rate of change of the states.

        `now` (states,); returns `rate` (states,).
        """

    @abstractmethod
    def speed_over_plate(self, now: Real, *, speed: float | Real) -> Real:
        """Return the speed of the skin over the plate.

        `now` (states,), `speed` (n,) [m/s]; returns `over_plate` () [m/s].
        """

    @abstractmethod
    def deflection(self, now: Real) -> Real:
        """Return the deflection of the bristles [m]."""

    @abstractmethod
    def displacement(self, now: Real) -> Real:
        """Return the displacement of the skin against the bone [m]."""

    def left(self, now: Real, *, strength: float, direction: int) -> float:
        """Return the remaining share of the strength of the friction.

        `now` (states,).
        """
        return 1 - direction * self.law.stiffness * float(self.deflection(now)) / strength

    @abstractmethod
    def let_go(self, now: Real) -> Real:
        """Return the states with a deflection of 0 [m], after the energy of the bristles has become heat [J]."""

    @abstractmethod
    def scale(self, *, strength: float, speed: float) -> Real:
        """Return the scale of each state.

        Returns `scale` (states,).
        """

    @abstractmethod
    def settled(self, *, speed: float, strength: float) -> Real:
        """Return the states of steady sliding.

        Returns `now` (states,).
        """

    @abstractmethod
    def natural_speed(self, strength: float) -> float:
        """Return the speed scale of a strength [N] where the hand rests, in m/s."""

    @abstractmethod
    def natural_force(self, speed: float) -> float:
        """Return the force scale of a speed [m/s] without friction, in N."""

    @abstractmethod
    def energies(self, now: Real) -> Energies:
        """Return the energies of the states over time [J]."""
