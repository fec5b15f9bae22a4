"""Nested tables, as a scenario file has them, changed by dotted paths, also of parameters that a model derives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from pydantic import BaseModel

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError, Problem, closest, nearest, question
from electrovib.core.samples import Samples

if TYPE_CHECKING:
    from electrovib.core.model import Model


def put(content: dict[str, Any], changes: Mapping[str, Any], *, strict: bool = True) -> list[Problem]:
    """Put changes by dotted path into nested tables, in place; return a problem for each that is refused.

    A table is set before single values in it. A new ``model`` is set first and keeps no parameter of the
    former one, so that its own parameters can be given beside it. If `strict`, paths that do not exist are
    refused; otherwise missing tables are made, and validation follows.
    """
    ordered = sorted(changes, key=lambda path: (path.count("."), not path.endswith(".model")))
    fresh: list[Any] = []
    problems = [_put(content, path, changes[path], fresh, strict=strict) for path in ordered]
    return _dropped(changes) + [problem for problem in problems if problem]


def _dropped(changes: Mapping[str, Any]) -> list[Problem]:
    """List tables that would be dropped as a whole because another model is set in their place."""
    return [
        Problem(
            f"is set beside the table '{table}', which it would replace as a whole; give one of the two",
            path=path,
        )
        for table, content in changes.items()
        for path, model in changes.items()
        if path.endswith(".model") and path.startswith(f"{table}.")
        if _has_another_model(content, path[len(table) + 1 :].split(".")[:-1], model)
    ]


def _has_another_model(table: Any, keys: Sequence[str], model: object) -> bool:
    for key in keys:
        table = table.get(key) if isinstance(table, Mapping) else None
    return isinstance(table, Mapping) and table.get("model") != model


def place_of(table: Sequence[Any], key: str) -> int | None:
    """Return the index that a key names, or None; only decimal notation is read, so that each entry has one path."""
    known = key.isascii() and key.isdecimal() and len(key) < 10 and str(int(key)) == key
    return int(key) if known and int(key) < len(table) else None


def _put(content: dict[str, Any], path: str, value: Any, fresh: list[Any], *, strict: bool) -> Problem | None:
    *parents, last = path.split(".")
    tables: list[Any] = [content]
    for depth, key in enumerate(parents):
        new = not strict or _among(tables[-1], fresh)
        inner = _inner(
            tables[-1], key, strict=not new, optional=last == "model" and depth == len(parents) - 1
        )
        if inner is None:
            return unknown(tables[-1], ".".join(parents[:depth]), key, path)
        if new and inner == [{}]:
            fresh += inner
        tables += inner
    if not _set(tables[-1], last, value, fresh, strict=strict):
        return unknown(tables[-1], ".".join(parents), last, path)
    if last in {"file", "model", "column", "unit"} or last.endswith(("_column", "_unit")):
        _forget_samples(tables)
    return None


def _inner(table: Any, key: str, *, strict: bool, optional: bool) -> list[Any] | None:
    """Return the inner table of a key in a list, or None; an absent optional model begins as an empty table."""
    if isinstance(table, list):
        return None if (place := place_of(table, key)) is None else [table[place]]
    if not isinstance(table, dict) or (strict and key not in table):
        return None
    if key not in table or (optional and table[key] is None):
        table[key] = {}
    return [table[key]]


def _set(table: Any, key: str, value: Any, fresh: list[Any], *, strict: bool) -> bool:
    """Set an item; return whether its key exists."""
    if isinstance(table, list) and (place := place_of(table, key)) is not None:
        table[place] = _own(value, fresh)
        return True
    if not isinstance(table, dict):
        return False
    if key == "model" and (table == {} or ("model" in table and table[key] != value)):
        table.clear()
        fresh.append(table)
    elif strict and key not in table and not _among(table, fresh):
        return False
    table[key] = _own(value, fresh)
    return True


def _own(value: Any, fresh: list[Any]) -> Any:
    """Copy given tables, in which more can then be set; the originals are not changed."""
    if isinstance(value, Mapping):
        fresh.append({key: _own(item, fresh) for key, item in value.items()})
        return fresh[-1]
    return [_own(item, fresh) for item in value] if isinstance(value, (list, tuple)) else value


def _among(table: Any, tables: list[Any]) -> bool:
    return any(table is other for other in tables)


def _forget_samples(tables: list[Any]) -> None:
    """Remove numbers that were read from a file after a change of how it is read."""
    for table in tables:
        if isinstance(table, dict) and table.get("file"):
            for key in [key for key, item in table.items() if isinstance(item, Samples)]:
                del table[key]


def unknown(table: Any, where: str, key: str, path: str) -> Problem:
    """Return the problem of a path that does not exist, from the table at which it ends."""
    if isinstance(table, list):
        why = f"'{where}' has entries 0 to {len(table) - 1}"
    elif table is None:
        why = f"'{where}' is not given, so without parameters of its own; if it is a table, set it whole"
    elif not isinstance(table, dict):
        why = f"'{where}' is a single value, without parameters of its own"
    else:
        owner = f" of {table['model']}" if "model" in table else f" in '{where}'" if where else ""
        why = f"unknown parameter '{key}'{owner}.{nearest(key, table)}"
    return Problem(why, path=path)


def stored_changes(model: BaseModel, changes: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Return changes by the paths of the parameters that a model stores, and a problem for each that is refused.

    A path may end in a derived parameter; what is set within a table that is given
    along with it keeps its names, because the table has no stored values yet.
    """
    problems: list[Problem] = []
    present = {path: present_path(model, path) for path in changes}
    changes = {path if present[path] in changes else present[path]: changes[path] for path in changes}
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


def present_path(model: Any, path: str) -> str:
    """Return a dotted path with the present names of the parameters in it; former ones warn."""
    owner, keys = model, list[str]()
    for key in path.split("."):
        keys.append(type(owner).present(key) if hasattr(owner, "present") else key)
        owner = _descended(owner, keys[-1:])
    return ".".join(keys)


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


_MOST: Final = 3
_MOST_MODELS: Final = 8


def meant(model: Model, path: str) -> str:
    """Write which parameters of a model, or which other models, have what an unknown path names; empty where none has."""
    owner, _, name = path.rpartition(".")
    if owner:
        return _of_other_models(model, owner.split("."), name)
    return _with_the_word(model, name)


def explained_path(model: Model, problem: Problem) -> Problem:
    """Return the problem of an unknown path with what it may mean, in the place of a name that is only spelled similarly."""
    asked = meant(model, problem.path)
    if not asked:
        return problem
    reason = problem.reason.partition(" Did you mean ")[0]
    return Problem(f"{reason}{asked}", path=problem.path, value=problem.value)


def _with_the_word(model: Model, word: str) -> str:
    """Ask for the parameters with a word as the last part of their paths, as another part, or in their meaning."""
    given = [(path, quantity.doc) for path, value, quantity in model.parameters() if value is not None]
    found = [item for item in given if item[0].rpartition(".")[2] == word]
    if not found and closest(word, type(model).model_fields) is None:
        found = [item for item in given if word in item[0].split(".")]
        found = found or [item for item in given if word in item[1].split()]
    return question([f"'{path}' ({meaning})" for path, meaning in found[:_MOST]] if word else [])


def _of_other_models(model: Model, owner: list[str], name: str) -> str:
    """Name the members of a family that have a parameter which the chosen member does not have."""
    holder, held = _descended(model, owner[:-1]), _descended(model, owner)
    family = holder.part(owner[-1]) if hasattr(holder, "part") else None
    if family is None or not family.is_family or held is None:
        return ""
    here = {*type(held).model_fields, *type(held).derived}
    if closest(name, here):
        return ""
    others = [key for key, member in sorted(find_members(family).items()) if name in member.model_fields]
    if not others:
        return ""
    more = ", ..." if len(others) > _MOST_MODELS else ""
    return f" Models with '{name}': {', '.join(others[:_MOST_MODELS])}{more}; to take one, set {'.'.join(owner)}.model as well."
