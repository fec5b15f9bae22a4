"""Keys of the quantities of a stack: signals by name, and quantities of a layer or of the force law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class FieldOf:
    """Field of a layer [V/m]."""

    layer: str

    def __str__(self) -> str:
        """Write it as messages name it."""
        return f"field of '{self.layer}'"


@dataclass(frozen=True, slots=True)
class DisplacementOf:
    """Bound displacement in a layer [C/m2], without conducted charge."""

    layer: str

    def __str__(self) -> str:
        """Write it as messages name it."""
        return f"displacement of '{self.layer}'"


@dataclass(frozen=True, slots=True)
class AmplitudeOf:
    """Amplitude that the pressure of a force law depends on, by its name there and in the law's unit."""

    name: str

    def __str__(self) -> str:
        """Write it as messages name it."""
        return f"amplitude {self.name} of the force law"


Key: TypeAlias = str | FieldOf | DisplacementOf | AmplitudeOf
"""A text is the name of a signal that has one value at each time."""


def amplitudes_among(found: Mapping[Key, T]) -> dict[str, T]:
    """Return the amplitudes of the force law among quantities, by their names in the law."""
    return {key.name: row for key, row in found.items() if isinstance(key, AmplitudeOf)}
