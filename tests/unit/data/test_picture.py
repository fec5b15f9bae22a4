"""Pictures are read within limits of size, and everything else is refused in a sentence."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from electrovib.core.errors import DataFileError
from electrovib.data import picture as module
from electrovib.data.picture import read_picture, unpacked

GREY = np.array([[0, 255, 7], [128, 1, 254]], dtype=np.uint8)


def chunk(name, content):
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def png(columns, rows, content=b""):
    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(content))
        + chunk(b"IEND", b"")
    )


@pytest.fixture
def file(tmp_path):
    return tmp_path / "texture.png"


def in_process(path, most_pixels=10**6):
    return dict(unpacked(path, most_pixels))["values"]


def test_grey_values_are_read_as_they_are(file):
    Image.fromarray(GREY).save(file)
    np.testing.assert_array_equal(read_picture(file, most_pixels=6), GREY)


def test_grey_in_colour_channels_a_palette_and_black_and_white_are_read(file):
    for convert in ("RGB", "P"):
        Image.fromarray(GREY).convert(convert).save(file)
        np.testing.assert_array_equal(in_process(file), GREY)
    Image.fromarray(GREY > 100).save(file)
    np.testing.assert_array_equal(in_process(file), np.where(GREY > 100, 255, 0))


def saved(mode):
    return lambda file: Image.fromarray(GREY).convert(mode).save(file)


def colour(file):
    Image.fromarray(np.dstack([GREY, GREY, GREY + 1])).save(file)


REFUSED = {
    "too many pixels": (
        lambda file: file.write_bytes(png(30_000, 30_000)),
        "30000 x 30000 pixels, and 1000000 are allowed|declares more than",
    ),
    "a bomb within Pillow's own limit": (
        lambda file: file.write_bytes(png(9_000, 9_000)),
        "has 9000 x 9000 pixels",
    ),
    "colours": (colour, "is a colour picture. Save it as 8-bit greyscale PNG"),
    "alpha": (saved("LA"), "alpha channel"),
    "16 bits": (lambda file: Image.fromarray(GREY.astype(np.uint16)).save(file), "8-bit grey is needed"),
    "no picture": (lambda file: file.write_bytes(b"no picture"), "is damaged or not a PNG picture"),
    "another format": (
        lambda file: Image.fromarray(GREY).save(file, format="GIF"),
        "is damaged or not a PNG picture",
    ),
    "an empty file": (lambda file: file.write_bytes(b""), "is damaged or not|is empty"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_other_pictures_are_refused(case, file):
    write, words = REFUSED[case]
    write(file)
    with pytest.raises(DataFileError, match=words):
        in_process(file)


@pytest.mark.parametrize("cut", [40, 60])
def test_a_truncated_picture_is_refused_in_one_sentence(cut, file):
    rows = b"".join(b"\0" + bytes(row) for row in np.zeros((50, 50), np.uint8))
    file.write_bytes(png(50, 50, rows)[:cut])
    with pytest.raises(DataFileError, match="is damaged or not a PNG picture") as caught:
        read_picture(file, most_pixels=10**6)
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
