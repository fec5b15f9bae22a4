"""Dotted paths: the name of a parameter in files, options, fits and messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError, nearest
from electrovib.core.meant import explained, meant
from electrovib.core.tables import derived_at, number_at, place_of, stored_changes, unknown

if TYPE_CHECKING:
    from electrovib.core.model import Model
    from electrovib.core.quantity import Quantity


def value_at(model: Model, path: str) -> Any:
    """Return what stands at a dotted path of a model: a float in SI, a text, or a nested table."""
    if (found := derived_at(model, path)) is not None:
        return getattr(*found)
    if (number := number_at(model, path)) is not None:
        return number
    table: Any = model.to_dict()
    for depth, key in enumerate(parts := path.split(".")):
        if isinstance(table, dict) and key in table:
            table = table[key]
        elif isinstance(table, list) and (place := place_of(table, key)) is not None:
            table = table[place]
        else:
            if how := type(model).how_to_add(model.to_dict(), path):
                raise InputError(how, path=path)
            raise InputError([explained(model, unknown(table, ".".join(parts[:depth]), key, path))])
    return table


def quantity_at(model: Model, path: str) -> Quantity:
    """Return the declaration of the parameter at a dotted path."""
    if (found := derived_at(model, path)) is not None:
        owner, name = found
        quantity: Quantity = owner.derived[name]
        return quantity
    declared = {where: quantity for where, _, quantity in model.parameters()}
    if path not in declared:
        how = type(model).how_to_add(model.to_dict(), path)
        asked = meant(model, path) or nearest(path, declared)
        raise InputError(how or f"no physical parameter has this path.{asked}", path=path)
    return declared[path]


def followers(model: Model, path: str) -> list[str]:
    """Find the stored parameters, without itself, that change when the one at a path alone is changed."""
    try:
        value = value_at(model, path)
    except InputError:
        return []
    if not isinstance(value, float):
        return []
    stored, _ = stored_changes(model, {path: 0.9 * value or 1.0})
    return [each for each, new in stored.items() if each != path and value_at(model, each) != new]
