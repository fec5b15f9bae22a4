"""What a field of a text means: a number in any notation, a number with its unit, a reading that is missing, or words."""

from __future__ import annotations

import functools
import re
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.data.unit_words import as_unit, kind_and_factor

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

MISSING: Final = frozenset({
    "", "nan", "-nan", "n/a", "#n/a", "na", "null", "none", "inf", "-inf", "+inf", "∞", "-∞", "+∞", "ol", "-ol", "+ol",
    "1.#qnan", "-1.#ind", "1.#inf", "-1.#inf", "clipping", "overflow", "overload", "ovld", "-ovld", "+ovld", "ovfl", "over",
    "+over", "-over", "ovrflw", "overrange", "underrange", "under", "o.l", "o.l.", "#value!", "#div/0!", "#num!", "#ref!",
    "#name?", "<na>", "infinity", "-infinity", "burnout", "over range", "under range", "out of range", "\\n",
})  # fmt: skip
"""Fields, in small letters, that state no number: empty, out of the range of the instrument, or no reading."""
_SIGNS_ALONE: Final = re.compile(r"\*+|-{2,}|\+{2,}|[_.]{2,}|\?+")
ALIKE: Final = str.maketrans({
    "\u2212": "-", "\u2013": "-", "\u00a0": " ", "\u202f": " ", "\u2009": " ", "\u2019": "'",
})  # fmt: skip
"""Signs that are written for a minus, a blank, an apostrophe."""
_LONGEST: Final = 64
"""Most characters of a number; the bound keeps the matching fast."""
_UNIT: Final = re.compile(r"(.*[\d.)]) ?((?:[^\W\d_]|[°%]).{0,11})")
THOUSANDS: Final = (",", ".", " ", "'")


@functools.cache
def _form(decimal: str, thousands: str) -> re.Pattern[str]:
    """Return the pattern of a number, whose sign may stand apart."""
    whole = r"\d+"
    if thousands:
        sign = re.escape(thousands)
        whole = rf"[1-9]\d{{0,2}}(?:{sign}\d{{3}})+|[1-9]\d?(?:{sign}\d\d)+{sign}\d{{3}}|\d+"
    point = re.escape(decimal)
    return re.compile(
        rf"(?:[+-] {{0,12}})?(?:(?:{whole})(?:{point}\d*)?|{point}\d+)(?:[eEdD][+-]?\d{{1,4}})?", re.ASCII
    )


@dataclass(frozen=True, kw_only=True)
class Notation:
    """How a text writes numbers: its decimal sign, and the sign between thousands, empty if there is none."""

    decimal: str = "."
    thousands: str = ""

    @functools.lru_cache(maxsize=16_384)  # noqa: B019  # a notation is a constant
    def number(self, cell: str) -> float | None:
        """Return the number that a field states; NaN where a reading is missing, None where the field is no number."""
        if len(cell) > _LONGEST:
            return None
        if (cell.lower() in MISSING and cell != "nA") or _SIGNS_ALONE.fullmatch(cell):
            return np.nan
        cell = cell.translate(ALIKE)
        below = cell[:1] == "(" and cell[-1:] == ")"  # as accountants write negative numbers
        text = cell[1:-1] if below else cell
        if not _form(self.decimal, self.thousands).fullmatch(text) or (below and text[0] in "+-"):
            return None
        plain = text.replace(self.thousands, "") if self.thousands else text
        plain = plain.replace(" ", "").replace(self.decimal, ".").replace("D", "E").replace("d", "e")
        return -float(plain) if below else float(plain)

    def is_number(self, cell: str) -> bool:
        """Return whether a field is a number or a reading that is missing."""
        return self.number(cell) is not None

    def quantity(self, cell: str) -> tuple[float, str] | None:
        """Return the number and the unit of a field such as ``1.2 us``; None if it is none."""
        found = _UNIT.fullmatch(cell.translate(ALIKE)) if len(cell) <= _LONGEST else None
        number = self.number(found[1]) if found else None
        if found is None or number is None:
            return None
        unit = as_unit(found[2]) or (found[2] if kind_and_factor(found[2]) else "")
        return (number, unit) if unit else None


@dataclass(frozen=True, kw_only=True)
class Cells:
    """A column of fields as numbers, NaN where a reading is missing.

    - `unit`: of fields that hold one each.
    - `missing`: how often which field stands for no reading.
    - `rows`, `word`: the rows that hold words instead, and the first of these words.
    """

    values: Real
    unit: str
    missing: dict[str, int]
    rows: np.ndarray[tuple[int], np.dtype[np.intp]]
    word: str = ""


def numbers_of(column: Any, notation: Notation) -> Cells:
    """Return what the fields of a column of a table of pandas mean; one that pandas read as numbers is taken as it is."""
    import pandas as pd

    none = np.empty(0, dtype=np.intp)
    if column.dtype.kind in "fiu":
        values = column.to_numpy(dtype=float)
        bad = ~np.isfinite(values)
        endless = np.isinf(values)
        count = {"empty": int(bad.sum() - endless.sum()), "infinite": int(endless.sum())}
        if endless.any():
            values = np.where(endless, np.nan, values)
        return Cells(values=values, unit="", missing=_counted(count), rows=none)
    codes, uniques = pd.factorize(column)
    texts = [str(each).strip() for each in uniques]
    found = [_number(each, text, notation) for each, text in zip(uniques, texts, strict=True)]
    unit, found = _with_units(texts, found, notation) if None in found else ("", found)
    values = np.array([np.nan if each is None else each for each in found] + [np.nan])[codes]
    odd = np.append(np.array([each is None for each in found], dtype=bool), False)[codes]
    many = np.bincount(codes[codes >= 0], minlength=len(texts))
    missing = Counter({"empty": int((codes < 0).sum())})
    for text, each, count in zip(texts, found, many, strict=True):
        if each is not None and not np.isfinite(each):
            missing[text or "empty"] += int(count)
    rows = np.flatnonzero(odd)
    return Cells(
        values=np.where(np.isinf(values), np.nan, values),
        unit=unit,
        missing=_counted(missing),
        rows=rows,
        word=texts[codes[rows[0]]] if rows.size else "",
    )


def _number(value: Any, text: str, notation: Notation) -> float | None:
    """Return the number of a field of a column in which pandas found words in other rows."""
    if isinstance(value, (bool, np.bool_)):
        return None
    if not isinstance(value, str):
        return float(value)
    return np.nan if text == "-" else notation.number(text)


def _with_units(
    texts: list[str], found: list[float | None], notation: Notation
) -> tuple[str, list[float | None]]:
    """Return the numbers of fields that hold a unit each, all in one unit; unchanged if they are of several kinds."""
    own = [notation.quantity(text) if each is None else None for text, each in zip(texts, found, strict=True)]
    units = {each[1] for each in own if each}
    known = {unit: kind_and_factor(unit) for unit in units}
    kinds = {each[0] if each else unit for unit, each in known.items()}
    plain = (number for number, each in zip(found, own, strict=True) if not each and number is not None)
    if len(kinds) != 1 or any(number and np.isfinite(number) for number in plain):
        return "", found  # a number without a unit among others is none, unless it is 0
    if len(units) == 1:
        return units.pop(), [each[0] if each else number for each, number in zip(own, found, strict=True)]
    scaled: list[float | None] = []
    for each, number in zip(own, found, strict=True):
        factor = known[each[1]] if each else None
        scaled.append(each[0] * factor[1] if each and factor else number)
    return kinds.pop(), scaled


def _counted(count: dict[str, int]) -> dict[str, int]:
    return {word: many for word, many in count.items() if many}
