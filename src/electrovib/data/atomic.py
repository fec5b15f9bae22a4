"""Files that are either whole or not there: written beside their place and moved into it at the end."""

from __future__ import annotations

import os
import secrets
import shutil
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator


@contextmanager
def writing(path: Path) -> Iterator[Path]:
    """Give a temporary file beside the output and put it in place once it is complete.

    Parameters
    ----------
    path : Path
        The output; an older file there stays untouched until the new one is complete.

    Yields
    ------
    Path
        An empty file in the same folder, ``*.partial``, to be overwritten; it is removed after any failure.

    Raises
    ------
    InputError
        If the output cannot be written.
    """
    check_writable([path])
    place = Path(os.path.realpath(path))  # a link keeps pointing to its file
    temporary = place.with_name(f".{place.name[:40]}.{secrets.token_hex(4)}.partial")
    try:
        temporary.touch(exist_ok=False)
        yield temporary
        _finish(temporary, place)
    except OSError as error:
        if error.filename is None or str(error.filename) == str(temporary):
            raise InputError(f"{path}: cannot be written: {error.strerror or error}.") from error
        raise
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _finish(temporary: Path, place: Path) -> None:
    if place.exists():
        shutil.copymode(place, temporary)
    with temporary.open("r+b") as written:  # else a power cut can leave the new name on an empty file
        os.fsync(written.fileno())
    temporary.replace(place)


def write_text(path: Path, text: str) -> None:
    """Write a whole text file, or leave the older one.

    Parameters
    ----------
    path : Path
        The output.
    text : str
        Its content, written as UTF-8 with the line ends it has.

    Raises
    ------
    InputError
        If the output cannot be written.
    """
    with writing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def check_writable(paths: Iterable[Path]) -> None:
    """Tell, before a long computation, whether its outputs can be written.

    Parameters
    ----------
    paths : iterable of Path
        The outputs; nothing is created.

    Raises
    ------
    InputError
        With one sentence for each output that cannot be written.
    """
    problems = [f"{path}: {why}" for path in paths if (why := _obstacle(path))]
    if problems:
        raise InputError(problems)


def _obstacle(path: Path) -> str:
    """Say in a sentence why this output cannot be written, or nothing."""
    try:
        place = Path(os.path.realpath(path))
        folder, exists = place.parent, place.exists()
        obstacles = (
            (place.is_dir(), "is a folder; give the name of a file in it."),
            (not folder.exists(), f"the folder '{path.parent}' does not exist; make it first."),
            (not folder.is_dir(), f"'{path.parent}' is not a folder."),
            (exists and not place.is_file(), "is not an ordinary file, so it cannot be replaced."),
            (exists and not os.access(place, os.W_OK), "is write-protected; choose another name."),
            (not os.access(folder, os.W_OK | os.X_OK), f"no permission to write in '{path.parent}'."),
        )
    except (OSError, ValueError) as error:  # a name too long, a zero byte, a folder that may not be entered
        return f"is not a usable file name: {error}."
    return next((why for is_true, why in obstacles if is_true), "")
