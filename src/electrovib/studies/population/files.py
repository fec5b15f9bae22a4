"""The files of a store: each group states the checksums of itself and of its files, and nothing is read that contradicts them."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.parsing import read_json
from electrovib.core.units import unit_in_files
from electrovib.data.atomic import WRITTEN_BY, Form, is_ours, unsigned, write_text, writing

METADATA: Final = "zarr.json"
"""Name of the file that describes a group or an array."""
PARTIAL: Final = ".partial"
"""End of the names of files that are being written."""
_LARGEST: Final = 64_000_000
"""Bytes of the description of a group, at most; the names of 300,000 chunks take half of them."""
_MOST_ADDED: Final = 20
"""Attributes that another program may have added to those of a group."""
_ADVICE: Final = (
    "Restore it from a copy; or remove the folder of the study, and the same command computes it again."
)
_HEAD: Final = re.compile(rb"electrovib study, checksum [0-9a-f]{32}, ([0-9]{20}) bytes\n")


@contextmanager
def written(path: Path, how: str = "written") -> Iterator[None]:
    """Report an error of the file system as one sentence."""
    try:
        yield
    except OSError as error:
        raise InputError(
            f"cannot be {how}: {error.strerror or error}. What was stored before is kept: remedy this, and the same command"
            " continues.",
            path=path,
        ) from error


@contextmanager
def _of_the_system() -> Iterator[None]:
    """Raise an error of the file system as itself: what follows for the study is said by the caller."""
    try:
        yield
    except InputError as error:
        raise error.__cause__ if isinstance(error.__cause__, OSError) else error from None


def write_group(folder: Path, attributes: Mapping[str, Any]) -> None:
    """Write the description of a group with the checksum of itself, as a whole."""
    with _of_the_system():
        text = _of_group(attributes, unsigned(Form.STUDY))
        write_text(folder / METADATA, text, Form.STUDY, force=True)  # what is there was read before


def _of_group(attributes: Mapping[str, Any], mark: str) -> str:
    marked = {WRITTEN_BY: mark, **attributes}
    return json.dumps({"zarr_format": 3, "node_type": "group", "attributes": marked}, indent=2)


def read_group(folder: Path) -> dict[str, Any]:
    """Read the attributes of a group that `write_group` wrote."""
    return _read_group(folder / METADATA)[0]


def _read_group(path: Path) -> tuple[dict[str, Any], str]:
    """Read the attributes that `write_group` wrote, and its text; what another program has added to it is no matter."""
    with written(path, "read"):
        _refuse_link(path)
        try:
            text = path.read_text(encoding="utf-8") if path.lstat().st_size <= _LARGEST else ""
            attributes: dict[str, Any] = dict(read_json(text)["attributes"])
            mark = str(attributes.pop(WRITTEN_BY))
            for _ in range(min(_MOST_ADDED, len(attributes))):
                checksum = hashlib.sha256(_of_group(attributes, unsigned(Form.STUDY)).encode()).hexdigest()
                if mark == unsigned(Form.STUDY)[:-32] + checksum[:32]:
                    return attributes, _of_group(attributes, mark)
                attributes.popitem()
        except (InputError, ValueError, TypeError, LookupError, AttributeError):
            pass
    raise _unmarked(path)


def write_sums(path: Path, about: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays and what they are in one file with the checksum of itself, which replaces the former one as a whole."""
    shapes = {name: [each.dtype.str, each.shape] for name, each in arrays.items()}
    text = json.dumps({**about, "arrays": shapes}).encode() + b"\n"
    head = f"{unsigned(Form.STUDY)}, {{:020d}} bytes\n"
    size = len(head.format(0)) + len(text) + sum(each.nbytes for each in arrays.values())
    with (
        _of_the_system(),
        writing({path: Form.STUDY}, force=True) as temporaries,
        temporaries[path].open("wb") as file,
    ):
        file.writelines([head.format(size).encode(), text])
        file.writelines(np.ascontiguousarray(each).data for each in arrays.values())


def read_sums(path: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Read what `write_sums` wrote."""
    with written(path, "read"), path.open("rb") as file:
        head = _HEAD.fullmatch(file.readline(100))
        _refuse_link(path)
        if head is None or int(head[1]) != path.lstat().st_size or not is_ours(path, Form.STUDY):
            raise _unmarked(path)
        about = read_json(file.readline().decode())
        arrays = {}
        for name, (kind, shape) in about.pop("arrays").items():
            values = np.fromfile(file, np.dtype(kind), math.prod(shape))
            arrays[name] = values.reshape(shape)
    return about, arrays


def _refuse_link(path: Path) -> None:
    if path.is_symlink() or not path.is_file():
        raise DataFileError(f"is not an ordinary file. {_ADVICE}", path=path)


def _unmarked(path: Path) -> DataFileError:
    """Return the error for a file that is not as this package wrote it."""
    return DataFileError(
        "is damaged, of an earlier version, or no study of electrovib: it does not state the checksum of its content."
        f" {_ADVICE}",
        path=path,
    )


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


def arrays_of(attributes: Mapping[str, Any]) -> list[str]:
    """List the arrays of a complete study, by the files that `stated` found."""
    places = (PurePosixPath(each) for each in attributes["files"])
    return [each.parent.name for each in places if each.name == METADATA]


def _files(place: Path) -> list[Path]:
    if place.is_file():
        return [place]
    return sorted(each for each in place.rglob("*") if each.is_file() and each.suffix != PARTIAL)


def _whole(path: Path) -> list[Any]:
    with path.open("rb") as file:
        return [path.stat().st_size, hashlib.file_digest(file, "sha256").hexdigest()]


def _end(path: Path) -> list[Any]:
    """Return size and checksum of a chunk of signals, which ends with the checksum."""
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
    """Refuse a store whose files are not as `stated` found them."""
    with written(store, "read"):
        for kind, checksum in (("files", _whole), ("chunks", _end)):
            for name, (size, expected) in attributes[kind].items():
                path = store / name
                if not path.is_file():
                    raise DataFileError(f"is missing. {_ADVICE}", path=path)
                if name == METADATA:  # of the group: checked by itself, whatever else stands in it
                    text = _read_group(path)[1].encode()
                    if [len(text), hashlib.sha256(text).hexdigest()] != [size, expected]:
                        raise _damaged(path)
                    continue
                if (there := path.stat().st_size) != size:
                    raise DataFileError(
                        f"is damaged: it has {there} instead of {size} bytes. {_ADVICE}", path=path
                    )
                if checksum(path)[1] != expected:
                    raise _damaged(path)


def _damaged(path: Path) -> DataFileError:
    return DataFileError(f"is damaged: its checksum is not that of its content. {_ADVICE}", path=path)


def make_array(place: Path, dims: Any, words: dict[Any, Any], **how: Any) -> Any:
    """Make an array, replacing one that was left incomplete; the signals of fingers end with a checksum in each chunk."""
    import zarr
    from zarr.codecs import Crc32cCodec

    return zarr.create_array(
        str(place),
        dimension_names=dims,
        attributes=words | {"units": unit_in_files(words["units"])} if "units" in words else words,
        compressors=[Crc32cCodec()] if how.get("dtype") == "float32" else "auto",
        config={"write_empty_chunks": True},
        overwrite=True,
        **how,
    )


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
        raise _damaged(place) from None
