"""Formulas of behavioural sources, recorded from Python arithmetic."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from electrovib.exports.spice.text import number

_FUNCTIONS: Final = {
    "absolute": "abs",
    "arctan": "atan",
    "cos": "cos",
    "cosh": "cosh",
    "exp": "exp",
    "fabs": "abs",
    "log": "ln",
    "maximum": "max",
    "minimum": "min",
    "sin": "sin",
    "sinh": "sinh",
    "sqrt": "sqrt",
    "tan": "tan",
    "tanh": "tanh",
}
_SIGNS: Final = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "true_divide": "/"}
_MOST_FACTORS = 4


class Formula:
    """A number that a behavioural source computes; arithmetic on it gives the formula of the result.

    Its `text` is a name, a call, or an expression in brackets. Elementary functions of numpy become those of
    ngspice; comparisons and conversions to a number raise TypeError.
    """

    def __init__(self, text: str) -> None:
        self.text = text

    def __bool__(self) -> bool:
        """Refuse: a formula has no value until ngspice evaluates it."""
        raise TypeError("a formula has no value yet")

    def __add__(self, other: object) -> Formula:
        return _joined(self, "+", other)

    def __radd__(self, other: object) -> Formula:
        return _joined(other, "+", self)

    def __sub__(self, other: object) -> Formula:
        return _joined(self, "-", other)

    def __rsub__(self, other: object) -> Formula:
        return _joined(other, "-", self)

    def __mul__(self, other: object) -> Formula:
        return _joined(self, "*", other)

    def __rmul__(self, other: object) -> Formula:
        return _joined(other, "*", self)

    def __truediv__(self, other: object) -> Formula:
        return _joined(self, "/", other)

    def __rtruediv__(self, other: object) -> Formula:
        return _joined(other, "/", self)

    def __neg__(self) -> Formula:
        return Formula(f"(0 - {self.text})")

    def __abs__(self) -> Formula:
        return Formula(f"abs({self.text})")

    def __pow__(self, exponent: object) -> Formula:
        """Write a power, with the sign of the base, of which ngspice takes the magnitude."""
        if not isinstance(exponent, (int, float)):
            raise TypeError("an exponent has to be a number")
        whole = float(exponent).is_integer()
        if whole and 1 <= exponent <= _MOST_FACTORS:
            return Formula(f"({' * '.join([self.text] * int(exponent))})")
        if not whole:
            return Formula(f"pow({self.text}, {number(exponent)})")
        even = int(exponent) - int(exponent) % 2
        magnitude = Formula(f"pow(abs({self.text}), {number(even)})")
        return magnitude if even == exponent else magnitude * self

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        name = ufunc.__name__
        if method != "__call__" or options:
            return NotImplemented
        if name in _FUNCTIONS:
            return Formula(f"{_FUNCTIONS[name]}({', '.join(_text(value) for value in inputs)})")
        if name in _SIGNS:
            return _joined(inputs[0], _SIGNS[name], inputs[1])
        if name in {"square", "power", "float_power", "negative"}:
            base = inputs[0]
            if not isinstance(base, Formula):
                return NotImplemented
            return -base if name == "negative" else base ** (2 if name == "square" else inputs[1])
        return NotImplemented


def _joined(left: object, sign: str, right: object) -> Formula:
    return Formula(f"({_text(left)} {sign} {_text(right)})")


def _text(value: object) -> str:
    if isinstance(value, Formula):
        return value.text
    if not isinstance(value, (int, float, np.generic, np.ndarray)):
        raise TypeError(f"'{value}' is neither a number nor a formula")
    written = number(float(value))
    return f"({written})" if written.startswith("-") else written
