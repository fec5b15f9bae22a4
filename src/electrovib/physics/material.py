"""Dielectrics: relative permittivity over frequency, conduction declared apart from polarisation."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.arrays import Complex
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.lamps import Lamp
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.debye_sum import DebyeSum

if TYPE_CHECKING:
    from collections.abc import Mapping


_CONDUCTIVITY = Quantity("S/m", 0, 1e3, "conductivity at zero frequency")
_HIGH = Quantity("1", 1, 1e9, "relative permittivity far above the band")
_STRENGTH = Quantity("1", 0, 1e12, "rise of the relative permittivity from above to below the relaxation")
_TIME = Quantity("s", 1e-15, 1e6, "relaxation time")
_BROADENING = Quantity("1", 0, 0.999, "0 for one relaxation time, towards 1 for a wide spread of them")
_NAN_PASSES = np.errstate(invalid="ignore")
"""A NaN in a frequency is handed on; numpy would warn of it when it divides complex numbers."""


class Material(Model, family=True):
    """What fills a layer.

    Notes
    -----
    Time factor exp(+j w t), eps* = eps' - j eps''; eps*(w) = polarisation(w) + conductivity/(j w eps0).
    Passive: Im eps* <= 0 at all frequencies. Every member declares its `conductivity` at zero frequency.
    """

    offered_by: ClassVar[tuple[str, ...]] = ("skins", "materials")

    @classmethod
    def from_offer(cls, offer: Any) -> Self:
        """Take the material out of a published skin, or as it is."""
        return cls.model_validate(getattr(offer, "material", offer))

    if TYPE_CHECKING:  # a parameter of most members; a mixture has it from its parts

        @property
        def conductivity(self) -> float:
            """Conductivity at zero frequency [S/m]."""

    @abstractmethod
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone.

        Parameters
        ----------
        frequency : array_like
            Hz, above 0, any shape; NaN gives NaN.

        Returns
        -------
        ndarray of complex
            Same shape, without conduction.
        """

    @_NAN_PASSES
    def complex_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity with conduction.

        Parameters
        ----------
        frequency : array_like
            Hz, above 0, any shape; NaN gives NaN.

        Returns
        -------
        ndarray of complex
            eps' - j eps'', 1, same shape.
        """
        angular = 2 * np.pi * np.asarray(frequency, dtype=float)
        total: Complex = self.polarisation(frequency) + self.conductivity / (
            1j * angular * VACUUM_PERMITTIVITY
        )
        return total

    def debye(self) -> DebyeSum | None:
        """Give the finite sum of Debye terms this material is, or None if it is not one."""
        return None

    @property
    def pulling_share(self) -> float:
        """Share of the area on which the field of this layer pulls; a bridge that conducts does not."""
        return 1.0

    def conducting(self, conductivity: float) -> Self:
        """Give the same material with another conductivity at zero frequency [S/m]."""
        return self.model_copy(update={"conductivity": conductivity})

    @property
    def slowest_relaxation(self) -> float | None:
        """Longest relaxation time a reduction may use [s]; None for no limit."""
        return None

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency at which the material is known [Hz]; a formula is, everywhere."""
        return 0.0, math.inf

    def lamps(self, name: str) -> tuple[Lamp, ...]:
        """Say how far the values of this material can be believed, in the layer of this name."""
        del name
        return ()


def _axis(frequency: ArrayLike) -> Complex:
    """Give j w."""
    axis: Complex = 2j * np.pi * np.asarray(frequency, dtype=float)
    return axis


def _level(value: float, frequency: ArrayLike) -> Complex:
    """Give the same number at all frequencies, NaN where the frequency is NaN."""
    return np.full(np.shape(frequency), value, complex) + 0 * _axis(frequency)


class Constant(Material):
    """A dielectric without dispersion."""

    equation: ClassVar[Mapping[str, str]] = {"polarisation": "permittivity"}
    example: ClassVar[Mapping[str, Any]] = {"permittivity": 3.35}

    permittivity: Annotated[Number, Quantity("1", 1, 1e9, "relative permittivity")]
    conductivity: Annotated[Number, _CONDUCTIVITY] = 0.0

    @_NAN_PASSES
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone, the same at all frequencies."""
        return _level(self.permittivity, frequency)

    def debye(self) -> DebyeSum:
        """Give the sum with no term at all."""
        return DebyeSum(self.permittivity, (), ())


class Debye(Material):
    """A dielectric with one relaxation time."""

    equation: ClassVar[Mapping[str, str]] = {
        "polarisation": "permittivity_high + strength/(1 + 2*pi*I*frequency*relaxation_time)"
    }
    example: ClassVar[Mapping[str, Any]] = {
        "permittivity_high": 4,
        "strength": 1100,
        "relaxation_time": 32e-9,
        "conductivity": 2e-4,
    }

    permittivity_high: Annotated[Number, _HIGH]
    strength: Annotated[Number, _STRENGTH]
    relaxation_time: Annotated[Number, _TIME]
    conductivity: Annotated[Number, _CONDUCTIVITY]

    @_NAN_PASSES
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        return self.debye().permittivity(frequency)

    def debye(self) -> DebyeSum:
        """Give the sum of one term."""
        return DebyeSum(self.permittivity_high, (self.strength,), (self.relaxation_time,))


class DebyeTerm(Model):
    """One relaxation of a Prony sum."""

    equation: ClassVar[Mapping[str, str]] = {
        "polarisation": "strength/(1 + 2*pi*I*frequency*relaxation_time)"
    }
    example: ClassVar[Mapping[str, Any]] = {"strength": 100, "relaxation_time": 1e-3}

    strength: Annotated[Number, _STRENGTH]
    relaxation_time: Annotated[Number, _TIME]

    @_NAN_PASSES
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Contribution to the relative permittivity [1] at frequencies [Hz] above 0; NaN gives NaN."""
        part: Complex = self.strength / (1 + _axis(frequency) * self.relaxation_time)
        return part


class Prony(Material):
    """A sum of Debye relaxations: any passive dielectric, as closely as there are terms."""

    example: ClassVar[Mapping[str, Any]] = {
        "permittivity_high": 50,
        "terms": [{"strength": 900, "relaxation_time": 2e-3}, {"strength": 300, "relaxation_time": 2e-5}],
        "conductivity": 1e-6,
    }

    permittivity_high: Annotated[Number, _HIGH]
    terms: Annotated[tuple[DebyeTerm, ...], Field(description="relaxations that are added")]
    conductivity: Annotated[Number, _CONDUCTIVITY]

    @_NAN_PASSES
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        parts = [term.polarisation(frequency) for term in self.terms]
        return sum(parts, start=_level(self.permittivity_high, frequency))

    def debye(self) -> DebyeSum:
        """Give the sum itself."""
        strengths = tuple(term.strength for term in self.terms)
        return DebyeSum(self.permittivity_high, strengths, tuple(term.relaxation_time for term in self.terms))


class ColeColeTerm(Model):
    """One broadened relaxation of a Cole-Cole dielectric."""

    reference: ClassVar[str] = "doi:10.1063/1.1750906"
    equation: ClassVar[Mapping[str, str]] = {
        "polarisation": "strength/(1 + (2*pi*I*frequency*relaxation_time)**(1 - broadening))"
    }
    example: ClassVar[Mapping[str, Any]] = {"strength": 280, "relaxation_time": 8e-8, "broadening": 0.16}

    strength: Annotated[Number, _STRENGTH]
    relaxation_time: Annotated[Number, _TIME]
    broadening: Annotated[Number, _BROADENING] = 0.0

    @_NAN_PASSES
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Contribution to the relative permittivity [1] at frequencies [Hz] above 0; NaN gives NaN."""
        part: Complex = self.strength / (
            1 + (_axis(frequency) * self.relaxation_time) ** (1 - self.broadening)
        )
        return part


class ColeCole(Material):
    """A sum of relaxations, each broadened symmetrically."""

    reference: ClassVar[str] = "doi:10.1063/1.1750906"
    example: ClassVar[Mapping[str, Any]] = {
        "permittivity_high": 4,
        "terms": [{"strength": 3e4, "relaxation_time": 1.6e-3, "broadening": 0.2}],
        "conductivity": 4e-4,
    }

    permittivity_high: Annotated[Number, _HIGH]
    terms: Annotated[tuple[ColeColeTerm, ...], Field(description="relaxations that are added")]
    conductivity: Annotated[Number, _CONDUCTIVITY]

    @_NAN_PASSES
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        parts = [term.polarisation(frequency) for term in self.terms]
        return sum(parts, start=_level(self.permittivity_high, frequency))

    def debye(self) -> DebyeSum | None:
        """Give the finite sum when no term is broadened."""
        if any(term.broadening for term in self.terms):
            return None
        strengths = tuple(term.strength for term in self.terms)
        return DebyeSum(self.permittivity_high, strengths, tuple(term.relaxation_time for term in self.terms))


class HavriliakNegami(Material):
    """A dielectric with one relaxation, broadened and skewed.

    Notes
    -----
    Only broadness <= 1 and broadness * skewness <= 1: outside, the dielectric may still be passive but has
    no form with non-negative Debye weights, hence no relaxation-time distribution.
    """

    reference: ClassVar[str] = "doi:10.1016/0032-3861(67)90021-3"
    equation: ClassVar[Mapping[str, str]] = {
        "polarisation": "permittivity_high"
        " + strength/(1 + (2*pi*I*frequency*relaxation_time)**broadness)**skewness"
    }
    example: ClassVar[Mapping[str, Any]] = {
        "permittivity_high": 5,
        "strength": 2000,
        "relaxation_time": 1e-3,
        "broadness": 0.8,
        "skewness": 0.7,
        "conductivity": 1e-6,
    }

    permittivity_high: Annotated[Number, _HIGH]
    strength: Annotated[Number, _STRENGTH]
    relaxation_time: Annotated[Number, _TIME]
    broadness: Annotated[Number, Quantity("1", 0.01, 1, "1 for one relaxation time, towards 0 for many")]
    skewness: Annotated[Number, Quantity("1", 0.01, 100, "1 for a symmetric spread; broadness*skewness <= 1")]
    conductivity: Annotated[Number, _CONDUCTIVITY]

    @model_validator(mode="after")
    def _has_distribution(self) -> Self:
        product = self.broadness * self.skewness
        if product > 1:
            why = f"broadness * skewness is {product:g}: only up to 1 is it a sum of relaxations; lower one"
            raise PydanticCustomError("skewness", "{why}", {"why": why})
        return self

    @_NAN_PASSES
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        spread = (_axis(frequency) * self.relaxation_time) ** self.broadness
        total: Complex = self.permittivity_high + self.strength / (1 + spread) ** self.skewness
        return total


class ConstantPhase(Material):
    """A dielectric whose loss angle is the same at all frequencies: eps' falls as a power of frequency.

    Notes
    -----
    eps*(f) = eps'(f0) (j f/f0)^(n-1)/cos((n-1) pi/2); n is the exponent of its admittance Y ~ (j w)^n, so a
    Cole admittance Y = G0 + Q (j w)^n is this material with a conductivity. It has no finite limit at low
    frequency: valid inside the band in which it was measured.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "polarisation": "permittivity*(I*frequency/reference_frequency)**(exponent - 1)"
        "/cos((exponent - 1)*pi/2)"
    }
    example: ClassVar[Mapping[str, Any]] = {
        "permittivity": 1560,
        "reference_frequency": 50.9,
        "exponent": 0.7545,
        "conductivity": 1e-6,
    }

    permittivity: Annotated[Number, Quantity("1", 1, 1e9, "eps' at the reference frequency")]
    reference_frequency: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "where eps' is given")]
    exponent: Annotated[Number, Quantity("1", 0.05, 0.9999, "exponent n of the admittance, 1 for no loss")]
    conductivity: Annotated[Number, _CONDUCTIVITY]

    @_NAN_PASSES
    def polarisation(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        power = self.exponent - 1
        ratio = 1j * np.asarray(frequency, dtype=float) / self.reference_frequency
        total: Complex = self.permittivity * ratio**power / math.cos(power * math.pi / 2)
        return total
