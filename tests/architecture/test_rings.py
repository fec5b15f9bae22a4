"""No module imports itself by way of others, imports inside functions included."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from source import SOURCE, nodes_of, text_of, tree_of

BY_NAME = {
    "electrovib": "public names are loaded on first use",
    "electrovib.core.discovery": "papers are found and never listed: it imports their folder, and models beside a family",
    "electrovib.data.registry": "finds the readers, so that one more is one file and no line elsewhere",
    "electrovib.data.guarded_child": "runs the reader that it is told, in a process of its own",
}
"""Modules that import by a text, and why: import-linter does not see such imports."""


def module_of(path: Path, root: Path) -> str:
    parts = path.relative_to(root.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(tree: ast.AST, known: set[str]):
    """Modules that a file imports at any time; not those it names for type checkers only."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            yield from (found for other in node.orelse for found in imports(other, known))
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name in known)
        elif isinstance(node, ast.ImportFrom):
            for name in node.names:
                inner = f"{node.module}.{name.name}"
                yield from ({inner, node.module} & known if inner not in known else {inner})
        else:
            yield from imports(node, known)


def graph(root: Path) -> dict[str, set[str]]:
    trees = {module_of(path, root): tree_of(path) for path in root.rglob("*.py")}
    return {name: set(imports(tree, set(trees))) - {name} for name, tree in trees.items()}


def test_no_ring_of_imports():
    found = graph(SOURCE)
    assert len(found) > 300
    assert sum(map(len, found.values())) > 1000
    try:
        tuple(TopologicalSorter(found).static_order())
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


@pytest.mark.parametrize(
    ("first", "ring"),
    [
        ("def f():\n    from package import b", True),
        ("from package.b import x", True),
        ("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from package.b import x", False),
        ("import package.b", True),
        ("x = 1", False),
    ],
)
def test_a_ring_would_be_seen(tmp_path, first, ring):
    package = tmp_path / "package"
    package.mkdir()
    for name, text in {
        "__init__": "",
        "a": first,
        "b": "class C:\n    def g(self):\n        import package.a",
    }.items():
        (package / f"{name}.py").write_text(text, encoding="utf-8")
    sorter = TopologicalSorter(graph(package))
    if ring:
        with pytest.raises(CycleError):
            sorter.prepare()
    else:
        sorter.prepare()


def test_imports_by_a_text_are_few_and_have_their_reason():
    """What is imported by a text can go to a higher layer without being seen."""
    words = ("import_module(", "__import__(", "run_module(")
    found = {
        module_of(path, SOURCE)
        for path in SOURCE.rglob("*.py")
        if any(word in text_of(path) for word in words)
    }
    assert found == set(BY_NAME)
    assert all(BY_NAME.values())


def test_no_module_below_names_one_above_in_a_text():
    """``"electrovib.papers"`` in discovery is the one: what a paper contributes is found, and never imported by name."""
    order = [
        "core",
        "data",
        "physics",
        "scenario",
        "solve",
        "study",
        "recordings",
        "papers",
        "view",
        "export",
        "bench",
        "apps",
    ]
    named = {
        (module_of(path, SOURCE), node.value.split(".")[1])
        for path in SOURCE.rglob("*.py")
        for node in nodes_of(path)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if node.value.startswith("electrovib.")
        and " " not in node.value
        and node.value.split(".")[1] in order
        if module_of(path, SOURCE).count(".") > 0
    }
    upwards = {(name, room) for name, room in named if order.index(name.split(".")[1]) < order.index(room)}
    assert upwards == {("electrovib.core.discovery", "papers")}
