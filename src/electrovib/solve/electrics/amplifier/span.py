"""One regime of an amplifier with limits, from one change to the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.solve.electrics.amplifier.course import Course

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


@dataclass(frozen=True, eq=False, kw_only=True)
class Span:
    """One regime of an amplifier with limits, from one change to the next.

    Parameters
    ----------
    start : float
        Beginning [s].
    mode : int
        1 or -1 at its largest current of that sign, 0 at its voltage.
    held : int
        1 or -1 while its target voltage is held at its largest voltage of that sign, else 0.
    course : Course or None
        Voltage of the plate; where the plate follows the drive, its deviation from the response without limits, or None
        for no deviation.
    states : ndarray, shape (modes,)
        States of the modes at the beginning [V]; deviations where `course` is one.
    slack : float
        By how much more a current may exceed its limit [A]: rounding at the time when it left a limit and stays near it.
    """

    start: float
    mode: int
    held: int
    course: Course | None
    states: Real
    slack: float = 0.0

    @property
    def follows(self) -> bool:
        """Return whether the plate follows the drive."""
        return self.mode == 0 and self.held == 0
