"""The declaration of a physical parameter: unit, range, meaning; and the unit of a column of a file."""

from __future__ import annotations

import functools
import math
import numbers
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, get_args

from pydantic import AfterValidator, Field
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from electrovib.core.units import KINDS, expected, format_quantity, parse_quantity

if TYPE_CHECKING:
    from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.fields import FieldInfo


def column_unit(kind: str) -> AfterValidator:
    """Declare that a text has to be a unit of a given kind, for instance ``"us"`` for ``"s"``."""
    return AfterValidator(functools.partial(_checked, kind))


ColumnName: TypeAlias = Annotated[str | int, Field(description="name or number of the column")]
"""Parameter that names a column of a file."""


def is_unit_of(kind: str, text: object) -> bool:
    """Return whether a text is a unit of a kind, with or without a prefix; ``"1"`` and ``"-"`` stand for no unit."""
    if kind == "1" and text in ("1", "-"):
        return True
    if not isinstance(text, str) or not text.strip() or text.strip()[0].isdigit():
        return False
    try:
        parse_quantity(f"1 {text}", kind)
    except ValueError:
        return False
    return True


def takes_unit(field: FieldInfo, text: object) -> bool:
    """Return whether a parameter that is a `column_unit` takes a text."""
    declared = (each.func for each in field.metadata if isinstance(each, AfterValidator))
    return all(is_unit_of(each.args[0], text) for each in declared if isinstance(each, functools.partial))


def _checked(kind: str, text: str) -> str:
    if not is_unit_of(kind, text):
        what = "no unit" if kind == "1" else KINDS[kind][0]
        why = f"the column holds {what}: expected a unit such as '{kind}'"
        raise PydanticCustomError("unit", "{why}", {"why": why})
    return text


Number: TypeAlias = float
"""A physical parameter: a finite float in SI."""


@dataclass(frozen=True)
class Quantity:
    """Unit, inclusive range and meaning of one physical parameter.

    `unit` is one of `electrovib.core.units.KINDS`, ``"1"`` for a pure number; `low` and `high` are finite, in
    that unit. `source` is that of the default; empty without a default, or where it is 0.
    """

    unit: str
    low: float
    high: float
    doc: str
    source: str = ""

    def __post_init__(self) -> None:
        if self.unit not in KINDS:
            msg = f"unit {self.unit!r} of '{self.doc}' is not one of {', '.join(KINDS)}"
            raise TypeError(msg)
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low <= self.high):
            msg = f"range of '{self.doc}' must be finite, low first: {self.low} to {self.high}"
            raise TypeError(msg)
        if not self.doc.strip():
            msg = f"a parameter in {self.unit} needs a meaning"
            raise TypeError(msg)

    def read(self, value: object) -> float:
        """Convert a text or a number to a float in SI within the range."""
        given = value
        if isinstance(value, str):
            try:
                value = parse_quantity(value, self.unit)
            except ValueError as error:
                raise PydanticCustomError("quantity", "{why}", {"why": str(error)}) from None
        if isinstance(value, bool) or not isinstance(value, numbers.Real):
            raise PydanticCustomError("quantity", "{why}", {"why": expected(self.unit)})
        try:
            number = float(value) + 0.0  # one zero, not two
        except OverflowError:  # a whole number of hundreds of digits
            number = math.inf
        if not math.isfinite(number):
            why = f"must be a finite number; {expected(self.unit)}"
            raise PydanticCustomError("quantity", "{why}", {"why": why})
        if not self.low <= number <= self.high:
            why = f"{self._in_si(given, number)}must lie between {self.range()}"
            raise PydanticCustomError("quantity", "{why}", {"why": why})
        return number

    def _in_si(self, given: object, number: float) -> str:
        """Say what a number without a unit was taken for; nothing where a unit was given, or there is none."""
        letters = given.lower().replace("e", "") if isinstance(given, str) else ""
        if self.unit == "1" or number == 0 or any(map(str.isalpha, letters)):
            return ""
        return f"a number without a unit is in SI, so this is {number:g} {self.unit}; "

    def range(self, between: str = " and ") -> str:
        """Write the range as text, with a word between its ends."""
        return f"{format_quantity(self.low, self.unit)}{between}{format_quantity(self.high, self.unit)}"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Validate with `read`; None is kept where the type of the field allows it."""
        del handler
        schema = core_schema.no_info_plain_validator_function(self.read)
        return core_schema.nullable_schema(schema) if type(None) in get_args(source) else schema

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Describe the parameter for user interfaces and documents."""
        del schema, handler
        return {
            "type": "number",
            "unit": self.unit,
            "minimum": self.low,
            "maximum": self.high,
            "description": self.doc,
        }


def quantity_of(model: type[BaseModel], field: str) -> Quantity | None:
    """Return the declaration of a field; None if it is no physical parameter."""
    declared = model.model_fields.get(field)
    return next((m for m in declared.metadata if isinstance(m, Quantity)), None) if declared else None
