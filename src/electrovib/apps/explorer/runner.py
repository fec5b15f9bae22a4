"""What a visitor of the page may ask for, and how work is done for it: outside of the event loop, for the latest wish alone."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Final, Generic, TypeVar

from electrovib.core.budget import listening

LOOPBACK: Final = ("127.0.0.1", "localhost", "[::1]")
"""Names of this machine as a browser writes them."""
MOST_CHANGES: Final = 60
"""Parameters that a link may change."""
LONGEST_VALUE: Final = 300
"""Letters of a value in a link."""
LONGEST_LINK: Final = 6000
"""Letters of the part of an address behind its question mark."""
MOST_SAMPLES: Final = 20_000
"""Output times, and frequencies, of one simulation."""
SHOWN_SAMPLES: Final = 400
"""Points of a curve that are sent to the browser."""
LARGEST_UPLOAD: Final = 20_000_000
"""Bytes of a recording."""
LARGEST_REQUEST: Final = LARGEST_UPLOAD + 100_000
"""Bytes of a request: those of a file, and those that its form adds."""
LARGEST_SCENARIO: Final = 500_000
"""Bytes of a scenario (TOML)."""
MOST_PARAMETERS: Final = 400
"""Parameters of a scenario, each of which has a slider."""
MOST_VALUES: Final = 2_000_000
"""Numbers of a recording, all channels together."""
MOST_COLUMNS: Final = 200
"""Columns of a recording, each of which is offered as a signal."""
LONGEST_LINE: Final = 20_000
"""Letters of a line of a recording that is a text."""
LONGEST_NAME: Final = 120
"""Letters of the name of a file or of a column that are shown."""
LARGEST_MESSAGE: Final = 1_000_000
"""Bytes of a message of a browser."""
LONGEST_RUN: Final = 20.0
"""Estimated seconds of one simulation, above which it is refused."""
LONGEST_SHORT_RUN: Final = 0.1
"""Estimated seconds up to which simulations take turns; a longer one runs beside fits and reports."""
LONGEST_QUICK_RUN: Final = 2.0
"""Seconds after which a simulation ends for whose result nobody waits any more."""
LARGEST_RUN: Final = 500e6
"""Estimated memory of one simulation, above which it is refused [bytes]."""
FINGERS: Final = 200
"""Draws from the population for a band."""


W = TypeVar("W")
NOTICED: Final = 0.3
"""Time after which a visitor is told that something is being computed [s]; for less the page would flicker."""
SERVER_ENDS: Final = threading.Event()
"""Set when the server is stopped; work in threads then ends as soon as it can."""

_TO_CLOSE: Final[set[Callable[[], None]]] = set()
_HERE: Final = threading.local()
"""In each thread, the presence of the visitor for whom it works."""


def end_work() -> None:
    """End what runs in threads, because the server is stopped."""
    SERVER_ENDS.set()
    for close in list(_TO_CLOSE):
        close()


class Presence:
    """Whether a visitor is still there, and what ends when the visitor leaves."""

    def __init__(self) -> None:
        self.has_left = False
        self.to_close: set[Callable[[], None]] = set()

    def leave(self) -> None:
        """Note that the visitor has left, and end what waits for other processes in the visitor's name."""
        self.has_left = True
        for close in list(self.to_close):
            close()

    @contextmanager
    def working(self, is_in_vain: Callable[[], bool] = bool) -> Iterator[None]:
        """End the work of this thread within the block once the visitor has left, or its result is no longer wanted."""
        _HERE.presence = self
        try:
            with interruptible(lambda: self.has_left or is_in_vain()):
                yield
        finally:
            _HERE.presence = None


@contextmanager
def closed_at_end(close: Callable[[], None]) -> Iterator[None]:
    """Call a function if the server is stopped, or the visitor leaves for whom this thread works, within the block.

    It is called from another thread, perhaps more than once.
    """
    presence: Presence = getattr(_HERE, "presence", None) or Presence()
    places = (_TO_CLOSE, presence.to_close)
    for each in places:
        each.add(close)
    try:
        if SERVER_ENDS.is_set() or presence.has_left:
            close()
        yield
    finally:
        for each in places:
            each.discard(close)


class InterruptedWorkError(Exception):
    """Work that was ended because nobody waits for its result; no mistake, which any part of the work may handle."""


@contextmanager
def interruptible(is_in_vain: Callable[[], bool]) -> Iterator[None]:
    """End time stepping between two steps once nobody waits for its result, with an `InterruptedWorkError` in the computation.

    `is_in_vain` is called often, from the thread that computes.
    """

    def check(_: float = 0.0) -> None:
        if SERVER_ENDS.is_set() or is_in_vain():
            raise InterruptedWorkError("The computation was ended, because its result is no longer wanted.")

    check()
    with listening(check):
        yield


class LatestOnly(Generic[W]):
    """Run a task for the latest of the values that arrive, and never two tasks at once.

    At most one value waits, so that no queue can grow however fast a slider moves. `is_stale` lets a long
    task end between two slices of its work when a newer value waits. `failed` is called with an exception
    that the task did not handle; the next value is then worked on as usual. `busy` is called with True when a
    task has run for `NOTICED`, and then with False when nothing runs any more.
    """

    def __init__(
        self,
        task: Callable[[W], Awaitable[None]],
        failed: Callable[[Exception], None],
        busy: Callable[[bool], object] = bool,
    ) -> None:
        self._task, self._failed, self._busy = task, failed, busy
        self._waiting: list[W] = []
        self._news = asyncio.Event()
        self._is_noticed = False
        self._running: asyncio.Task[None] | None = None

    def ask(self, value: W) -> None:
        """Let the task run for a value as soon as it is free; a value that waits already is forgotten."""
        self._waiting = [value]
        self._news.set()
        if self._running is None or self._running.done():
            self._running = asyncio.get_running_loop().create_task(self._work())

    @property
    def is_stale(self) -> bool:
        """Whether a newer value waits than the one for which the task runs."""
        return bool(self._waiting)

    async def rests(self, seconds: float) -> bool:
        """Wait, and return whether no newer value has come in the meantime; return at once when one comes."""
        with suppress(TimeoutError):
            await asyncio.wait_for(self._news.wait(), seconds)
        return not self.is_stale

    @property
    def is_idle(self) -> bool:
        """Whether nothing runs and nothing waits."""
        return not self._waiting and (self._running is None or self._running.done())

    def stop(self) -> None:
        """Forget what waits and cancel the task that runs."""
        self._waiting = []
        if self._running is not None:
            self._running.cancel()

    async def _work(self) -> None:
        while self._waiting:
            notice = asyncio.get_running_loop().call_later(NOTICED, self._tell, True)
            self._news.clear()
            try:
                await self._task(self._waiting.pop())
            except Exception as error:  # noqa: BLE001 - a mistake of ours must not end the page
                self._failed(error)
            finally:
                notice.cancel()
        self._tell(False)

    def _tell(self, is_busy: bool) -> None:
        """Tell whether a task takes long, where that has changed."""
        if is_busy != self._is_noticed:
            self._is_noticed = is_busy
            self._busy(is_busy)


@dataclass(frozen=True)
class Workers:
    """Where the work of the page runs, outside of the event loop.

    `quick` has threads for simulations that a slider repeats, `patient` for work of many seconds, such as
    long simulations, fits and reports, so that no short simulation waits for one.
    """

    quick: Executor
    patient: Executor


async def apart(executor: Executor, work: Callable[[], W]) -> W:
    """Run a function outside of the event loop and return its result; once the server ends, what waits for it is cancelled."""
    if SERVER_ENDS.is_set():
        raise asyncio.CancelledError
    return await asyncio.get_running_loop().run_in_executor(executor, work)
