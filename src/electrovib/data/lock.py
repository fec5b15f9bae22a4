"""One process at a time for what a file stands for: a lock that ends with its process, in whatever manner that ends."""

from __future__ import annotations

import errno
import os
import socket
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from filelock import BaseFileLock

HOLDER: Final = ".holder"
"""End of the name of the file beside a lock that names the process that holds it."""
_UNSUPPORTED: Final = {
    errno.ENOSYS,
    errno.ENOLCK,
    getattr(errno, "ENOTSUP", -1),
    getattr(errno, "EOPNOTSUPP", -1),
}


class HeldError(Exception):
    """Another process holds the lock; its text names that process, or is empty."""


@contextmanager
def held(lock: Path) -> Iterator[str]:
    """Hold a lock within the block, without waiting; yield the name of a process that was killed while it held it, or ""."""
    holder = lock.with_name(f"{lock.name}{HOLDER}")
    taken = _taken(lock, holder)
    try:
        left = _text(holder)
        holder.write_text(f"process {os.getpid()} on {socket.gethostname()}", encoding="utf-8")
        yield left
    finally:
        _released(taken, lock, holder)


def _taken(lock: Path, holder: Path) -> BaseFileLock:
    """Take a lock of the operating system, or where a file system has none, a file that names its process."""
    from filelock import FileLock, SoftFileLock, Timeout

    try:
        try:
            taken: BaseFileLock = FileLock(lock)
            taken.acquire(timeout=0)
        except OSError as error:
            if isinstance(error, Timeout) or error.errno not in _UNSUPPORTED:
                raise
            taken = SoftFileLock(lock)
            taken.acquire(timeout=0)
    except Timeout:
        raise HeldError(_text(holder)) from None
    return taken


def _released(taken: BaseFileLock, lock: Path, holder: Path) -> None:
    from filelock import SoftFileLock

    with suppress(OSError):
        holder.unlink()
    if not isinstance(taken, SoftFileLock):
        with suppress(OSError):  # while it is held, so that nobody locks a file that is about to vanish
            lock.unlink()
    taken.release()


def _text(holder: Path) -> str:
    try:
        return holder.read_text(encoding="utf-8", errors="replace")[:200].strip()
    except OSError:
        return ""
