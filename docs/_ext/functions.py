"""A page for each public function and class of the package."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from types import ModuleType
from typing import Any, Final

from rst import grid, hidden_contents, joined, plain, title

import electrovib as ev

PARTS: Final = {
    "scenario": "Scenarios and spaces",
    "solve": "Simulation",
    "study": "Studies, comparisons and limits",
    "recordings": "Recordings",
    "papers": "Papers",
    "view": "Reports and plots",
    "export": "Export",
    "data": "Files",
    "bench": "Bench",
    "apps": "Complete tasks",
    "core": "Budget",
}
"""Folders of the package, in the order in which their functions are listed; another folder comes last under its name."""
CALLABLE_PACKAGES: Final = {"export": "electrovib.exports.save", "study": "electrovib.studies.population"}
"""A package that has the name of its main function and can be called as it, and the module of the function."""


def public() -> Iterator[tuple[str, str, Any]]:
    """Find the public functions and classes.

    Yields
    ------
    tuple
        Name in the package, dotted path by which it is documented, the object.
    """
    for name in dir(ev):
        thing = getattr(ev, name)
        if name in CALLABLE_PACKAGES:
            module = CALLABLE_PACKAGES[name]
            yield name, f"{module}.{name}", getattr(importlib.import_module(module), name)
        elif isinstance(thing, ModuleType):
            for plot in thing.__all__:
                yield f"{name}.{plot}", f"{thing.__name__}.{plot}", getattr(thing, plot)
        elif callable(thing):
            yield name, f"electrovib.{name}", thing


def pages() -> dict[str, str]:
    """Return the pages by file name: one for each function or class, and the list of all."""
    found = list(public())
    return {f"functions/{name}.rst": page(name, path, thing) for name, path, thing in found} | {
        "functions/index.rst": index(found)
    }


def page(name: str, path: str, thing: Any) -> str:
    """Write the page of one function or class."""
    if inspect.isclass(thing):
        members = ", ".join(own_members(thing))
        text = f".. autoclass:: {path}" + (f"\n   :members: {members}" if members else "")
    else:
        text = f".. autofunction:: {path}"
    return joined([title(f"ev.{name}"), text])


def own_members(kind: type) -> list[str]:
    """Return the documented public methods and properties that the package itself defines for a class."""
    found = {}
    for base in kind.__mro__:
        if base.__module__.startswith("electrovib."):
            found |= {name: value for name, value in vars(base).items() if not name.startswith("_")}
    shown = (property, classmethod, staticmethod)
    return sorted(
        name
        for name, value in found.items()
        if (inspect.isfunction(value) or isinstance(value, shown))
        and inspect.getdoc(getattr(kind, name))
        and "validat" not in type(value).__name__.lower()
        and name in dir_of(kind)
    )


def dir_of(kind: type) -> set[str]:
    """Return the names that completion offers for an object of a class."""
    fields = set(getattr(kind, "model_fields", ()))
    return set(dir(kind)) - fields


def index(found: list[tuple[str, str, Any]]) -> str:
    """Write the list of all functions, by folder of the package."""
    parts = [
        title("Functions"),
        "The public functions and classes after ``import electrovib as ev``. Every function that takes a scenario takes the"
        " name of a paper's scenario, a TOML file, nested tables, a `Scenario`, a Trace or its file.",
    ]
    folders: dict[str, list[tuple[str, str]]] = {name: [] for name in PARTS}
    for name, _, thing in found:
        folder = inspect.unwrap(thing).__module__.split(".")[1]
        folders.setdefault(folder, []).append((f":doc:`ev.{name} <{name}>`", summary(thing)))
    for folder, rows in folders.items():
        if rows:
            parts += [title(PARTS.get(folder, folder), "-"), grid(("name", "what it does"), rows, "30 70")]
    return joined([*parts, hidden_contents(f"ev.{name} <{name}>" for name, _, _ in found)])


def summary(thing: Any) -> str:
    """Return the first paragraph of a docstring."""
    return plain((inspect.getdoc(thing) or "").partition("\n\n")[0])
