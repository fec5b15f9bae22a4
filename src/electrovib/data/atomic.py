"""Files written as a whole or not at all, which replace only files of this package; and locks, for one process at a time."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import socket
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError, refuse
from electrovib.core.files import kind_of
from electrovib.data.marks import Form, is_ours, sign

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

_UNFINISHED: Final = ".partial"
_LEFT: Final = 86400.0
"""Age from which an unfinished file is removed, which no writing lasts [s]."""


@contextmanager
def writing(outputs: Mapping[Path, Form | None], *, force: bool = False) -> Iterator[dict[Path, Path]]:
    """Provide temporary files beside the outputs, and move them into place once all of them are complete.

    Yields for each output an empty file to be overwritten, which is removed after any failure. Files are
    replaced in the order of `outputs`, so that the one that states which files belong together comes first. A
    form None means that a file carries no mark. Files that we did not write are replaced only with `force`.
    """
    check_writable(outputs, force=force)
    places = {path: Path(os.path.realpath(path)) for path in outputs}  # a link keeps pointing to its file
    temporaries = {
        path: place.with_name(f"{_hidden(place)}{secrets.token_hex(4)}{_UNFINISHED}")
        for path, place in places.items()
    }
    try:
        for path, temporary in temporaries.items():
            for other in left_by_a_kill(path):
                with suppress(OSError):
                    if time.time() - other.stat().st_mtime > _LEFT:
                        other.unlink()
            temporary.touch(exist_ok=False)
        yield temporaries
        for path, form in outputs.items():
            _complete(temporaries[path], places[path], form)
        _take_places({temporaries[path]: place for path, place in places.items()})
    except OSError as error:
        named = [path for path, temporary in temporaries.items() if str(error.filename) == str(temporary)]
        if error.filename is None or named:
            whose = ", ".join(map(str, named or outputs))
            raise InputError(f"{whose}: cannot be written: {error.strerror or error}.") from error
        raise
    finally:
        for temporary in temporaries.values():
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


def _hidden(place: Path) -> str:
    return f".{place.name[:40]}."


def left_by_a_kill(path: Path) -> list[Path]:
    """Find the temporary files that a process killed while writing this output has left beside it."""
    place = Path(os.path.realpath(path))
    return sorted(
        other
        for other in place.parent.iterdir()
        if other.name.startswith(_hidden(place)) and other.name.endswith(_UNFINISHED)
    )


def _complete(temporary: Path, place: Path, form: Form | None) -> None:
    if form is not None:
        sign(temporary, form)
    if place.exists():
        shutil.copymode(place, temporary)
    with temporary.open("r+b") as written:  # else a power cut can leave the new name on an empty file
        os.fsync(written.fileno())


def _take_places(moves: Mapping[Path, Path]) -> None:
    """Replace all older files; an interrupt between two of them is delayed, so that all belong to one save."""
    try:
        for temporary, place in moves.items():
            temporary.replace(place)
    except KeyboardInterrupt:
        for temporary, place in moves.items():
            if temporary.exists():
                temporary.replace(place)
        raise


def write_text(path: Path, text: str, form: Form | None, *, force: bool = False) -> None:
    """Write a text, which has the mark of its form if there is one, as a whole, or keep the older file."""
    with writing({path: form}, force=force) as temporaries:
        temporaries[path].write_text(text, encoding="utf-8", newline="")


def output_path(given: str | Path) -> Path:
    """Return the path of an output; a blank one, as of a variable that is not set, would be the folder where one is."""
    if not str(given).strip():
        raise InputError("the name of the output is blank; give one, or omit it")
    return Path(given)


def check_folder(
    folder: Path, files: Mapping[str, Form | None], *, inputs: Iterable[Path] = (), force: bool = False
) -> None:
    """Check, before a long computation, that these files can be written into a folder."""
    nearest = next(place for place in (folder, *folder.parents) if kind_of(place))
    if kind_of(nearest) != "folder":
        raise InputError(f"'{nearest}' is a file, not a folder: give the name of a folder", path=folder)
    if nearest != folder:
        if why := _obstacle(nearest / folder.relative_to(nearest).parts[0]):
            raise InputError(why, path=folder)
    else:
        check_writable({folder / name: form for name, form in files.items()}, inputs=inputs, force=force)


def write_folder(
    folder: Path,
    contents: Mapping[str, str | bytes],
    forms: Mapping[str, Form | None],
    *,
    force: bool = False,
) -> list[Path]:
    """Write files into a folder, all of them or none."""
    make_folder(folder)
    outputs = {folder / name: forms[name] for name in contents}
    with writing(outputs, force=force) as temporaries:
        for path, content in zip(outputs, contents.values(), strict=True):
            temporaries[path].write_bytes(content.encode() if isinstance(content, str) else content)
    return list(outputs)


def make_folder(folder: Path) -> None:
    """Make a folder, and those in which it lies."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror or error}.", path=folder) from error


def check_writable(
    outputs: Mapping[Path, Form | None], *, inputs: Iterable[Path] = (), force: bool = False
) -> None:
    """Check, before a long computation, whether its outputs can be written; `inputs` are never replaced."""
    read = list(inputs)
    problems = []
    taken: dict[str, Path] = {}
    for path, form in outputs.items():
        why = _obstacle(path) or _input_of(path, read) or ("" if force else _not_ours(path, form))
        if not why and (first := taken.setdefault(os.path.realpath(path), path)) != path:
            why = f"is the same file as the output '{first}'; give two names."
        problems += [f"{path}: {why}"] if why else []
    refuse(problems)


def _input_of(path: Path, inputs: Iterable[Path]) -> str:
    """Return a sentence if this output is also an input, else an empty text."""
    for source in inputs:
        with suppress(OSError):
            if path.samefile(source):
                return f"is an input, read as '{source}'; an output never replaces it: give another name."
    return ""


def _not_ours(path: Path, form: Form | None) -> str:
    """Return a sentence if this output would replace a file of the user, else an empty text."""
    if not path.exists() or (form is not None and is_ours(path, form)):
        return ""
    what = f"no {form} that electrovib wrote, or it was changed since" if form else "possibly somebody else's"
    return f"exists already and is {what}; give another name, or replace it with --force (force=True)."


def _obstacle(path: Path) -> str:
    """Return a sentence that states why this output cannot be written, or an empty text if it can."""
    try:
        place = Path(os.path.realpath(path))
        folder, exists = place.parent, False
        # from Python 3.14 on, `Path.exists` would hide a name that is too long
        with suppress(FileNotFoundError, NotADirectoryError):
            exists = bool(place.stat())
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
    from filelock import BaseFileLock, FileLock, SoftFileLock, Timeout

    holder = lock.with_name(f"{lock.name}{HOLDER}")
    taken: BaseFileLock = FileLock(lock)
    try:
        try:
            taken.acquire(timeout=0)
        except OSError as error:
            if isinstance(error, Timeout) or error.errno not in _UNSUPPORTED:
                raise
            taken = SoftFileLock(lock)  # a file that names its process, where a file system has no locks
            taken.acquire(timeout=0)
    except Timeout:
        raise HeldError(_text(holder)) from None
    try:
        left = _text(holder)
        holder.write_text(f"process {os.getpid()} on {socket.gethostname()}", encoding="utf-8")
        yield left
    finally:
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
