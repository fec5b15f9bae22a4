"""A published set of electrical values of skin, with its source and status."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.citation import STATUSES

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.physics.material import Material


@dataclass(frozen=True, kw_only=True)
class Skin:
    """Electrical values of stratum corneum, or of skin that is used in its place.

    `name` is for legends; `status` says how far the `source` was read: one of
    `electrovib.core.citation.STATUSES`; `note` gives site, assumptions and limits of use. With
    `reproduces_force` false the time constant may be shown, but the set must not be used to predict a force.
    """

    name: str
    material: Material
    status: str
    source: str
    note: str
    reproduces_force: bool = True

    def __post_init__(self) -> None:
        """Refuse an unknown status."""
        if self.status not in STATUSES:
            msg = f"skin '{self.name}': status '{self.status}' is not one of {', '.join(STATUSES)}"
            raise ValueError(msg)


def time_constant(material: Material, frequency: ArrayLike) -> NDArray[np.float64]:
    """Relaxation time constant [s] of a dielectric at a frequency [Hz]: tau = eps0 eps' rho = eps'/(w eps'').

    Conduction is included in eps''.
    """
    permittivity = material.complex_permittivity(frequency)
    angular = 2 * np.pi * np.asarray(frequency, dtype=float)
    result: NDArray[np.float64] = permittivity.real / (-permittivity.imag * angular)
    return result
