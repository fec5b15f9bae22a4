"""Dotted paths: the name of a parameter everywhere, and a model with the numbers at some of them replaced."""

from __future__ import annotations

import functools
import re
from typing import TYPE_CHECKING, Any, Final, TypeVar

from pydantic import ValidationError

from electrovib.core.errors import InputError, nearest
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.tables import (
    derived_at,
    explained_path,
    meant,
    place_of,
    present_path,
    stored_at,
    stored_changes,
    unknown,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.quantity import Quantity


def value_at(model: Model, path: str) -> Any:
    """Return what stands at a dotted path of a model: a float in SI, a text, or a nested table."""
    if (found := derived_at(model, path)) is not None:
        return getattr(*found)
    if isinstance(number := stored_at(model, path.split(".")), float):
        return number
    table: Any = model.to_dict()
    for depth, key in enumerate(parts := path.split(".")):
        if isinstance(table, dict) and key in table:
            table = table[key]
        elif isinstance(table, list) and (place := place_of(table, key)) is not None:
            table = table[place]
        elif (present := present_path(model, path)) != path:
            return value_at(model, present)
        else:
            if how := type(model).how_to_add(model.to_dict(), path):
                raise InputError(how, path=path)
            raise InputError([explained_path(model, unknown(table, ".".join(parts[:depth]), key, path))])
    return table


def quantity_at(model: Model, path: str) -> Quantity:
    """Return the declaration of the parameter at a dotted path."""
    if (found := derived_at(model, path)) is not None:
        owner, name = found
        quantity: Quantity = owner.derived[name]
        return quantity
    declared = {where: quantity for where, _, quantity in model.parameters()}
    if path not in declared and (present := present_path(model, path)) != path:
        return quantity_at(model, present)
    if path not in declared:
        how = type(model).how_to_add(model.to_dict(), path)
        asked = meant(model, path) or nearest(path, declared)
        raise InputError(how or f"no physical parameter has this path.{asked}", path=path)
    return declared[path]


_LONGEST: Final = 48
"""Longest meaning of a parameter, in letters, that names an axis."""


_HEIGHTS: Final = ("amplitude", "high", "level")
"""Parameters that say how high the voltage of a drive is."""


def words_at(model: Model | None, path: str) -> str:
    """Name the parameter at a dotted path as an axis does: ``thickness of the insulator``, ``drive voltage``.

    They are the first words of its meaning, or its own name where these are long, a number, or also those of another one
    beside it; the part follows where a parameter of another part has the same. Of what is no parameter of the model they
    are its own words, without underscores.
    """
    *before, name = path.split(".")
    try:
        quantity = quantity_at(model, path) if model is not None and before else None
    except InputError:
        quantity = None
    if model is None or quantity is None:
        return path.replace("_", " ")
    words = _first_words(path, quantity)
    others = (where for where, _, each in model.parameters() if _first_words(where, each) == words)
    parts = [where.split(".")[:-1] for where in others]
    if len(words) > _LONGEST or words[0].isdigit() or parts.count(before) > 1:
        words = f"{name} of the {before[1 if before[0] == 'stack' else 0]}".replace("_", " ")
    place = " ".join(str(int(each) + 1) if each.isdigit() else each for each in before[1:])
    return f"{words} ({place})" if place and any(part != before for part in parts) else words


def _first_words(path: str, quantity: Quantity) -> str:
    """Return the first words of a meaning, with the name of the layer; the height of a drive is the drive voltage."""
    *before, name = path.split(".")
    words = re.split(r"[;,:(]", quantity.doc)[0].strip()
    if before[:1] == ["stack"]:
        layer = f"the {before[1].replace('_', ' ')}"
        return words.replace("the layer", layer) if "the layer" in words else f"{words} of {layer}"
    return "drive voltage" if before[:1] == ["drive"] and quantity.unit == "V" and name in _HEIGHTS else words


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


M = TypeVar("M", bound=Model)


def with_numbers(model: M, numbers: Mapping[str, float]) -> M:
    """Return a valid copy with other numbers at some stored paths, as `Model.replace` does, only faster.

    A part whose parameters have ranges and no rule among each other is not validated again when the new
    numbers are in these ranges; parts without a change are shared with the original.
    """
    try:
        return _rebuilt(model, nested(numbers))
    except (ValidationError, LookupError, TypeError):
        return model.replace(numbers)  # reports what is wrong with them


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by dotted path as tables within tables."""
    tree: dict[str, Any] = {}
    for path, value in values.items():
        *parents, last = path.split(".")
        branch = tree
        for key in parents:
            branch = branch.setdefault(key, {})
        branch[last] = value
    return tree


def _rebuilt(model: M, tree: Mapping[str, Any]) -> M:
    content = dict(model)
    plain = _has_ranges_only(type(model))
    for key, change in tree.items():
        is_part = isinstance(change, dict)
        content[key] = _put(content[key], change) if is_part else change
        plain = plain and (is_part or _is_in_range(type(model), key, change))
    return _copied(model, content) if plain else type(model).model_validate(content)


@functools.cache
def _has_ranges_only(kind: type[Model]) -> bool:
    """Tell whether a model has no rules but the types and ranges of its parameters."""
    rules = kind.__pydantic_decorators__
    own = {*rules.model_validators, *rules.field_validators} - {
        *Model.__pydantic_decorators__.model_validators,
        *Model.__pydantic_decorators__.field_validators,
    }
    built = kind.complete.__func__ is Model.complete.__func__  # type: ignore[attr-defined]
    return built and not own and not kind.__private_attributes__ and "model_post_init" not in vars(kind)


def _is_in_range(kind: type[Model], name: str, value: Any) -> bool:
    """Tell whether a number is what the validation of a physical parameter would keep unchanged."""
    quantity = _declared(kind).get(name)
    is_number = type(value) is float and value != 0
    return quantity is not None and is_number and quantity.low <= value <= quantity.high


@functools.cache
def _declared(kind: type[Model]) -> dict[str, Quantity]:
    return {name: found for name in kind.model_fields if (found := quantity_of(kind, name)) is not None}


def _copied(model: M, content: dict[str, Any]) -> M:
    copy = type(model).__new__(type(model))
    object.__setattr__(copy, "__dict__", content)
    object.__setattr__(copy, "__pydantic_fields_set__", set(content))
    object.__setattr__(copy, "__pydantic_extra__", None)
    object.__setattr__(copy, "__pydantic_private__", None)
    return copy


def _put(value: Any, tree: Mapping[str, Any]) -> Any:
    if isinstance(value, tuple):
        return tuple(
            _rebuilt(item, tree[str(index)]) if str(index) in tree else item
            for index, item in enumerate(value)
        )
    return _rebuilt(value, tree)
