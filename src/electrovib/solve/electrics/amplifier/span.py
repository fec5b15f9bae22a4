"""One thing that an amplifier with limits does, from one change to the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.solve.electrics.amplifier.course import Course

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


@dataclass(frozen=True, eq=False, kw_only=True)
class Span:
    """What an amplifier does from one change to the next.

    Parameters
    ----------
    start : float
        s.
    mode : int
        1 or -1 at its largest current of that sign, 0 at its voltage.
    held : int
        1 or -1 while its aim is held at its largest voltage of that sign, else 0.
    course : Course or None
        The plate; where it follows the drive, its distance from what it would do without limits, or None for none.
    states : ndarray, shape (modes,)
        At the beginning [V], of the same.
    slack : float
        By how much more a current may pass its limit [A]: rounding of when it left a limit that it stays near.
    """

    start: float
    mode: int
    held: int
    course: Course | None
    states: Real
    slack: float = 0.0

    @property
    def follows(self) -> bool:
        """Tell whether the plate follows the drive."""
        return self.mode == 0 and self.held == 0
