"""Tektronix internal format (.isf): a preamble of keys and one curve, a binary block of IEEE 488.2."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import FileFormat, NotRead, begins, recorded_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

_BEGIN: Final = re.compile(rb"#([1-9])(\d+)")


def block_at(raw: bytes, begin: int = 0) -> tuple[int, int] | None:
    """Return where the data of a block of definite length begin, and the length that it states; None of anything else."""
    found = _BEGIN.match(raw, begin, begin + 11)
    count = int(found[1]) if found else 0
    if found is None or len(found[2]) < count:
        return None
    return begin + 2 + count, int(found[2][:count])


_SHORT: Final = {
    "byt_n": "byt_nr", "bit_n": "bit_nr", "enc": "encdg", "bn_f": "bn_fmt", "byt_o": "byt_or", "nr_p": "nr_pt",
    "pt_f": "pt_fmt", "xun": "xunit", "xin": "xincr", "xze": "xzero", "pt_o": "pt_off", "yun": "yunit", "ymu": "ymult",
    "yof": "yoff", "yze": "yzero", "wfi": "wfid",
}  # fmt: skip
"""Maps short keys of the preamble, in small letters, to the long ones."""
_LONGEST_PREAMBLE: Final = 20_000
_KEY: Final = re.compile(r"\s*:?(?:WFMP(?:RE)?:|WFMO(?:UTPRE)?:|CURV[EV]?:)?([A-Za-z_]+)\s+(.*)", re.DOTALL)
_CURVE: Final = re.compile(rb"(?:\A|[;:\n])\s*CURVE?\s+(?=[#\d+-])", re.IGNORECASE)


def read_isf(path: Path) -> Recorded:
    """Read one waveform of a Tektronix oscilloscope.

    value = yzero + ymult (count - yoff), time = xzero + xincr (index - pt_off). Of an envelope (PT_FMT ENV) a
    pair of points belongs to one interval of two times xincr; minimum and maximum are two channels, which are
    never averaged.
    """
    raw = path.read_bytes()
    begin = _CURVE.search(raw[:_LONGEST_PREAMBLE])
    if begin is None:
        raise DataFileError("is not in Tektronix's internal format: it holds no 'CURVE #'.")
    keys = preamble_of(raw[: begin.start()].decode("latin-1"))
    try:
        counts, rest = _counts(raw, begin.end(), keys)
        yzero, yoff, xzero, pt_off = (
            number_of(keys, key) if key in keys else 0.0 for key in ("yzero", "yoff", "xzero", "pt_off")
        )
        values, step = yzero + number_of(keys, "ymult") * (counts - yoff), number_of(keys, "xincr")
    except NoNumberError as error:
        raise DataFileError(f"{error} in its preamble.") from None
    start = xzero - step * pt_off
    name = keys.get("wfid", "").strip('" ').partition(",")[0] or "CH1"
    unit, table = keys.get("yunit", "").strip('" '), {name: values}
    if keys.get("pt_fmt", "Y").upper().startswith("ENV"):
        if values.size % 2:
            raise DataFileError("is an envelope with an odd number of points: it is damaged.")
        pairs, step = np.sort(values.reshape(-1, 2)), 2 * step
        table = {f"{name} minimum": pairs[:, 0], f"{name} maximum": pairs[:, 1]}
    columns = [(label, unit, samples) for label, samples in table.items()]
    more = NotRead(name=f"{len(rest)} bytes behind the curve", why="of a file the first curve is read")
    others = [more] if rest.strip(b";\r\n") else []
    return recorded_of(columns, step=step, start=start, attributes=keys, not_read=others)


class NoNumberError(ValueError):
    """A preamble states no number for a key."""


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
        raise NoNumberError(f"states no number for {key.upper()}")
    return found


def _counts(raw: bytes, begin: int, keys: Mapping[str, str]) -> tuple[Real, bytes]:
    """Read the curve, a block in the sample format of the preamble or numbers with commas, and what is behind it."""
    stated, encoding = keys.get("nr_pt", ""), keys.get("encdg", "BIN").upper()
    points = int(stated) if stated.isascii() and stated.isdigit() else None
    if encoding.startswith("ASC") and raw[begin : begin + 1] != b"#":
        text, _, rest = raw[begin:].partition(b";")
        try:
            counts = np.array(text.split(b","), dtype=float)
        except ValueError:
            raise DataFileError("has a curve that is not made of numbers: it is damaged.") from None
    else:
        counts, rest = _of_block(raw, begin, keys, points)
    if points is not None and points != counts.size:
        raise DataFileError(f"states {stated} points and holds {counts.size}: it is damaged.")
    return counts, rest


def _of_block(raw: bytes, begin: int, keys: Mapping[str, str], points: int | None) -> tuple[Real, bytes]:
    """Read a binary curve; the length of a block that states none is that of the points."""
    width = int(number_of(keys, "byt_nr"))
    encoding, form = keys.get("encdg", "BIN").upper(), keys.get("bn_fmt", "RI").upper()
    if width not in (1, 2) or not encoding.startswith("BIN") or form not in ("RI", "RP"):
        raise DataFileError(
            f"has samples of {width} bytes, {encoding} {form}; known are 1 or 2 bytes of BIN RI or RP."
        )
    block = block_at(raw, begin)
    if block is None and points is not None and raw[begin : begin + 2] == b"#0":
        block = begin + 2, points * width
    if block is None:
        raise DataFileError("has a curve of unknown length.")
    first, length = block
    if first + length > len(raw):
        held = max(len(raw) - first, 0)
        raise DataFileError(f"states {length} bytes of samples and holds {held}: it is cut off.")
    if length % width:
        raise DataFileError("ends within a sample: it is damaged.")
    order = "<" if keys.get("byt_or", "MSB").upper().startswith("LSB") else ">"
    kind = np.dtype(f"{order}{'i' if form == 'RI' else 'u'}{width}")
    counts = np.frombuffer(raw, kind, count=length // width, offset=first).astype(float)
    return counts, raw[first + length :]


FORMAT: Final = FileFormat(
    name="isf",
    description="Tektronix internal format (.isf)",
    can_read=begins(rb"(?i)\s*:?(WFMP|WFMO|BYT_N|CURV)", ".isf"),
    read=read_isf,
)
