"""A space as nested tables and as TOML, with the source of each distribution and how sure it is."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.citation import STATUSES, UNVERIFIED, status_text
from electrovib.core.errors import InputError, nearest
from electrovib.core.units import exact_text
from electrovib.scenario.distributions import Distribution, Truncated

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.scenario.space.relations import Grouping
    from electrovib.scenario.space.space import Space


CONFIDENCES: Final = ("high", "medium", "low")
"""How far the numbers of a distribution are those of the fingers meant, as the author of the space judges."""


@dataclass(frozen=True, kw_only=True)
class Origin:
    """Source of a distribution, or of the share of a group.

    `status` is one of `electrovib.core.citation.STATUSES` and `confidence` one of `CONFIDENCES`; empty where
    none is stated. `choice` is what no source gives and the author of the space has chosen. With `optional`
    the entry is omitted for a scenario without the parameter.
    """

    source: str = ""
    status: str = ""
    confidence: str = ""
    choice: str = ""
    optional: bool = False

    @property
    def is_unverified(self) -> bool:
        """Whether the numbers are cited from memory."""
        return self.status == UNVERIFIED

    @property
    def in_words(self) -> str:
        """Status, confidence, source and choice as one text."""
        parts = [status_text(self.status)] if self.status else []
        parts += [f"{self.confidence} confidence"] if self.confidence else []
        parts += [self.source] if self.source else []
        parts += [f"a choice: {self.choice}"] if self.choice else []
        return "; ".join(parts)

    def as_table(self) -> dict[str, Any]:
        """Return what is stated, as keys of the table of a distribution."""
        return {each.name: value for each in fields(self) if (value := getattr(self, each.name))}


KEYS: Final = tuple(each.name for each in fields(Origin))
"""Keys of the table of a distribution that are not numbers of the distribution."""


def read_origin(where: str, content: Mapping[str, Any]) -> Origin:
    """Read the source of a distribution from its table."""
    allowed = {"status": STATUSES, "confidence": CONFIDENCES}
    given = {name: content[name] for name in KEYS if name in content}
    for name, value in given.items():
        kind = bool if name == "optional" else str
        if not isinstance(value, kind):
            wanted = "true or false" if kind is bool else "a text"
            raise InputError(f"{where}.{name} = {value!r}: expected {wanted}")
        if value and value not in allowed.get(name, (value,)):
            raise InputError(
                f"{where}.{name} = {value}: expected one of {', '.join(allowed[name])}."
                f"{nearest(str(value), allowed[name])}"
            )
    return Origin(**given)


SCHEMA: Final = 1
"""Version of the space files that this package reads and writes."""
_FEW: Final = 5
"""Measured values that are written out in one line."""
WITHOUT_UNIT: Final = frozenset({"factor"})
"""Numbers of a distribution that are dimensionless, whatever the unit of the parameter."""


def space_table(space: Space, *, texts: bool = False) -> dict[str, Any]:
    """Write a space as nested tables; `texts` writes a number with a unit where that reads back to the same float."""
    units = space.units if texts else {}
    entries = {
        path: _written(each, units.get(path, "1")) | _origin(space, path)
        for path, each in space.distributions.items()
    }
    groups = {name: _grouping(space, name, each, units) for name, each in space.groupings.items()}
    found: dict[str, Any] = {
        "title": space.title,
        "relations": [f"{less} < {more}" for less, more in space.relations],
        "space": entries,
        "correlation": {f"{a} ~ {b}": value for (a, b), value in space.correlations.items()},
        "groups": groups,
    }
    return {"schema": SCHEMA} | {name: part for name, part in found.items() if part}


def space_lines(space: Space) -> list[str]:
    """Write distributions, correlations, relations and groups, a line each."""
    table = space_table(space, texts=True)
    lines = _entry_lines(table.get("space", {}))
    lines += [f"{pair} = {value:g}" for pair, value in table.get("correlation", {}).items()]
    lines += table.get("relations", [])
    for name, groups in table.get("groups", {}).items():
        for label, group in groups.items():
            lines.append(f"{name}: {label}, {group['share']:g} of all")
            lines += [f"  {line}" for line in _entry_lines(group["space"])]
    return lines


def _entry_lines(entries: dict[str, Any]) -> list[str]:
    shown = {path: {k: v for k, v in table.items() if k not in KEYS} for path, table in entries.items()}
    return [
        f"{path}: {', '.join(str(value) if key == 'model' else f'{key} {_short(value)}' for key, value in table.items())}"
        for path, table in shown.items()
    ]


def _short(value: Any) -> str:
    return f"({len(value)} of them)" if isinstance(value, list) and len(value) > _FEW else str(value)


def _grouping(space: Space, name: str, grouping: Grouping, units: Any) -> dict[str, Any]:
    found = {}
    for label, group in grouping.groups.items():
        where = f"groups.{name}.{label}"
        entries = {
            path: _written(each, units.get(path, "1")) | _origin(space, f"{where}.{path}")
            for path, each in group.distributions.items()
        }
        found[label] = {"share": group.share} | _origin(space, where) | {"space": entries}
    return found


def _origin(space: Space, where: str) -> dict[str, Any]:
    origin = space.origins.get(where)
    return {} if origin is None else origin.as_table()


def _written(distribution: Distribution, unit: str) -> dict[str, Any]:
    if isinstance(distribution, Truncated):
        ends = {"low": distribution.low, "high": distribution.high}
        return _written(distribution.distribution, unit) | _numbers(ends, unit)
    numbers = {each.name: getattr(distribution, each.name) for each in dataclasses.fields(distribution)}  # type: ignore[arg-type]
    return {"model": type(distribution).__name__} | _numbers(numbers, unit)


def _numbers(numbers: dict[str, Any], unit: str) -> dict[str, Any]:
    """Write the numbers that are finite; an end that is infinite is omitted."""
    found: dict[str, Any] = {}
    for name, value in numbers.items():
        own = "1" if name in WITHOUT_UNIT else unit
        if isinstance(value, tuple):
            found[name] = [exact_text(each, own) for each in value]
        elif math.isfinite(value):
            found[name] = exact_text(value, own)
    return found
