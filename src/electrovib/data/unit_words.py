"""Units: their kinds and factors, the words that instruments write for them, and headings that hold a name and a unit."""

from __future__ import annotations

import functools
import re
import unicodedata
from typing import Final

from electrovib.core.units import KINDS, parse_quantity

_ANGLE: Final = re.compile(r"rad|deg|°|turn|rev|rpm|cycle")
_LONGEST_HEADING: Final = 200
_BRACKETS: Final = re.compile(r"(.*?)(\s*[\[({<])\s*([^\])}>]*?)\s*[\])}>]\s*")
_OF_A_NODE: Final = {"v": "V", "i": "A"}
"""Names before brackets directly behind them that hold a node of a circuit, if not their own unit: ``V(a)``, ``I(R1)``."""
_LIKE_A_UNIT: Final = re.compile(
    r"(deg(ree)?s?[ .]?|°)[CFK]|[CFK]|%.{0,8}|counts?|a\.?u\.?|bits?|[mk]?bar|psi|mmHg|[munµ]?V ?(rms|pp|p|ac|dc)"
    r"|[munµ]?A ?(rms|pp|p|ac|dc)|dB\w?|[^\W\d_]{1,6}[ .*·⋅-]?[^\W\d_]{0,5}[ ]?[/^*·⋅²³].*|[munµkM]?N[ .]?m",
    re.IGNORECASE,
)
"""Units that are none of electrovib, and remain as written."""
_PARTS_OF_ZPLOT: Final = re.compile(r"(Z'{1,2})\s?\([ab]\)")
"""Headings of the parts of an impedance, of which ZPlot calls one a and the other b."""
_RESISTIVITY: Final = re.compile(r"([kMGTmuµ]?)(?:[Oo]hms?|OHMS?|Ω|\u2126)[ .*·⋅-]?(c?m)(\^?2|²|)")
_TIME: Final = re.compile(r"(?P<name>(?i:t|time|zeit|temps)_(?P<unit>[mnuµ]?s))")
"""Headings of times that end with their unit; after other names a letter may be an index, as N in ``F_N``."""
_SIEMENS: Final = re.compile(r"[munp]S")
_TIMES: Final = re.compile(r"t(ime)?\b|zeit|temps|x\b", re.IGNORECASE)
"""Names of columns in which some oscilloscopes write S for a second."""
_CONDUCTIVITY: Final = re.compile(r"(?P<name>.+?)(?: in |/)(?P<unit>[mnuµ]?S/c?m)")
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
    "cn": "cN", "kn": "kN", "g": "g", "kg": "kg", "gf": "gf", "kgf": "kgf", "lbf": "lbf", "cm": "cm", "kpa": "kPa", "rpm": "rpm",
}  # fmt: skip
"""Maps words and signs that instruments write for units, in small letters, to the units of electrovib."""
_WITH_PREFIX: Final = re.compile(r"[pnumkMG]?(V|A|Hz|N|ohm|Ω|F|Pa|W)|[pnum]?s|[numck]?m|min")
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
    if found := _TIME.fullmatch(heading) or _CONDUCTIVITY.fullmatch(heading):
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
