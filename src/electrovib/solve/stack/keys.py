"""What is asked of a stack: quantities of one number, by their signal's name, and those of a layer or of the law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class FieldOf:
    """Field of a layer [V/m]."""

    layer: str


@dataclass(frozen=True, slots=True)
class DisplacementOf:
    """Displacement in a layer [C/m2], without what conducts."""

    layer: str


@dataclass(frozen=True, slots=True)
class AmplitudeOf:
    """What the pressure of a force law takes, by its name there and in the law's unit."""

    name: str


Key: TypeAlias = str | FieldOf | DisplacementOf | AmplitudeOf
"""A text is the name of a signal of one number at a time."""
