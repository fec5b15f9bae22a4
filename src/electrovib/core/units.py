"""Conversion between texts with units and floats in SI."""

from __future__ import annotations

import functools
import math
import re
from decimal import Decimal
from typing import Final

from electrovib.core.errors import InputError

PREFIXES: Final = {
    "f": -15,
    "p": -12,
    "n": -9,
    "u": -6,
    "m": -3,
    "c": -2,
    "d": -1,
    "": 0,
    "k": 3,
    "M": 6,
    "G": 9,
    "T": 12,
}
SHOWN_PREFIXES: Final = ("f", "p", "n", "u", "m", "", "k", "M", "G", "T")

KINDS: Final = {
    "1": ("a plain number", "0.5"),
    "m": ("a length", "90 um"),
    "m2": ("an area", "1 cm2"),
    "s": ("a time", "36 ms"),
    "Hz": ("a frequency", "1 kHz"),
    "V": ("a voltage", "150 V"),
    "A": ("a current", "250 uA"),
    "A/m2": ("a current density", "1 A/m2"),
    "C": ("a charge", "3 nC"),
    "C/m2": ("a charge per area", "-330 uC/m2"),
    "F": ("a capacitance", "100 pF"),
    "J": ("an energy", "1 mJ"),
    "N": ("a force", "0.5 N"),
    "Pa": ("a pressure", "1 kPa"),
    "ohm": ("a resistance", "1 kohm"),
    "ohm m": ("a resistivity", "0.5 Mohm m"),
    "ohm m2": ("a resistance times area", "100 ohm m2"),
    "S/m": ("a conductivity", "1.79 uS/m"),
    "V/m": ("an electric field", "3 MV/m"),
    "V/s": ("a slew rate", "1 kV/s"),
    "m/s": ("a speed", "40 mm/s"),
    "kg": ("a mass", "0.2 g"),
    "N/m": ("a stiffness", "1 kN/m"),
    "N s/m": ("a damping", "1 N s/m"),
    "kg s/m": ("a mass per speed", "32 g s/m"),
    "N s/m2": ("a stiffness per speed", "4 kN s/m2"),
    "N/V": ("a sensitivity", "0.31 N/V"),
    "N/A": ("a force per current", "41 N/A"),
    "Pa/m": ("a stiffness per area", "10 MPa/m"),
    "Pa s/m": ("a damping per area", "1 kPa s/m"),
    "J/m2": ("an energy per area", "0.17 J/m2"),
    "S": ("a conductance", "20 uS"),
    "S/m2": ("a conductance per area", "20 mS/m2"),
    "rad": ("an angle", "0.5 rad"),
}
"""Every unit of a parameter, a signal or a measurement: name of the quantity, and an example."""

_STEM: Final = {"kg": ("g", -3)}
"""Units whose SI form has a prefix: the stem that takes prefixes, and the power of ten of the SI form."""
_LONGEST: Final = 64
"""Most characters of a number with a unit; the bound keeps the matching fast."""
_NUMBER = r"([+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?)"
_SYMBOL = re.compile(r"([A-Za-z]+)(\d?)")
_PINT_LENGTH: Final = 32
_SPELLINGS: Final = str.maketrans(
    {
        "\N{MICRO SIGN}": "u",
        "\N{GREEK SMALL LETTER MU}": "u",
        "\N{OHM SIGN}": "ohm",
        "\N{GREEK CAPITAL LETTER OMEGA}": "ohm",
        "\N{SUPERSCRIPT TWO}": "^2",
        "\N{SUPERSCRIPT THREE}": "^3",
        "\N{MIDDLE DOT}": "*",
        "\N{DOT OPERATOR}": "*",
        "\N{MINUS SIGN}": "-",
    }
)
_POWER = r"(?:(?:\*\*|\^)-?[1-9]|[23])"
_PINT_UNIT = rf"[A-Za-z%\N{{DEGREE SIGN}}]+{_POWER}?"
_RATIO = re.compile(rf"\s*{_NUMBER}\s*/\s*(\d+\.?\d*)(\s*[^\s\d/].*|)")
_PINT_TEXT = re.compile(rf"\s*{_NUMBER}\s*({_PINT_UNIT}(?:(?:\s*[*/]\s*|\s+){_PINT_UNIT})*)\s*")


def parse_quantity(text: str, unit: str) -> float:
    """Convert a text with a unit, such as ``"90 um"``, to the nearest float in SI; a number without a unit is in SI."""
    plain = text.translate(_SPELLINGS) if len(text) <= _LONGEST else ""
    if own := _own_unit_pattern(unit).fullmatch(plain):
        value: float | None = float(Decimal(own[1]).scaleb(_power_of_ten(unit, own[2])))
    else:
        value = _parse_other_unit(plain, unit)
    if value is None and (ratio := _RATIO.fullmatch(plain)) and float(ratio[2]):  # a sensitivity: "4/9 N/V"
        return parse_quantity(ratio[1] + ratio[3], unit) / float(ratio[2])
    if value is None or not math.isfinite(value):
        comma = re.fullmatch(r"\s*([+-]?\d+),(\d+.*)", text[:_LONGEST])
        point = f"; the decimal sign is a point: '{comma[1]}.{comma[2].rstrip()}'" if comma else ""
        raise ValueError(expected(unit) + point)
    return value


def parse_count(text: str) -> int:
    """Read a whole number, also ``1e3`` and ``1_000``; a sign that may separate thousands or decimals is refused."""
    if parts := re.fullmatch(r"\s*(\d{1,3})([.,' ])(\d{3}(?:\2\d{3})*)\s*", text):
        whole = "".join(each for each in text if each.isdigit())
        raise ValueError(f"it can be read as {whole} and as {parts[1]}; write {whole} or {parts[1]}")
    try:
        value = Decimal(text) if len(text) <= _LONGEST else Decimal("nan")
    except ArithmeticError:
        value = Decimal("nan")
    if not value.is_finite() or value != value.to_integral_value() or value.adjusted() > _LONGEST:
        raise ValueError("expected a whole number, such as 1000 or 1e3")
    return int(value)


def number_in(unit: str, option: str, value: str | float) -> float:
    """Return a number in SI that a parameter or an option is given, as it is or as a text with a unit."""
    try:
        return parse_quantity(value, unit) if isinstance(value, str) else float(value)
    except (TypeError, ValueError) as error:
        why = str(error) if isinstance(value, str) else expected(unit)
        raise InputError(why, path=option, value=str(value)) from None


def expected(unit: str) -> str:
    """Write what is expected of a parameter with this unit, with an example."""
    kind, example = KINDS[unit]
    return f"expected {kind}, for instance '{example}'"


def format_quantity(value: float, unit: str, *, digits: int = 6) -> str:
    """Write a number in SI with its unit, and with a prefix where it reads better (``90 um``)."""
    value += 0.0  # one zero, not two
    if unit == "1":
        return f"{value:.{digits}g}"
    if value == 0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    value = float(f"{value:.{digits}g}")  # rounded first: 999.96 with three digits is 1 k
    stem, shift = _STEM.get(unit, (unit, 0))
    power = int(_first_symbol(unit)[1] or 1)
    prefixes = SHOWN_PREFIXES if power == 1 else ("u", "m", "c", "")
    fitting = [p for p in prefixes if abs(value) >= 0.99999999 * 10.0 ** (PREFIXES[p] * power + shift)]
    prefix = max(fitting, key=lambda p: PREFIXES[p]) if fitting else prefixes[0]
    scaled = Decimal(repr(float(value))).scaleb(-PREFIXES[prefix] * power - shift)
    number = f"{float(scaled):.{digits}g}"
    if "e" in number:
        return f"{value:.{digits}g} {unit}"
    return f"{number} {prefix}{stem}"


def digits_of_interval(value: float, lower: float, upper: float) -> int:
    """Return the significant digits that show an interval: two of its width, from 4 to 15, and 4 where it has no width."""
    width = upper - lower
    if not (math.isfinite(width) and width > 0 and value):
        return 4
    return min(max(4, 2 - math.floor(math.log10(width / abs(value)))), 15)


def exact_text(value: float, unit: str) -> str | float:
    """Return a text with a unit if it reads back to exactly this float, else the float."""
    for digits in (6, 12, 17):
        text = format_quantity(value, unit, digits=digits)
        if unit != "1" and parse_quantity(text, unit) == value:
            return text
    return value


def _first_symbol(unit: str) -> tuple[str, str]:
    match = _SYMBOL.match(unit)
    assert match is not None
    return match[1], match[2]


@functools.cache
def _own_unit_pattern(unit: str) -> re.Pattern[str]:
    if unit == "1":
        return re.compile(rf"\s*{_NUMBER}\s*(%?)\s*")
    parts = []
    for index, piece in enumerate(re.split(r"([ /])", _STEM.get(unit, (unit, 0))[0])):
        if piece == " ":
            parts.append(r"\s*[\s*]\s*")
        elif piece == "/":
            parts.append(r"\s*/\s*")
        else:
            symbol, power = _first_symbol(piece)
            written = "[oO]hm" if symbol == "ohm" else symbol
            exponent = rf"(?:\^|\*\*)?{power}" if power else ""
            prefix = "([fpnumcdkMGT]?)" if index == 0 else ""
            parts.append(f"{prefix}{written}{exponent}")
    return re.compile(rf"\s*{_NUMBER}\s*(?:{''.join(parts)})?\s*")


def _power_of_ten(unit: str, prefix: str | None) -> int:
    """Return the power of ten by which a number with a prefix, or %, is in SI; one without a unit (None) is in SI."""
    if unit == "1":
        return -2 if prefix else 0
    if prefix is None:
        return 0
    return PREFIXES[prefix] * int(_first_symbol(unit)[1] or 1) + _STEM.get(unit, (unit, 0))[1]


def _parse_other_unit(text: str, unit: str) -> float | None:
    """Convert a short text with any other unit by pint; pint does not return from towers of powers."""
    match = _PINT_TEXT.fullmatch(text) if len(text) <= _PINT_LENGTH and unit != "1" else None
    if match is None:
        return None
    import pint

    try:
        quantity = _registry().Quantity(float(match[1]), _for_pint(match[2]))
        if unit != "rad" and "radian" in str(quantity.to_root_units().units):
            return None  # pint takes 1 rad/s for 1 Hz
        return float(quantity.to(_for_pint(unit)).magnitude)
    except (pint.errors.PintError, ArithmeticError, ValueError, TypeError, AttributeError, AssertionError):
        return None


def _for_pint(unit: str) -> str:
    """Write powers with two stars and products with one."""
    powers = re.sub(_POWER, lambda power: f"**{power[0].lstrip('*^')}", unit)
    return re.sub(r"(?<=[^\s*/])\s+(?=[^\s*/])", "*", powers)


@functools.cache
def _registry():  # type: ignore[no-untyped-def]  # noqa: ANN202  # pint's registry class is built at run time
    import pint

    return pint.UnitRegistry()


def unit_in_files(unit: str) -> str:
    """Write the powers of a unit as pint and UDUNITS read them: ``C/m^2`` for ``C/m2``."""
    return re.sub(r"(?<=m)(?=[23])", "^", unit)


def unit_of_files(unit: str) -> str:
    """Return what `unit_in_files` was given."""
    return re.sub(r"(?<=m)\^(?=[23])", "", unit)
