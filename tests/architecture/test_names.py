"""One word for one idea: no two classes of the package have the same name."""

from __future__ import annotations

import ast
from collections import defaultdict

from source import SOURCE, nodes_of

COVERED = sorted(path.name for path in SOURCE.iterdir() if (path / "__init__.py").exists())
"""Packages whose classes are compared: all."""


def classes(root, packages):
    found = defaultdict(list)
    for package in packages:
        for path in sorted((root / package).rglob("*.py")):
            for node in nodes_of(path):
                if isinstance(node, ast.ClassDef):
                    found[node.name].append(f"{path.relative_to(root)}:{node.lineno}")
    return found


def test_no_class_name_twice():
    found = classes(SOURCE, COVERED)
    assert {name: places for name, places in found.items() if len(places) > 1} == {}
    assert len(found) > 200


def test_a_second_class_of_a_name_would_be_seen(tmp_path):
    for package in ("a", "b"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "m.py").write_text("def f():\n    class Layer: pass\n", encoding="utf-8")
    assert classes(tmp_path, ["a", "b"]) == {"Layer": ["a/m.py:2", "b/m.py:2"]}
