"""Words of a netlist: numbers, names, lines, and formulas of behavioural sources, recorded from Python arithmetic."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

WIDTH = 110
"""Largest number of characters in a line that can be broken."""


def number(value: float) -> str:
    """Return a number [any unit] with 15 digits, more than the precision of a voltage in ngspice."""
    return f"{float(value):.15g}"


def continued(line: str) -> str:
    """Return a long element broken at blanks, with the continuation sign of ngspice."""
    return "\n".join(textwrap.wrap(line, WIDTH, subsequent_indent="+ ", break_long_words=False))


def remark(text: str) -> str:
    """Return a text as comment lines, long lines broken and unprintable characters removed."""
    lines = []
    for paragraph in text.splitlines():
        plain = "".join(sign for sign in paragraph if sign.isprintable())
        lines += textwrap.wrap(plain, WIDTH, initial_indent="* ", subsequent_indent="*   ") or ["*"]
    return "\n".join(lines)


@dataclass
class Names:
    """Names in use, all lower case and different, because ngspice ignores case."""

    taken: set[str] = field(default_factory=set)

    def new(self, wanted: str) -> str:
        """Return an unused name of letters a to z, digits and underscores, as near to the wanted one as possible."""
        plain = unicodedata.normalize("NFKD", wanted).encode("ascii", "ignore").decode().lower()
        plain = re.sub(r"[^a-z0-9_]", "_", plain).strip("_") or "layer"
        name, count = plain, 1
        while name in self.taken:
            count += 1
            name = f"{plain}_{count}"
        self.taken.add(name)
        return name


_FUNCTIONS: Final = {name: name for name in ("cos", "cosh", "exp", "sin", "sinh", "sqrt", "tan", "tanh")} | {
    "absolute": "abs",
    "arctan": "atan",
    "fabs": "abs",
    "log": "ln",
    "maximum": "max",
    "minimum": "min",
}
"""Functions of numpy as ngspice calls them."""
_SIGNS: Final = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "true_divide": "/"}
_MOST_FACTORS = 4


class Formula(NDArrayOperatorsMixin):
    """A number that a behavioural source computes; arithmetic on it gives the formula of the result.

    Its `text` is a name, a call, or an expression in brackets. Elementary functions of numpy become those of
    ngspice; comparisons and conversions to a number raise TypeError.
    """

    def __init__(self, text: str) -> None:
        self.text = text

    def __bool__(self) -> bool:
        """Refuse: a formula has no value until ngspice evaluates it."""
        raise TypeError("a formula has no value yet")

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        name, first = ufunc.__name__, inputs[0]
        if method != "__call__" or options:
            return NotImplemented
        if name in _FUNCTIONS:
            return Formula(f"{_FUNCTIONS[name]}({', '.join(_text(value) for value in inputs)})")
        if name in _SIGNS:
            return Formula(f"({_text(first)} {_SIGNS[name]} {_text(inputs[1])})")
        if name == "negative":
            return Formula(f"(0 - {_text(first)})")
        if name in {"square", "power", "float_power"} and isinstance(first, Formula):
            return _power(first, 2 if name == "square" else inputs[1])
        return NotImplemented


def _power(base: Formula, exponent: object) -> Formula:
    """Write a power, with the sign of the base, of which ngspice takes the magnitude."""
    if not isinstance(exponent, (int, float)):
        raise TypeError("an exponent has to be a number")
    whole = float(exponent).is_integer()
    if whole and 1 <= exponent <= _MOST_FACTORS:
        return Formula(f"({' * '.join([base.text] * int(exponent))})")
    if not whole:
        return Formula(f"pow({base.text}, {number(exponent)})")
    even = int(exponent) - int(exponent) % 2
    magnitude = f"pow(abs({base.text}), {number(even)})"
    return Formula(magnitude if even == exponent else f"({magnitude} * {base.text})")


def _text(value: object) -> str:
    if isinstance(value, Formula):
        return value.text
    if not isinstance(value, (int, float, np.generic, np.ndarray)):
        raise TypeError(f"'{value}' is neither a number nor a formula")
    written = number(float(value))
    return f"({written})" if written.startswith("-") else written
