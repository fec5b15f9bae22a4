"""The form in which a force law sees a stack over time, where there are no modes."""

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
    """A layer's state as numbers over time, shape (n,)."""

    thickness: Any
    material: Material
    field: Real
    displacement: Real


@dataclass(frozen=True, kw_only=True)
class TimeSection:
    """The stack as a solver found it over time, where it has no modes: gap in motion, several leaks."""

    layers: dict[str, TimeLayer]
    roles: Mapping[str, Role]
    voltage: Real
    current_density: Real
    interface_displacement: Real

    @property
    def frequency(self) -> Real:
        """Refuse: a law that asks for the frequency has no time-domain form.

        Raises
        ------
        TypeError
            Always.
        """
        raise TypeError("a record has no single frequency")

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self.layers)

    def __getitem__(self, name: str) -> TimeLayer:
        """Look up a layer."""
        return self.layers[name]

    def inverse_root_thickness(self, names: Sequence[str]) -> Any:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2], where nothing in them disperses.

        Raises
        ------
        InputError
            If a permittivity depends on frequency: the filter needs modes, which this stack has not.
        """
        total: Any = 0.0
        for name in names:
            low, high = (self[name].material.bound_permittivity(np.array(f)) for f in _APART)
            if abs(low - high) > 1e-12 * abs(high):
                raise InputError(
                    f"stack.{name}.material: the law filters by permittivities, which depend on frequency here; with this"
                    " gap, leak or amplifier use force.model = MaxwellStressInGap, or a material that does not disperse"
                )
            total = total + self[name].thickness / float(high.real)
        return total**-0.5
