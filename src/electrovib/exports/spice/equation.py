"""The declared equation of a model, or its code, as a formula of ngspice."""

from __future__ import annotations

import ast
import operator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.exports.spice.formula import Formula

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.model import Model

_OPERATIONS: Final[dict[type[ast.AST], Callable[..., Any]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: lambda value: value,
}
_FUNCTIONS: Final[dict[str, Callable[..., Any]]] = {
    "Abs": np.abs,
    "Max": lambda one, other: (
        (one + other + np.abs(one - other)) / 2
    ),  # ngspice needs a derivative at the kink
    "Min": lambda one, other: (one + other - np.abs(one - other)) / 2,
    "atan": np.arctan,
    "cos": np.cos,
    "cosh": np.cosh,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "sinh": np.sinh,
    "sqrt": np.sqrt,
    "tanh": np.tanh,
}
_REASONS = (TypeError, ValueError, KeyError, AttributeError, SyntaxError, np.exceptions.DTypePromotionError)


def written(model: Model, method: str, arguments: Mapping[str, Formula], *, path: str) -> Formula:
    """Return the result of a method of a model as a formula of ngspice, or refuse one that is no elementary formula."""
    try:
        printed = model.equation.get(method)
        if printed is None:
            return _checked(getattr(model, method)(**arguments))
        known = {name: value for name, value in model if isinstance(value, (int, float))}
        return _checked(
            _evaluated(ast.parse(printed, mode="eval").body, {**_CONSTANTS, **known, **arguments})
        )
    except _REASONS as error:
        raise InputError(
            f"{path} = {type(model).__name__}: its {method.replace('_', ' ')} cannot be written as one formula of"
            f" ngspice ({error}); use 'electrovib run', or another {path}"
        ) from None


_CONSTANTS: Final = {"eps0": eps0, "pi": np.pi}


def _checked(value: Any) -> Formula:
    if isinstance(value, Formula):
        return value
    return Formula(f"({float(value)!r})")


def _evaluated(node: ast.AST, known: Mapping[str, Any]) -> Any:
    """Evaluate an equation of arithmetic and elementary functions; anything else raises KeyError or TypeError."""
    match node:
        case ast.Constant(value=int() | float() as value):
            return value
        case ast.Name(id=name):
            return known[name]
        case ast.BinOp(left=left, op=sign, right=right):
            return _OPERATIONS[type(sign)](_evaluated(left, known), _evaluated(right, known))
        case ast.UnaryOp(op=sign, operand=operand):
            return _OPERATIONS[type(sign)](_evaluated(operand, known))
        case ast.Call(func=ast.Name(id=name), args=inputs, keywords=[]):
            return _FUNCTIONS[name](*(_evaluated(one, known) for one in inputs))
        case _:
            raise TypeError(f"'{ast.unparse(node)}' is not an elementary formula")
