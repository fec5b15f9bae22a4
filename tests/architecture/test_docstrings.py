"""Everything public says what it is; what a user or an author of a model calls says what it takes and gives, in which unit.

Full numpydoc is for the names of `electrovib`, the public methods of the classes among them and of the families of models.
Every other function has one sentence, and a formula, shape or unit where name and types do not say it.
"""

import ast
import functools
import inspect
import re
from dataclasses import is_dataclass
from typing import NamedTuple

from source import SOURCE, nodes_of, tree_of

import electrovib
from electrovib.apps.cli import fit, options, plan
from electrovib.studies.catalogue.items import families


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


def arguments(node):
    found = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return [argument for argument in found if argument.arg not in {"self", "cls"}]


def called_by_users():
    """Functions and methods that users and authors of models call: `module.name`, without `electrovib.`."""
    found = [getattr(electrovib, name) for name in dir(electrovib)]
    found += [getattr(electrovib.plot, name) for name in electrovib.plot.__all__]
    kinds = {thing for thing in found if inspect.isclass(thing)} | set(families())
    names = {named(inspect.unwrap(thing)) for thing in found if inspect.isfunction(thing)}
    for kind in kinds:
        inherited = {name for base in kind.__mro__[1:] for name in vars(base)}
        names |= {f"{named(kind)}.{name}" for name in vars(kind) if is_public(name) and name not in inherited}
    return names


def named(thing):
    return f"{thing.__module__}.{thing.__qualname__}".removeprefix("electrovib.")


def sections(thing, called):
    """Sections that a docstring needs; a single argument none where a sentence has the units: 'Voltage [V] at a time [s].'"""
    node = thing.node
    if not isinstance(node, ast.FunctionDef) or thing.where not in called or not arguments(node):
        return []
    if {ast.unparse(each) for each in node.decorator_list} & {"property", "model_validator", "overload"}:
        return []
    if len(arguments(node)) == 1 and re.search(r"\[[^\]]+\]", thing.text):
        return []
    gives = node.returns is not None and ast.unparse(node.returns) not in {"None", "NoReturn"}
    return ["Parameters", "Returns"] if gives else ["Parameters"]


def test_everything_public_says_what_it_is():
    silent = [name for path, name in modules() if not ast.get_docstring(tree_of(path))]
    things = everything_public()
    silent += [thing.where for thing in things if not first_sentence(thing.text)]
    assert not silent, "\n".join(silent)
    found = {"core.units.parse_quantity", "solve.simulate.simulate", "physics.material.relaxations.Debye"}
    assert found <= {thing.where for thing in things}
    assert len(things) > 200


def first_sentence(text):
    paragraph = " ".join(text.strip().split("\n\n")[0].split())
    return paragraph if paragraph.endswith((".", "?")) and len(paragraph.split()) >= 2 else ""


def test_what_is_called_is_described():
    called, lacking = called_by_users(), []
    for thing in everything_public():
        text = thing.text.replace("Yields\n", "Returns\n")
        lacking += [
            f"{thing.where}: {name}" for name in sections(thing, called) if f"{name}\n---" not in text
        ]
    assert not lacking, f"{len(lacking)}:\n" + "\n".join(lacking)
    wanted = {"solve.simulate.simulate", "view.plots.over_time.force", "physics.force.ForceLaw.pressure"}
    assert wanted <= called


def test_described_parameters_exist():
    """A Parameters section names the arguments there are, all of them; that of a command omits what its module describes."""
    wrong = []
    for thing in everything_public():
        if isinstance(thing.node, ast.FunctionDef) and "Parameters\n---" in thing.text:
            described = described_names(thing.text)
            actual = {argument.arg for argument in arguments(thing.node)}
            actual |= {extra.arg for extra in (thing.node.args.vararg, thing.node.args.kwarg) if extra}
            if thing.where.startswith("apps.cli."):
                classes = options_by_class()
                names = {each.arg: ast.unparse(each.annotation) for each in arguments(thing.node)}
                actual = {
                    one for name, kind in names.items() for one in classes.get(kind, {name.strip("_")})
                } & described
            if described != actual:
                wrong.append(f"{thing.where}: {sorted(described)}, not {sorted(actual)}")
    assert not wrong, "\n".join(wrong)


@functools.cache
def options_by_class():
    """Names of the options of each class of them, such as `options.AnswerOptions`, by how a command names it."""
    known = {f"options.{name}": kind for name, kind in vars(options).items()} | vars(fit) | vars(plan)
    return {
        name: set(inspect.signature(kind).parameters) for name, kind in known.items() if is_dataclass(kind)
    }


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


def test_a_missing_sentence_and_a_number_without_a_name_are_noticed():
    assert first_sentence("Voltage of\nthe drive.\n\nMore") == "Voltage of the drive."
    assert not any(first_sentence(text) for text in ("", "voltage", "Voltage of the drive"))
    assert nameless_returns("Sum.\n\nReturns\n-------\nfloat\n    N.\n\nNotes\n-----\nfloat") == ["float"]
    assert nameless_returns("Sum.\n\nReturns\n-------\nforce : float\n    Attraction [N].") == []
    assert nameless_returns("Sum.\n\nReturns\n-------\nTrace\n    Of the run.") == []
