"""The groups of a store: each states the checksums of itself and of all its files, and nothing is read that contradicts them."""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final, Literal

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.parsing import read_json
from electrovib.data.atomic import write_text
from electrovib.data.marks import WRITTEN_BY, Form, is_ours, unsigned
from electrovib.study.population.folder import PARTIAL, written

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

METADATA: Final = "zarr.json"
"""Name of the file that describes a group or an array."""
_LARGEST: Final = 64_000_000
"""Bytes of the description of a group, at most; the names of 300,000 chunks take half of them."""
_ADVICE: Final = (
    "Restore it from a copy; or remove the folder of the study, and the same command computes it again."
)


def write_group(folder: Path, attributes: Mapping[str, Any]) -> None:
    """Write the description of a group with the checksum of itself, as a whole."""
    marked = {WRITTEN_BY: unsigned(Form.STUDY), **attributes}
    table = {"zarr_format": 3, "node_type": "group", "attributes": marked}
    try:
        write_text(folder / METADATA, json.dumps(table, indent=2), Form.STUDY)
    except InputError as error:  # what follows for the study is said by the caller
        raise error.__cause__ if isinstance(error.__cause__, OSError) else error from None


def read_group(folder: Path) -> dict[str, Any]:
    """Read the attributes of a group that `write_group` wrote."""
    path = folder / METADATA
    with written(path, "read"):
        size = path.lstat().st_size
        if path.is_symlink() or not path.is_file():
            raise DataFileError(f"is not an ordinary file. {_ADVICE}", path=path)
        if size > _LARGEST or not is_ours(path, Form.STUDY):
            raise DataFileError(
                "is damaged, of an earlier version, or no study of electrovib: it does not state the checksum of its content."
                f" {_ADVICE}",
                path=path,
            )
        attributes: dict[str, Any] = read_json(path.read_text(encoding="utf-8"))["attributes"]
    del attributes[WRITTEN_BY]
    return attributes


def stated(store: Path, places: Iterable[str], rows: Iterable[str] = ()) -> dict[str, dict[str, list[Any]]]:
    """State sizes and checksums of files."""
    rows = tuple(rows)
    files = [each for place in [*places, *rows] for each in _files(store / place)]
    names = {each: each.relative_to(store).as_posix() for each in files}
    chunks = {each for each in files if each.name != METADATA and names[each].split("/c/")[0] in rows}
    return {
        "files": {names[each]: _whole(each) for each in files if each not in chunks},
        "chunks": {names[each]: _end(each) for each in files if each in chunks},
    }


def arrays_of(attributes: Mapping[str, Any], group: str) -> list[str]:
    """List the arrays of a group, by the files that `stated` found."""
    places = (PurePosixPath(each) for each in attributes["files"])
    return [
        each.parent.name
        for each in places
        if each.name == METADATA and each.parent.parent == PurePosixPath(group)
    ]


def _files(place: Path) -> list[Path]:
    if place.is_file():
        return [place]
    return sorted(each for each in place.rglob("*") if each.is_file() and each.suffix != PARTIAL)


def _whole(path: Path) -> list[Any]:
    with path.open("rb") as file:
        return [path.stat().st_size, hashlib.file_digest(file, "sha256").hexdigest()]


def _end(path: Path) -> list[Any]:
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - 4))
        return [size, file.read(4).hex()]


def refuse_irregular(store: Path) -> None:
    """Refuse a store with anything but ordinary files and folders in it; nothing is opened."""
    folders: list[str | Path] = [store]
    with written(store, "read"):
        while folders:
            with (
                suppress(FileNotFoundError),
                os.scandir(folders.pop()) as entries,
            ):  # removed by another process
                for each in entries:
                    what = "a link" if each.is_symlink() else "not an ordinary file"
                    if each.is_symlink() or not (each.is_file() or each.is_dir()):
                        raise DataFileError(
                            f"is {what}, which no study writes, and was not opened. {_ADVICE}", path=each.path
                        )
                    folders += [each.path] if each.is_dir() else []


def refuse_damaged(store: Path, attributes: Mapping[str, Any]) -> None:
    """Refuse a store whose files are not as a group states."""
    with written(store, "read"):
        for kind, checksum in (("files", _whole), ("chunks", _end)):
            for name, (size, expected) in attributes[kind].items():
                path = store / name
                if not path.is_file():
                    raise DataFileError(f"is missing. {_ADVICE}", path=path)
                if (there := path.stat().st_size) != size:
                    raise DataFileError(
                        f"is damaged: it has {there} instead of {size} bytes. {_ADVICE}", path=path
                    )
                if checksum(path)[1] != expected:
                    raise damaged(path)


def damaged(path: Path) -> DataFileError:
    """Return the error for a file whose content is not what was written."""
    return DataFileError(f"is damaged: its checksum is not that of its content. {_ADVICE}", path=path)


def open_array(place: Path, mode: Literal["r", "r+"] = "r") -> Any:
    """Open an array whose files are as its group states, for reading or also for writing (``r+``)."""
    import zarr

    return zarr.open_array(str(place), mode=mode, zarr_format=3)


@contextmanager
def rows_read(place: Path) -> Iterator[None]:
    """Report chunks whose values are not those of their checksum as one sentence."""
    try:
        with written(place, "read"):
            yield
    except ValueError:  # by the codec of the checksums
        raise damaged(place) from None
