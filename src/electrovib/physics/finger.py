"""The fingertip: lateral dynamics under friction, mass, spring and damper of the moving skin; and its moisture."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from electrovib.core.errors import InputError, Problem
from electrovib.core.model import Model, read_model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.stages import Resonance

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray


class Finger(Model, family=True):
    """Lateral response of the skin in contact to a lateral force.

    Notes
    -----
    Every member is one resonance with a static compliance, which the solver integrates.
    """

    never_negative: ClassVar[frozenset[str]] = frozenset(
        {"compliance", "compliance_at_rest", "natural_frequency", "damping_ratio"}
    )

    @abstractmethod
    def compliance_at_rest(self) -> float:
        """Return the displacement per constant force [m/N]."""

    @abstractmethod
    def natural_frequency(self) -> float:
        """Return the natural frequency without damping [Hz]."""

    @abstractmethod
    def damping_ratio(self) -> float:
        """Return the damping over the critical damping [1]."""

    @abstractmethod
    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the complex displacement per force [m/N] at frequencies [Hz]."""

    def resonance(self) -> Resonance:
        """Return the resonance that the solver integrates, to be scaled by `compliance_at_rest`."""
        return Resonance(self.natural_frequency(), self.damping_ratio())

    def lumped(self) -> tuple[float, float, float]:
        """Return mass [kg], stiffness [N/m] and damping [N s/m] of the resonance, for a friction whose contact deflects."""
        stiffness = 1 / self.compliance_at_rest()
        mass = stiffness / (2 * math.pi * self.natural_frequency()) ** 2
        return mass, stiffness, 2 * self.damping_ratio() * math.sqrt(stiffness * mass)

    def at_speed(self, speed: float | None) -> Finger:
        """Return the fingertip at a sliding speed; by default the same at all speeds.

        Parameters
        ----------
        speed : float or None
            Sliding speed [m/s]; None where none is stated.

        Returns
        -------
        Finger
            Fingertip at that speed.
        """
        del speed
        return self


class GrowthWithSpeed(Model):
    """Mass and stiffness that increase linearly with sliding speed.

    Notes
    -----
    The slopes are from the abstract of Balasubramanian, Pool and Vardar 2025 (ten persons, 20 to 100 mm/s, 0.2 to
    0.6 N). Their intercepts are not in the abstract, so mass and stiffness must be given at one known speed. Damping
    is taken as constant, because the abstract does not state its change.
    """

    reference: ClassVar[str] = "arXiv:2505.11162"
    status: ClassVar[str] = "abstract"
    equation: ClassVar[Mapping[str, str]] = {
        "added_mass": "mass_slope*(speed - known_at)",
        "added_stiffness": "stiffness_slope*(speed - known_at)",
    }
    example: ClassVar[Mapping[str, Any]] = {"known_at": 0.05}

    known_at: Annotated[Number, Quantity("m/s", 0, 10, "sliding speed at which mass and stiffness are given")]
    mass_slope: Annotated[
        Number,
        Quantity("kg s/m", -10, 10, "rise of the mass with sliding speed, abstract: 3.23e-5 kg per mm/s"),
    ] = 3.23e-2
    stiffness_slope: Annotated[
        Number,
        Quantity(
            "N s/m2", -1e6, 1e6, "rise of the stiffness with sliding speed, abstract: 4.04 N/m per mm/s"
        ),
    ] = 4.04e3

    def added_mass(self, speed: float) -> float:
        """Return the change of the mass from the speed at which it is given.

        Parameters
        ----------
        speed : float
            Sliding speed [m/s].

        Returns
        -------
        added_mass : float
            Mass at this speed less that at `known_at` [kg].
        """
        return self.mass_slope * (speed - self.known_at)

    def added_stiffness(self, speed: float) -> float:
        """Return the change of the stiffness from the speed at which it is given.

        Parameters
        ----------
        speed : float
            Sliding speed [m/s].

        Returns
        -------
        added_stiffness : float
            Stiffness at this speed less that at `known_at` [N/m].
        """
        return self.stiffness_slope * (speed - self.known_at)


class MassSpringDamper(Finger):
    """Lateral fingertip as one mass that is connected to the bone by a spring and a damper in parallel.

    Notes
    -----
    The model of skin as mass, damper and spring is that of the abstract of Balasubramanian, Pool and Vardar 2025. No
    value has a default, because no verified source is known. The orders of magnitude of Wiertlewski and Hayward 2012,
    cited from memory, unverified, are 1 kN/m, 1 N s/m and 0.1 to 0.2 g: elastic below about 100 Hz, viscous above,
    overdamped. They vary between persons and with load. One mass, spring and damper may not suffice at 0.05 to 0.5 N
    and 50 to 500 Hz (abstract, World Haptics 2005).
    """

    reference: ClassVar[str] = "arXiv:2505.11162"
    status: ClassVar[str] = "abstract"
    equation: ClassVar[Mapping[str, str]] = {
        "compliance": "1/(stiffness - mass*(2*pi*frequency)**2 + 2*pi*I*frequency*damping)",
        "compliance_at_rest": "1/stiffness",
        "natural_frequency": "sqrt(stiffness/mass)/(2*pi)",
        "damping_ratio": "damping/(2*sqrt(stiffness*mass))",
    }
    example: ClassVar[Mapping[str, Any]] = {"mass": 1.5e-4, "stiffness": 1e3, "damping": 1.0}

    mass: Annotated[Number, Quantity("kg", 1e-7, 1, "mass that moves with the skin of the contact")]
    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]
    damping: Annotated[Number, Quantity("N s/m", 1e-6, 1e4, "lateral damping of the fingertip")]
    growth: Annotated[
        GrowthWithSpeed | None, Field(description="rise of mass and stiffness with sliding speed")
    ] = None

    @np.errstate(invalid="ignore")  # NaN gives NaN
    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the complex displacement per force [m/N] at frequencies [Hz]."""
        angular = 2 * np.pi * np.asarray(frequency, dtype=float)
        return np.asarray(1 / (self.stiffness - self.mass * angular**2 + 1j * angular * self.damping))

    def compliance_at_rest(self) -> float:
        """Return the displacement per constant force [m/N]."""
        return 1 / self.stiffness

    def natural_frequency(self) -> float:
        """Return the natural frequency without damping [Hz]."""
        return math.sqrt(self.stiffness / self.mass) / (2 * math.pi)

    def damping_ratio(self) -> float:
        """Return the damping over the critical damping [1]."""
        return self.damping / (2 * math.sqrt(self.stiffness * self.mass))

    def lumped(self) -> tuple[float, float, float]:
        """Return mass [kg], stiffness [N/m] and damping [N s/m]."""
        return self.mass, self.stiffness, self.damping

    def at_speed(self, speed: float | None) -> MassSpringDamper:
        """Return the fingertip with mass and stiffness at a sliding speed [m/s]; their slopes were measured from 0.02 to 0.1."""
        if self.growth is None:
            return self
        if speed is None:
            raise InputError("finger.growth needs motion.speed, for instance motion.speed = '50 mm/s'")
        mass = self.mass + self.growth.added_mass(speed)
        stiffness = self.stiffness + self.growth.added_stiffness(speed)
        if not (mass > 0 and stiffness > 0):
            raise InputError(
                f"at {speed:g} m/s the mass would be {mass:.3g} kg and the stiffness {stiffness:.3g} N/m. Both must"
                " stay positive: give them at a speed nearer to this one.",
                path="finger.growth",
            )
        try:
            return read_model(
                MassSpringDamper, {"mass": mass, "stiffness": stiffness, "damping": self.damping}
            )
        except InputError as error:
            raise InputError(
                Problem(
                    f"at {speed:g} m/s {problem}. Give mass and stiffness at a speed nearer to this one.",
                    path="finger.growth",
                )
                for problem in error.problems
            ) from None


_CONDUCTANCE = Quantity("S/m2", 1e-9, 1e6, "conductance of the skin per area")
_RESISTIVITY = Quantity("ohm m", 1e-3, 1e18, "resistivity of the medium in the gap")
_COEFFICIENT = Quantity("1", 0, 100, "coefficient of friction")


class Moisture(Model):
    """Moisture of a finger, from dry to wet.

    Notes
    -----
    The conductance of the skin goes from 2 to 20 uS/cm2, the skin conductance levels of palmar skin as quoted by another
    source. For the resistivity of the gap and for friction no source of dry and wet values could be read: they have to be
    given. Conductance and resistivity are interpolated geometrically, the coefficient of friction linearly. Occlusion over
    time, menisci and their attraction are not modelled.
    """

    equation: ClassVar[dict[str, str]] = {
        "skin_conductivity": "thickness*dry_skin_conductance**(1 - level)*wet_skin_conductance**level",
        "gap_resistivity": "dry_gap_resistivity**(1 - level)*wet_gap_resistivity**level",
        "coefficient": "dry_coefficient*(1 - level) + wet_coefficient*level",
    }
    example: ClassVar[dict[str, Any]] = {
        "level": 0.5,
        "dry_gap_resistivity": 1e12,
        "wet_gap_resistivity": 1e6,
        "dry_coefficient": 0.4,
        "wet_coefficient": 0.8,
    }

    level: Annotated[Number, Quantity("1", 0, 1, "moisture of the finger, 0 for dry and 1 for wet")]
    dry_gap_resistivity: Annotated[Number, _RESISTIVITY]
    wet_gap_resistivity: Annotated[Number, _RESISTIVITY]
    dry_coefficient: Annotated[Number, _COEFFICIENT]
    wet_coefficient: Annotated[Number, _COEFFICIENT]
    dry_skin_conductance: Annotated[Number, _CONDUCTANCE] = 0.02
    wet_skin_conductance: Annotated[Number, _CONDUCTANCE] = 0.2

    def skin_conductivity(self, thickness: float) -> float:
        """Return the conductivity of the stratum corneum.

        Parameters
        ----------
        thickness : float
            Thickness of the stratum corneum [m].

        Returns
        -------
        conductivity : float
            Conductivity of the stratum corneum [S/m].
        """
        between: float = self.dry_skin_conductance ** (1 - self.level) * self.wet_skin_conductance**self.level
        return thickness * between

    def gap_resistivity(self) -> float:
        """Resistivity of the medium in the gap [ohm m]."""
        between: float = self.dry_gap_resistivity ** (1 - self.level) * self.wet_gap_resistivity**self.level
        return between

    def coefficient(self) -> float:
        """Coefficient of friction, dimensionless."""
        return self.dry_coefficient * (1 - self.level) + self.wet_coefficient * self.level
