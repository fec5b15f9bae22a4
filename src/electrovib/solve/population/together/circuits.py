"""Source, return path and contact area of many fingers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.population.together.arrays import flat
from electrovib.solve.population.together.layers import Poles

if TYPE_CHECKING:
    from electrovib.physics.circuit import SeriesElement


@dataclass(frozen=True, eq=False, kw_only=True)
class ManyCircuits:
    """What surrounds the layers, each number shared or one for each finger.

    Parameters
    ----------
    area : float or ndarray, shape (fingers,)
        Contact area [m2].
    resistance : float or ndarray, shape (fingers,)
        Series resistance [ohm].
    elastance, rate : float or ndarray, shape (fingers,)
        One over the capacitance of the body [1/F], 0 for none, and the rate of its leak [1/s].
    second : float or ndarray, shape (fingers,)
        First contact area over that of a second, equal stack; 0 for none.
    charge : float or ndarray, shape (fingers,)
        Net charge of the body at time 0 [C].
    """

    area: Any
    resistance: Any
    elastance: Any
    rate: Any
    second: Any
    charge: Any = 0.0

    @classmethod
    def around(cls, *, area: Any, element: SeriesElement, second: Any) -> ManyCircuits:
        """Return the circuit of a series element with columns.

        `area`, `second` (fingers, 1) [m2].
        """
        return cls(
            area=flat(area),
            resistance=flat(element.resistance),
            elastance=flat(element.elastance),
            rate=flat(element.rate),
            second=flat(second),
            charge=flat(element.charge),
        )


def body_poles(circuit: ManyCircuits, fingers: int) -> Poles:
    """Return the capacitor of the body as a part in series."""
    regular = np.ones(fingers, bool)
    if isinstance(circuit.rate, np.ndarray):
        regular = circuit.rate > 0
    return Poles(
        rates=(circuit.rate,), residues=(circuit.area * circuit.elastance,), bound=(0.0,), regular=regular
    )


def is_there(value: Any) -> bool:
    """Return whether a number is not 0 for all fingers."""
    return isinstance(value, np.ndarray) or bool(value)
