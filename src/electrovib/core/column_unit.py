"""The unit of a column of a file, as a scenario states it."""

from __future__ import annotations

import functools

from pydantic import AfterValidator
from pydantic_core import PydanticCustomError

from electrovib.core.units import KINDS, parse_quantity


def column_unit(kind: str) -> AfterValidator:
    """Declare that a text has to be a unit of a given kind, for instance ``"us"`` for ``"s"``."""
    return AfterValidator(functools.partial(_checked, kind))


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


def _checked(kind: str, text: str) -> str:
    if not is_unit_of(kind, text):
        what = "no unit" if kind == "1" else KINDS[kind][0]
        why = f"the column holds {what}: expected a unit such as '{kind}'"
        raise PydanticCustomError("unit", "{why}", {"why": why})
    return text
