"""Greyscale pictures (.png)."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.budget import megabytes
from electrovib.core.errors import DataFileError
from electrovib.data.faults import check_file, read_by_library

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

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
