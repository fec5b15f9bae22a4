"""Signals that end a process, turned into one exception while a bench is in use."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from electrovib.bench.faults import BenchStopped

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

_STOPPING: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
_REPEATED: Final = "SIGALRM"
"""The command line repeats an interrupt by it."""


class Stops:
    """What has asked the process to end while a bench is in use: the first signal raises once, later ones only wait.

    An exception in a signal handler can be lost: Python only prints what a callback raises, and a compiled
    library whose import is interrupted raises an ImportError instead. So the signal is kept too, and `check`
    raises for it again.
    """

    def __init__(self) -> None:
        self.first: signal.Signals | None = None
        self.is_held = False

    def received(self, number: int, frame: FrameType | None) -> None:
        """Keep the first signal and raise for it, unless signals are held."""
        del frame
        if self.first is None:
            self.first = signal.Signals(number)
            self.check()

    def check(self) -> None:
        """Raise if the process was asked to end."""
        error = self.error()
        if error is not None and not self.is_held:
            raise error

    def error(self) -> KeyboardInterrupt | BenchStopped | None:
        """Return the exception of the first signal, or None."""
        if self.first is None:
            return None
        return KeyboardInterrupt() if self.first == signal.SIGINT else BenchStopped(self.first.name)


@contextmanager
def stopping_signals() -> Iterator[Stops]:
    """Raise KeyboardInterrupt or `BenchStopped` at the first signal that asks the process to end, and keep it.

    With `is_held` set nothing is raised any more. A signal that came then, or whose exception was lost, is
    sent again after the block, unless the block raises. Only the main thread receives signals; in another one
    nothing is changed.
    """
    stops = Stops()
    if threading.current_thread() is not threading.main_thread():
        yield stops
        return
    known = [getattr(signal, name) for name in (*_STOPPING, _REPEATED) if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in known}
    repeated = before.get(getattr(signal, _REPEATED, None))

    def again(number: int, frame: FrameType | None) -> None:
        if not stops.is_held and callable(repeated):
            repeated(number, frame)

    try:
        for number in known:
            signal.signal(number, again if number.name == _REPEATED else stops.received)
        yield stops
    finally:
        for number, former in reversed(before.items()):  # SIGINT last: its handler may raise at once
            signal.signal(number, former)
    if stops.first is not None:
        signal.raise_signal(stops.first)
