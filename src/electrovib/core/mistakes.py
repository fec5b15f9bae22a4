"""What is wrong with a table that should be a model, as sentences for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pydantic_core import InitErrorDetails, PydanticCustomError

from electrovib.core.discovery import find_members
from electrovib.core.errors import LONGEST_QUOTED, Problem, nearest, shortened
from electrovib.core.quantity import quantity_of

if TYPE_CHECKING:
    from electrovib.core.model import Model


def explained(model: type[Model], item: Any) -> InitErrorDetails:
    """Say for an unknown parameter of which class it was, and the nearest known one."""
    kind, loc, given = item["type"], item["loc"], item["input"]
    if kind == "extra_forbidden" and len(loc) == 1:
        kind, why = "unknown", _unknown(model, str(loc[0]))
    elif kind == "missing" and len(loc) == 1:
        kind, why = "missing_parameter", f"missing: {_meaning(model, str(loc[0]))}"
    else:
        why = item["msg"]
    if not loc and isinstance(given, Mapping) and model.is_member:
        given = {"model": model.__name__, **given}
    return InitErrorDetails(type=PydanticCustomError(kind, "{why}", {"why": why}), loc=loc, input=given)


def _unknown(model: type[Model], name: str) -> str:
    if name in model.former_parameters:
        return f"is the former name of '{model.former_parameters[name]}', which is given as well; remove one of the two"
    known = nearest(name, [*model.model_fields, *model.derived])
    return f"unknown parameter '{shortened(name, LONGEST_QUOTED)}' of {model.__name__}.{known}"


def _meaning(model: type[Model], field: str) -> str:
    quantity = quantity_of(model, field)
    if quantity is None:
        return model.model_fields[field].description or f"'{field}' of {model.__name__}"
    return f"{quantity.doc}, between {quantity.range()}"


def wants(model: type[Model], value: object) -> str:
    """Say how to write what stands where a table belongs; of a family, which members there are."""
    expected = (
        'expected "author_year/name" of a paper, or a table' if model.offered_by else "expected a table"
    )
    if not model.is_family:
        return f"{expected} of parameters of {model.__name__}"
    known = nearest(str(value), find_members(model))
    return f'{expected} that names a {model.__name__} model, {{ model = "..." }}.{known}'


def problem(item: Mapping[str, Any]) -> Problem:
    """Say one validation error with its dotted path and the value that stands there."""
    path = ".".join(shortened(str(part), LONGEST_QUOTED) for part in item["loc"])
    why = item["msg"].removeprefix("Value error, ")
    shows_value = item["type"] not in {"missing_parameter", "unknown"}
    return Problem(why, path=path, value=shown(item["input"]) if shows_value else "")


def shown(value: Any) -> str:
    """Write the value that an error is about, on one short line."""
    if isinstance(value, Mapping):
        named = [
            f"{key} = {shortened(repr(value[key]), LONGEST_QUOTED)}, "
            for key in ("model", "file")
            if value.get(key)
        ]
        return f"{{{''.join(named)}...}}"
    try:
        text = repr(value)
    except ValueError:  # Python writes no whole number of thousands of digits
        text = "a whole number of thousands of digits"
    return shortened(text, LONGEST_QUOTED)
