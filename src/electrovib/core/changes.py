"""Changes of a model, written with the parameters that it stores: derived parameters are translated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from electrovib.core.errors import InputError, Problem
from electrovib.core.tables import place_of


def stored_changes(model: BaseModel, changes: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Return changes by the paths of the parameters that a model stores, and a problem for each that is refused.

    A path may end in a derived parameter; what is set within a table that is given
    along with it keeps its names, because the table has no stored values yet.
    """
    problems: list[Problem] = []
    fresh = {path.removesuffix(".model") for path, value in changes.items() if _is_fresh(model, path, value)}
    found: dict[str, Any] = {}
    together: dict[str, dict[str, Any]] = {}
    for path, value in changes.items():
        parent, _, last = path.rpartition(".")
        if any(f"{parent}.".startswith(f"{table}.") for table in fresh):
            found[path] = value
        else:
            together.setdefault(parent, {})[last] = value
    for parent, given in together.items():
        owner = _descended(model, parent.split(".") if parent else [])
        start = f"{parent}." if parent else ""
        try:
            kept = owner.stored(given) if hasattr(owner, "stored") else given
        except InputError as error:
            problems += [problem.within(parent) if parent else problem for problem in error.problems]
            kept = {name: value for name, value in given.items() if name not in type(owner).derived}
        found |= {f"{start}{name}": value for name, value in kept.items()}
    return found, problems


def derived_at(model: BaseModel, path: str) -> tuple[Any, str] | None:
    """Return the model that derives the parameter at a dotted path, and the parameter's name; None for a stored one."""
    *parents, last = path.split(".")
    owner = _descended(model, parents)
    return (owner, last) if last in getattr(type(owner), "derived", {}) else None


def number_at(model: BaseModel, path: str) -> float | None:
    """Return the number that is stored at a dotted path; None for a text, a table, an absent value or no such path."""
    *parents, last = path.split(".")
    owner = _descended(model, parents)
    found = dict(owner).get(last) if isinstance(owner, BaseModel) else None
    return found if isinstance(found, float) else None


def is_stored_as_given(model: BaseModel, path: str, kind: type[BaseModel]) -> bool:
    """Return whether a parameter is stored and, by the default `stored` of `kind`, its change alters no other parameter."""
    *parents, last = path.split(".")
    owner = _descended(model, parents)
    plain = getattr(type(owner), "stored", None) is kind.stored  # type: ignore[attr-defined]
    return plain and last not in getattr(type(owner), "derived", {})


def _is_fresh(model: BaseModel, path: str, value: Any) -> bool:
    """Tell whether a change sets a whole table, or another model, in place of what is stored."""
    if path.rpartition(".")[2] != "model":
        return isinstance(value, (Mapping, list, tuple, BaseModel))
    owner = _descended(model, path.split(".")[:-1])
    return bool(type(owner).__name__ != value)


def _descended(model: Any, keys: list[str]) -> Any:
    """Return what is stored at the end of keys; None where they lead to nothing."""
    owner = model
    for key in keys:
        if isinstance(owner, BaseModel):
            owner = dict(owner).get(key)
        elif isinstance(owner, tuple) and (place := place_of(owner, key)) is not None:
            owner = owner[place]
        else:
            owner = None
    return owner
