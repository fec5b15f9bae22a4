"""The form of a stack over time that a force law reads where there are no modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.interface import Role

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.material import Material
from electrovib.solve.stack.section import _APART


@dataclass(frozen=True, kw_only=True)
class TimeLayer:
    """State of a layer as values over time, shape (n,)."""

    thickness: Any
    material: Material
    field: Real
    displacement: Real


@dataclass(frozen=True, kw_only=True)
class TimeSection:
    """The stack as values over time, for solvers without modes: moving gap, several leaks."""

    layers: dict[str, TimeLayer]
    roles: Mapping[str, Role]
    voltage: Real
    current_density: Real
    interface_displacement: Real

    @property
    def frequency(self) -> Real:
        """Raise a TypeError: a law that reads the frequency has no time-domain form."""
        raise TypeError("a record has no single frequency")

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self.layers)

    def __getitem__(self, name: str) -> TimeLayer:
        """Return a layer by its name."""
        return self.layers[name]

    def inverse_root_thickness(self, names: Sequence[str]) -> Any:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2], which must not be dispersive."""
        total: Any = 0.0
        for name in names:
            low, high = (self[name].material.bound_permittivity(np.array(f)) for f in _APART)
            if abs(low - high) > 1e-12 * abs(high):
                raise InputError(
                    f"stack.{name}.material: the force law filters by permittivities, and this one depends on frequency; with"
                    " this gap, leak or amplifier use force.model = MaxwellStressInGap, or a non-dispersive material"
                )
            total = total + self[name].thickness / float(high.real)
        return total**-0.5
