"""A gap that follows load, attraction and the repulsion of the surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable


class Repelling(Protocol):
    """Repulsive pressure between finger and plate."""

    def pressure(self, gap: Any) -> Any:
        """Return the pressure [Pa] at a gap [m]; it decreases with the gap."""


@dataclass(frozen=True, kw_only=True)
class Yielding:
    """A gap that follows load, attraction and the repulsive pressure of the surfaces.

    Parameters
    ----------
    surface : Repelling
        Repulsive pressure as a function of the gap.
    load : callable
        Pressure of the load [Pa] at a time [s].
    start : float
        Gap at time 0, at rest [m].
    damping : float
        Damping per area [Pa s/m], above 0 unless there is a mass.
    mass : float
        Mass per area [kg/m2]; 0 for overdamped motion.
    pulling : float
        Share of the area on which the field of the gap attracts.
    together : callable, optional
        Pressure of load and attraction together [Pa] at a time [s] and a pressure of attraction [Pa], on an area that
        grows with both; by default their sum.
    """

    surface: Repelling
    load: Callable[[float], float]
    start: float
    damping: float = 0.0
    mass: float = 0.0
    pulling: float = 1.0
    together: Callable[[float, float], float] | None = None

    def __post_init__(self) -> None:
        """Refuse a gap without damping and mass."""
        if self.damping <= 0 and self.mass <= 0:
            raise InputError("damping = 0 and mass = 0: nothing slows the gap down; give one of them")
