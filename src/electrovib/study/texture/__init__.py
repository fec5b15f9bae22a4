"""Textures as drives: of a whole path of the finger, and block by block while it moves."""

from electrovib.study.texture.drive import TextureDrive, texture_drive
from electrovib.study.texture.reading import read_path, read_texture
from electrovib.study.texture.stream import StreamClosedError, TextureStream, texture_stream

__all__ = [
    "StreamClosedError",
    "TextureDrive",
    "TextureStream",
    "read_path",
    "read_texture",
    "texture_drive",
    "texture_stream",
]
