"""Dielectrics: of one permittivity, of one loss angle, and with relaxations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from electrovib.core.arrays import Complex
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.material.base import CONDUCTIVITY, NAN_PASSES, Material, axis, level

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


_HIGH = Quantity("1", 1, 1e9, "relative permittivity far above the band")
_STRENGTH = Quantity("1", 0, 1e12, "increase of the relative permittivity from above to below the relaxation")
_TIME = Quantity("s", 1e-15, 1e6, "relaxation time")
_BROADENING = Quantity("1", 0, 0.999, "0 for one relaxation time, towards 1 for a wide spread of them")


class Debye(Material):
    """A dielectric with one relaxation time."""

    equation: ClassVar[Mapping[str, str]] = {
        "bound_permittivity": "permittivity_high + strength/(1 + 2*pi*I*frequency*relaxation_time)"
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
    conductivity: Annotated[Number, CONDUCTIVITY]

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        return self.debye().permittivity(frequency)

    def debye(self) -> DebyeSum:
        """Return the sum of one term."""
        return DebyeSum(self.permittivity_high, (self.strength,), (self.relaxation_time,))


class DebyeTerm(Model):
    """One relaxation of a Prony sum."""

    equation: ClassVar[Mapping[str, str]] = {
        "bound_permittivity": "strength/(1 + 2*pi*I*frequency*relaxation_time)"
    }
    example: ClassVar[Mapping[str, Any]] = {"strength": 100, "relaxation_time": 1e-3}

    strength: Annotated[Number, _STRENGTH]
    relaxation_time: Annotated[Number, _TIME]

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Contribution to the relative permittivity [1] at frequencies [Hz] above 0; NaN gives NaN."""
        part: Complex = self.strength / (1 + axis(frequency) * self.relaxation_time)
        return part


class Prony(Material):
    """A sum of Debye relaxations, which approximates any passive relaxing dielectric with enough terms."""

    equation: ClassVar[Mapping[str, str]] = {
        "s": "2*pi*I*frequency",
        "relaxing": "sum(term.strength/(1 + s*term.relaxation_time) for term in terms)",
        "bound_permittivity": "permittivity_high + relaxing",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "permittivity_high": 50,
        "terms": [{"strength": 900, "relaxation_time": 2e-3}, {"strength": 300, "relaxation_time": 2e-5}],
        "conductivity": 1e-6,
    }

    permittivity_high: Annotated[Number, _HIGH]
    terms: Annotated[tuple[DebyeTerm, ...], Field(description="relaxations that are added")]
    conductivity: Annotated[Number, CONDUCTIVITY]

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        return _added(self.permittivity_high, self.terms, frequency)

    def debye(self) -> DebyeSum:
        """Return the sum itself."""
        return _debye_sum(self.permittivity_high, self.terms)


class ColeColeTerm(Model):
    """One broadened relaxation of a Cole-Cole dielectric."""

    reference: ClassVar[str] = "doi:10.1063/1.1750906"
    equation: ClassVar[Mapping[str, str]] = {
        "bound_permittivity": "strength/(1 + (2*pi*I*frequency*relaxation_time)**(1 - broadening))"
    }
    example: ClassVar[Mapping[str, Any]] = {"strength": 280, "relaxation_time": 8e-8, "broadening": 0.16}

    strength: Annotated[Number, _STRENGTH]
    relaxation_time: Annotated[Number, _TIME]
    broadening: Annotated[Number, _BROADENING] = 0.0

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Contribution to the relative permittivity [1] at frequencies [Hz] above 0; NaN gives NaN."""
        part: Complex = self.strength / (
            1 + (axis(frequency) * self.relaxation_time) ** (1 - self.broadening)
        )
        return part


class ColeCole(Material):
    """A sum of relaxations, each broadened symmetrically."""

    reference: ClassVar[str] = "doi:10.1063/1.1750906"
    equation: ClassVar[Mapping[str, str]] = {
        "s": "2*pi*I*frequency",
        "relaxing": "sum(term.strength/(1 + (s*term.relaxation_time)**(1 - term.broadening)) for term in terms)",
        "bound_permittivity": "permittivity_high + relaxing",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "permittivity_high": 4,
        "terms": [{"strength": 3e4, "relaxation_time": 1.6e-3, "broadening": 0.2}],
        "conductivity": 4e-4,
    }

    permittivity_high: Annotated[Number, _HIGH]
    terms: Annotated[tuple[ColeColeTerm, ...], Field(description="relaxations that are added")]
    conductivity: Annotated[Number, CONDUCTIVITY]

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        return _added(self.permittivity_high, self.terms, frequency)

    def debye(self) -> DebyeSum | None:
        """Return the finite sum if no term is broadened, None otherwise."""
        if any(term.broadening for term in self.terms):
            return None
        return _debye_sum(self.permittivity_high, self.terms)


class HavriliakNegami(Material):
    """A dielectric with one relaxation, broadened and skewed.

    Notes
    -----
    Limited to broadness <= 1 and broadness * skewness <= 1: beyond these the dielectric may still be passive, but it has no
    distribution of relaxation times with non-negative weights.
    """

    reference: ClassVar[str] = "doi:10.1016/0032-3861(67)90021-3"
    equation: ClassVar[Mapping[str, str]] = {
        "s": "2*pi*I*frequency",
        "bound_permittivity": "permittivity_high + strength/(1 + (s*relaxation_time)**broadness)**skewness",
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
    conductivity: Annotated[Number, CONDUCTIVITY]

    @model_validator(mode="after")
    def _has_distribution(self) -> Self:
        product = self.broadness * self.skewness
        if product > 1:
            why = f"broadness * skewness is {product:g}: a sum of relaxations needs at most 1; reduce one of the two"
            raise ValueError(why)
        return self

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        spread = (axis(frequency) * self.relaxation_time) ** self.broadness
        total: Complex = self.permittivity_high + self.strength / (1 + spread) ** self.skewness
        return total


def _added(high: float, terms: Sequence[DebyeTerm | ColeColeTerm], frequency: ArrayLike) -> Complex:
    """Add what relaxes to the relative permittivity far above the band."""
    return sum((term.bound_permittivity(frequency) for term in terms), start=level(high, frequency=frequency))


def _debye_sum(high: float, terms: Sequence[DebyeTerm | ColeColeTerm]) -> DebyeSum:
    strengths, times = [term.strength for term in terms], [term.relaxation_time for term in terms]
    return DebyeSum(high, tuple(strengths), tuple(times))


class Constant(Material):
    """A dielectric without dispersion."""

    equation: ClassVar[Mapping[str, str]] = {"bound_permittivity": "permittivity"}
    example: ClassVar[Mapping[str, Any]] = {"permittivity": 3.35}

    permittivity: Annotated[Number, Quantity("1", 1, 1e9, "relative permittivity")]
    conductivity: Annotated[Number, CONDUCTIVITY] = 0.0

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone, the same at all frequencies."""
        return level(self.permittivity, frequency=frequency)

    def debye(self) -> DebyeSum:
        """Return the sum without any relaxation."""
        return DebyeSum(self.permittivity, (), ())


class ConstantPhase(Material):
    """A dielectric with one loss angle at all frequencies: eps' falls as a power of the frequency.

    Notes
    -----
    eps*(f) = eps'(f0) (j f/f0)^(n-1)/cos((n-1) pi/2); n is the exponent of its admittance Y ~ (j w)^n, so a
    Cole admittance Y = G0 + Q (j w)^n is this material with a conductivity. The permittivity has no finite limit at low
    frequency: it is valid inside the band in which it was measured.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "bound_permittivity": "permittivity*(I*frequency/reference_frequency)**(exponent - 1)"
        "/cos((exponent - 1)*pi/2)"
    }
    example: ClassVar[Mapping[str, Any]] = {
        "permittivity": 1560,
        "reference_frequency": 50.9,
        "exponent": 0.7545,
        "conductivity": 1e-6,
    }

    permittivity: Annotated[Number, Quantity("1", 1, 1e9, "eps' at the reference frequency")]
    reference_frequency: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "frequency at which eps' is given")]
    exponent: Annotated[Number, Quantity("1", 0.05, 0.9999, "exponent n of the admittance, 1 for no loss")]
    conductivity: Annotated[Number, CONDUCTIVITY]

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        power = self.exponent - 1
        ratio = 1j * np.asarray(frequency, dtype=float) / self.reference_frequency
        total: Complex = self.permittivity * ratio**power / np.cos(power * np.pi / 2)
        return total
