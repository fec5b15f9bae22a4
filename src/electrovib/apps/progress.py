"""A progress bar for a computation that takes longer than a second."""

from __future__ import annotations

import logging
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from electrovib.core.budget import items_heard, listening

PATIENCE = 1.0
"""Time before the progress bar is shown [s]."""
_PARTS = 1000
_REPLACE = "\r\x1b[K"
"""Return to the beginning of the line, and remove it."""


@contextmanager
def tracked(title: str, *, counted: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Show progress on the error output if the block takes longer than a second and the output is a terminal.

    The callable that it gives takes the number of parts done and of all parts; calling it is optional.
    `counted` shows the number of parts, the rate and the time left too.
    """
    state: dict[str, Any] = {"done": 0, "total": None, "bar": None, "over": False}
    lock = threading.Lock()

    def update(done: int, total: int) -> None:
        with lock:
            state.update(done=done, total=total)
            if state["bar"] is not None:
                state["bar"].update(state["task"], completed=done, total=total)

    def show() -> None:
        from rich.console import Console
        from rich.progress import Progress

        with lock:
            if state["over"]:
                return
            bar = Progress(*_columns(counted=counted), console=Console(stderr=True), transient=True)
            state["task"] = bar.add_task(title, total=state["total"], completed=state["done"])
            bar.start()
            state["bar"] = bar

    timer = threading.Timer(PATIENCE, show)
    timer.daemon = True
    if _watched():
        timer.start()
    try:
        with listening(lambda share: update(round(_PARTS * share), _PARTS)):
            yield update
    finally:
        timer.cancel()
        with lock:
            state["over"] = True
            if state["bar"] is not None:
                state["bar"].stop()


@contextmanager
def heard(name: str, listener: Callable[[logging.LogRecord], None]) -> Iterator[None]:
    """Pass on what a logger is told in the block."""

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            listener(record)

    handler, logger = Handler(), logging.getLogger(name)
    before = logger.level
    logger.setLevel(logging.INFO)
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)


@contextmanager
def items_shown(title: str) -> Iterator[None]:
    """Show the item of a computation that is computed at present on one line of the error output, if that is a terminal.

    Each item replaces the line of the one before; at the end the line is removed.
    """
    if not _watched():
        yield
        return
    begin = time.monotonic()

    def show(name: str, number: int, count: int) -> None:
        words = f"{title}, after {time.monotonic() - begin:.0f} s: {number} of {count}, {name}"
        room = shutil.get_terminal_size().columns - 1
        sys.stderr.write(f"{_REPLACE}{words[:room]}")
        sys.stderr.flush()

    try:
        with items_heard(show):
            yield
    finally:
        sys.stderr.write(_REPLACE)
        sys.stderr.flush()


def _watched() -> bool:
    """Tell whether the error output is a terminal; a program without one has none."""
    return sys.stderr is not None and sys.stderr.isatty()


def _columns(*, counted: bool) -> list[Any]:
    """Return the columns of the bar: title, bar, elapsed time; where parts are counted, their number, rate and time left."""
    from rich.progress import BarColumn, ProgressColumn, TextColumn, TimeElapsedColumn
    from rich.text import Text

    class Counted(ProgressColumn):
        """Number of parts, parts a second and time left, over the last half minute."""

        def render(self, task: Any) -> Text:
            return Text(progress_words(task.completed, task.total, task.speed, task.time_remaining))

    columns: list[Any] = [TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()]
    return [*columns, Counted()] if counted else columns


def progress_words(done: float, total: float | None, rate: float | None, left: float | None) -> str:
    """Write how far a computation is: ``20480 of 100000, 5.1e+04/s, 2 s left`` (parts, parts a second)."""
    from electrovib.core.budget import duration

    if total is None:
        return ""
    words = f"{done:.0f} of {total:.0f}"
    words += f", {rate:.2g}/s" if rate else ""
    return words + (f", {duration(left)} left" if left is not None and rate else "")
