"""Messages about a table that cannot be read as a model."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from electrovib.core.discovery import find_members
from electrovib.core.errors import LONGEST_QUOTED, InputError, Problem, nearest, shortened
from electrovib.core.quantity import quantity_of
from electrovib.core.search import near

if TYPE_CHECKING:
    from electrovib.core.model import Model

B = TypeVar("B", bound=BaseModel)
MOST_NAMES: Final = 12
"""Names that are listed in one sentence."""


def explained(model: type[Model], item: Any) -> InitErrorDetails:
    """Rewrite a validation error: of an unknown parameter with its class and the nearest known name."""
    kind, loc, given = item["type"], item["loc"], item["input"]
    if kind == "extra_forbidden" and len(loc) == 1:
        kind, why = "unknown", _unknown(model, str(loc[0]))
    elif kind == "missing" and len(loc) == 1:
        kind, why = "missing_parameter", f"missing: {_meaning(model, str(loc[0]))}"
    else:
        why = item["msg"].removeprefix("Value error, ")
    if not loc and isinstance(given, Mapping) and model.is_member:
        given = {"model": model.__name__, **given}
    return InitErrorDetails(type=PydanticCustomError(kind, "{why}", {"why": why}), loc=loc, input=given)


def _unknown(model: type[Model], name: str) -> str:
    known = nearest(name, [*model.model_fields, *model.derived])
    return f"unknown parameter '{shortened(name, LONGEST_QUOTED)}' of {model.__name__}.{known}"


def _meaning(model: type[Model], field: str) -> str:
    quantity = quantity_of(model, field)
    if quantity is None:
        return model.model_fields[field].description or f"'{field}' of {model.__name__}"
    return f"{quantity.doc}, between {quantity.range()}"


def wants(model: type[Model], value: object) -> str:
    """Write what is expected in the place of a table; of a family, with the nearest members."""
    expected = (
        'expected "author_year/name" of a paper, or a table' if model.offered_by else "expected a table"
    )
    if not model.is_family:
        return f"{expected} of parameters of {model.__name__}{model.how_to_omit}"
    return f'{expected} that names a {model.__name__} model, {{ model = "..." }}.{near_members(model, str(value))}'


def near_members(family: type[Model], name: str) -> str:
    """Ask for the three members of a family that a wrong name is most like, with what each is; else list all."""
    meanings = {key: first_line(member) for key, member in find_members(family).items()}
    return near(name, meanings, kind=family.__name__)


def first_line(thing: object) -> str:
    """Return the first line of a docstring, without its full stop."""
    text = (inspect.getdoc(thing) or "").strip()
    return " ".join(text.split("\n\n")[0].split()).rstrip(".")


def problems(items: Iterable[Mapping[str, Any]]) -> list[Problem]:
    """Convert validation errors; names that one table has, or lacks, for the same reason are one `Problem`."""
    found: dict[object, list[tuple[Problem, str]]] = {}
    for item in items:
        each, name = problem(item), shortened(str((item["loc"] or ("",))[-1]), LONGEST_QUOTED)
        alike = item["type"] in {"missing_parameter", "unknown"} and f"'{name}'" in each.reason
        same = (item["loc"][:-1], each.reason.replace(f"'{name}'", "", 1)) if alike else len(found)
        found.setdefault(same, []).append((each, name))
    return [_together(each) if len(each) > 1 else each[0][0] for each in found.values()]


def _together(alike: list[tuple[Problem, str]]) -> Problem:
    """Write as one problem those that differ in a name alone."""
    (first, name), rest = alike[0], len(alike) - MOST_NAMES
    listed = ", ".join(f"'{each}'" for _, each in alike[:MOST_NAMES])
    listed += f" and {rest} more" if rest > 0 else ""
    why = first.reason.replace(f"parameter '{name}'", f"parameters '{name}'", 1)
    why = why.replace(f"'{name}'", listed, 1)
    return Problem(why, path=first.path.rpartition(".")[0])


def problem(item: Mapping[str, Any]) -> Problem:
    """Convert a validation error to a `Problem` with its dotted path and value."""
    path = ".".join(shortened(str(part), LONGEST_QUOTED) for part in item["loc"])
    why = item["msg"].removeprefix("Value error, ")
    shows_value = item["type"] not in {"missing_parameter", "unknown"}
    return Problem(why, path=path, value=shown(item["input"]) if shows_value else "")


def shown(value: Any) -> str:
    """Write the value of an error on one short line."""
    if isinstance(value, Mapping):
        held = {key: value[key] for key in ("model", "file") if value.get(key)}
        named = (f"{key} = {shortened(repr(each), LONGEST_QUOTED)}, " for key, each in held.items())
        return f"{{{''.join(named)}...}}"
    try:
        text = repr(value)
    except ValueError:  # Python writes no whole number of thousands of digits
        text = "a whole number of thousands of digits"
    return shortened(text, LONGEST_QUOTED)


_EXPECTED: Final = {
    "string_type": "expected a text",
    "dict_type": "expected a table",
    "list_type": "expected a list of names",
    "tuple_type": "expected a list",
}
"""What is expected where a validation error is of this type."""


def read_entries(kind: type[B], content: object, *, of: str, beside: object = None) -> B:
    """Read the tables of a file by their declaration and list every mistake at once.

    `of` says of what they are the entries; `beside` is what a validator of the declaration gets as its context.
    """
    try:
        return kind.model_validate(content, context=beside)
    except ValidationError as error:
        raise InputError(entry_problem(kind, each, of) for each in error.errors(include_url=False)) from None


def entry_problem(kind: type[BaseModel], item: Mapping[str, Any], of: str) -> Problem:
    """Convert a validation error of entries, with the nearest name, or an example of what is missing."""
    loc, why = item["loc"], _EXPECTED.get(item["type"], item["msg"])
    path, name = ".".join(map(str, loc)), str(loc[-1]) if loc else ""
    if item["type"] == "extra_forbidden":
        known = (field.alias or each for each, field in kind.model_fields.items()) if len(loc) == 1 else ()
        return Problem(f"no entry of {of}.{nearest(name, known)}", path=path)
    if item["type"] == "missing":
        field = kind.model_fields.get(name)
        examples = " or ".join(map(json.dumps, (field and field.examples) or ()))
        why = f"missing, for instance {name} = {examples}" if examples else "missing"
    return Problem(
        why, path=path, value="" if item["type"] in {"missing", "needed"} else shown(item["input"])
    )
