"""Dotted paths: one name for a parameter in files, options, sliders, fits and messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError, Problem, nearest
from electrovib.core.model import Model, quantity_of
from electrovib.core.samples import Samples

if TYPE_CHECKING:
    from collections.abc import Iterator

    from electrovib.core.quantity import Quantity


def replaced(model: Model, changes: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Put changes into the nested tables of a model; the result is not yet validated.

    Parameters
    ----------
    model : Model
        What to start from.
    changes : mapping of str to value
        Dotted path to new value.

    Returns
    -------
    content : dict
        Nested tables.
    problems : list of Problem
        One for each path that does not exist.
    """
    content = model.to_dict()
    return content, put(content, changes)


def put(content: dict[str, Any], changes: Mapping[str, Any], *, strict: bool = True) -> list[Problem]:
    """Put changes into nested tables in place.

    Parameters
    ----------
    content : dict
        Nested tables.
    changes : mapping of str to value
        Dotted path to new value. A table comes before what is set in it, which then counts. A new ``model`` comes first
        and takes nothing over from the former one, so its own parameters can be given along with it.
    strict : bool
        Refuse paths that are not there; else trust that validation follows, and make what is missing.

    Returns
    -------
    list of Problem
        One for each path that does not exist, and each table that would be dropped.
    """
    ordered = sorted(changes, key=lambda path: (path.count("."), not path.endswith(".model")))
    fresh: list[Any] = []
    problems = [_put(content, path, changes[path], fresh, strict=strict) for path in ordered]
    return _dropped(changes) + [problem for problem in problems if problem]


def _dropped(changes: Mapping[str, Any]) -> list[Problem]:
    """Say which tables would be dropped whole, because another model is set in their place."""
    return [
        Problem(
            f"is set beside the table '{table}', of which nothing would then count; give one of the two",
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


def _place(table: Sequence[Any], key: str) -> int | None:
    """Read the number of an entry; only as it is usually written, so that each has one path."""
    known = key.isascii() and key.isdecimal() and len(key) < 10 and str(int(key)) == key
    return int(key) if known and int(key) < len(table) else None


def _put(content: dict[str, Any], path: str, value: Any, fresh: list[Any], *, strict: bool) -> Problem | None:
    *parents, last = path.split(".")
    tables: list[Any] = [content]
    for depth, key in enumerate(parents):
        inner = _inner(tables[-1], key, strict=strict, optional=last == "model" and depth == len(parents) - 1)
        if inner is None:
            return _unknown(tables[-1], ".".join(parents[:depth]), key, path)
        tables += inner
    if not _set(tables[-1], last, value, fresh, strict=strict):
        return _unknown(tables[-1], ".".join(parents), last, path)
    if last in {"file", "model", "column", "unit"} or last.endswith(("_column", "_unit")):
        _forget_samples(tables)
    return None


def _inner(table: Any, key: str, *, strict: bool, optional: bool) -> list[Any] | None:
    """Step into a table; an optional model that is absent so far begins as an empty one."""
    if isinstance(table, list):
        return None if (place := _place(table, key)) is None else [table[place]]
    if not isinstance(table, dict) or (strict and key not in table):
        return None
    if key not in table or (optional and table[key] is None):
        table[key] = {}
    return [table[key]]


def _set(table: Any, key: str, value: Any, fresh: list[Any], *, strict: bool) -> bool:
    """Set an item; tell whether there is such a place."""
    if isinstance(table, list):
        if (place := _place(table, key)) is None:
            return False
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
    """Copy given tables, in which more can then be set; what was given stays as it is."""
    if isinstance(value, Mapping):
        fresh.append({key: _own(item, fresh) for key, item in value.items()})
        return fresh[-1]
    return [_own(item, fresh) for item in value] if isinstance(value, (list, tuple)) else value


def _among(table: Any, tables: list[Any]) -> bool:
    return any(table is other for other in tables)


def _forget_samples(tables: list[Any]) -> None:
    """Numbers that were read from a file must not survive a change of how it is read."""
    for table in tables:
        if isinstance(table, dict) and table.get("file"):
            for key in [key for key, item in table.items() if isinstance(item, Samples)]:
                del table[key]


def _unknown(table: Any, where: str, key: str, path: str) -> Problem:
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


def value_at(model: Model, path: str) -> Any:
    """Look a dotted path up.

    Parameters
    ----------
    model : Model
        Where to look.
    path : str
        Dotted path.

    Returns
    -------
    object
        A float in SI, a text, a nested table.

    Raises
    ------
    InputError
        If there is no such path; the message has the nearest name.
    """
    table: Any = model.to_dict()
    for depth, key in enumerate(parts := path.split(".")):
        if isinstance(table, dict) and key in table:
            table = table[key]
        elif isinstance(table, list) and (place := _place(table, key)) is not None:
            table = table[place]
        else:
            raise InputError([_unknown(table, ".".join(parts[:depth]), key, path)])
    return table


def quantity_at(model: Model, path: str) -> Quantity:
    """Find the declaration of the parameter at a dotted path.

    Raises
    ------
    InputError
        If the path names no physical parameter.
    """
    declared = {where: quantity for where, _, quantity in walk_parameters(model)}
    if path not in declared:
        raise InputError(f"no physical parameter has this path.{nearest(path, declared)}", path=path)
    return declared[path]


def walk_parameters(model: Model, prefix: str = "") -> Iterator[tuple[str, float | None, Quantity]]:
    """Walk over all physical parameters of a tree of models, in the order of the file.

    Yields
    ------
    tuple
        Dotted path, value in SI (None where it is optional and absent), declaration.
    """
    for name, value in model:
        path = f"{prefix}{name}"
        quantity = quantity_of(type(model), name) if name in type(model).model_fields else None
        if quantity is not None:
            yield path, value, quantity
        elif isinstance(value, Model):
            yield from walk_parameters(value, f"{path}.")
        elif isinstance(value, tuple):
            for index, item in enumerate(value):
                if isinstance(item, Model):
                    yield from walk_parameters(item, f"{path}.{index}.")
