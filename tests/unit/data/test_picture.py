"""Pictures are read within limits of size, and everything else is refused in a sentence."""

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from electrovib.core.errors import DataFileError
from electrovib.data import registry as module
from electrovib.data.registry import _unpacked, read_picture

GREY = np.array([[0, 255, 7], [128, 1, 254]], dtype=np.uint8)


def chunk(name, content):
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def png(columns, rows, content=b""):
    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    parts = {b"IHDR": head, b"IDAT": zlib.compress(content), b"IEND": b""}
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(name, part) for name, part in parts.items())


@pytest.fixture
def file(tmp_path):
    return tmp_path / "texture.png"


def in_process(path, most_pixels=10**6):
    return _unpacked(path, most_pixels)


def test_grey_values_are_read_as_they_are(file):
    Image.fromarray(GREY).save(file)
    np.testing.assert_array_equal(read_picture(file, most_pixels=6), GREY)
    for convert in ("RGB", "P"):
        Image.fromarray(GREY).convert(convert).save(file)
        np.testing.assert_array_equal(in_process(file), GREY)
    Image.fromarray(GREY > 100).save(file)
    np.testing.assert_array_equal(in_process(file), np.where(GREY > 100, 255, 0))


def image(values, mode="", form="PNG"):
    """Bytes of a picture."""
    found, picture = io.BytesIO(), Image.fromarray(values)
    (picture.convert(mode) if mode else picture).save(found, format=form)
    return found.getvalue()


ROWS = b"".join(b"\0" + bytes(50) for _ in range(50))
REFUSED = {
    "too many pixels": (
        png(30_000, 30_000),
        "30000 x 30000 pixels, and 1000000 are allowed|declares more than",
    ),
    "a bomb within Pillow's own limit": (png(9_000, 9_000), "has 9000 x 9000 pixels"),
    "colours": (
        image(np.dstack([GREY, GREY, GREY + 1])),
        "is a colour picture. Save it as 8-bit greyscale PNG",
    ),
    "alpha": (image(GREY, "LA"), "alpha channel"),
    "16 bits": (image(GREY.astype(np.uint16)), "8-bit grey is needed"),
    "no picture": (b"no picture", "is damaged or not a PNG picture"),
    "another format": (image(GREY, form="GIF"), "is damaged or not a PNG picture"),
    "an empty file": (b"", "is damaged or not|is empty"),
    "cut": (png(50, 50, ROWS)[:40], "is damaged or not a PNG picture"),
    "cut later": (png(50, 50, ROWS)[:60], "is damaged or not a PNG picture"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_other_pictures_are_refused_in_one_sentence(case, file):
    content, words = REFUSED[case]
    file.write_bytes(content)
    read = (lambda path: read_picture(path, most_pixels=10**6)) if "cut" in case else in_process
    with pytest.raises(DataFileError, match=words) as caught:
        read(file)
    assert len(caught.value.problems) == 1


def test_rows_that_a_picture_declares_and_does_not_hold_are_black(file):
    """Black is the plate's own friction: no voltage."""
    file.write_bytes(png(50, 50, b"\0" + b"\7" * 50))
    values = read_picture(file, most_pixels=10**6)
    assert values[0].tolist() == [7] * 50
    assert not values[1:].any()


def test_a_large_file_is_refused_before_it_is_read(file, monkeypatch):
    monkeypatch.setattr(module, "MOST_BYTES", 100)
    file.write_bytes(b"0" * 101)
    with pytest.raises(DataFileError, match=r"has 0\.000101 MB, and a picture may have 0\.0001 MB"):
        read_picture(file, most_pixels=1)
