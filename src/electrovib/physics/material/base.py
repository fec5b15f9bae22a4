"""The family of dielectrics: relative permittivity over frequency, with conduction declared separately."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, field_validator

from electrovib.core.arrays import Complex, Real
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.discovery import find_members
from electrovib.core.errors import LONGEST_QUOTED, InputError, closest, shortened
from electrovib.core.model import Model
from electrovib.core.quantity import Quantity
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.material.library import (
    UNVERIFIED,
    Substance,
    find_substance,
    materials,
    nearest_substances,
)

CONDUCTIVITY = Quantity("S/m", 0, 1e3, "conductivity at zero frequency")
NAN_PASSES = np.errstate(invalid="ignore")
"""A NaN in a frequency gives NaN; numpy would warn of it when it divides complex numbers."""


class Material(Model, family=True):
    """The dielectric that fills a layer.

    Notes
    -----
    `substance` names the material of the library from which the breakdown strength of the layer is taken; a material
    that is taken from the library by its name has it.
    Time factor exp(+j w t), eps* = eps' - j eps''; eps*(w) = bound_permittivity(w) + conductivity/(j w eps0).
    Passive: Im eps* <= 0 at all frequencies. Every member declares its `conductivity` at zero frequency.
    """

    never_negative: ClassVar[frozenset[str]] = frozenset({"bound_permittivity", "complex_permittivity"})

    offered_by: ClassVar[tuple[str, ...]] = ("skins", "materials")
    later_parameters: ClassVar[frozenset[str]] = frozenset({"substance"})

    substance: Annotated[
        str | None, Field(description="material of the library, whose breakdown strength is taken")
    ] = None

    @field_validator("substance")
    @classmethod
    def _is_in_the_library(cls, name: str | None) -> str | None:
        if name is None:
            return None
        if (found := find_substance(name)) is None:
            raise ValueError(_not_in_the_library(name))
        return found.name

    @classmethod
    def is_offer(cls, text: str) -> bool:
        """Tell whether a text is the name of a material: every text in the place of its table is."""
        return bool(text)

    @classmethod
    def offer(cls, name: str) -> Any:
        """Find a material of the library by its name, or one that a paper offers as ``author_year/name``.

        Raises
        ------
        InputError
            If nothing has that name; the message has the nearest names.
        """
        if "/" in name:
            return super().offer(name)
        if (found := find_substance(name)) is None:
            model = closest(name, find_members(Material))  # type: ignore[type-abstract]
            table = f'; a model is chosen by a table, {{ model = "{model}", ... }}' if model else ""
            raise InputError(_not_in_the_library(name) + table)
        return found

    @classmethod
    def from_offer(cls, offer: Any) -> Self:
        """Return the material of a published skin or of the library, or a material as it is."""
        return cls.model_validate(getattr(offer, "material", offer))

    if TYPE_CHECKING:  # a parameter of most members; computed from the parts of a mixture

        @property
        def conductivity(self) -> float:
            """Conductivity at zero frequency [S/m]."""

    @abstractmethod
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone.

        Parameters
        ----------
        frequency : array_like
            Frequency [Hz], above 0, any shape; NaN gives NaN.

        Returns
        -------
        permittivity : ndarray of complex
            Relative permittivity eps' - j eps'' without conduction, dimensionless, same shape.
        """

    @NAN_PASSES
    def complex_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity with conduction.

        Parameters
        ----------
        frequency : array_like
            Frequency [Hz], above 0, any shape; NaN gives NaN.

        Returns
        -------
        permittivity : ndarray of complex
            eps' - j eps'', dimensionless, same shape.
        """
        angular = 2 * np.pi * np.asarray(frequency, dtype=float)
        total: Complex = self.bound_permittivity(frequency) + self.conductivity / (
            1j * angular * VACUUM_PERMITTIVITY
        )
        return total

    def debye(self) -> DebyeSum | None:
        """Return this material as a finite sum of Debye terms; None if it is not one.

        Returns
        -------
        DebyeSum or None
            Many fingers are computed in arrays where this method runs on columns too: parameters may then be arrays of
            shape (fingers, 1).
        """
        return None

    def table(self) -> tuple[Real, Complex] | None:
        """Return frequencies [Hz] and bound permittivities where it is a measured table; None for a formula."""
        return None

    def conduction_bounds(self) -> tuple[float, float] | None:
        """Return the least and the largest conductivity that a table allows [S/m]; None for a formula."""
        return None

    @property
    def pulling_share(self) -> float:
        """Share of the area on which the field of this layer attracts, dimensionless; less than 1 with conducting bridges."""
        return 1.0

    def conducting(self, conductivity: float) -> Self:
        """Return the same material with another conductivity at zero frequency [S/m]."""
        return self.model_copy(update={"conductivity": conductivity})

    @property
    def slowest_relaxation(self) -> float | None:
        """Longest relaxation time that a reduction may use [s]; None for no limit."""
        return None

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency at which the material is known [Hz]; 0 and infinite for a formula."""
        return 0.0, math.inf

    def diagnostics(self, name: str) -> tuple[Diagnostic, ...]:
        """State how reliable the values of this material are.

        Parameters
        ----------
        name : str
            Of the layer that it fills.

        Returns
        -------
        found : tuple of Diagnostic
            One if it takes values of the library that are unverified or unknown.
        """
        found = None if self.substance is None else find_substance(self.substance)
        return () if found is None else _doubtful(found, self.to_dict(), name)


def _doubtful(substance: Substance, table: dict[str, Any], layer: str) -> tuple[Diagnostic, ...]:
    """State which values that a layer takes from the library are unverified or unknown."""
    by_status: dict[str, list[str]] = {}
    for parameter, status in substance.taken_by(table).items():
        by_status.setdefault(status, []).append(parameter.replace("_", " "))
    parts = [
        f"{words}: {', '.join(by_status[status])}"
        for status, words in _DOUBTFUL.items()
        if status in by_status
    ]
    if not parts:
        return ()
    listed = f"'electrovib list {substance.name}' lists the sources"
    text = f"values of {substance.name} in '{layer}' are {'; '.join(parts)} ({listed})"
    return (Diagnostic(f"material, {layer}", "unknown", text),)


_DOUBTFUL: Final = {
    UNVERIFIED: "cited from memory, unverified",
    "unknown": "not found in a source and taken as 0",
}
"""Status of a value to the words for it."""


def _not_in_the_library(name: str) -> str:
    close = nearest_substances(name)
    listed = ", ".join(close or [each.name for each in materials()])
    quoted = shortened(name, LONGEST_QUOTED)
    return f"no material '{quoted}'. {'Nearest' if close else 'Known'}: {listed}; a paper's is named 'author_year/name'"


def axis(frequency: ArrayLike) -> Complex:
    """Return the imaginary angular frequency j w [1/s] of frequencies [Hz], any shape; NaN gives NaN."""
    result: Complex = 2j * np.pi * np.asarray(frequency, dtype=float)
    return result


def level(value: float, *, frequency: ArrayLike) -> Complex:
    """Return the same number at all frequencies, as a complex array; NaN where the frequency is NaN."""
    return np.asarray(value + 0 * axis(frequency))
