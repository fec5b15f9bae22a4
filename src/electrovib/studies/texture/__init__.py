"""Textures as drives: of a whole path of the finger, and block by block while it moves."""

from electrovib.studies.texture.drive import TextureDrive, texture_drive
from electrovib.studies.texture.opening import texture_stream
from electrovib.studies.texture.reading import read_path, read_texture
from electrovib.studies.texture.stream import StreamClosedError, TextureStream

__all__ = [
    "StreamClosedError",
    "TextureDrive",
    "TextureStream",
    "read_path",
    "read_texture",
    "texture_drive",
    "texture_stream",
]
