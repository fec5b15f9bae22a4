"""Time on a bench: that of the system, or a simulated one that passes only while the program waits."""

from __future__ import annotations

import time
from typing import Protocol


class BenchClock(Protocol):
    """A clock that can be read and waited for."""

    def now(self) -> float:
        """Return the time [s] since any fixed instant."""

    def sleep(self, duration: float) -> None:
        """Wait for a duration [s]."""


class SystemClock:
    """The clock of the system."""

    def now(self) -> float:
        """Return the time [s] since any fixed instant."""
        return time.monotonic()

    def sleep(self, duration: float) -> None:
        """Wait for a duration [s]."""
        time.sleep(duration)


class SimulatedClock:
    """A clock that advances only in `sleep`."""

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        """Return the time [s] since its beginning."""
        return self._now

    def sleep(self, duration: float) -> None:
        """Advance by a duration [s]."""
        self._now += max(duration, 0.0)
