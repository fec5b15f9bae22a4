"""The words of a netlist, its section, and the readings of it that are linear in the drive, for the force law."""

from __future__ import annotations

import ast
import operator
import re
import textwrap
import unicodedata
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.stack import beside_interface
from electrovib.solve.stack.modes import merged_terms
from electrovib.solve.stack.section import StackLayer, inverse_root_thickness

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from electrovib.core.model import Model
    from electrovib.exports.spice.circuit import Start
    from electrovib.physics.stack import Layer, Role
    from electrovib.solve.stack.prony import Reduction
    from electrovib.solve.stack.transfer import Transfer

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


_RECORDED: Final = {name: name for name in ("cos", "cosh", "exp", "sin", "sinh", "sqrt", "tan", "tanh")} | {
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
        if name in _RECORDED:
            return Formula(f"{_RECORDED[name]}({', '.join(_text(value) for value in inputs)})")
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
        lines = [self._remark(), f"C_{self.name}_high {ends} {number(self.high)}{initial(start)}"]
        for count, branch in enumerate(self.branches, start=1):
            resistance = 1 / (branch.rate * branch.capacitance)
            lines += [
                f"R_{self.name}_{count} {self.plate_side} {branch.node} {number(resistance)}",
                f"C_{self.name}_{count} {branch.node} {self.finger_side} {number(branch.capacitance)}"
                f"{initial(branch.start)}",
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


def initial(voltage: float) -> str:
    """Return the condition that a capacitor begins at a voltage [V]; nothing for 0."""
    return f" IC={number(voltage)}" if voltage else ""


_OPERATIONS: Final[dict[type[ast.AST], Callable[..., Any]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
}
_FUNCTIONS: Final[dict[str, Callable[..., Any]]] = {
    "Abs": np.abs,
    # ngspice needs a derivative at the kink
    "Max": lambda one, other: (one + other + np.abs(one - other)) / 2,
    "Min": lambda one, other: (one + other - np.abs(one - other)) / 2,
    "atan": np.arctan,
    **{name: getattr(np, name) for name in ("cos", "cosh", "exp", "log", "sin", "sinh", "sqrt", "tanh")},
}
_REASONS = (TypeError, ValueError, KeyError, AttributeError, SyntaxError, np.exceptions.DTypePromotionError)


def written(model: Model, method: str, arguments: Mapping[str, Formula], *, path: str) -> Formula:
    """Return the result of a method of a model as a formula of ngspice, or refuse one that is no elementary formula."""
    try:
        printed = model.equation.get(method)
        if printed is None:
            found = getattr(model, method)(**arguments)
        else:
            known = {name: value for name, value in model if isinstance(value, (int, float))}
            found = _evaluated(ast.parse(printed, mode="eval").body, {**_CONSTANTS, **known, **arguments})
        return found if isinstance(found, Formula) else Formula(f"({float(found)!r})")
    except _REASONS as error:
        raise InputError(
            f"{path} = {type(model).__name__}: its {method.replace('_', ' ')} cannot be written as one formula of"
            f" ngspice ({error}); use 'electrovib run', or another {path}"
        ) from None


_CONSTANTS: Final = {"eps0": eps0, "pi": np.pi}


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


PRECISION = 1e-9
"""Relative error of the filter of the square root, far below that of the time steps."""
CAPACITANCE = 1e-9
"""Capacitance of the sections of the filter [F]; the resistance follows from the rate, so any value gives the same filter."""


ENDLESS = 1e18
"""Resistance in parallel with an integrating capacitor [ohm], because ngspice needs a path for direct current."""


@dataclass(kw_only=True)
class ReadSection:
    """The stack of the first contact, from plate to finger, as readings of the circuit, to which filters are added."""

    slabs: dict[str, LayerElements]
    roles: Mapping[str, Role]
    start: Start
    area: float
    elements: list[str] = field(default_factory=list)
    filters: int = 0
    _interface: MeterReading | None = None

    @property
    def frequency(self) -> np.ndarray:
        """Refuse: a circuit has no single frequency."""
        raise TypeError("a circuit has no single frequency")

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self.slabs)

    def __getitem__(self, name: str) -> StackLayer:
        """Return the state of a layer; its displacement is the charge on its capacitors over the area."""
        slab, in_modes = self.slabs[name], self.start.in_modes
        thickness, area = slab.layer.thickness, slab.area
        charge = {slab.voltage: slab.high / area}
        charge |= {
            between(branch.node, slab.finger_side): branch.capacitance / area for branch in slab.branches
        }
        return StackLayer(
            thickness=thickness,
            material=slab.layer.material,
            field=MeterReading({slab.voltage: 1 / thickness}, in_modes(lambda modes: modes[name].field)),
            displacement=MeterReading(charge, in_modes(lambda modes: modes[name].displacement)),
        )

    @property
    def voltage(self) -> MeterReading:
        """Voltage across all layers."""
        ends = [*self.slabs.values()]
        across = between(ends[0].plate_side, ends[-1].finger_side)
        return MeterReading({across: 1.0}, self.start.in_modes(lambda modes: modes.voltage))

    @property
    def current_density(self) -> MeterReading:
        """Total current density."""
        transfer = self.start.in_modes(lambda modes: modes.current_density)
        return MeterReading({"I(V_current)": 1 / self.area}, transfer)

    @property
    def interface_displacement(self) -> MeterReading:
        """Displacement at the interface of plate and finger, for a stack without a gap.

        It is the charge on the last layer of the plate if that does not conduct, else the integral of the
        current, on a separate capacitor.
        """
        last = beside_interface(self.roles, "plate")
        charged = any(slab.layer.initial_charge for slab in self.slabs.values())
        if last is not None and not charged and self._blocks(last):
            on_last: MeterReading = self[last].displacement
            return on_last
        if self._interface is None:
            charge = self.start.interface_charge()
            held = initial(charge * self.area / CAPACITANCE)
            self.elements += [
                remark("charge at the interface: V(interface) times 1 nF is the integral of the current"),
                "F_interface 0 interface V_current 1",
                f"C_interface interface 0 {number(CAPACITANCE)}{held}",
                f"R_interface interface 0 {number(ENDLESS)}",
            ]
            transfer = self.start.in_modes(lambda modes: modes.interface_displacement)
            self._interface = MeterReading({"V(interface)": CAPACITANCE / self.area}, transfer)
        return self._interface

    def _blocks(self, name: str) -> bool:
        layer = self.slabs[name].layer
        return layer.leak is None and layer.material.conductivity == 0

    def inverse_root_thickness(self, names: Sequence[str]) -> FilterToBuild:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2] as a filter."""
        slabs = [(self.slabs[name].layer.thickness, self.slabs[name].reduction.debye) for name in names]
        avoid = None if self.start.section is None else self.start.section.modes.rates
        return FilterToBuild(inverse_root_thickness(slabs, avoid=avoid, tolerance=PRECISION), self._filtered)

    def _filtered(self, transfer: Transfer, signal: MeterReading) -> MeterReading:
        """Add a filter after a reading: first-order sections in parallel, and the signal itself."""
        if not len(transfer.rates):
            return signal * float(transfer.direct)
        self.filters += 1
        name = f"filter_{self.filters}"
        said = f"square root of the layers' capacitance: {len(transfer.rates)} first-order sections, to {PRECISION:g}"
        self.elements.append(remark(said))
        self.elements.append(continued(f"B{name} {name} 0 V = {signal.text}"))
        weights = {f"V({name})": transfer.direct}
        starts = self.start.lowpassed(signal.transfer, transfer.rates)
        for count, (rate, gain, start) in enumerate(
            zip(transfer.rates, transfer.gains, starts, strict=True), 1
        ):
            node = f"{name}_{count}"
            self.elements += [
                f"R{node} {name} {node} {number(1 / (rate * CAPACITANCE))}",
                f"C{node} {node} 0 {number(CAPACITANCE)}{initial(start)}",
            ]
            weights[f"V({node})"] = float(gain)
        modes = None if signal.transfer is None else transfer * signal.transfer
        return MeterReading(weights, modes)


@dataclass(frozen=True, eq=False)
class MeterReading:
    """A weighted sum of voltages and currents of the circuit; `transfer` is the same quantity in modes, if needed."""

    weights: Mapping[str, float]
    transfer: Transfer | None = None

    __array_ufunc__ = None  # so that a numpy number on the left uses __rmul__

    @property
    def text(self) -> str:
        """The sum in the syntax of ngspice."""
        terms = [name if weight == 1 else f"{number(weight)}*{name}" for name, weight in self.weights.items()]
        return " + ".join(terms).replace("+ -", "- ") or "0"

    def __add__(self, other: MeterReading) -> MeterReading:
        weights = dict(self.weights)
        for name, weight in other.weights.items():
            weights[name] = weights.get(name, 0.0) + weight
        known = self.transfer is not None and other.transfer is not None
        return MeterReading(weights, self.transfer + other.transfer if known else None)  # type: ignore[operator]

    def __sub__(self, other: MeterReading) -> MeterReading:
        return self + other * -1.0

    def __mul__(self, other: float | FilterToBuild) -> MeterReading:
        """Scale or filter."""
        if isinstance(other, FilterToBuild):
            return other.through(self)
        factor = float(other)
        weights = {name: weight * factor for name, weight in self.weights.items()}
        return MeterReading(weights, None if self.transfer is None else self.transfer * factor)

    __rmul__ = __mul__

    def __truediv__(self, other: float) -> MeterReading:
        return self * (1 / float(other))


@dataclass(frozen=True, eq=False)
class FilterToBuild:
    """A filter with real poles and no free part, which `build` adds to the circuit after a reading."""

    transfer: Transfer
    build: Callable[[Transfer, MeterReading], MeterReading]

    __array_ufunc__ = None

    def through(self, signal: MeterReading) -> MeterReading:
        """Return the reading of the output for a reading of the input."""
        return self.build(self.transfer, signal)

    def __mul__(self, other: MeterReading | float) -> MeterReading | FilterToBuild:
        """Filter a reading, or scale the filter."""
        if isinstance(other, MeterReading):
            return self.through(other)
        return FilterToBuild(self.transfer * float(other), self.build)

    __rmul__ = __mul__
