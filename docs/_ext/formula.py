"""Declared equations as formulas in LaTeX, in the order in which they are declared."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator
from typing import Final

SYMBOLS: Final = {"eps0": r"\varepsilon_0", "pi": r"\pi", "I": r"\mathrm{j}"}
"""Names that are no parameters, and their signs."""
FUNCTIONS: Final = {
    "Max": r"\max",
    "Min": r"\min",
    "cos": r"\cos",
    "cosh": r"\cosh",
    "exp": r"\exp",
    "log": r"\ln",
    "sin": r"\sin",
    "sinh": r"\sinh",
    "tan": r"\tan",
    "tanh": r"\tanh",
}
"""Functions with a sign of their own; the name of any other is set upright."""
RELATIONS: Final[dict[type[ast.cmpop], str]] = {
    ast.Lt: "<",
    ast.LtE: r"\leq",
    ast.Gt: ">",
    ast.GtE: r"\geq",
    ast.Eq: "=",
}
LOOSE, SUM, PRODUCT, FRACTION, POWER, ATOM = range(6)
"""How tightly a formula holds together: one that is looser than its place needs parentheses."""


def lines(name: str, text: str) -> list[str]:
    """Return an equation in LaTeX.

    Parameters
    ----------
    name : str
        What is computed: a derivative in time if it ends in ``'``; else the last part of a dotted path is shown.
    text : str
        Right side in the notation of `electrovib.core.model.Model.equation`.

    Returns
    -------
    lines : list of str
        One formula, or one for each case with its condition.
    """
    if name.endswith("'"):
        left = rf"\frac{{\mathrm{{d}}\,{named(name[:-1])}}}{{\mathrm{{d}}t}}"
    else:
        left = named(name.rpartition(".")[2])
    found = list(cases(ast.parse(text, mode="eval").body))
    written = []
    for place, (condition, node) in enumerate(found):
        line = f"{left} = {formula(node)}"
        if condition is not None:
            line += rf" \quad {in_words(condition)}"
        elif place:
            line += r" \quad \mathrm{otherwise}"
        written.append(line)
    return written


def cases(node: ast.expr) -> Iterator[tuple[ast.expr | None, ast.expr]]:
    """Return the cases of a formula, each with its condition; None for the case without one."""
    choice = next((inner for inner in ast.walk(node) if isinstance(inner, ast.IfExp)), None)
    if choice is None:
        yield None, node
        return
    yield choice.test, replaced(node, choice, choice.body)
    yield from cases(replaced(node, choice, choice.orelse))


def replaced(node: ast.expr, old: ast.expr, new: ast.expr) -> ast.expr:
    """Return a copy of a formula with one part replaced."""
    return copy.deepcopy(node, {id(old): new})


def formula(node: ast.expr, *, flat: bool = False) -> str:
    """Return a formula without cases in LaTeX; `flat` with a stroke in place of a fraction, for exponents."""
    return set_in(node, LOOSE, flat=flat)


def set_in(node: ast.expr, place: int, *, flat: bool) -> str:
    """Return a formula for a place that needs a formula as tight as this, in parentheses if it is looser."""
    text, tight = laid_out(node, flat=flat)
    return text if tight >= place else rf"\left({text}\right)"


def laid_out(node: ast.expr, *, flat: bool) -> tuple[str, int]:  # noqa: PLR0911  # one for each form
    """Return a formula in LaTeX, and how tightly it holds together."""
    match node:
        case ast.Constant(value=value):
            return f"{value}", ATOM
        case ast.Name() | ast.Attribute():
            return named(dotted(node)), ATOM
        case ast.Subscript(value=value, slice=ast.Name(id=index)):
            return f"{set_in(value, ATOM, flat=flat)}_{{{named(index)}}}", ATOM
        case ast.Tuple(elts=parts):
            return rf"\left({listed(parts, flat=flat)}\right)", ATOM
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return f"-{set_in(operand, PRODUCT, flat=flat)}", SUM
        case ast.BinOp():
            return joined(node, flat=flat)
        case ast.Call():
            return called(node, flat=flat)
    raise ValueError(f"'{ast.unparse(node)}' cannot be drawn as a formula")


def joined(node: ast.BinOp, *, flat: bool) -> tuple[str, int]:  # noqa: PLR0911  # one for each operation
    """Return two formulas joined by an operation, and how tightly that holds together."""

    def both(before: int, after: int) -> tuple[str, str]:
        return set_in(node.left, before, flat=flat), set_in(node.right, after, flat=flat)

    match node.op:
        case ast.Add():
            left, right = both(SUM, SUM + isinstance(node.right, ast.UnaryOp))
            return f"{left} + {right}", SUM
        case ast.Sub():
            left, right = both(SUM, PRODUCT)
            return f"{left} - {right}", SUM
        case ast.Mod():
            left, right = both(PRODUCT, PRODUCT)
            return rf"{left}\ \mathrm{{mod}}\ {right}", LOOSE
        case ast.Mult():
            left, right = both(SUM if isinstance(node.left, ast.UnaryOp) else PRODUCT, FRACTION)
            return f"{left}{between(node)}{right}", PRODUCT
        case ast.Div() if flat:
            left, right = both(PRODUCT, POWER)
            return f"{left} / {right}", PRODUCT
        case ast.Div():
            return rf"\frac{{{formula(node.left)}}}{{{formula(node.right)}}}", FRACTION
        case ast.Pow():
            base = set_in(node.left, ATOM, flat=flat)
            return f"{base}^{{{formula(node.right, flat=True)}}}", POWER
    raise ValueError(f"'{ast.unparse(node)}' cannot be drawn as a formula")


def between(node: ast.BinOp) -> str:
    """Return the sign of a multiplication: a dot between two names of several letters, else a small distance."""
    left = node.left
    if isinstance(left, ast.UnaryOp):
        left = left.operand
    if isinstance(left, ast.BinOp) and isinstance(left.op, ast.Mult):
        left = left.right
    return r" \cdot " if is_long(left) and is_long(node.right) else r"\,"


def is_long(node: ast.expr) -> bool:
    """Return whether a formula is a name of several letters, a power of one, or a method of a part."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        return is_long(node.left)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        return True
    return isinstance(node, (ast.Name, ast.Attribute)) and long_name(dotted(node))


def called(node: ast.Call, *, flat: bool) -> tuple[str, int]:
    """Return a function of its arguments, and how tightly that holds together."""
    name, inputs = dotted(node.func), node.args
    match name, inputs:
        case "sum", [ast.GeneratorExp(elt=term, generators=[ast.comprehension(target=each, iter=of)])]:
            below = rf"{named(dotted(each))}\,\in\,{named(dotted(of))}"
            return rf"\sum_{{{below}}} {set_in(term, PRODUCT, flat=flat)}", SUM
        case "sqrt", [under]:
            return rf"\sqrt{{{formula(under, flat=flat)}}}", ATOM
        case "Abs", [size]:
            return rf"\left|{formula(size, flat=True)}\right|", ATOM
        case _, []:
            return named(name), ATOM
    sign = FUNCTIONS.get(name) or named(name)
    return rf"{sign}\left({listed(inputs, flat=flat)}\right)", ATOM


def listed(parts: list[ast.expr], *, flat: bool) -> str:
    """Return formulas with commas between them."""
    return r",\ ".join(formula(part, flat=flat) for part in parts)


def in_words(condition: ast.expr) -> str:
    """Return the condition of a case in LaTeX."""
    match condition:
        case ast.Compare(left=left, ops=[ast.Is()], comparators=[ast.Constant(value=None)]):
            return rf"\mathrm{{without}}\ {formula(left)}"
        case ast.Compare(left=left, ops=ops, comparators=others):
            text = rf"\mathrm{{for}}\ {formula(left, flat=True)}"
            for sign, other in zip(ops, others, strict=True):
                text += f" {RELATIONS[type(sign)]} {formula(other, flat=True)}"
            return text
    raise ValueError(f"'{ast.unparse(condition)}' cannot be drawn as a condition")


def dotted(node: ast.expr) -> str:
    """Return a name, or a path of names with dots; methods without arguments in it are omitted."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Attribute(value=ast.Call(func=ast.Attribute(value=inner), args=[]), attr=name):
            return f"{dotted(inner)}.{name}"
        case ast.Attribute(value=inner, attr=name):
            return f"{dotted(inner)}.{name}"
    raise ValueError(f"'{ast.unparse(node)}' is no name")


def long_name(name: str) -> bool:
    """Return whether a name is set upright, because it has several letters."""
    return len(name) > 1 and name not in SYMBOLS


def named(name: str) -> str:
    """Return the name of a parameter or of an argument in LaTeX."""
    if not long_name(name):
        return SYMBOLS.get(name, name)
    escaped = name.replace("_", r"\_").replace(".", r".\!")  # a dot is followed by a space
    return rf"\mathrm{{{escaped}}}"
