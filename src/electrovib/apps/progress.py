"""A progress bar for a computation that takes longer than a second."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from electrovib.core.budget import listening

PATIENCE = 1.0
"""Time before the progress bar is shown [s]."""
_PARTS = 1000


@contextmanager
def tracked(title: str) -> Iterator[Callable[[int, int], None]]:
    """Show progress on the error output if the block takes longer than a second and the output is a terminal.

    Parameters
    ----------
    title : str
        What is computed.

    Yields
    ------
    callable
        Takes the number of parts done and the number of all parts; calling it is optional.
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
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        with lock:
            if state["over"]:
                return
            columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
            bar = Progress(*columns, console=Console(stderr=True), transient=True)
            state["task"] = bar.add_task(title, total=state["total"], completed=state["done"])
            bar.start()
            state["bar"] = bar

    timer = threading.Timer(PATIENCE, show)
    timer.daemon = True
    if sys.stderr.isatty():
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
