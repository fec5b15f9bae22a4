"""The lock of a store: one process at a time, released when the process ends in whatever manner."""

from __future__ import annotations

import errno
import json
import os
import socket
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Final

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

NAME: Final = ".lock"
_BYTE: Final = 1 << 30
"""Offset of the byte that is locked where locks belong to bytes: beyond the text, which stays readable."""
_UNSUPPORTED: Final = {
    errno.ENOSYS,
    errno.ENOLCK,
    getattr(errno, "ENOTSUP", -1),
    getattr(errno, "EOPNOTSUPP", -1),
}


@contextmanager
def locked(store: Path) -> Iterator[None]:
    """Hold the lock of a store within the block.

    The operating system releases the lock of a process that ends, killed ones included: ``flock``, or
    ``locking`` on Windows. Where neither exists, or the file system has no locks, the file names the process,
    and is taken over if that process has ended on this computer.
    """
    path = store / NAME
    file = _taken(path)
    try:
        file.seek(0)
        file.truncate()
        file.write(json.dumps({"host": socket.gethostname(), "process": os.getpid()}).encode())
        file.flush()
        yield
    finally:
        _released(path, file)


def _taken(path: Path) -> BinaryIO:
    """Open the file of the lock and lock it; again if it was removed by the process that held it until now."""
    while True:
        file = path.open("a+b")
        try:
            _lock(file, path)
            if _still_there(path, file):
                return file
        except BaseException:
            file.close()
            raise
        file.close()


def _lock(file: BinaryIO, path: Path) -> None:
    kind = _kind()
    try:
        if kind is None:
            _refuse_if_alive(file, path)
        elif kind.__name__ == "fcntl":
            kind.flock(file.fileno(), kind.LOCK_EX | kind.LOCK_NB)
        else:
            file.seek(_BYTE)
            kind.locking(file.fileno(), kind.LK_NBLCK, 1)
    except OSError as error:
        if error.errno not in _UNSUPPORTED:
            raise InputError(_busy(file, path)) from None
        _refuse_if_alive(file, path)


def _kind() -> Any:
    """Return the module of file locks of this system, or None."""
    try:
        import fcntl
    except ImportError:
        return _of_windows()
    return fcntl


def _of_windows() -> Any:
    try:
        import msvcrt
    except ImportError:
        return None
    return msvcrt


def _still_there(path: Path, file: BinaryIO) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False


def _released(path: Path, file: BinaryIO) -> None:
    if os.name == "posix":  # removed while it is held, so that nobody locks a file that is about to vanish
        with suppress(OSError):
            path.unlink()
        file.close()
    else:
        file.close()
        with suppress(OSError):
            path.unlink()


def _holder(file: BinaryIO) -> dict[str, Any]:
    try:
        file.seek(0)
        found = json.loads(file.read(1000))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _busy(file: BinaryIO, path: Path) -> str:
    holder = _holder(file)
    who = f" (process {holder['process']} on {holder['host']})" if {"process", "host"} <= set(holder) else ""
    return f"{path.parent}: another process{who} is writing this study; wait until it ends, or give another name."


def _refuse_if_alive(file: BinaryIO, path: Path) -> None:
    """Refuse a lock whose process may still run, where the system has no locks."""
    holder = _holder(file)
    if not holder or _has_ended(holder):
        return
    raise InputError(f"{_busy(file, path)} If it has ended, remove {path}.")


def _has_ended(holder: dict[str, Any]) -> bool:
    if os.name != "posix" or holder.get("host") != socket.gethostname():
        return False
    try:
        os.kill(int(holder["process"]), 0)
    except ProcessLookupError:
        return True
    except (OSError, ValueError, KeyError):
        return False
    return False
