"""Evaluation of declared equations with NumPy, apart from the code of the models."""

import ast
import copy
import functools
import inspect
import operator

import numpy as np
from scipy.special import erf

from electrovib.core.constants import VACUUM_PERMITTIVITY

CONSTANTS = {"eps0": VACUUM_PERMITTIVITY, "pi": np.pi, "I": 1j, "x": 0, "y": 1, "first": 0}
FUNCTIONS = {
    "Abs": np.abs,
    "Max": lambda *values: functools.reduce(np.maximum, values),
    "Min": lambda *values: functools.reduce(np.minimum, values),
    "cos": np.cos,
    "erf": erf,
    "exp": np.exp,
    "interpolated": np.interp,
    "im": np.imag,
    "log": np.log,
    "re": np.real,
    "round": np.round,
    "sign": np.sign,
    "sin": np.sin,
    "sqrt": np.sqrt,
}
OPERATIONS = {
    ast.Add: operator.add,
    ast.Div: operator.truediv,
    ast.Mod: np.mod,
    ast.Mult: operator.mul,
    ast.Pow: operator.pow,
    ast.Sub: operator.sub,
}
RELATIONS = {ast.Lt: operator.lt, ast.LtE: operator.le, ast.Is: operator.is_}


class Evaluation:
    """Values of the equations of one model.

    Parameters
    ----------
    model : Model
        Its parameters and methods can be used by the equations.
    arguments : dict
        Values of what the equations depend on besides.
    equations : mapping of str to str
        By default those that the model declares.
    """

    def __init__(self, model, arguments, equations=None):
        self.model = model
        self.equations = dict(model.equation if equations is None else equations)
        fields = {name: getattr(value, "values", value) for name, value in model}  # arrays of samples
        self.known = {**CONSTANTS, **fields, **arguments}

    def value(self, name):
        with np.errstate(all="ignore"):  # the case that is not chosen
            return self.of(parsed(self.equations[name]))

    def of(self, node):
        return getattr(self, f"_{type(node).__name__.lower()}")(node)

    def _constant(self, node):
        return node.value

    def _name(self, node):
        if node.id not in self.known and not hasattr(self.model, node.id) and node.id in self.equations:
            self.known[node.id] = self.of(parsed(self.equations[node.id]))
        return self.known[node.id]

    def _attribute(self, node):
        return getattr(self.of(node.value), node.attr)

    def _unaryop(self, node):
        assert isinstance(node.op, ast.USub)
        return -self.of(node.operand)

    def _binop(self, node):
        left = self.of(node.left)
        if isinstance(node.op, ast.Pow):
            left = left if np.iscomplexobj(left) else np.asarray(left, float)
        return OPERATIONS[type(node.op)](left, self.of(node.right))

    def _ifexp(self, node):
        chosen = self.of(node.test)
        if np.ndim(chosen) == 0:
            return self.of(node.body if chosen else node.orelse)
        return np.where(chosen, self.of(node.body), self.of(node.orelse))

    def _compare(self, node):
        sides = [self.of(side) for side in (node.left, *node.comparators)]
        pairs = zip(node.ops, sides[:-1], sides[1:], strict=True)
        return functools.reduce(operator.and_, (RELATIONS[type(sign)](*both) for sign, *both in pairs))

    def _subscript(self, node):
        return self.of(node.value)[..., self.of(node.slice)]

    def _tuple(self, node):
        return np.stack(np.broadcast_arrays(*(self.of(part) for part in node.elts)), axis=-1)

    def _call(self, node):
        match node.func, node.args:
            case ast.Name(id="sum"), [ast.GeneratorExp(elt=term, generators=[each])]:
                return sum(self._with(each.target.id, item).of(term) for item in self.of(each.iter))
            case ast.Name(id=name), inputs if name in FUNCTIONS:
                return FUNCTIONS[name](*(self.of(one) for one in inputs))
            case ast.Name(id=name), inputs:
                method = getattr(self.model, name)
            case ast.Attribute(), inputs:
                method = self.of(node.func)
        return method(**dict(zip(arguments_of(method), (self.of(one) for one in inputs), strict=True)))

    def _with(self, name, value):
        inner = Evaluation(self.model, self.known, self.equations)
        inner.known[name] = value
        return inner


def parsed(text):
    return ast.parse(text, mode="eval").body


def arguments_of(method):
    return [name for name in inspect.signature(method).parameters if name != "self"]


def method_of(model, name):
    """Return the method that an equation declares; None for a quantity that only other equations use."""
    name = "voltage" if name == getattr(model, "quantity", None) else name
    owner, _, last = name.rpartition(".")
    found = getattr(model, owner)() if hasattr(model, owner) else model
    method = getattr(found, last, None)
    return method if callable(method) else None


def symbols(text):
    """Return the parts of an equation that stand for one value each: names, paths of names, results of methods."""
    tree, found, inside = parsed(text), set(), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            inside.add(node.value)
        elif isinstance(node, ast.comprehension):
            inside |= {node.iter, node.target}
        elif isinstance(node, ast.Subscript):
            inside.add(node.slice)
        elif isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Is):
            inside |= {node.left, *node.comparators}
        elif isinstance(node, ast.Call):
            inside.add(node.func)
    for node in ast.walk(tree):
        method = isinstance(node, ast.Call) and (
            isinstance(node.func, ast.Attribute) or node.func.id not in FUNCTIONS
        )
        if node in inside or (isinstance(node, ast.Call) and getattr(node.func, "id", "") == "sum"):
            continue
        if isinstance(node, (ast.Name, ast.Attribute)) or method:
            found.add(ast.unparse(node))
    return found - {"pi", "eps0"}


def twisted(text, symbol, factor):
    """Return the equation with one symbol multiplied by a factor wherever it stands for a value."""

    class Put(ast.NodeTransformer):
        def visit(self, node):
            if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Is):
                return node
            if isinstance(node, ast.expr) and ast.unparse(node) == symbol:
                return ast.BinOp(ast.Constant(factor), ast.Mult(), copy.deepcopy(node))
            return self.generic_visit(node)

    return ast.unparse(Put().visit(parsed(text)))
