"""What a text means: units and the words that instruments write for them, headings with both, numbers, missing readings."""

from __future__ import annotations

import functools
import re
import unicodedata
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.units import KINDS, parse_quantity

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_ANGLE: Final = re.compile(r"rad|deg|°|turn|rev|rpm|cycle")
_LONGEST_HEADING: Final = 200
_BRACKETS: Final = re.compile(r"(.*?)(\s*[\[({<])\s*(?!M[VAN][\])])([^\])}>]*?)\s*[\])}>](?:-data)?\s*")
"""Heading with a unit that is not MV, MA or MN; impedance analysers of Keysight write ``|Z|(Ohm)-data``."""
_OF_A_NODE: Final = {"v": "V", "i": "A"}
"""Names before brackets directly behind them that hold a node of a circuit, if not their own unit: ``V(a)``, ``I(R1)``."""
_LIKE_A_UNIT: Final = re.compile(
    r"(?i)(deg(ree)?s?[ .]?|°)[CFK]|[CFK]|%.{0,8}|counts?|a\.?u\.?|bits?|[mk]?bar|psi|mmHg|[munµ]?V ?(rms|pp|p|ac|dc)"
    r"|[munµ]?A ?(rms|pp|p|ac|dc)|dB\w?|[^\W\d_]{1,6}[ .*·⋅-]?[^\W\d_]{0,5}[ ]?[/^*·⋅²³].*|[munµkM]?N[ .]?m"
)
"""Units that are none of electrovib, and remain as written."""
_PARTS_OF_ZPLOT: Final = re.compile(r"(Z'{1,2})\s?\([ab]\)")
"""Headings of the parts of an impedance, of which ZPlot calls one a and the other b."""
_RESISTIVITY: Final = re.compile(r"([kMGTmuµ]?)(?:[Oo]hms?|OHMS?|Ω|\u2126)[ .*·⋅-]?(c?m)(\^?2|²|)")
_SIEMENS: Final = re.compile(r"[munp]S")
_TIMES: Final = re.compile(r"t(ime)?\b|zeit|temps|x\b", re.IGNORECASE)
"""Names of columns in which some oscilloscopes write S for a second."""
_AT_THE_END: Final = (
    re.compile(r"(?P<name>(?i:t|time|zeit|temps)_(?P<unit>[mnuµ]?s))"),
    re.compile(r"(?P<name>.+_(?P<unit>[pnuµmk][VANF]|[munµ]s|[nuµmc]m|[kM]?Hz|k?Pa|k?gf))"),
    re.compile(r"(?P<name>(?:CH|MATH)\d)(?P<unit>[VA])"),
    re.compile(r"(?P<name>.+?)(?: in |/)(?P<unit>[mnuµ]?S/c?m)"),
)
"""Headings that end with their unit: times, names of scripts, channels of Rigol, conductivities.

After other names than those of times a single letter may be an index, as N in ``F_N``.
"""
UNITS: Final = {
    "volt": "V", "volts": "V", "v": "V", "mv": "mV", "uv": "uV", "kv": "kV", "ampere": "A", "amperes": "A",
    "amp": "A", "amps": "A", "a": "A", "ma": "mA", "ua": "uA", "second": "s", "seconds": "s", "sec": "s", "s": "s",
    "ms": "ms", "us": "us", "µs": "us", "ns": "ns", "hertz": "Hz", "hz": "Hz", "khz": "kHz", "mhz": "MHz",
    "newton": "N", "newtons": "N", "n": "N", "mn": "mN", "ohm": "ohm", "ohms": "ohm", "ω": "ohm", "Ω": "ohm",
    "degree": "deg", "degrees": "deg", "deg": "deg", "°": "deg", "rad": "rad", "radians": "rad", "f": "F",
    "s/m": "S/m", "m": "m", "mm": "mm", "um": "um", "µm": "um", "m/s": "m/s", "mm/s": "mm/s", "pa": "Pa", "w": "W",
    "db": "dB", "%": "%", "unknown": "", "-": "1", "#": "",
    "'": "deg", "v vs. ref.": "V", "bits": "", "deg c": "", "sequence": "",
    "value": "", "na": "nA", "pf": "pF", "nf": "nF", "uf": "uF", "kohm": "kohm", "msec": "ms", "usec": "us", "µsec": "us",
    "millis": "ms", "micros": "us", "gram": "g", "grams": "g", "gram-force": "gf",
    "cn": "cN", "kn": "kN", "g": "g", "kg": "kg", "gf": "gf", "kgf": "kgf", "lbf": "lbf", "cm": "cm", "kpa": "kPa", "rpm": "rpm",
}  # fmt: skip
"""Maps words and signs that instruments write for units, in small letters, to the units of electrovib."""
_WITH_PREFIX: Final = re.compile(r"[pnumkMG]?(V|A|Hz|N|ohm|Ω|F|Pa|W)|[pnum]?s|[numck]?m|min")
_POWER: Final = re.compile(
    r"[x×*·]? ?(?:1[eE]|10 ?\^|10\*\*|10(?=[-+\u2212]))\(?([-+\u2212]?\d{1,2})\)? ?[x×*·]? ?(V|A|N|s|m|F|Pa|ohm|W)"
)
_OF_POWER: Final = {"-9": "n", "-6": "u", "-3": "m", "0": "", "3": "k", "6": "M"}
"""Prefix of a power of ten that stands before a unit, as in ``[10^-3 N]``."""
HAS_POWER: Final = re.compile(r"\b(10 ?\^|10\*\*|1[eE])\(? ?[-+\u2212]?\d|[x×*] ?(10|1e)", re.IGNORECASE)
"""Headings with a power of ten that may stand for a factor of the numbers, or for one that they have already."""
_PER_TIME: Final = re.compile(r"([a-zµ]{1,2})/(s|sec|second)s?", re.IGNORECASE)
_FORCE: Final = re.compile(r"f([a-z]|_[a-z]+)?|.*(force|load|friction|kraft|effort).*", re.IGNORECASE)
"""Names of columns of forces, which some tribometers state in the mass whose weight they are."""
UNIT_NAMES: Final = {word for word, unit in UNITS.items() if unit and word.isalpha() and len(word) > 3}
"""Words that name a unit and nothing else, so that a heading of one such word states the unit."""


@functools.cache
def kind_and_factor(unit: str) -> tuple[str, float] | None:
    """Return the SI unit of the kind to which a unit text belongs, and the conversion factor."""
    if unit in ("1", "-"):
        return "1", 1.0
    if not unit or len(unit) > 24:
        return None
    # likely kinds first, because each miss asks pint; to pint an angle is a plain number and rad/s is Hz
    for kind in sorted(KINDS, key=lambda kind: -len(kind) if unit.endswith(kind) else 0):
        if (kind == "rad") == bool(_ANGLE.search(unit)):
            try:
                return kind, parse_quantity(f"1 {unit}", kind)
            except ValueError:
                continue
    return None


def name_and_known_unit(heading: str) -> tuple[str, str]:
    """Split a heading such as ``time [us]`` whose brackets hold a unit that is known, or stand in square ones behind a blank."""
    start = max(heading.rfind("["), heading.rfind("("))
    if start < 1 or heading[-1:] not in "])":
        return heading, ""
    name, unit = heading[:start].rstrip(), heading[start + 1 : -1]
    if not name or not unit.strip() or "]" in unit or ")" in unit:
        return heading, ""
    is_unit = len(name) < start and heading[start] == "["
    return (name, unit.strip()) if is_unit or kind_and_factor(unit.strip()) else (heading, "")


def name_and_unit(heading: str) -> tuple[str, str]:
    """Split ``Time (s)``, ``CH1 [mV]`` or ``Volt``, ``in s``; a unit that is not known stays as written."""
    heading = heading[:_LONGEST_HEADING]
    if found := _PARTS_OF_ZPLOT.fullmatch(heading):
        return found[1], "ohm"
    if (found := _BRACKETS.fullmatch(heading)) and _is_unit(*found.group(1, 2, 3)):
        name, _, unit = found.groups()
        siemens = _SIEMENS.fullmatch(unit) and not _TIMES.match(name)
        known = unit if siemens else as_unit(unit)
        return name or heading, unit if known is None else known
    if heading.startswith("in ") and as_unit(heading[3:]):  # as Rohde & Schwarz write the time
        return "time", as_unit(heading[3:]) or ""
    if found := next(filter(None, (form.fullmatch(heading) for form in _AT_THE_END)), None):
        return found["name"], found["unit"].replace("µ", "u")
    parted = [heading.rpartition(sign) for sign in (" / ", " in ", ", ")]
    for name, _, last in (*parted, heading.partition("/"), heading.rpartition("/")):
        if name and as_unit(last) and not _PER_TIME.fullmatch(heading):
            return name, as_unit(last) or ""
    return heading, ""


def _is_unit(name: str, opening: str, unit: str) -> bool:
    """Return whether brackets of a heading hold its unit, not a part of its name as in ``Re(Z)``, ``V(out)``, ``tan(delta)``."""
    if opening.endswith("["):
        return True
    kind = kind_and_factor(as_unit(unit) or unit)
    if opening == "(" and (own := _OF_A_NODE.get(name.lower())):
        return kind is not None and kind[0] == own
    return as_unit(unit) is not None or kind is not None or bool(_LIKE_A_UNIT.fullmatch(unit))


def as_unit(text: str) -> str | None:
    """Return the unit that a word stands for; None if it is no unit, and empty for a word such as ``"unknown"``."""
    text = unicodedata.normalize("NFKC", text).strip().replace("\u03bc", "u")
    if text in ("MV", "MA", "MN"):
        return ""  # instruments with capitals alone write mV, mA and mN so, and none measures megavolts
    if found := _POWER.fullmatch(text):
        text = _OF_POWER.get(found[1].replace("\u2212", "-").lstrip("+"), "?") + found[2]
    if _WITH_PREFIX.fullmatch(text):
        return text.replace("Ω", "ohm")
    if found := _RESISTIVITY.fullmatch(text.strip()):
        return f"{found[1]}ohm {found[2]}{'2' if found[3] else ''}"
    if (found := _PER_TIME.fullmatch(text.strip())) and UNITS.get(found[1].lower(), "").endswith("m"):
        return f"{UNITS[found[1].lower()]}/s"
    return UNITS.get(text.strip().lower(), UNITS.get(text.strip()))


def unit_of_force(name: str, unit: str) -> str:
    """Return the unit of a column; the mass in which a force is stated becomes the force of its weight."""
    return f"{unit}f" if unit in ("g", "kg") and _FORCE.fullmatch(name) else unit


MISSING: Final = frozenset({
    "", "nan", "-nan", "n/a", "#n/a", "na", "null", "none", "inf", "-inf", "+inf", "∞", "-∞", "+∞", "ol", "-ol", "+ol",
    "1.#qnan", "-1.#ind", "1.#inf", "-1.#inf", "clipping", "overflow", "overload", "ovld", "-ovld", "+ovld", "ovfl", "over",
    "+over", "-over", "ovrflw", "overrange", "underrange", "under", "o.l", "o.l.", "#value!", "#div/0!", "#num!", "#ref!",
    "#name?", "<na>", "infinity", "-infinity", "burnout", "over range", "under range", "out of range", "\\n",
})  # fmt: skip
"""Fields, in small letters, that state no number: empty, out of the range of the instrument, or no reading."""
_SIGNS_ALONE: Final = re.compile(r"\*+|-{2,}|\+{2,}|[_.]{2,}|\?+")
ALIKE: Final = str.maketrans({
    "\u2212": "-", "\u2013": "-", "\u00a0": " ", "\u202f": " ", "\u2009": " ", "\u2019": "'",
})  # fmt: skip
"""Signs that are written for a minus, a blank, an apostrophe."""
_LONGEST: Final = 64
"""Most characters of a number; the bound keeps the matching fast."""
_UNIT: Final = re.compile(r"(.*[\d.)]) ?((?:[^\W\d_]|[°%]).{0,11})")
THOUSANDS: Final = (",", ".", " ", "'")


@functools.cache
def _form(decimal: str, thousands: str) -> re.Pattern[str]:
    """Return the pattern of a number, whose sign may stand apart."""
    whole = r"\d+"
    if thousands:
        sign = re.escape(thousands)
        whole = rf"[1-9]\d{{0,2}}(?:{sign}\d{{3}})+|[1-9]\d?(?:{sign}\d\d)+{sign}\d{{3}}|\d+"
    point = re.escape(decimal)
    return re.compile(
        rf"(?:[+-] {{0,12}})?(?:(?:{whole})(?:{point}\d*)?|{point}\d+)(?:[eEdD][+-]?\d{{1,4}})?", re.ASCII
    )


@dataclass(frozen=True, kw_only=True)
class Notation:
    """How a text writes numbers: its decimal sign, and the sign between thousands, empty if there is none."""

    decimal: str = "."
    thousands: str = ""

    @functools.lru_cache(maxsize=16_384)  # noqa: B019  # a notation is a constant
    def number(self, cell: str) -> float | None:
        """Return the number that a field states; NaN where a reading is missing, None where the field is no number."""
        if len(cell) > _LONGEST:
            return None
        if (cell.lower() in MISSING and cell != "nA") or _SIGNS_ALONE.fullmatch(cell):
            return np.nan
        cell = cell.translate(ALIKE)
        below = cell[:1] == "(" and cell[-1:] == ")"  # as accountants write negative numbers
        text = cell[1:-1] if below else cell
        if not _form(self.decimal, self.thousands).fullmatch(text) or (below and text[0] in "+-"):
            return None
        plain = text.replace(self.thousands, "") if self.thousands else text
        plain = plain.replace(" ", "").replace(self.decimal, ".").replace("D", "E").replace("d", "e")
        return -float(plain) if below else float(plain)

    def is_number(self, cell: str) -> bool:
        """Return whether a field is a number or a reading that is missing."""
        return self.number(cell) is not None

    def states(self, cell: str) -> bool:
        """Return whether a field is a number, with its unit or without one, or a reading that is missing."""
        return self.is_number(cell) or self.quantity(cell) is not None

    def quantity(self, cell: str) -> tuple[float, str] | None:
        """Return the number and the unit of a field such as ``1.2 us``; None if it is none."""
        found = _UNIT.fullmatch(cell.translate(ALIKE)) if len(cell) <= _LONGEST else None
        number = self.number(found[1]) if found else None
        if found is None or number is None:
            return None
        unit = as_unit(found[2]) or (found[2] if kind_and_factor(found[2]) else "")
        return (number, unit) if unit else None


@dataclass(frozen=True, kw_only=True)
class Cells:
    """A column of fields as numbers, NaN or infinite where a reading is missing.

    - `unit`: of fields that hold one each.
    - `missing`: how often which field stands for no reading.
    - `rows`, `word`: the rows that hold words instead, and the first of these words.
    """

    values: Real
    unit: str
    missing: dict[str, int]
    rows: np.ndarray[tuple[int], np.dtype[np.intp]]
    word: str = ""


def numbers_of(column: Any, notation: Notation) -> Cells:
    """Return what the fields of a column of a table of pandas mean; one that pandas read as numbers is taken as it is."""
    import pandas as pd

    none = np.empty(0, dtype=np.intp)
    if column.dtype.kind in "fiu":
        values = column.to_numpy(dtype=float)
        bad = ~np.isfinite(values)
        endless = np.isinf(values)
        count = {"empty": int(bad.sum() - endless.sum()), "infinite": int(endless.sum())}
        return Cells(values=values, unit="", missing=_counted(count), rows=none)
    codes, uniques = pd.factorize(column)
    texts = [str(each).strip() for each in uniques]
    found = [_number(each, text, notation) for each, text in zip(uniques, texts, strict=True)]
    unit, found = _with_units(texts, found, notation) if None in found else ("", found)
    values = np.array([np.nan if each is None else each for each in found] + [np.nan])[codes]
    odd = np.append(np.array([each is None for each in found], dtype=bool), False)[codes]
    many = np.bincount(codes[codes >= 0], minlength=len(texts))
    missing = Counter({"empty": int((codes < 0).sum())})
    for text, each, count in zip(texts, found, many, strict=True):
        if each is not None and not np.isfinite(each):
            missing[text or "empty"] += int(count)
    rows = np.flatnonzero(odd)
    return Cells(
        values=values,
        unit=unit,
        missing=_counted(missing),
        rows=rows,
        word=texts[codes[rows[0]]] if rows.size else "",
    )


def _number(value: Any, text: str, notation: Notation) -> float | None:
    """Return the number of a field of a column in which pandas found words in other rows."""
    if isinstance(value, (bool, np.bool_)):
        return None
    if not isinstance(value, str):
        return float(value)
    return np.nan if text == "-" else notation.number(text)


def _with_units(
    texts: list[str], found: list[float | None], notation: Notation
) -> tuple[str, list[float | None]]:
    """Return the numbers of fields that hold a unit each, all in one unit; unchanged if they are of several kinds."""
    own = [notation.quantity(text) if each is None else None for text, each in zip(texts, found, strict=True)]
    units = {each[1] for each in own if each}
    known = {unit: kind_and_factor(unit) for unit in units}
    kinds = {each[0] if each else unit for unit, each in known.items()}
    plain = (number for number, each in zip(found, own, strict=True) if not each and number is not None)
    if len(kinds) != 1 or any(number and np.isfinite(number) for number in plain):
        return "", found  # a number without a unit among others is none, unless it is 0
    if len(units) == 1:
        return units.pop(), [each[0] if each else number for each, number in zip(own, found, strict=True)]
    scaled: list[float | None] = []
    for each, number in zip(own, found, strict=True):
        factor = known[each[1]] if each else None
        scaled.append(each[0] * factor[1] if each and factor else number)
    return kinds.pop(), scaled


def _counted(count: dict[str, int]) -> dict[str, int]:
    return {word: many for word, many in count.items() if many}
