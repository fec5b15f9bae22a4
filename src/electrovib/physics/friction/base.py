"""The load, and the family of frictions."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.time_profile import Steady, TimeProfile

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike


FOLLOWED = "friction of steady sliding, which this one follows"


class Load(Model):
    """Load of the finger: normal force and its time profile."""

    equation: ClassVar[Mapping[str, str]] = {"forces": "normal_force*time_profile.share(time)"}
    example: ClassVar[Mapping[str, Any]] = {"normal_force": 0.5}

    normal_force: Annotated[
        Number, Quantity("N", 0, 1e3, "normal force on the finger, times its profile in time")
    ]
    time_profile: TimeProfile = Steady()

    def forces(self, time: ArrayLike) -> Real:
        """Return the normal force of the load [N] at times [s]."""
        return np.asarray(self.normal_force * self.time_profile.share(time))


class Friction(Model, family=True):
    """Friction of a finger on the plate.

    Notes
    -----
    A member belongs to one of three families: `SteadyFriction` without memory, `FollowingFriction` with a linear memory,
    `BristleFriction` with a state of its own, which declares in `deflects` that the contact deflects before it slides: friction
    and skin are then solved together by time stepping.
    """

    deflects: ClassVar[bool] = False

    @abstractmethod
    def without_memory(self) -> SteadyFriction:
        """Return the law of steady sliding that this friction is, or follows."""

    def memory(self, speed: Real) -> tuple[tuple[float, Real], ...]:
        """Return the parts of the friction that follow the law of steady sliding, with their rates.

        Parameters
        ----------
        speed : float or ndarray
            Sliding speed [m/s]; NaN where none is stated.

        Returns
        -------
        parts : tuple of (float, float or ndarray)
            Share of each part [1] and the rate at which it relaxes [1/s], above 0, of the shape of `speed`; NaN where
            the rate depends on the speed and none is stated.
        """
        del speed
        raise InputError(
            f"friction = {type(self).__name__}: no solver; derive it from SteadyFriction, FollowingFriction or BristleFriction"
        )

    @property
    def has_memory(self) -> bool:
        """Whether the friction depends on the past, because it is not itself the law of steady sliding."""
        return self.without_memory() is not self


class SteadyFriction(Friction, family=True):
    """Friction of steady sliding, without memory.

    Notes
    -----
    A member declares in `proportional_to` its parameters to which the friction is proportional, in `is_linear` that the
    friction is a linear function of load and attraction, and in `needs_real_area` that it needs the real contact area.
    """

    never_negative: ClassVar[frozenset[str]] = frozenset({"lateral_force"})

    proportional_to: ClassVar[tuple[str, ...]] = ()
    is_linear: ClassVar[bool] = False
    needs_real_area: ClassVar[bool] = False

    @abstractmethod
    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Return the friction force of the sliding finger.

        Parameters
        ----------
        normal_force, electrostatic_force : float or ndarray, one shape
            Load and attraction [N]; NaN gives NaN.
        real_contact_area : float or ndarray, same shape
            Real contact area under load and attraction [m2]; NaN where the contact does not define it, which gives NaN in
            laws of the real area only.

        Returns
        -------
        lateral_force : float or ndarray, same shape
            Friction force [N].
        """

    def without_memory(self) -> SteadyFriction:
        """Return the law itself."""
        return self

    def memory(self, speed: Real) -> tuple[tuple[float, Real], ...]:
        """Return no parts: the law has no memory."""
        del speed
        return ()


class FollowingFriction(Friction, family=True):
    """Friction that relaxes linearly towards the friction of a law without memory.

    Notes
    -----
    F = (1 - sum share_i) F_steady + sum share_i F_i, F_i' = rate_i (F_steady - F_i).
    """

    steady: Annotated[SteadyFriction, Field(description=FOLLOWED)]

    def without_memory(self) -> SteadyFriction:
        """Return the law of steady sliding that this friction follows."""
        return self.steady

    @abstractmethod
    def memory(self, speed: Real) -> tuple[tuple[float, Real], ...]:
        """Return the parts of the friction that follow the law of steady sliding, with their rates [1/s], as `Friction` does."""
