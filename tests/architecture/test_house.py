"""The house stays one that a newcomer can read: few doors in `solve/`, one place of choice, short functions."""

from __future__ import annotations

import ast

from source import SOURCE, nodes_of

from electrovib.solve.choice import SOLVERS

FLAT = 8
LONG_FUNCTION, SHARE = 25, 0.9
LONGEST_FUNCTION = 60


def modules():
    return {path: nodes_of(path) for path in sorted(SOURCE.rglob("*.py"))}


def test_few_modules_lie_flat_in_solve():
    flat = [path.name for path in (SOURCE / "solve").glob("*.py") if path.name != "__init__.py"]
    assert len(flat) <= FLAT, flat
    assert {"simulate.py", "choice.py"} <= set(flat)


def test_nobody_steers_by_the_name_of_a_solver():
    """Which solver runs is decided by what it takes; what follows from it is in its `Method`."""
    names = {solver.method.name for solver in SOLVERS}
    found = [
        f"{path.relative_to(SOURCE)}:{node.lineno}"
        for path, nodes in modules().items()
        for node in nodes
        if isinstance(node, ast.Compare)
        for inner in ast.walk(node)
        if isinstance(inner, ast.Constant) and inner.value in names
    ]
    assert not found


def test_one_module_lists_the_solvers():
    """Methods are put together with what they take in one place alone."""
    makers = [
        str(path.relative_to(SOURCE))
        for path, nodes in modules().items()
        if any(isinstance(node, ast.Name) and node.id == "Solver" for node in nodes)
    ]
    assert makers == ["solve/choice.py"]


def code_lines(node):
    """Lines of a function without its docstring."""
    text = ast.get_docstring(node, clean=False)
    docstring = node.body[0].end_lineno - node.body[0].lineno + 1 if text is not None else 0
    return node.end_lineno - node.lineno + 1 - docstring


def test_functions_fit_a_screen():
    sizes = {
        f"{path.relative_to(SOURCE)}:{node.lineno} {node.name}": code_lines(node)
        for path, nodes in modules().items()
        for node in nodes
        if isinstance(node, ast.FunctionDef)
    }
    assert not [name for name, size in sizes.items() if size > LONGEST_FUNCTION]
    assert sum(size < LONG_FUNCTION for size in sizes.values()) > SHARE * len(sizes)
