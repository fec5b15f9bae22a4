"""Result of the reduction of a swipe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from electrovib.recordings.swipe.baseline import Estimate

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, kw_only=True, repr=False)
class SwipeResult:
    """One swipe, reduced to forces and friction.

    - `normal_force`, `lateral_force`: means over the window [N]; the lateral force is positive in the
      direction of the friction of this swipe.
    - `direction`: 1 if the position increases, else -1; without a position, the sign of the lateral force.
    - `speed`, `distance`: mean speed in the window and sliding distance of the whole slide. Without a
      position the speed is the declared one; None if not known.
    - `trace`: whole record, with the baseline of this swipe subtracted.
    """

    normal_force: Estimate
    lateral_force: Estimate
    friction: Estimate
    direction: int
    speed: float | None
    distance: float | None
    contact: tuple[float, float]
    window: tuple[float, float]
    words: tuple[str, ...]
    trace: xarray.Dataset

    def __repr__(self) -> str:
        return "\n".join(self.words)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and texts for JSON, in SI, without the Trace."""
        return {
            "normal_force": self.normal_force.to_dict(),
            "lateral_force": self.lateral_force.to_dict(),
            "friction": self.friction.to_dict(),
            "direction": self.direction,
            "speed": self.speed,
            "distance": self.distance,
            "contact": list(self.contact),
            "window": list(self.window),
            "words": list(self.words),
        }
