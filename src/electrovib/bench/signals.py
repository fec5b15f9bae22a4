"""Signals that end a process, turned into one exception while a bench is in use."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, NoReturn

from electrovib.bench.faults import BenchStopped

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

_STOPPING: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
_HELD: Final = ("SIGALRM", *_STOPPING)
"""The command line repeats an interrupt by SIGALRM."""


def _known(names: tuple[str, ...]) -> list[signal.Signals]:
    return [getattr(signal, name) for name in names if hasattr(signal, name)]


def _stop(number: int, frame: FrameType | None) -> NoReturn:
    """Raise once; further signals are ignored, so that none of them can keep the bench from being taken to 0 V."""
    del frame
    for each in _known(_HELD):
        signal.signal(each, _ignore)
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    raise BenchStopped(signal.Signals(number).name)


@contextmanager
def stopping_signals() -> Iterator[None]:
    """Raise KeyboardInterrupt or `BenchStopped` at the first signal that asks the process to end, and ignore later ones.

    Yields
    ------
    None
        Only the main thread receives signals; in another one nothing is changed.
    """
    with _handled(_STOPPING, _stop):
        yield


@contextmanager
def undisturbed() -> Iterator[None]:
    """Ignore interrupts and requests to end while the bench is taken to 0 V and the data are saved.

    Yields
    ------
    None
        Only the main thread receives signals; in another one nothing is changed.
    """
    with _handled(_HELD, _ignore):
        yield


@contextmanager
def _handled(names: tuple[str, ...], handler: object) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in _known(_HELD)}
    try:
        for number in _known(names):
            signal.signal(number, handler)  # type: ignore[arg-type]
        yield
    finally:
        for number, former in before.items():
            signal.signal(number, former)


def _ignore(number: int, frame: FrameType | None) -> None:
    del number, frame
