"""Checkpoints of a running study, written by a thread while the next fingers are evaluated."""

from __future__ import annotations

import functools
import queue
import threading
import time
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError
from electrovib.study.population.declared import BLOCK

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from electrovib.study.population.merged import MergedFingers
    from electrovib.study.population.store import StudyStore

PAUSE: Final = 1.0
"""Least time between two checkpoints [s]; a study that is killed loses at most about this."""
_SHARE: Final = 4.0
"""A checkpoint follows the last one after at least this many times the time that it took."""
_WAITING: Final = 4
"""Tiles that wait to be written, at most."""


class CheckpointWriter:
    """Thread that writes the progress of a study to its store.

    Parameters
    ----------
    store : StudyStore
        Store of the study.
    merged : MergedFingers
        Fingers merged so far, restored from the store by the caller.
    """

    def __init__(self, store: StudyStore, merged: MergedFingers) -> None:
        self.store, self.merged = store, merged
        self.pause = PAUSE
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue(_WAITING)
        self._error: BaseException | None = None
        self._committing = threading.Event()
        self._all_evaluated = False
        self._last = time.monotonic()
        self._stored = store.stored
        self._thread = threading.Thread(target=self._work, name="checkpoints of a study", daemon=True)
        self._thread.start()

    def after(self, rows: Mapping[str, tuple[int, NDArray[Any]]]) -> None:
        """Write the signals of completed blocks where every finger is kept, and a checkpoint where one is due."""
        self._raise()
        if self.merged.declared.draws:
            for name, (start, values) in rows.items():
                self._put(functools.partial(self.store.write_rows, name, start, values))
        if not self._committing.is_set() and time.monotonic() - self._last >= self.pause:
            self._checkpoint()

    def finish(self) -> None:
        """Write a last checkpoint if there is anything new, and wait until everything is written."""
        self._drain()
        if self.merged.fingers > self.store.fingers:
            self._checkpoint()
            self._drain()

    def complete(self) -> None:
        """Wait until the signals that are part of the result are written; a checkpoint is no longer needed."""
        self._all_evaluated = True
        self._drain()

    def close(self) -> None:
        """End the thread after the job at which it is; nothing is raised."""
        while self._thread.is_alive():
            try:
                self._jobs.put(None, timeout=0.05)
                break
            except queue.Full:
                continue
        self._thread.join()

    def _checkpoint(self) -> None:
        merged, fingers, state = self.merged, self.merged.fingers, self.merged.state()
        begin, stop = self._stored, merged.blocks
        self._committing.set()
        self._stored = stop

        def commit() -> None:
            begun = time.monotonic()
            if not merged.declared.draws:
                for name, values in merged.values.items():
                    for start in range(begin, stop, BLOCK):
                        if self._all_evaluated:
                            return
                        self.store.write_rows(name, start, values[start : min(start + BLOCK, stop)])
            if self._all_evaluated:
                return
            self.store.commit(fingers, state)
            self._last = time.monotonic()
            self.pause = max(PAUSE, _SHARE * (self._last - begun))
            self._committing.clear()

        self._put(commit)

    def _put(self, job: Callable[[], None]) -> None:
        while True:
            self._raise()
            try:
                self._jobs.put(job, timeout=0.1)
            except queue.Full:
                continue
            return

    def _drain(self) -> None:
        while self._jobs.unfinished_tasks and self._thread.is_alive():
            time.sleep(0.001)
        self._raise()

    def _raise(self) -> None:
        if self._error is not None:
            error, self._error = self._error, None
            raise error

    def _work(self) -> None:
        failed = False
        while (job := self._jobs.get()) is not None:
            try:
                if not failed:
                    job()
            except Exception as error:  # noqa: BLE001 - raised again in the thread that computes
                failed = True
                self._error = (
                    error if isinstance(error, InputError) else InputError(f"{self.store.path}: {error}")
                )
            finally:
                self._jobs.task_done()
        self._jobs.task_done()
