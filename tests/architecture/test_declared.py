"""Solvers ask a model what it can do, and not of which class it is: a contributed one takes the way of the shipped ones."""

from __future__ import annotations

import ast

import pytest
from source import SOURCE, text_of

ROOMS = (
    "electrics",
    "mechanics",
    "nonlinear",
    "diagnostics",
    "equilibrium",
    "closed_form",
    "choice.py",
    "effort.py",
)
FAMILIES = ("friction", "contact", "finger.py", "time_profile.py", "rig.py")


def modules(parent, names):
    for name in names:
        yield from [parent / name] if name.endswith(".py") else sorted((parent / name).glob("*.py"))


MODELS = {
    node.name
    for path in modules(SOURCE / "physics", FAMILIES)
    for node in ast.parse(text_of(path)).body
    if isinstance(node, ast.ClassDef)
}


def asked(tree):
    """Classes that `isinstance` compares with; an assertion, which narrows a type for the checker, is not a question."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Assert):
            continue
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "isinstance":
            yield from (name.id for name in ast.walk(node.args[1]) if isinstance(name, ast.Name))
        yield from asked(node)


@pytest.mark.parametrize("path", [*modules(SOURCE / "solve", ROOMS)], ids=lambda path: path.stem)
def test_no_solver_asks_for_the_class_of_a_model(path):
    assert not MODELS & set(asked(ast.parse(text_of(path))))


def test_the_check_can_fail():
    assert {"Coulomb", "FixedArea", "MassSpringDamper", "Steady"} <= MODELS
    tree = ast.parse("x = 1 if isinstance(law, (Coulomb, int)) else 0\nassert isinstance(law, Dahl)")
    assert set(asked(tree)) & MODELS == {"Coulomb"}
