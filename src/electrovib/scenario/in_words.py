"""A tree of models in a few lines of plain text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples
from electrovib.core.units import format_quantity

if TYPE_CHECKING:
    from collections.abc import Iterator


def lines_of(model: Model) -> Iterator[str]:
    """Write the parts of a model that are not the default, one line each; of a stack one line for each layer."""
    fields = type(model).model_fields
    for name, value in model:
        if not isinstance(value, Model) or (name in fields and fields[name].default == value):
            continue
        layers = getattr(value, "layers", None)
        if isinstance(layers, dict):
            yield from (f"{name}.{layer}: {in_words(part)}" for layer, part in layers.items())
        else:
            yield f"{name}: {in_words(value)}"


def in_words(model: Model) -> str:
    """Write a model in one line, its parameters that are not the default: ``Trapezium(high = 100 V, rise = 1 ms)``."""
    kind = type(model)
    given = []
    for name, value in model:
        field = kind.model_fields.get(name)
        if value is None or (field is not None and field.default == value):
            continue
        quantity = quantity_of(kind, name) if field is not None else None
        given.append(
            f"{name} = {format_quantity(value, quantity.unit, digits=4) if quantity else _text(value)}"
        )
    return f"{kind.__name__}({', '.join(given)})"


def _text(value: Any) -> str:
    if isinstance(value, Model):
        return in_words(value)
    if isinstance(value, Samples):
        return str(value)
    if isinstance(value, tuple):
        return f"({', '.join(map(_text, value))})"
    return repr(value) if isinstance(value, str) else str(value)
