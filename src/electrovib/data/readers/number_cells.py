"""Fields of a text that are numbers, or state that there is none."""

from __future__ import annotations

import re
from typing import Final

_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?", re.ASCII)
_DECIMAL_COMMA: Final = re.compile(r"[+-]?(\d+,\d*|,\d+|\d+)([eEdD][+-]?\d+)?", re.ASCII)
_LONGEST_NUMBER: Final = 64
"""Most characters of a number; the bound keeps the matching fast."""
MISSING: Final = frozenset({
    "", "****", "--", "---", "nan", "-nan", "n/a", "#n/a", "na", "null", "inf", "-inf", "+inf", "∞", "-∞", "+∞", "ol", "-ol",
    "1.#qnan", "-1.#ind", "1.#inf", "-1.#inf", "9.91e37", "clipping", "overflow", "overload", "ovld", "-ovld", "+ovld", "ovfl",
    "ovrflw", "overrange", "underrange", "o.l", "o.l.", "#value!", "#div/0!", "#num!", "#ref!",
})  # fmt: skip
"""Fields, in small letters, that state no number: empty, out of the range of the instrument, or no reading."""


def is_number(cell: str, *, decimal_comma: bool) -> bool:
    """Return whether a field is a number."""
    if len(cell) > _LONGEST_NUMBER:
        return False
    form = _DECIMAL_COMMA if decimal_comma else _NUMBER
    return bool(form.fullmatch(cell)) or (bool(cell) and cell.lower() in MISSING)
