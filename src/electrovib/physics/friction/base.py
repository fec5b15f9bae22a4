"""The load, and the family of frictions."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

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


class Coulomb(SteadyFriction):
    """Friction proportional to the sum of load and attraction (Coulomb's law)."""

    equation: ClassVar[Mapping[str, str]] = {
        "lateral_force": "coefficient*(normal_force + electrostatic_force)"
    }
    example: ClassVar[Mapping[str, Any]] = {"coefficient": 0.5}
    proportional_to: ClassVar[tuple[str, ...]] = ("coefficient",)
    is_linear: ClassVar[bool] = True

    coefficient: Annotated[Number, Quantity("1", 0, 100, "coefficient of friction of the sliding finger")]

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Return the friction force [N]."""
        del real_contact_area
        return self.coefficient * (normal_force + electrostatic_force)


class PowerLaw(SteadyFriction):
    """Friction with a coefficient that is a power of the sum of load and attraction.

    Notes
    -----
    mu = coefficient (W/at_force)^exponent with W the sum of load and attraction. Skin has a negative exponent: the
    coefficient falls with load on acrylic and glass (Warman and Ennos 2009), on aluminium by 46 % from 1 to 20 N
    (Seo 2009), which an exponent of -0.206 gives. Attraction then adds less friction than with a constant coefficient.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "lateral_force": "coefficient*at_force*(Abs(normal_force + electrostatic_force)/at_force)**(1 + exponent)"
        ""
    }
    example: ClassVar[Mapping[str, Any]] = {"coefficient": 0.6, "at_force": 1.0, "exponent": -0.206}
    proportional_to: ClassVar[tuple[str, ...]] = ("coefficient",)

    coefficient: Annotated[Number, Quantity("1", 0, 100, "coefficient of friction at at_force")]
    at_force: Annotated[
        Number, Quantity("N", 1e-4, 1e3, "sum of load and attraction to which the coefficient applies")
    ]
    exponent: Annotated[Number, Quantity("1", -0.99, 2, "power of the coefficient; negative for skin")]

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Return the friction force [N]."""
        del real_contact_area
        share = np.abs(normal_force + electrostatic_force) / self.at_force
        return np.asarray(self.coefficient * self.at_force * share ** (1 + self.exponent))[()]


class AdhesiveShear(SteadyFriction):
    """Friction as a shear strength times the real contact area.

    Notes
    -----
    F = shear_strength A_real: attraction increases friction by increasing the real contact area, which the contact has
    to define with a `surface`.
    """

    equation: ClassVar[Mapping[str, str]] = {"lateral_force": "shear_strength*real_contact_area"}
    example: ClassVar[Mapping[str, Any]] = {"shear_strength": 1e6}
    proportional_to: ClassVar[tuple[str, ...]] = ("shear_strength",)
    needs_real_area: ClassVar[bool] = True

    shear_strength: Annotated[Number, Quantity("Pa", 1, 1e10, "friction over the real contact area")]

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Return the friction force [N]."""
        del normal_force, electrostatic_force
        return self.shear_strength * real_contact_area


_COULOMB: Mapping[str, Any] = {"model": "Coulomb", "coefficient": 0.5}


class FirstOrderLag(FollowingFriction):
    """Friction that follows a steady law as a first-order low-pass, whose corner may rise with the sliding speed.

    Notes
    -----
    `steady_friction` is the friction of the law `steady`, and `speed` the sliding speed. Balasubramanian et al. 2025
    measured a first-order response whose corner rises by 13.8 Hz for each mm/s, a renewal length of 72.5 um,
    between 20 and 100 mm/s; the corner at one speed is not known from a source and has no default.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "corner": "cut_off + (speed - at_speed)/renewal_length",
        "friction'": "2*pi*corner(speed)*(steady_friction - friction)",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "steady": _COULOMB,
        "cut_off": 500.0,
        "at_speed": 0.02,
        "renewal_length": 72.5e-6,
    }

    cut_off: Annotated[
        Number, Quantity("Hz", 1e-3, 1e9, "corner frequency of the friction response at the speed at_speed")
    ]
    at_speed: Annotated[Number, Quantity("m/s", 0, 100, "sliding speed to which the corner applies")] = 0.0
    renewal_length: Annotated[
        Number | None,
        Quantity(
            "m",
            1e-9,
            1e3,
            "length that divides the change of speed to give the change of the corner; none if absent",
        ),
    ] = None

    def corner(self, speed: Real) -> Real:
        """Return the corner frequency of the response.

        Parameters
        ----------
        speed : float or ndarray
            Sliding speed [m/s]; NaN gives NaN.

        Returns
        -------
        corner : float or ndarray, same shape
            Corner frequency [Hz]; negative where the linear law is extrapolated too far below `at_speed`.
        """
        growth = 0.0 if self.renewal_length is None else 1 / self.renewal_length
        return np.asarray(self.cut_off + (speed - self.at_speed) * growth)[()]

    def memory(self, speed: Real) -> tuple[tuple[float, Real], ...]:
        """Return one part, the whole friction."""
        where = np.full(np.shape(speed), self.at_speed) if self.renewal_length is None else speed
        return ((1.0, 2 * np.pi * self.corner(where)),)


class Relaxation(Model):
    """One relaxation of friction.

    Notes
    -----
    `friction`, of which the share `share` counts, follows `steady_friction`, that of a law without memory.
    """

    equation: ClassVar[Mapping[str, str]] = {"friction'": "(steady_friction - friction)/time"}
    example: ClassVar[Mapping[str, Any]] = {"share": 0.2, "time": 70e-3}

    share: Annotated[Number, Quantity("1", 0, 1, "share of the friction that relaxes")]
    time: Annotated[Number, Quantity("s", 1e-9, 1e5, "relaxation time")]


class Creep(FollowingFriction):
    """Friction part of which follows a steady law by slow relaxations, as viscoelastic skin does.

    Notes
    -----
    `steady_friction` is the friction of the law `steady`; the friction `part.friction` of each relaxation follows it, and
    the share `part.share` of it counts. Real contact grows while skin relaxes under a load: finger pads relax with about
    4 ms, 70 ms and 1.4 s in normal indentation (Pawluk and Howe 1999, doi:10.1115/1.2835100); the shares of friction have
    to be given.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "part.friction'": "(steady_friction - part.friction)/part.time",
        "friction": "steady_friction + sum(part.share*(part.friction - steady_friction) for part in relaxations)",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "steady": _COULOMB,
        "relaxations": ({"share": 0.2, "time": 4e-3}, {"share": 0.2, "time": 70e-3}),
    }

    relaxations: Annotated[
        tuple[Relaxation, ...], Field(description="relaxations, in the order of their times")
    ]

    def memory(self, speed: Real) -> tuple[tuple[float, Real], ...]:
        """Return the relaxing parts, the same at every speed."""
        return tuple((each.share, np.full(np.shape(speed), 1 / each.time)) for each in self.relaxations)

    @model_validator(mode="after")
    def _at_most_all(self) -> Self:
        if not self.relaxations or sum(each.share for each in self.relaxations) > 1:
            raise ValueError("relaxations must be at least one, with shares that add up to 1 at most")
        times = [each.time for each in self.relaxations]
        if sorted(set(times)) != times:
            raise ValueError("relaxations must be in the order of their times, each once")
        return self
