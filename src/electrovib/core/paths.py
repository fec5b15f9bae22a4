"""Dotted paths: one name for a parameter in files, options, sliders, fits and messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError, nearest
from electrovib.core.model import Model, quantity_of
from electrovib.core.samples import Samples

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from electrovib.core.quantity import Quantity


def replaced(model: Model, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Put changes into the nested tables of a model; the result is not yet validated.

    Parameters
    ----------
    model : Model
        What to start from.
    changes : mapping of str to value
        Dotted path to new value.

    Returns
    -------
    dict
        Nested tables.

    Raises
    ------
    InputError
        For every path that does not exist.
    """
    content = model.to_dict()
    problems = [problem for path, value in changes.items() if (problem := _put(content, path, value))]
    if problems:
        raise InputError(problems)
    return content


def _put(content: dict[str, Any], path: str, value: Any) -> str | None:
    *parents, last = path.split(".")
    table: Any = content
    for depth, key in enumerate(parents):
        if isinstance(table, list) and key.isdigit() and int(key) < len(table):
            table = table[int(key)]
        elif isinstance(table, dict) and key in table and table[key] is not None:
            table = table[key]
        else:
            return _unknown(table, ".".join(parents[:depth]), key, path)
    if isinstance(table, list) and last.isdigit() and int(last) < len(table):
        table[int(last)] = value
    elif not isinstance(table, dict) or last not in table:
        return _unknown(table, ".".join(parents), last, path)
    elif last == "model" and table[last] != value:
        # another model has other parameters: keep none but the name, so nothing is carried over silently
        table.clear()
        table["model"] = value
    else:
        table[last] = value
        if last == "file":  # numbers of the former file must not survive it
            for key in [key for key, item in table.items() if isinstance(item, Samples)]:
                del table[key]
    return None


def _unknown(table: Any, where: str, key: str, path: str) -> str:
    known = nearest(key, table) if isinstance(table, dict) else ""
    place = f" in '{where}'" if where else ""
    return f"{path}: no parameter '{key}'{place}.{known}"


def value_at(model: Model, path: str) -> Any:
    """Look a dotted path up; raise InputError when there is none.

    Returns
    -------
    object
        A float in SI, a text, a nested table.
    """
    table: Any = model.to_dict()
    for depth, key in enumerate(parts := path.split(".")):
        if isinstance(table, dict) and key in table:
            table = table[key]
        elif isinstance(table, list) and key.isdigit() and int(key) < len(table):
            table = table[int(key)]
        else:
            raise InputError(_unknown(table, ".".join(parts[:depth]), key, path))
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
        raise InputError(f"{path}: no physical parameter has this path.{nearest(path, declared)}")
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
