"""Textures as drives: of a whole path of the finger, and block by block while it moves."""

from electrovib.studies.texture.drive import TextureDrive as TextureDrive
from electrovib.studies.texture.drive import texture_drive as texture_drive
from electrovib.studies.texture.drive import texture_stream as texture_stream
from electrovib.studies.texture.reading import read_path as read_path
from electrovib.studies.texture.reading import read_texture as read_texture
from electrovib.studies.texture.stream import StreamClosedError as StreamClosedError
