"""A layer as capacitors and resistors: above all relaxations, a branch for each, a leak; and its equation for ngspice."""

from __future__ import annotations

import ast
import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.exports.spice.formula import Formula
from electrovib.exports.spice.text import continued, number, remark
from electrovib.solve.stack.modes import merged_terms

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.model import Model
    from electrovib.physics.stack import Layer
    from electrovib.solve.stack.prony import Reduction


@dataclass(frozen=True, kw_only=True)
class Branch:
    """One relaxation: a resistor from the near face to a node, a capacitor from there to the far face."""

    node: str
    capacitance: float
    rate: float
    start: float


@dataclass(frozen=True, kw_only=True)
class LayerElements:
    """A layer of one contact between two nodes; the initial fields in its relaxations end with the fastest [V/m]."""

    path: str
    name: str
    plate_side: str
    finger_side: str
    layer: Layer
    reduction: Reduction
    area: float
    field: float
    relaxed: tuple[float, ...]

    @property
    def high(self) -> float:
        """Capacitance above all relaxations [F]."""
        return eps0 * self.reduction.debye.high * self.area / self.layer.thickness

    @property
    def branches(self) -> list[Branch]:
        """The relaxations, slowest first."""
        rates, strengths = merged_terms(self.reduction.debye)
        thickness = self.layer.thickness
        return [
            Branch(
                node=f"in_{self.name}_{count}",
                capacitance=eps0 * strength * self.area / thickness,
                rate=rate,
                start=start * thickness,
            )
            for count, (rate, strength, start) in enumerate(
                zip(rates.tolist(), strengths.tolist(), self.relaxed, strict=True), start=1
            )
        ]

    @property
    def voltage(self) -> str:
        """Voltage from the plate's side to the finger's side, in the syntax of ngspice."""
        return between(self.plate_side, self.finger_side)

    @property
    def admittances(self) -> tuple[float, float, float]:
        """Largest conductance of a resistor, conductance of the leak [S], largest capacitance [F]."""
        leak = self.layer.material.conductivity * self.area / self.layer.thickness
        fastest = max((branch.rate * branch.capacitance for branch in self.branches), default=0.0)
        return max(leak, fastest), leak, max([self.high, *(branch.capacitance for branch in self.branches)])

    def elements(self) -> list[str]:
        """Return the elements of the layer."""
        ends, layer = f"{self.plate_side} {self.finger_side}", self.layer
        start = self.field * layer.thickness
        lines = [self._remark(), f"C_{self.name}_high {ends} {number(self.high)}{_initial(start)}"]
        for count, branch in enumerate(self.branches, start=1):
            resistance = 1 / (branch.rate * branch.capacitance)
            lines += [
                f"R_{self.name}_{count} {self.plate_side} {branch.node} {number(resistance)}",
                f"C_{self.name}_{count} {branch.node} {self.finger_side} {number(branch.capacitance)}"
                f"{_initial(branch.start)}",
            ]
        if layer.material.conductivity > 0:
            resistance = layer.thickness / (layer.material.conductivity * self.area)
            lines.append(f"R_{self.name}_conduction {ends} {number(resistance)}")
        if layer.leak is not None:
            field = Formula(f"({self.voltage}/{number(layer.thickness)})")
            density = written(layer.leak, "current_density", {"E": field}, path=f"stack.{self.path}.leak")
            lines.append(continued(f"B_{self.name}_leak {ends} I = {number(self.area)}*{density.text}"))
        return lines

    def _remark(self) -> str:
        layer, debye = self.layer, self.reduction.debye
        static = debye.high + sum(debye.strengths)
        said = [
            f"{self.path}: {format_quantity(layer.thickness, 'm', digits=6)} of {type(layer.material).__name__}"
            f" on {format_quantity(self.area, 'm2', digits=6)}",
            f"relative permittivity {static:.6g}",
        ]
        if self.branches:
            said[-1] = f"relative permittivity {debye.high:.6g} above and {static:.6g} below its relaxations"
        if self.reduction.largest_error:
            said.append(
                f"a sum of {len(self.branches)} Debye terms, within {self.reduction.largest_error:.2g} of the declared"
                " permittivity"
            )
        said.append(f"conductivity {format_quantity(layer.material.conductivity, 'S/m', digits=6)}")
        if layer.leak is not None:
            said.append(f"leak {type(layer.leak).__name__}")
        return remark("; ".join(said))


def between(first: str, second: str) -> str:
    """Return the voltage between two nodes in the syntax of ngspice."""
    return f"V({first})" if second == "0" else f"V({first},{second})"


def _initial(voltage: float) -> str:
    return f" IC={number(voltage)}" if voltage else ""


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
