"""Friction with a state: the contact deflects like bristles before it slides, so that stick-slip can occur."""

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
"""Relative distance from the strength within which Dahl's rate is linear for exponents below 1, whose slope diverges."""
_STIFFNESS = Quantity("N/m", 1e-3, 1e12, "stiffness of the contact before it slides")


class Bristles(NamedTuple):
    """Parameters of the bristle law z' = u left |left|^(exponent - 1), left = 1 - stiffness z sign(u)/g(u).

    Parameters
    ----------
    stiffness : float
        Stiffness of the contact before it slides [N/m].
    excess, stribeck_speed : float
        Parameters [1] and [m/s] of g(u) = strength (1 + excess exp(-(u/stribeck_speed)^2)).
    exponent : float
        Power with which the stiffness decreases [1].
    nearest : float
        Lower limit of |left| in the power [1]; 0 where the exponent is 1 or above.
    bristle_damping, viscous_damping : float
        Damping of the deflection and of the sliding [N s/m].
    """

    stiffness: float
    excess: float = 0.0
    stribeck_speed: float = 1.0
    exponent: float = 1.0
    nearest: float = 0.0
    bristle_damping: float = 0.0
    viscous_damping: float = 0.0


def strength_at_speed(speed: Any, strength: Any, excess: Any, stribeck_speed: Any) -> Any:
    """Return the strength [N] at a speed [m/s] from that of fast sliding [N], for numbers or arrays.

    strength (1 + excess exp(-(speed/stribeck_speed)^2)); the compiled time stepping uses this function too.
    """
    return strength * (1 + excess * np.exp(-((speed / stribeck_speed) ** 2)))


def yielding_rate(
    deflection: Any, speed: Any, level: Any, direction: Any, stiffness: Any, exponent: Any, nearest: Any
) -> Any:
    """Return the rate of the deflection [m/s] under the strength at its speed [N], for numbers or arrays.

    It is u left |left|^(exponent - 1) as in `Bristles`, with `level` as g(u); the compiled time stepping uses
    this function too.
    """
    left = 1 - direction * stiffness * deflection / level
    return speed * left * np.hypot(left, nearest) ** (exponent - 1)


class BristleFriction(Friction, family=True):
    """Friction of a contact that deflects before it slides.

    Notes
    -----
    `steady` is the law of friction at fast sliding, under the load and attraction of each instant. The state is the
    deflection z; the elastic energy is stiffness z^2/2.
    """

    deflects: ClassVar[bool] = True
    steady: Annotated[SteadyFriction, Field(description=FOLLOWED)]
    stiffness: Annotated[Number, _STIFFNESS]

    def without_memory(self) -> SteadyFriction:
        """Return the law of friction at fast sliding."""
        return self.steady

    def memory(self, speed: Real) -> tuple[tuple[float, Real], ...]:
        """Return no parts: what the friction remembers is the deflection of the contact."""
        del speed
        return ()

    @property
    def yields_smoothly(self) -> bool:
        """Whether the rate of the deflection is smooth where the bristles reach the strength."""
        return True

    @property
    def bristles(self) -> Bristles | None:
        """Parameters of the bristle law, for compiled time stepping; None for a law of another form."""
        return None

    def strength_at(self, speed: Real, strength: Real) -> Real:
        """Return the steady friction at a speed, without its viscous part.

        Parameters
        ----------
        speed : float or ndarray
            Sliding speed [m/s].
        strength : float or ndarray, same shape
            Friction of fast sliding [N].

        Returns
        -------
        strength : float or ndarray, same shape
            Steady friction at this speed [N].
        """
        return np.asarray(strength + 0 * np.asarray(speed))[()]

    @abstractmethod
    def deflection_rate(self, deflection: Real, speed: Real, strength: Real, direction: Real) -> Real:
        """Return the rate at which the contact deflects.

        Parameters
        ----------
        deflection : float or ndarray
            Deflection of the contact [m], along the motion.
        speed : float or ndarray, same shape
            Speed of the skin over the plate [m/s].
        strength : float or ndarray, same shape
            Friction of the steady law at this instant [N], above 0.
        direction : float or ndarray, same shape
            Sign of the speed, 1 or -1 [1], given separately because the law has a kink at speed 0.

        Returns
        -------
        rate : float or ndarray, same shape
            Rate of change of the deflection [m/s].
        """

    @abstractmethod
    def force(self, deflection: Real, rate: Real, speed: Real) -> Real:
        """Return the friction force on the skin, against the motion.

        Parameters
        ----------
        deflection : float or ndarray
            Deflection of the contact [m].
        rate : float or ndarray, same shape
            Rate of change of the deflection [m/s].
        speed : float or ndarray, same shape
            Speed of the skin over the plate [m/s].

        Returns
        -------
        friction_force : float or ndarray, same shape
            Friction force [N].
        """


class LuGre(BristleFriction):
    """Bristle friction whose strength decreases with speed, which allows stick-slip.

    Notes
    -----
    The law of Canudas de Wit et al. 1995 with the load in `strength_at` only: the elastic energy of the bristles does not
    depend on the load, and friction dissipates at every instant as long as bristle_damping is 0, or small compared with
    4 strength_at/abs(speed).
    """

    reference: ClassVar[str] = "C. Canudas de Wit et al., IEEE Trans. Autom. Control 40, 419 (1995)"
    status: ClassVar[str] = "derived"
    equation: ClassVar[Mapping[str, str]] = {
        "strength_at": "strength*(1 + (static_ratio - 1)*exp(-(speed/stribeck_speed)**2))",
        "deflection_rate": "speed*(1 - direction*stiffness*deflection/strength_at(speed, strength))",
        "force": "stiffness*deflection + bristle_damping*rate + viscous_damping*speed",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "steady": _COULOMB,
        "stiffness": 500.0,
        "static_ratio": 1.5,
        "stribeck_speed": 5e-3,
    }

    static_ratio: Annotated[Number, Quantity("1", 1, 100, "largest static over kinetic friction")]
    stribeck_speed: Annotated[Number, Quantity("m/s", 1e-9, 100, "speed that reduces the excess to 1/e")]
    bristle_damping: Annotated[Number, Quantity("N s/m", 0, 1e6, "damping of the deflection")] = 0.0
    viscous_damping: Annotated[Number, Quantity("N s/m", 0, 1e6, "damping of the sliding")] = 0.0

    def strength_at(self, speed: Real, strength: Real) -> Real:
        """Return the steady friction [N], larger at low speeds."""
        excess = self.static_ratio - 1
        return np.asarray(strength_at_speed(np.asarray(speed), strength, excess, self.stribeck_speed))[()]

    @property
    def bristles(self) -> Bristles:
        """Parameters of the bristle law."""
        damping = {"bristle_damping": self.bristle_damping, "viscous_damping": self.viscous_damping}
        return Bristles(self.stiffness, self.static_ratio - 1, self.stribeck_speed, **damping)

    def deflection_rate(self, deflection: Real, speed: Real, strength: Real, direction: Real) -> Real:
        """Return the rate of the deflection [m/s]."""
        level = self.strength_at(speed, strength)
        return np.asarray(yielding_rate(deflection, speed, level, direction, self.stiffness, 1.0, 0.0))[()]

    def force(self, deflection: Real, rate: Real, speed: Real) -> Real:
        """Return the friction force [N]."""
        return self.stiffness * deflection + self.bristle_damping * rate + self.viscous_damping * speed


class Dahl(BristleFriction):
    """Bristle friction after Dahl: the stiffness decreases to 0 as the force approaches the strength.

    Notes
    -----
    Steady sliding is at the strength, without a static excess, so the law alone gives no stick-slip. With an exponent below
    1 the strength is reached after a finite distance, and the rate is linear over the last 1e-8 of the strength. A
    simulation of a finger by others uses coefficient 0.6, 500 N/m and exponent 0.7.
    """

    reference: ClassVar[str] = "P. R. Dahl, Aerospace Corporation, TOR-0158(3107-18)-1 (1968)"
    status: ClassVar[str] = "derived"
    equation: ClassVar[Mapping[str, str]] = {
        "remaining": "1 - direction*stiffness*deflection/strength",
        "deflection_rate": "speed*sign(remaining)*Abs(remaining)**exponent",
        "force": "stiffness*deflection",
    }
    example: ClassVar[Mapping[str, Any]] = {"steady": _COULOMB, "stiffness": 500.0}

    exponent: Annotated[
        Number, Quantity("1", 0.5, 5, "power with which the stiffness decreases; 1 is an exponential")
    ] = 1.0

    @property
    def yields_smoothly(self) -> bool:
        """Whether |1 - r|^exponent sign(1 - r) is a polynomial, which it is for odd exponents."""
        return self.exponent % 2 == 1

    @property
    def bristles(self) -> Bristles:
        """Parameters of the bristle law."""
        nearest = _NEAREST if self.exponent < 1 else 0.0
        return Bristles(self.stiffness, exponent=self.exponent, nearest=nearest)

    def deflection_rate(self, deflection: Real, speed: Real, strength: Real, direction: Real) -> Real:
        """Return the rate of the deflection [m/s]."""
        numbers = self.stiffness, self.exponent, self.bristles.nearest
        return np.asarray(yielding_rate(np.asarray(deflection), speed, strength, direction, *numbers))[()]

    def force(self, deflection: Real, rate: Real, speed: Real) -> Real:
        """Return the friction force [N]."""
        del rate, speed
        return self.stiffness * deflection
