"""Sound files (.wav) as recorded by sound cards."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import FileFormat, begins, recorded_of

if TYPE_CHECKING:
    from pathlib import Path

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

_PLAIN, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE
_LONG: Final = 0xFFFFFFFF
"""Size of the samples of a file of RF64, whose part ``ds64`` states the true one."""
_MOST_CHANNELS: Final = 256


def read_wave(path: Path) -> Recorded:
    """Read a sound file, its channels as shares of full scale, because the file states no other unit."""
    raw = path.read_bytes()
    order = ">" if raw[:4] == b"RIFX" else "<"
    form, data = _parts(raw, order)
    code, channels, rate, _, block, bits = struct.unpack_from(f"{order}HHIIHH", form)
    if code == _EXTENSIBLE and len(form) >= 26:
        code = struct.unpack_from(f"{order}H", form, 24)[0]
    width = bits // 8
    if code not in (_PLAIN, _FLOAT) or width not in ((1, 2, 3, 4) if code == _PLAIN else (4, 8)) or bits % 8:
        raise DataFileError(
            f"is a sound file of the form {code} with {bits} bits; known are whole numbers of 8 to 32 and floats of 32 and 64"
            " bits without compression."
        )
    if not 0 < channels <= _MOST_CHANNELS or block != channels * width or not rate:
        raise DataFileError(
            f"is damaged or not a sound file ({channels} channels, {block} bytes a sample, {rate} Hz)."
        )
    count = len(data) // block
    shares = _shares(data[: count * block], order, width, is_float=code == _FLOAT).reshape(count, channels)
    columns = [(f"channel {at + 1}", "1", shares[:, at]) for at in range(channels)]
    return recorded_of(columns, step=1 / rate)


def _parts(raw: bytes, order: str) -> tuple[bytes, bytes]:
    """Return the format and the samples; samples that are cut off end with the file."""
    found: dict[bytes, bytes] = {}
    place = 12
    while place + 8 <= len(raw):
        name = raw[place : place + 4]
        size = struct.unpack_from(f"{order}I", raw, place + 4)[0]
        if size == _LONG and name == b"data" and len(found.get(b"ds64", b"")) >= 16:
            size = struct.unpack_from("<8xQ", found[b"ds64"])[0]
        found.setdefault(name, raw[place + 8 : place + 8 + size])
        place += 8 + size + size % 2
    is_sound = raw[:4] in (b"RIFF", b"RIFX", b"RF64") and b"data" in found
    if not is_sound or len(found.get(b"fmt ", b"")) < 16:
        raise DataFileError("is damaged or not a sound file (it has no format or no samples).")
    return found[b"fmt "], found[b"data"]


def _shares(data: bytes, order: str, width: int, *, is_float: bool) -> Real:
    """Scale whole numbers to full scale; floats are shares already."""
    if is_float:
        return np.frombuffer(data, f"{order}f{width}").astype(float)
    if width == 1:
        return (np.frombuffer(data, "u1").astype(float) - 128) / 128
    if width == 3:  # as the upper bytes of whole numbers of four
        three = np.frombuffer(data, "u1").reshape(-1, 3)
        data = np.insert(three, 0 if order == "<" else 3, 0, axis=1).tobytes()
        width = 4
    return np.frombuffer(data, f"{order}i{width}").astype(float) / 2.0 ** (8 * width - 1)


FORMAT: Final = FileFormat(
    name="wav",
    description="sound files (.wav, also RF64), as shares of full scale",
    can_read=begins(rb"(RIF[FX]|RF64).{4}WAVE", ".wav"),
    read=read_wave,
)
