"""Friction with a state: the contact deflects like bristles before it slides, so that it can stick and slip."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from electrovib.core.arrays import Real
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.friction.base import FOLLOWED, Friction, SteadyFriction

if TYPE_CHECKING:
    from collections.abc import Mapping

_COULOMB: Mapping[str, Any] = {"model": "Coulomb", "coefficient": 0.5}
_NEAREST = 1e-8
"""Share of the strength within which Dahl's rate is straight for exponents below 1, whose slope would be endless."""
_STIFFNESS = Quantity("N/m", 1e-3, 1e12, "stiffness of the contact before it slides")


class Bristles(NamedTuple):
    """Numbers of the laws that share one formula, z' = u left |left|^(exponent - 1), left = 1 - stiffness z sign(u)/g(u).

    Parameters
    ----------
    stiffness : float
        Of the contact before it slides [N/m].
    excess, stribeck_speed : float
        g(u) = strength (1 + excess exp(-(u/stribeck_speed)^2)) [1], [m/s].
    exponent : float
        How the stiffness falls [1].
    nearest : float
        Smallest |left| that the power sees [1]; 0 where the exponent is 1 or above.
    bristle_damping, viscous_damping : float
        N s/m.
    """

    stiffness: float
    excess: float = 0.0
    stribeck_speed: float = 1.0
    exponent: float = 1.0
    nearest: float = 0.0
    bristle_damping: float = 0.0
    viscous_damping: float = 0.0


def strength_at_speed(speed: Any, strength: Any, excess: Any, stribeck_speed: Any) -> Any:
    """Strength [N] at a speed [m/s], numbers or arrays, of one [N] at fast sliding; a march compiles this line too."""
    return strength * (1 + excess * np.exp(-((speed / stribeck_speed) ** 2)))


def yielding_rate(
    deflection: Any, speed: Any, level: Any, direction: Any, stiffness: Any, exponent: Any, nearest: Any
) -> Any:
    """Rate of the deflection [m/s] under a strength at its speed [N], numbers or arrays; a march compiles this too."""
    left = 1 - direction * stiffness * deflection / level
    return speed * left * np.hypot(left, nearest) ** (exponent - 1)


class BristleFriction(Friction, family=True):
    """Friction of a contact that deflects before it slides.

    Notes
    -----
    `steady` gives the friction of sliding at a fast speed, which load and attraction change in time; the
    deflection z is the state. It stores stiffness z^2/2.
    """

    steady: Annotated[SteadyFriction, Field(description=FOLLOWED)]
    stiffness: Annotated[Number, _STIFFNESS]

    def without_memory(self) -> SteadyFriction:
        """Give the law whose friction it reaches when it slides fast."""
        return self.steady

    @property
    def yields_smoothly(self) -> bool:
        """Tell whether the rate of the deflection is smooth where the bristles reach the strength."""
        return True

    @property
    def bristles(self) -> Bristles | None:
        """Give its numbers if it is a law of that formula, which is marched in compiled steps; else None."""
        return None

    def strength_at(self, speed: Real, strength: Real) -> Real:
        """Steady friction at a speed, without viscous part.

        Parameters
        ----------
        speed : float or ndarray
            m/s.
        strength : float or ndarray, same shape
            Of fast sliding [N].

        Returns
        -------
        float or ndarray
            N, same shape.
        """
        return np.asarray(strength + 0 * np.asarray(speed))[()]

    @abstractmethod
    def deflection_rate(self, deflection: Real, speed: Real, strength: Real, direction: Real) -> Real:
        """Rate at which the contact deflects.

        Parameters
        ----------
        deflection : float or ndarray
            z [m], along the motion.
        speed : float or ndarray, same shape
            Speed of the skin over the plate [m/s].
        strength : float or ndarray, same shape
            What the steady law gives now [N], above 0.
        direction : float or ndarray, same shape
            Sign of the speed, 1 or -1 [1], given apart because the law has its kink there.

        Returns
        -------
        float or ndarray
            m/s, same shape.
        """

    @abstractmethod
    def force(self, deflection: Real, rate: Real, speed: Real) -> Real:
        """Friction force on the skin, against the motion.

        Parameters
        ----------
        deflection : float or ndarray
            z [m].
        rate : float or ndarray, same shape
            Its rate of change [m/s].
        speed : float or ndarray, same shape
            Speed of the skin over the plate [m/s].

        Returns
        -------
        float or ndarray
            N, same shape.
        """


class LuGre(BristleFriction):
    """Bristles that slip at a strength which falls with speed: sticking, slipping, and the step between.

    Notes
    -----
    z' = u - |u| stiffness z/g(u), g = strength (1 + (static_ratio - 1) exp(-(u/stribeck_speed)^2)), F =
    stiffness z + bristle_damping z' + viscous_damping u. Canudas de Wit et al. 1995 with the load in g only, so
    that the bristles' energy does not depend on the load and friction takes energy at every instant as long as
    bristle_damping is 0, or small against 4 g/|u|.
    """

    reference: ClassVar[str] = "C. Canudas de Wit et al., IEEE Trans. Autom. Control 40, 419 (1995)"
    status: ClassVar[str] = "derived"
    example: ClassVar[Mapping[str, Any]] = {
        "steady": _COULOMB,
        "stiffness": 500.0,
        "static_ratio": 1.5,
        "stribeck_speed": 5e-3,
    }

    static_ratio: Annotated[
        Number, Quantity("1", 1, 100, "largest friction at rest over that of fast sliding")
    ]
    stribeck_speed: Annotated[
        Number, Quantity("m/s", 1e-9, 100, "speed at which the excess has fallen to 1/e")
    ]
    bristle_damping: Annotated[Number, Quantity("N s/m", 0, 1e6, "damping of the deflection")] = 0.0
    viscous_damping: Annotated[Number, Quantity("N s/m", 0, 1e6, "damping of the sliding")] = 0.0

    def strength_at(self, speed: Real, strength: Real) -> Real:
        """Steady friction [N], larger at slow speeds."""
        excess = self.static_ratio - 1
        return np.asarray(strength_at_speed(np.asarray(speed), strength, excess, self.stribeck_speed))[()]

    @property
    def bristles(self) -> Bristles:
        """Give its numbers."""
        damping = {"bristle_damping": self.bristle_damping, "viscous_damping": self.viscous_damping}
        return Bristles(self.stiffness, self.static_ratio - 1, self.stribeck_speed, **damping)

    def deflection_rate(self, deflection: Real, speed: Real, strength: Real, direction: Real) -> Real:
        """Rate of the deflection [m/s]."""
        level = self.strength_at(speed, strength)
        return np.asarray(yielding_rate(deflection, speed, level, direction, self.stiffness, 1.0, 0.0))[()]

    def force(self, deflection: Real, rate: Real, speed: Real) -> Real:
        """Friction force [N]."""
        return self.stiffness * deflection + self.bristle_damping * rate + self.viscous_damping * speed


class Dahl(BristleFriction):
    """Bristles that yield as metals do: the stiffness falls to nothing as the force nears the strength.

    Notes
    -----
    z' = u |1 - r|^exponent sign(1 - r), r = stiffness z sign(u)/strength, F = stiffness z. It slides steadily at
    the strength and knows no static excess: it does not stick and slip by itself. Below exponent 1 it reaches
    the strength after a finite way, and the last 1e-8 of it is taken as straight. A finger in other people's
    code has coefficient 0.6, 500 N/m, exponent 0.7.
    """

    reference: ClassVar[str] = "P. R. Dahl, Aerospace Corporation, TOR-0158(3107-18)-1 (1968)"
    status: ClassVar[str] = "derived"
    example: ClassVar[Mapping[str, Any]] = {"steady": _COULOMB, "stiffness": 500.0}

    exponent: Annotated[Number, Quantity("1", 0.5, 5, "how the stiffness falls; 1 is an exponential")] = 1.0

    @property
    def yields_smoothly(self) -> bool:
        """Tell whether |1 - r|^exponent sign(1 - r) is a polynomial: odd exponents."""
        return self.exponent % 2 == 1

    @property
    def bristles(self) -> Bristles:
        """Give its numbers."""
        return Bristles(
            self.stiffness, exponent=self.exponent, nearest=_NEAREST if self.exponent < 1 else 0.0
        )

    def deflection_rate(self, deflection: Real, speed: Real, strength: Real, direction: Real) -> Real:
        """Rate of the deflection [m/s]."""
        numbers = self.stiffness, self.exponent, self.bristles.nearest
        return np.asarray(yielding_rate(np.asarray(deflection), speed, strength, direction, *numbers))[()]

    def force(self, deflection: Real, rate: Real, speed: Real) -> Real:
        """Friction force [N]."""
        del rate, speed
        return self.stiffness * deflection
