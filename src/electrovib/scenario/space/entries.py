"""Distributions from tables of a TOML file, in the unit of their parameter."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError, nearest
from electrovib.core.files import note_input
from electrovib.core.units import format_quantity, parse_quantity
from electrovib.data.columns import read_columns
from electrovib.scenario.distributions import Distribution, Empirical, Normal, Truncated
from electrovib.scenario.space.origin import KEYS
from electrovib.scenario.space.writing import WITHOUT_UNIT

if TYPE_CHECKING:
    from electrovib.core.quantity import Quantity

LARGEST_OUTSIDE: Final = 1e-12
"""Probability of values outside the range of a parameter that is allowed; a study has fewer draws."""
_KINDS: Final[dict[str, type[Distribution]]] = {
    kind.__name__: kind for kind in Distribution.__subclasses__() if kind is not Truncated
}
_ENDS: Final = ("low", "high")
_FILE: Final = ("file", "column")


def read_distribution(path: str, content: Any, quantity: Quantity, *, folder: Path) -> Distribution:
    """Read the table of one distribution, ``{ model = "Normal", mean = "5 um", deviation = "1 um" }``.

    ``low`` and ``high`` truncate any distribution, and a number alone is that value for every draw. All
    values, but for a negligible share, have to be within the range of the parameter. Keys of the source are
    not read here.
    """
    if isinstance(content, (int, float, str)) and not isinstance(content, bool):
        content = {"model": "Empirical", "values": [content]}
    kind = _kind(path, content)
    names = [each.name for each in dataclasses.fields(kind)]  # type: ignore[arg-type]
    known = list(dict.fromkeys([*names, *_ENDS, *(_FILE if kind is Empirical else ())]))
    given = {name: value for name, value in content.items() if name not in {"model", *KEYS}}
    foreign = [name for name in given if name not in known]
    if foreign:
        raise InputError(
            f"{path}.{foreign[0]}: unknown parameter of {kind.__name__}.{nearest(foreign[0], known)}"
        )
    if "file" in given:
        given = _with_measured(path, given, quantity, folder)
    numbers = {
        name: _number(f"{path}.{name}", value, "1" if name in WITHOUT_UNIT else quantity.unit)
        for name, value in given.items()
    }
    try:
        found = _built(kind, numbers, names)
    except TypeError:
        missing = [name for name in names if name not in numbers]
        raise InputError(f"{path}.{missing[0]}: missing parameter of {kind.__name__}") from None
    except InputError as error:
        raise InputError(f"{path}: {problem}" for problem in error.problems) from None
    return _within(path, found, quantity)


def _kind(path: str, content: Any) -> type[Distribution]:
    name = content.get("model") if isinstance(content, Mapping) else content
    if not isinstance(content, Mapping) or name not in _KINDS:
        raise InputError(
            f"{path}: expected a table with the model of a distribution.{nearest(str(name), _KINDS)}"
        )
    return _KINDS[str(name)]


def _built(kind: type[Distribution], numbers: dict[str, Any], names: list[str]) -> Distribution:
    """Build a distribution, truncated at ends that are not parameters of its own."""
    found = kind(**{name: value for name, value in numbers.items() if name in names})
    ends = {name: value for name, value in numbers.items() if name not in names}
    if not ends:
        return found
    return found.truncated(ends.get("low", -math.inf), ends.get("high", math.inf))


def _with_measured(path: str, given: dict[str, Any], quantity: Quantity, folder: Path) -> dict[str, Any]:
    """Replace the name of a file by the values of its column."""
    if "values" in given:
        raise InputError(f"{path}.values: given in the table and in a file; omit one of them")
    column = given.get("column", 0)
    if isinstance(column, bool) or not isinstance(column, (int, str)):
        raise InputError(
            f"{path}.column = {column!r}: expected the heading of a column, or its number from 0"
        )
    file = folder / str(given["file"])
    note_input(file)
    values = read_columns(file, {"values": (column, quantity.unit)})["values"]
    return {name: each for name, each in given.items() if name not in _FILE} | {"values": values.tolist()}


def _within(path: str, found: Distribution, quantity: Quantity) -> Distribution:
    """Refuse values outside the range of a parameter, with the ends that keep them inside."""
    if isinstance(found, Normal) and found.low == 0 < quantity.low:  # positive, as a fit writes it
        found = found.truncated(quantity.low, math.inf)
    outside = {
        "low": (found.share(math.nextafter(quantity.low, -math.inf)), quantity.low),
        "high": (found.share_above(quantity.high), quantity.high),
    }
    wrong = {name: pair for name, pair in outside.items() if pair[0] > LARGEST_OUTSIDE}
    if not wrong:
        return found
    share = sum(pair[0] for pair in wrong.values())
    ends = " and ".join(
        f"{name} = '{format_quantity(end, quantity.unit)}'" for name, (_, end) in wrong.items()
    )
    raise InputError(
        f"{path}: a share of {share:.2g} of the values is outside the range of this parameter, allowed is"
        f" {quantity.range()}; truncate the distribution, with {ends} at most"
    )


def _number(path: str, value: Any, unit: str) -> Any:
    if isinstance(value, (list, tuple)):
        return tuple(_number(path, each, unit) for each in value)
    if isinstance(value, str):
        try:
            return parse_quantity(value, unit)
        except ValueError as error:
            raise InputError(f"{path} = {value}: {error}") from None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"{path} = {value!r}: expected a finite number, or a text with a unit")
    return float(value)
