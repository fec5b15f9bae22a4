"""What a swipe is reduced to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from electrovib.recordings.swipe_baseline import (
    Estimate,
)

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, kw_only=True)
class SwipeResult:
    """One swipe, reduced.

    Parameters
    ----------
    normal_force, lateral_force : Estimate
        Mean over the window [N]; the lateral force counts along the side to which friction pulls here.
    friction : Estimate
        Their ratio [1].
    direction : int
        1 where the position grows, else -1; without a position, that of the lateral force.
    speed, way : float or None
        Mean speed in the window [m/s], way of the whole slide [m]; without a position the speed is the stated one, and
        what is not known is None.
    contact, window : tuple of float
        Begin and end [s].
    words : tuple of str
        What was decided, and what cannot be.
    trace : Trace
        The whole record with this swipe's baseline taken off.
    """

    normal_force: Estimate
    lateral_force: Estimate
    friction: Estimate
    direction: int
    speed: float | None
    way: float | None
    contact: tuple[float, float]
    window: tuple[float, float]
    words: tuple[str, ...]
    trace: xarray.Dataset

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers and words for JSON, in SI, without the Trace."""
        return {
            "normal_force": self.normal_force.to_dict(),
            "lateral_force": self.lateral_force.to_dict(),
            "friction": self.friction.to_dict(),
            "direction": self.direction,
            "speed": self.speed,
            "way": self.way,
            "contact": list(self.contact),
            "window": list(self.window),
            "words": list(self.words),
        }
