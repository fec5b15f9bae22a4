"""Declared equations as lines of text, one for each case."""

from __future__ import annotations

import ast
import re


def formula_lines(name: str, text: str) -> tuple[str, ...]:
    """Return a declared equation in words, one line ``name = formula``, with ``, for condition``, for each case."""
    shown = name if name.endswith("'") else name.rpartition(".")[2]
    node = ast.parse(text, mode="eval").body
    found = []
    while isinstance(node, ast.IfExp):
        found.append(f"{shown} = {_written(node.body, text)}, {_condition(node.test, text)}")
        node = node.orelse
    otherwise = ", otherwise" if found else ""
    return (*found, f"{shown} = {_written(node, text)}{otherwise}")


def _written(node: ast.expr, text: str) -> str:
    """Return a part of an equation as it is declared; methods without arguments on a path are omitted."""
    return re.sub(r"\.\w+\(\)", "", ast.get_source_segment(text, node) or ast.unparse(node))


def _condition(node: ast.expr, text: str) -> str:
    """Return a condition in words; the absence of an optional parameter is one."""
    if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Is):
        return f"without {_written(node.left, text)}"
    return f"for {_written(node, text)}"
