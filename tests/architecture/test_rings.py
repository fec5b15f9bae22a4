"""Data flows one way: layers, no ring of imports (those inside functions included), and no import by a text but a few."""

import ast
import subprocess
import sys
import tomllib
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from source import ROOT, SOURCE, nodes_of, text_of, tree_of

BY_NAME = {
    "electrovib": "public names are loaded on first use",
    "electrovib.core.discovery": "papers are found and never listed: it imports their folder, and models beside a family",
    "electrovib.data.registry": "finds the readers, so that one more is one file and no line elsewhere",
    "electrovib.data.guarded": "runs the reader that it is told, in a process of its own",
    "electrovib.recordings.fit.least_squares": "asks for a package of the extra fit by the name that its sentence states",
}
"""Modules that import by a text, and why: import-linter does not see such imports."""
CONFIGURATION = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LAYERS = CONFIGURATION["tool"]["importlinter"]["contracts"][0]["layers"]
PLACES = {name.strip(): place for place, line in enumerate(reversed(LAYERS)) for name in line.split("|")}
"""Height of each room, core at 0."""


def test_layers_are_kept():
    script = "from importlinter.cli import lint_imports_command as c; c(['--no-cache'])"
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 kept, 0 broken" in done.stdout


def test_every_folder_is_a_package_in_a_layer_in_the_order_of_the_data():
    order = ["core", "physics", "scenario", "solve", "studies", "papers", "view", "exports", "bench", "apps"]
    assert [PLACES[name] for name in order] == sorted({PLACES[name] for name in order})
    for one, other in (("data", "physics"), ("recordings", "studies")):
        assert PLACES[one] == PLACES[other]
    assert set(PLACES) == {path.name for path in SOURCE.iterdir() if (path / "__init__.py").exists()}
    folders = {path.parent for path in SOURCE.rglob("*.py")}
    assert not [str(folder.relative_to(ROOT)) for folder in folders if not (folder / "__init__.py").exists()]


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
    second = "class C:\n    def g(self):\n        import package.a"
    for name, text in {"__init__": "", "a": first, "b": second}.items():
        (package / f"{name}.py").write_text(text, encoding="utf-8")
    try:
        TopologicalSorter(graph(package)).prepare()
    except CycleError:
        assert ring
    else:
        assert not ring


def test_imports_by_a_text_are_few_and_have_their_reason_and_no_paper_is_named_below():
    """What is imported by a text can go to a higher layer without being seen; a new paper needs no line anywhere."""
    words = ("import_module(", "__import__(", "run_module(")
    texts = {module_of(path, SOURCE): text_of(path) for path in SOURCE.rglob("*.py")}
    assert {name for name, text in texts.items() if any(word in text for word in words)} == set(BY_NAME)
    assert all(BY_NAME.values())
    papers = [path.stem for path in (SOURCE / "papers").iterdir() if "_20" in path.stem or "_19" in path.stem]
    assert {"vezzoli_2014", "strong_1970"} <= set(papers)
    for name, text in texts.items():
        room = f"{name}.".split(".")[1]
        if PLACES.get(room, PLACES["apps"]) < PLACES["papers"]:
            assert not [paper for paper in papers if f"papers.{paper}" in text], name


def test_no_module_below_names_one_above_in_a_text():
    """``"electrovib.papers"`` in discovery is the one: what a paper contributes is found, and never imported by name."""
    upwards = set()
    for path in SOURCE.rglob("*.py"):
        name = module_of(path, SOURCE)
        for node in nodes_of(path):
            text = node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""
            if "." in name and text.startswith("electrovib.") and " " not in text:
                room = text.split(".")[1]
                if PLACES[name.split(".")[1]] < PLACES.get(room, 0):
                    upwards.add((name, room))
    assert upwards == {("electrovib.core.discovery", "papers")}
