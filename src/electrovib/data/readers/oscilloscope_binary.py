"""Binary files of oscilloscopes (.wfm, .bin, .trc), read with RigolWFM."""

from __future__ import annotations

import re
import struct
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.guarded import read_by_library
from electrovib.data.recorded import CanRead, FileFormat, NotRead, check_declared, recorded_of, text_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

_PACKAGE: Final = "RigolWFM"
_UNITS: Final = {"v": "V", "a": "A", "w": "W"}
_TEKTRONIX_HEAD: Final = 248
"""First bytes of a Tektronix .wfm, up to the kind of its samples."""
_LONGEST_STATEMENTS: Final = 1 << 16


def _is_known(head: bytes) -> bool:
    """Return whether the first bytes are those of a known binary file of an oscilloscope."""
    return (
        re.match(rb"[\x0f\xf0]{2}:WFM#", head) is not None
        or re.match(rb"(#9\d{9})?WAVEDESC", head) is not None
        or re.match(rb"(AG|RG)(0[13]|10)", head) is not None
    )


def read_oscilloscope_binary(path: Path) -> Recorded:
    """Read the analogue channels of a binary file of an oscilloscope."""
    found = read_by_library(lambda: dict(_channels(path)), path, "a binary file of an oscilloscope")
    step, start, model, frames = found.pop("about")
    table = [(name, unit, values) for (_, name, unit), values in found.items()]
    later = NotRead(name=f"frames 2 to {frames} of {frames}", why="of a file the first frame is read")
    about, others = {"model": model} | _unsure(path), [later] if frames > 1 else []
    return recorded_of(table, step=step, start=start, attributes=about, not_read=others)


def _unsure(path: Path) -> dict[str, str]:
    """State what is not sure of a Rigol .wfm."""
    with path.open("rb") as file:
        known = _is_known(file.read(64))
    words = "the vertical offset: the package that reads .wfm of Rigol gives it a wrong sign for some models; compare with .csv"
    return {} if known else {"unsure": words}


def _tektronix(path: Path) -> tuple[str, int] | None:
    """Return the unit of the samples and the number of frames of a Tektronix .wfm; None of another file."""
    with path.open("rb") as file:
        head = file.read(_TEKTRONIX_HEAD)
    found = re.match(rb"(\x0f\x0f|\xf0\xf0):WFM#00([123])", head)
    if found is None or len(head) < _TEKTRONIX_HEAD:
        return None
    order = "<" if found[1] == b"\x0f\x0f" else ">"
    explicit = 166 if found[2] == b"1" else 168
    if _holds_carrier(path):
        why = "holds I and Q, the two parts of a modulated carrier, which are not read; save the samples over time"
        raise DataFileError(f"{why}, or I and Q as .csv.")
    (storage,) = struct.unpack_from(f"{order}i", head, explicit + 76)
    if storage == 1:
        why = "holds an envelope, a minimum and a maximum of each interval; save the samples, or the envelope as .csv"
        raise DataFileError(f"{why}.")
    unit = head[explicit + 20 : explicit + 40].partition(b"\0")[0].decode("latin-1").strip()
    return unit, 1 + int(struct.unpack_from(f"{order}I", head, 72)[0])


def _holds_carrier(path: Path) -> bool:
    """Return whether the statements behind the samples of a Tektronix .wfm are those of a carrier."""
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - _LONGEST_STATEMENTS, 0))
        _, mark, statements = file.read().rpartition(b"tekmeta!")
    return bool(mark) and b"IQ_" in statements


def _step(times: Real, stated: object) -> float:
    """Return the time between samples: as stated, where n stamps spread the time of n samples over n - 1 intervals."""
    step = float(times[-1] - times[0]) / (times.size - 1)
    if not isinstance(stated, (int, float)) or not np.isfinite(stated) or stated <= 0:
        return step
    spread = stated * times.size / (times.size - 1)
    return float(stated) if abs(step - spread) <= 1e-9 * spread else step


def _channels(path: Path) -> Iterator[tuple[Any, Any]]:
    """Yield step, start, model and frames, then number, name, unit and values of each channel."""
    from RigolWFM import wfm

    unit, frames = _tektronix(path) or (None, 1)
    found = wfm.Wfm.from_file(str(path))
    recorded = [channel for channel in found.channels if channel.volts is not None and len(channel.volts) > 1]
    if not recorded:
        raise ValueError("it holds no channel")
    check_declared(path, sum(len(channel.volts) for channel in recorded))
    times = np.asarray(recorded[0].times, dtype=float)
    step = _step(times, getattr(recorded[0], "seconds_per_point", None))
    if not np.isfinite(step) or step <= 0 or not np.isfinite(times[0]):
        raise ValueError("it states no time step")
    yield "about", [step, float(times[0]), text_of(getattr(found, "header_name", "")), frames]
    for at, channel in enumerate(recorded):
        named = str(getattr(channel.unit, "name", "")).lower()
        stated = _UNITS.get(named, "") if unit is None else unit
        yield (at, str(channel.name), stated), np.asarray(channel.volts, dtype=float)


def _can_read(head: bytes, suffix: str) -> CanRead:
    if _is_known(head):
        return CanRead.YES
    return CanRead.PERHAPS if suffix in (".wfm", ".trc", ".bin") and b"\0" in head else CanRead.NO


FORMAT: Final = FileFormat(
    name="scope",
    description="Tektronix and Rigol .wfm, Keysight, Rigol and Siglent .bin, LeCroy .trc",
    can_read=_can_read,
    read=read_oscilloscope_binary,
    package=_PACKAGE,
)
