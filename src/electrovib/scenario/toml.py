"""A scenario as a commented TOML file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from electrovib.core.discovery import find_members
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples
from electrovib.core.units import exact_text

if TYPE_CHECKING:
    from electrovib.scenario.experiment import Scenario

SCHEMA: Final = 1
"""Version of the scenario files that this package reads and writes."""


def to_toml(scenario: Scenario) -> str:
    """Write a scenario as TOML with the meaning of every parameter; it reads back equal."""
    import tomlkit
    from tomlkit.items import KeyType, SingleKey

    document = tomlkit.document()
    document.add("schema", tomlkit.item(SCHEMA))
    if scenario.title:
        document.add("title", tomlkit.item(scenario.title))
    for name, value in scenario:
        if isinstance(value, Model):
            document.add(name, model_table(value))
    if scenario.sources:
        sources = tomlkit.table()
        for path, text in scenario.sources.items():
            sources.add(SingleKey(path, t=KeyType.Basic), tomlkit.item(text))
        document.add("sources", sources)
    return tomlkit.dumps(document)


def model_table(model: Model) -> Any:
    """Return a model as a table of TOML, each number with its unit where it reads back exactly."""
    import tomlkit

    table = tomlkit.table()
    if model.is_member:
        table.add("model", tomlkit.item(type(model).__name__))
    nested = []
    for name, value in model:
        if value is None or (isinstance(value, Samples) and getattr(model, "file", None)):
            continue
        if isinstance(value, Model):
            nested.append((name, value))
            continue
        item = tomlkit.item(_written(model, name, value))
        meaning = _meaning(model, name)
        if meaning and "\n" not in tomlkit.dumps({name: item}).strip():
            item.comment(meaning)
        table.add(name, item)
    for name, value in nested:
        table.add(name, model_table(value))
    return table


def _meaning(model: Model, name: str) -> str:
    quantity = quantity_of(type(model), name)
    if quantity is not None:
        return quantity.doc
    field = type(model).model_fields.get(name)
    return (field.description or "") if field is not None else ""


def left_away(model: Model, prefix: str = "") -> dict[str, str]:
    """Find the optional parts that a tree of models does not have, by path, and what can be added there."""
    found: dict[str, str] = {}
    for name, value in model:
        kind = type(model).part(name)
        if value is None and kind is not None:
            names = sorted(find_members(kind)) if kind.is_family else list(kind.model_fields)
            found[f"{prefix}{name}"] = ("one of " if kind.is_family else "") + ", ".join(names)
    for name, value in model:
        if isinstance(value, Model):
            found |= left_away(value, f"{prefix}{name}.")
    return found


def _written(model: Model, name: str, value: Any) -> Any:
    quantity = quantity_of(type(model), name)
    if quantity is not None:
        return exact_text(value, quantity.unit)
    if isinstance(value, tuple):
        return [_inline(item) if isinstance(item, Model) else item for item in value]
    return value.packed() if isinstance(value, Samples) else value


def _inline(model: Model) -> Any:
    import tomlkit

    table = tomlkit.inline_table()
    if model.is_member:
        table.add("model", type(model).__name__)
    for name, value in model:
        if value is None:
            continue
        table.add(name, _inline(value) if isinstance(value, Model) else _written(model, name, value))
    return table
