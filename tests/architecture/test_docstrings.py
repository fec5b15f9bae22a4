"""Everything public says what it is; what takes arrays or several numbers says what they are, in which unit.

Read from the source text, so that nothing has to be imported and nothing inherited counts.
"""

from __future__ import annotations

import ast
import re
from typing import NamedTuple

import pytest
from source import SOURCE, nodes_of, tree_of

WITH_SECTIONS = ("core", "physics", "scenario", "solve", "study", "recordings")
ARRAYS = ("ArrayLike", "NDArray", "ndarray", "Real", "Complex")


class Public(NamedTuple):
    where: str
    node: ast.AST
    owner: ast.ClassDef | None

    @property
    def text(self):
        return ast.get_docstring(self.node) or ""


def is_public(name):
    return not name.startswith("_")


def modules():
    for path in sorted(SOURCE.rglob("*.py")):
        parts = path.relative_to(SOURCE).with_suffix("").parts
        if all(is_public(part) or part == "__init__" for part in parts):
            yield path, ".".join(part for part in parts if part != "__init__") or "electrovib"


def public_things(path, module):
    tree = tree_of(path)
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and is_public(node.name):
            yield Public(f"{module}.{node.name}", node, None)
        if isinstance(node, ast.ClassDef) and is_public(node.name):
            for inner in node.body:
                if isinstance(inner, ast.FunctionDef | ast.ClassDef) and is_public(inner.name):
                    yield Public(f"{module}.{node.name}.{inner.name}", inner, node)


def everything_public():
    return [thing for path, module in modules() for thing in public_things(path, module)]


def decorators(node):
    return {ast.unparse(decorator) for decorator in node.decorator_list}


def arguments(node):
    found = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return [argument for argument in found if argument.arg not in {"self", "cls"}]


def takes_numbers(node):
    """Tell whether an argument is a physical number or an array of them."""
    written = [ast.unparse(argument.annotation) for argument in arguments(node) if argument.annotation]
    return any(word in text for text in written for word in ARRAYS) or any(
        "float" in text.split(" | ") for text in written
    )


def sentence_with_units(thing):
    """A single argument needs no sections where the one sentence has the units: 'Voltage [V] at a time [s].'"""
    return len(arguments(thing.node)) == 1 and re.search(r"\[[^\]]+\]", thing.text) is not None


def gives_something(node):
    return node.returns is not None and ast.unparse(node.returns) not in {"None", "NoReturn"}


def repeats_a_declared_method(thing, methods_of):
    """A member's method whose meaning the family has given: found by name in a base class of the package."""
    if thing.owner is None:
        return False
    waiting = [ast.unparse(base) for base in thing.owner.bases]
    while waiting:
        base = waiting.pop()
        inner, further = methods_of.get(base, (set(), []))
        if thing.node.name in inner:
            return True
        waiting += further
    return False


def declared_methods():
    found = {}
    for path, _ in modules():
        for node in nodes_of(path):
            if isinstance(node, ast.ClassDef):
                inner = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
                found[node.name] = (inner, [ast.unparse(base) for base in node.bases])
    return found


def needs_sections(thing, methods_of):
    node = thing.node
    if not isinstance(node, ast.FunctionDef) or not thing.where.startswith(WITH_SECTIONS):
        return False
    if decorators(node) & {"property", "model_validator", "overload"} or not arguments(node):
        return False
    if repeats_a_declared_method(thing, methods_of):
        return False
    return takes_numbers(node) and not sentence_with_units(thing)


def test_every_module_says_what_it_is():
    silent = [name for path, name in modules() if not ast.get_docstring(tree_of(path))]
    assert not silent


def test_everything_public_has_a_first_sentence():
    silent = [thing.where for thing in everything_public() if not first_sentence(thing.text)]
    assert not silent, "\n".join(silent)


def first_sentence(text):
    paragraph = " ".join(text.strip().split("\n\n")[0].split())
    return paragraph if paragraph.endswith((".", "?")) and len(paragraph.split()) >= 2 else ""


def test_arrays_and_numbers_are_described():
    methods_of = declared_methods()
    lacking = []
    for thing in everything_public():
        if needs_sections(thing, methods_of):
            wanted = ["Parameters"] + ["Returns"] * gives_something(thing.node)
            missing = [
                name for name in wanted if f"{name}\n---" not in thing.text.replace("Yields\n", "Returns\n")
            ]
            if missing:
                lacking.append(f"{thing.where}: {', '.join(missing)}")
    assert not lacking, f"{len(lacking)}:\n" + "\n".join(lacking)


def test_described_parameters_exist():
    """A Parameters section names the arguments there are, all of them."""
    wrong = []
    for thing in everything_public():
        if isinstance(thing.node, ast.FunctionDef) and "Parameters\n---" in thing.text:
            described = described_names(thing.text)
            actual = {argument.arg for argument in arguments(thing.node)}
            actual |= {extra.arg for extra in (thing.node.args.vararg, thing.node.args.kwarg) if extra}
            if described != actual:
                wrong.append(
                    f"{thing.where}: describes {sorted(described - actual)}, not {sorted(actual - described)}"
                )
    assert not wrong, "\n".join(wrong)


def described_names(text):
    """Names before the colon at the margin of the Parameters section."""
    section = text.split("Parameters\n", 1)[1].split("\n", 1)[1]
    names = set()
    lines = section.splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if following.startswith("---"):
            break
        if line and not line.startswith(" "):
            names |= {name.strip().lstrip("*") for name in line.split(" : ")[0].split(",")}
    return names


@pytest.mark.parametrize(
    ("text", "good"),
    [
        ("Voltage of the drive.", True),
        ("Voltage of\nthe drive.\n\nMore", True),
        ("", False),
        ("voltage", False),
        ("Voltage of the drive", False),
    ],
)
def test_a_missing_sentence_is_noticed(text, good):
    assert bool(first_sentence(text)) == good


def test_public_things_are_found():
    names = {thing.where for thing in everything_public()}
    assert {
        "core.units.parse_quantity",
        "solve.simulate.simulate",
        "physics.material.relaxations.Debye",
    } <= names
    assert len(names) > 200


NUMBERS = re.compile(r"(float|int|complex|ndarray|tuple|array|number)\b")


def nameless_returns(text):
    """Lines of a Returns section that give the type of a number and no name: a reader has to know what it is."""
    if "Returns\n-------\n" not in text:
        return []
    section = re.split(r"\n\n\w[\w ]*\n---", text.split("Returns\n-------\n")[1])[0]
    return [
        line for line in section.splitlines() if NUMBERS.match(line) and not re.match(r"\w[\w, ]* : ", line)
    ]


def test_every_number_that_is_returned_has_a_name():
    wrong = []
    for path, module in modules():
        for node in nodes_of(path):
            if isinstance(node, ast.FunctionDef):
                found = nameless_returns(ast.get_docstring(node) or "")
                wrong += [f"{module}.{node.name}: {line}" for line in found]
    assert not wrong, "\n".join(wrong)


def test_a_number_without_a_name_is_noticed():
    assert nameless_returns("Sum.\n\nReturns\n-------\nfloat\n    N.\n\nNotes\n-----\nfloat") == ["float"]
    assert nameless_returns("Sum.\n\nReturns\n-------\nforce : float\n    Attraction [N].") == []
    assert nameless_returns("Sum.\n\nReturns\n-------\nTrace\n    Of the run.") == []
