"""One process at a time for each bench: a lock of the operating system, which ends with the process that holds it."""

from __future__ import annotations

import hashlib
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from electrovib.bench.faults import BenchError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from typing import IO


def lock_file(resources: Mapping[str, str]) -> Path:
    """Return the file of the lock of a bench with these addresses."""
    key = hashlib.sha256("\n".join(sorted(resources.values())).encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"electrovib-bench-{key}.lock"


@contextmanager
def one_process(resources: Mapping[str, str]) -> Iterator[str]:
    """Hold the lock of a bench, or refuse if another process holds it.

    It gives what the last process left in the file: empty if that ended in order, ``running ...`` if it was
    killed.
    """
    path = lock_file(resources)
    with path.open("a+", encoding="utf-8") as file:
        if not _take(file):
            raise BenchError(
                f"another process uses this bench (lock {path}); wait until it has ended, there is no option to override this"
            )
        try:
            file.seek(0)
            left = file.read().strip()
            _put(file, f"running, process {os.getpid()}")
            yield left
        finally:
            _put(file, "")
            _release(file)


def _put(file: IO[str], text: str) -> None:
    file.seek(0)
    file.truncate()
    file.write(text)
    file.flush()


def _take(file: IO[str]) -> bool:
    """Take the lock without waiting."""
    try:
        import fcntl
    except ImportError:
        return _take_elsewhere(file)
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _take_elsewhere(file: IO[str]) -> bool:
    """Take the lock on Windows."""
    import msvcrt

    locking = getattr(msvcrt, "locking")  # noqa: B009  # absent from the type stubs of other systems
    file.seek(0)
    try:
        locking(file.fileno(), getattr(msvcrt, "LK_NBLCK"), 1)  # noqa: B009
    except OSError:
        return False
    return True


def _release(file: IO[str]) -> None:
    """Give the lock back; closing the file would do so too."""
    try:
        import fcntl
    except ImportError:
        return
    fcntl.flock(file.fileno(), fcntl.LOCK_UN)
