"""Files that this package writes: as a whole or not at all, with a mark of their checksum; tables as CSV and JSON; locks."""

from __future__ import annotations

import csv
import errno
import hashlib
import io
import json
import math
import os
import re
import secrets
import shutil
import socket
import time
from collections.abc import Mapping
from contextlib import contextmanager, suppress
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Final

from electrovib.core.diagnostics import Diagnostic, comment_lines
from electrovib.core.errors import DataFileError, InputError, refuse
from electrovib.core.files import kind_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    import xarray


class Form(StrEnum):
    """Form of a file that this package writes."""

    NETCDF = "Trace as netCDF"
    MATLAB = "Trace as MATLAB file"
    PAGE = "HTML page"
    NETLIST = "netlist"
    SCENARIO = "scenario"
    TABLE = "table as CSV"
    SPACE = "space of parameters"
    CHECK = "check of limits as JSON"
    DESIGN = "design as JSON"
    WAVEFORM = "waveform"
    STUDY = "study"
    MEASUREMENT = "measurement"
    FIGURE = "figure"
    LATEX = "tables in LaTeX"
    TEXT = "text"


WRITTEN_BY: Final = "written_by"
"""Name of the mark in formats with named attributes."""

VERIFIED: Final = "checksum"
"""Name of the diagnostic of a Trace that could not be verified."""

_EMPTY: Final = "0" * 32
_HEAD: Final = 1 << 16  # every format has its mark in its first or last 64 kB
_BLOCK: Final = 1 << 20


def unsigned(form: Form) -> str:
    """Return the mark that a writer puts once near the beginning or the end of its content and that `sign` completes."""
    return f"electrovib {form}, checksum {_EMPTY}"


def plain(value: Any) -> Any:
    """Return numbers and tables as JSON has them: lists, and None for a number that is not finite."""
    if isinstance(value, Mapping):
        return {str(name): plain(each) for name, each in value.items()}
    value = value.tolist() if hasattr(value, "tolist") else value  # an array of numpy
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def json_text(form: Form, content: Mapping[str, object]) -> str:
    """Write nested tables as JSON with the mark of their form."""
    marked = {WRITTEN_BY: unsigned(form)} | dict(content)
    return json.dumps(marked, indent=1, ensure_ascii=False) + "\n"


def sign(path: Path, form: Form) -> None:
    """Write the checksum of a complete file into its mark; a file without a mark remains unchanged."""
    with path.open("r+b") as file:
        if place := _place(file, unsigned(form).encode()):
            checksum = _checksum(file, place)
            file.seek(place)
            file.write(checksum)


def is_ours(path: Path, form: Form) -> bool:
    """Return whether this package wrote a file in this form and it has not been changed since."""
    try:
        return bool(_is_unchanged(path, form))
    except OSError:
        return False


def _is_unchanged(path: Path, form: Form) -> bool | None:
    """Return whether a file has the content of the checksum in its mark; None without a mark of this form."""
    with path.open("rb") as file:
        if not (place := _place(file, _any_checksum(form))):
            return None
        file.seek(place)
        return file.read(len(_EMPTY)) == _checksum(file, place)


def has_checksum(path: Path, form: Form) -> bool:
    """Return whether a file has the content of its checksum, False without one; a file that was changed is refused."""
    unchanged = _is_unchanged(path, form)
    if unchanged is False:
        raise DataFileError(
            "is damaged, or was edited: its content is not that of its checksum. Make it again; a file that was edited on"
            f" purpose is read, not verified, without its attribute {WRITTEN_BY}",
            path=path,
        )
    return bool(unchanged)


def not_verified(trace: xarray.Dataset, path: Path) -> xarray.Dataset:
    """Return a Trace that was read from a file without a checksum, which says so."""
    why = f"not verified: {path.name} states no checksum, so that damage of its numbers would not be noticed"
    judged = json.loads(trace.attrs.get("validity", "[]"))
    judged.append(Diagnostic(VERIFIED, "warning", why).to_dict())
    trace.attrs["validity"] = json.dumps(judged)
    return trace


def _any_checksum(form: Form) -> bytes:
    return re.escape(unsigned(form).removesuffix(_EMPTY).encode()) + b"[0-9a-f]{%d}" % len(_EMPTY)


def _place(file: BinaryIO, mark: bytes) -> int:
    """Find where the checksum of a mark begins, near the beginning or the end of a file; 0 without one."""
    size = file.seek(0, io.SEEK_END)
    for start in (0, max(size - _HEAD, 0)):
        file.seek(start)
        if found := re.search(mark, file.read(_HEAD)):
            return start + found.end() - len(_EMPTY)
    return 0


def _checksum(file: BinaryIO, place: int) -> bytes:
    """Hash a file with zeros in place of its checksum."""
    hashed = hashlib.sha256()
    file.seek(0)
    hashed.update(file.read(place))
    hashed.update(_EMPTY.encode())
    file.seek(place + len(_EMPTY))
    while block := file.read(_BLOCK):
        hashed.update(block)
    return hashed.hexdigest()[: len(_EMPTY)].encode()


def csv_text(
    headings: Sequence[object],
    rows: Iterable[Iterable[object]],
    *,
    remarks: Iterable[str] = (),
    diagnostics: Iterable[Diagnostic] = (),
    marked: bool = True,
) -> str:
    """Write a table, `marked` as one that a later run may replace; a cell None stays empty."""
    text = io.StringIO()
    text.write(csv_head(remarks, diagnostics, marked=marked))
    table = csv.writer(text, lineterminator="\n")
    table.writerow(headings)
    table.writerows([_cell(each) for each in row] for row in rows)
    return text.getvalue()


def csv_head(
    remarks: Iterable[str] = (), diagnostics: Iterable[Diagnostic] = (), *, marked: bool = True
) -> str:
    """Write the comments before a table: its mark, the remarks that are not empty, and the diagnostics."""
    said = [" ".join(each.split()) for each in remarks if each]
    lines = [unsigned(Form.TABLE)] * marked + said
    return "".join(f"# {line}\n" for line in lines) + comment_lines(diagnostics)


def _cell(value: object) -> object:
    return "" if value is None else repr(float(value)) if isinstance(value, float) else value


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
