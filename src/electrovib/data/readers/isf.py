"""Tektronix internal format (.isf): a preamble of keys, as the oscilloscopes also send it, and one binary curve."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import DataColumn, FileFormat, Recorded, begins

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

_SHORT: Final = {
    "byt_n": "byt_nr", "bit_n": "bit_nr", "enc": "encdg", "bn_f": "bn_fmt", "byt_o": "byt_or", "nr_p": "nr_pt",
    "pt_f": "pt_fmt", "xun": "xunit", "xin": "xincr", "xze": "xzero", "pt_o": "pt_off", "yun": "yunit", "ymu": "ymult",
    "yof": "yoff", "yze": "yzero", "wfi": "wfid",
}  # fmt: skip
"""Maps short keys of the preamble, in small letters, to the long ones."""
_LONGEST_PREAMBLE: Final = 20_000
_KEY: Final = re.compile(r"\s*:?(?:WFMP(?:RE)?:|WFMO(?:UTPRE)?:|CURV[EV]?:)?([A-Za-z_]+)\s+(.*)", re.DOTALL)
_CURVE: Final = re.compile(rb":?CURVE?\s+#", re.IGNORECASE)


def read_isf(path: Path) -> Recorded:
    """Read one waveform of a Tektronix oscilloscope.

    value = yzero + ymult (count - yoff), time = xzero + xincr (index - pt_off). Of an envelope (PT_FMT ENV) a
    pair of points belongs to one interval of two times xincr; minimum and maximum are two channels, which are
    never averaged.
    """
    raw = path.read_bytes()
    begin = _CURVE.search(raw[:_LONGEST_PREAMBLE])
    if begin is None:
        raise DataFileError("is not in Tektronix's internal format: it holds no 'CURVE #'.", path=path)
    keys = preamble_of(raw[: begin.start()].decode("latin-1"))
    counts = _counts(path, raw, begin.end(), keys)
    offsets = _number(path, keys, "yzero", 0.0), _number(path, keys, "yoff", 0.0)
    values = offsets[0] + _number(path, keys, "ymult") * (counts - offsets[1])
    step, origin = _number(path, keys, "xincr"), _number(path, keys, "xzero", 0.0)
    start = origin - step * _number(path, keys, "pt_off", 0.0)
    name = keys.get("wfid", "").strip('" ').partition(",")[0] or "CH1"
    unit = keys.get("yunit", "").strip('" ')
    if keys.get("pt_fmt", "Y").upper().startswith("ENV"):
        if values.size % 2:
            raise DataFileError("is an envelope with an odd number of points: it is damaged.", path=path)
        low, high = np.minimum(values[::2], values[1::2]), np.maximum(values[::2], values[1::2])
        channels = (
            DataColumn(name=f"{name} minimum", unit=unit, values=low),
            DataColumn(name=f"{name} maximum", unit=unit, values=high),
        )
        return Recorded(channels=channels, step=2 * step, start=start, attributes=keys)
    return Recorded(
        channels=(DataColumn(name=name, unit=unit, values=values),), step=step, start=start, attributes=keys
    )


def preamble_of(text: str) -> dict[str, str]:
    """Read the keys of a preamble, long and in small letters; semicolons within quotation marks do not end a value."""
    found = {}
    for part in re.findall(r'(?:"[^"]*"|[^;"])+', text):
        if match := _KEY.match(part):
            key, value = match.group(1).lower(), match.group(2).strip()
            found[_SHORT.get(key, key)] = value
    return found


def number_of(keys: Mapping[str, str], key: str) -> float:
    """Return the number that a preamble states for a key."""
    try:
        found = float(keys.get(key, ""))
    except ValueError:
        found = np.nan
    if not np.isfinite(found):
        raise ValueError(f"states no number for {key.upper()}")
    return found


def _number(path: Path, keys: Mapping[str, str], key: str, default: float | None = None) -> float:
    if key not in keys and default is not None:
        return default
    try:
        return number_of(keys, key)
    except ValueError as error:
        raise DataFileError(f"{error} in its preamble.", path=path) from None


def _counts(
    path: Path, raw: bytes, begin: int, keys: Mapping[str, str]
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Read the curve ``#<n><length><binary>`` in the sample format of the preamble."""
    digits = raw[begin : begin + 1]
    if not digits.isdigit() or digits == b"0":
        raise DataFileError("has a curve of unknown length.", path=path)
    size = raw[begin + 1 : begin + 1 + int(digits)]
    if not size.isdigit():
        raise DataFileError("has a curve of unknown length.", path=path)
    first, length = begin + 1 + int(digits), int(size)
    if first + length > len(raw):
        raise DataFileError(
            f"states {length} bytes of samples and holds {max(len(raw) - first, 0)}: it is cut off.",
            path=path,
        )
    width = int(_number(path, keys, "byt_nr"))
    encoding = keys.get("encdg", "BIN").upper()
    form = keys.get("bn_fmt", "RI").upper()
    if width not in (1, 2) or not encoding.startswith("BIN") or form not in ("RI", "RP"):
        raise DataFileError(
            f"has samples of {width} bytes, {encoding} {form}; known are 1 or 2 bytes of BIN RI or RP.",
            path=path,
        )
    order = "<" if keys.get("byt_or", "MSB").upper().startswith("LSB") else ">"
    kind = np.dtype(f"{order}{'i' if form == 'RI' else 'u'}{width}")
    if length % width:
        raise DataFileError("ends within a sample: it is damaged.", path=path)
    counts = np.frombuffer(raw, kind, count=length // width, offset=first).astype(np.float64)
    stated = keys.get("nr_pt", "")
    if stated.isascii() and stated.isdigit() and int(stated) != counts.size:
        raise DataFileError(f"states {stated} points and holds {counts.size}: it is damaged.", path=path)
    if counts.size < 2:
        raise DataFileError("holds fewer than two samples.", path=path)
    return counts


FORMAT: Final = FileFormat(
    name="isf",
    description="Tektronix internal format (.isf)",
    can_read=begins(rb"(?i)\s*:?(WFMP|WFMO|BYT_N|CURV)", ".isf"),
    read=read_isf,
)
