"""Short forms in which the library writes its values down, in the units of the sources."""

from __future__ import annotations

from typing import Final

from electrovib.physics.material.library.record import BreakdownStrength, SourcedValue

MICROMETRE: Final = 1e-6
MEGAVOLT_PER_METRE: Final = 1e6
VOLT_PER_MIL: Final = 1 / 25.4e-6
"""V/m."""
OHM_CENTIMETRE: Final = 1e-2
"""Ohm m."""


def permittivity(value: float, conditions: str, source: str, status: str) -> SourcedValue:
    """Declare a relative permittivity."""
    return SourcedValue(value=value, unit="1", conditions=conditions, source=source, status=status)


def from_resistivity(resistivity: float, conditions: str, source: str, status: str) -> SourcedValue:
    """Declare a conductivity [S/m] by the resistivity [ohm m] that a source prints."""
    return SourcedValue(
        value=1 / resistivity, unit="S/m", conditions=conditions, source=source, status=status
    )


def strength(
    value: float, thickness: float | tuple[float, float] | None, conditions: str, source: str, status: str
) -> BreakdownStrength:
    """Declare a breakdown strength [V/m] with the thickness at which it was measured [m].

    `thickness` is one, or the thinnest and the thickest; None if the source does not state it.
    """
    edges = (thickness, thickness) if isinstance(thickness, float) else thickness
    return BreakdownStrength(
        value=value, unit="V/m", thickness=edges, conditions=conditions, source=source, status=status
    )
