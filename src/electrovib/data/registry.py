"""Files of instruments, whole or by columns in SI: the reader is found from the first bytes, else the suffix; pictures."""

from __future__ import annotations

import dataclasses
import functools
import importlib.util
import pkgutil
import warnings
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import megabytes
from electrovib.core.errors import DataFileError, nearest
from electrovib.core.file_kinds import foreign
from electrovib.core.parsing import truth
from electrovib.data import readers
from electrovib.data.guarded import check_file, read_by_library
from electrovib.data.recorded import (
    CanRead,
    DataColumn,
    FileFormat,
    Recorded,
    agreed_unit,
    called,
    choose,
    without_missing_numbers,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

_EXTRA: Final = "formats"
"""Name of the optional dependencies that the readers of foreign formats need."""
HEAD: Final = 4096
"""First bytes from which a format is recognised."""


def _formats() -> tuple[FileFormat, ...]:
    """Collect the ``FORMAT`` of every module of `electrovib.data.readers`."""
    names = (f"{readers.__name__}.{info.name}" for info in pkgutil.iter_modules(readers.__path__))
    found: list[FileFormat] = [importlib.import_module(name).FORMAT for name in names]
    return tuple(sorted(found, key=lambda each: (each.is_last, each.name)))


FORMATS: Final = _formats()
"""All formats; of several that take a file with the same certainty the first is used."""


def format_of(path: Path) -> FileFormat:
    """Find the format of a file from its first bytes and its suffix."""
    check_file(path)
    with path.open("rb") as file:
        head = file.read(HEAD)
    if why := foreign(path, head):
        raise DataFileError(f"{why}.", path=path)
    best = max(FORMATS, key=lambda each: each.can_read(head, path.suffix.lower()).value)
    if best.can_read(head, path.suffix.lower()) is CanRead.NO:
        listed = "; ".join(each.description for each in FORMATS)
        raise DataFileError(f"is in no format that is known. Known are {listed}.", path=path)
    return best


def read_recorded(path: Path, *, reader: str = "", **options: Any) -> Recorded:
    """Read a file of an instrument; an option that does not belong to its format is refused."""
    by_name = {each.name: each for each in FORMATS}
    if reader and reader not in by_name:
        raise DataFileError(f"there is no reader '{reader}'.{nearest(reader, by_name)}", path=path)
    chosen = by_name[reader] if reader else format_of(path)
    check_file(path)
    _check_package(path, chosen)
    given = {name: value for name, value in options.items() if value is not None}
    if foreign := [name for name in given if name not in chosen.options]:
        raise DataFileError(f"the option {foreign[0]} does not belong to {chosen.description}.", path=path)
    if "decimal_comma" in given:
        given["decimal_comma"] = truth(given["decimal_comma"], "decimal_comma")
    try:
        return without_missing_numbers(chosen.read(path, **given))
    except DataFileError as error:
        raise error.of_file(path) from None


def _check_package(path: Path, chosen: FileFormat) -> None:
    """Refuse to read a file without the package that reads it."""
    if chosen.package and importlib.util.find_spec(chosen.package) is None:
        how = f"pip install 'electrovib[{_EXTRA}]'{chosen.otherwise}"
        why = f"is read with the package {chosen.package}, which is not installed: {how}"
        raise DataFileError(why, path=path)


def format_lines() -> list[str]:
    """List the readers: name, what it reads, and the package it needs."""
    lines = [
        f"{each.name:<10} {each.description}" + (f"; needs {each.package}" if each.package else "")
        for each in FORMATS
    ]
    return [*lines, f"The packages are installed with: pip install 'electrovib[{_EXTRA}]'"]


def read_columns(
    path: Path, wanted: Mapping[str, tuple[str | int, str]], *, missing: bool = False
) -> dict[str, Real]:
    """Read the wanted columns of a measured file, converted to SI.

    `wanted` maps a name to heading, or number from 0, and unit; a unit in the file has priority over it, and
    must be of the same kind. With `missing`, NaN, infinities and fields of text that state no reading (as NaN) are accepted.
    Text has lines of ``#`` as comments; of a ``.mat`` file ``"name[3]"`` is column 3 of the array ``name``,
    and ``"trial.force"`` a field of a struct.
    """
    chosen = format_of(path)
    _check_package(path, chosen)
    asked = [column for column, _ in wanted.values()]
    read = chosen.columns or functools.partial(_of_recorded, chosen.read)
    try:
        found = read(path, asked, missing)
    except DataFileError as error:
        raise error.of_file(path) from None
    if len({len(column.values) for column in found.values()}) > 1:
        sizes = ", ".join(f"{called(column.name)} {len(column.values)}" for column in found.values())
        raise DataFileError(f"the columns differ in length: {sizes}.", path=path)
    return {name: found[column].in_si(path, unit, missing=missing) for name, (column, unit) in wanted.items()}


def _of_recorded(
    read: Callable[[Path], Recorded], path: Path, asked: Sequence[str | int], missing: bool
) -> dict[str | int, DataColumn]:
    """Choose columns of a format that has no other access to them."""
    del missing
    channels = read(path).channels
    names, numbered = [channel.name for channel in channels], range(len(channels))
    chosen = {column: choose(names, column, numbered) for column in asked}
    units = {column: agreed_unit(names[at], channels[at].unit, unit) for column, (at, unit) in chosen.items()}
    return {
        column: dataclasses.replace(channels[at], unit=units[column]) for column, (at, _) in chosen.items()
    }


MOST_BYTES: Final = 20_000_000
"""Largest file of a picture [bytes]; a choice."""
_HOW: Final = "Save it as 8-bit greyscale PNG without transparency."


def read_picture(path: Path, *, most_pixels: int) -> NDArray[np.uint8]:
    """Read a greyscale picture, checked before it is unpacked, as values 0 to 255, (rows, columns), the upper row first."""
    check_file(path)
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise DataFileError(
            f"has {megabytes(size)}, and a picture may have {megabytes(MOST_BYTES)}. Reduce its resolution.",
            path=path,
        )
    return read_by_library(lambda: _unpacked(path, most_pixels), path, "a PNG picture")


def _unpacked(path: Path, most_pixels: int) -> NDArray[np.uint8]:
    """Return the grey values of a picture."""
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(path, formats=("PNG",))
    except Image.DecompressionBombError:
        raise DataFileError(f"declares more than {most_pixels} pixels.", path=path) from None
    except UnidentifiedImageError:
        raise DataFileError(f"is damaged or not a PNG picture. {_HOW}", path=path) from None
    with picture:
        columns, rows = picture.size
        if columns * rows > most_pixels:
            raise DataFileError(
                f"has {columns} x {rows} pixels, and {most_pixels} are allowed. Reduce its resolution.",
                path=path,
            )
        if getattr(picture, "n_frames", 1) > 1:
            raise DataFileError(f"is an animation. {_HOW}", path=path)
        if picture.mode in {"LA", "RGBA", "PA"} or "transparency" in picture.info:
            raise DataFileError(f"has transparent pixels or an alpha channel. {_HOW}", path=path)
        if picture.mode not in {"1", "L", "P", "RGB"}:
            raise DataFileError(
                f"has pixels of the kind '{picture.mode}', and 8-bit grey is needed. {_HOW}", path=path
            )
        return _grey(path, np.asarray(picture.convert("L" if picture.mode in "1L" else "RGB")))


def _grey(path: Path, values: NDArray[np.uint8]) -> NDArray[np.uint8]:
    if values.ndim == 2:
        return values
    if np.any(values != values[..., :1]):
        raise DataFileError(f"is a colour picture. {_HOW}", path=path)
    return np.ascontiguousarray(values[..., 0])
