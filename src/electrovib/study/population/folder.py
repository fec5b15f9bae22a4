"""The folder of a store: errors of the file system as sentences, and what is removed from it."""

from __future__ import annotations

import importlib.util
import shutil
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError
from electrovib.study.population.lock import NAME as LOCK

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

SUFFIX: Final = ".zarr"
CHECKPOINT: Final = "checkpoint"
"""Group of a store that holds what is needed to resume the study; absent once it is complete."""
COMPLETE: Final = "complete"
"""Attribute of a store whose study is complete."""
PARTIAL: Final = ".partial"
"""End of the names of files that are being written."""


def clear(path: Path) -> None:
    """Remove what a complete study no longer needs."""
    shutil.rmtree(path / CHECKPOINT, ignore_errors=True)
    remove_partial(path)


def remove_unbegun(path: Path) -> None:
    """Remove what a new study wrote unless fingers of it are complete; the lock is that of the caller."""
    if (path / CHECKPOINT / "zarr.json").exists():
        return
    for each in path.iterdir():
        if each.is_dir():
            shutil.rmtree(each, ignore_errors=True)
        elif each.name != LOCK:
            each.unlink(missing_ok=True)


def remove_partial(path: Path) -> None:
    """Remove the files that a killed process was writing."""
    for each in list(path.rglob(f"*{PARTIAL}")):
        with suppress(OSError):
            each.unlink()


@contextmanager
def written(path: Path, how: str = "written") -> Iterator[None]:
    """Report an error of the file system as one sentence."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"cannot be {how}: {reason}. What was stored before is kept: remedy this, and the same command continues.",
            path=path,
        ) from error


def require_zarr() -> None:
    """Refuse to go on without zarr."""
    if importlib.util.find_spec("zarr") is None:
        raise InputError(
            "a study is stored with zarr, which is not installed: pip install 'electrovib[study]'"
        )
