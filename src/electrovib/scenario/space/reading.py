"""Spaces from TOML files, tables and the populations that the package ships."""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import LONGEST_QUOTED, InputError, gathered, nearest, shortened
from electrovib.core.files import kind_of, note_input
from electrovib.core.parsing import read_toml_file
from electrovib.core.paths import quantity_at
from electrovib.core.units import format_quantity, parse_quantity
from electrovib.scenario.distributions import Distribution, Empirical, Normal, Truncated
from electrovib.scenario.reading import Source, read_scenario
from electrovib.scenario.space.relations import Group, Grouping, check_relations
from electrovib.scenario.space.shipped import read_shipped, shipped_names
from electrovib.scenario.space.space import Space
from electrovib.scenario.space.writing import KEYS, SCHEMA, WITHOUT_UNIT, Origin, read_origin

if TYPE_CHECKING:
    from electrovib.core.quantity import Quantity
    from electrovib.scenario.experiment import Scenario

SpaceSource: TypeAlias = "str | Path | Mapping[str, Any] | Space"
"""Anything that a space can be read from."""


def read_space(scenario: Source, source: SpaceSource) -> Space:
    """Read a space of the parameters of a scenario: their probability distributions.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Scenario that has the parameters, as for `electrovib.load`.
    source : str, Path, mapping or Space
        A TOML file with the tables ``space``, ``correlation``, ``groups`` and the list ``relations``; the same as nested
        tables, or the table ``space`` alone; the name of a shipped population such as ``"fingers"``; or a Space.

    Returns
    -------
    space : Space
        Distributions in SI, all within the ranges of the parameters.

    Raises
    ------
    InputError
        Every mistake at once.

    Notes
    -----
    An entry is ``"PATH" = { model = "Normal", mean = "5 um", deviation = "1 um", low = "1 um" }``, numbers in SI and texts
    with a unit; the models are Normal, LogNormal (median, factor), Uniform, LogUniform, Triangular (low, likely, high) and
    Empirical (values, or file and column), and ``low`` and ``high`` truncate any of them. ``"PATH ~ PATH" = 0.5`` in
    ``correlation`` is the coefficient of a Gaussian copula, ``"PATH < PATH"`` a relation.

    Examples
    --------
    >>> space = ev.read_space("bau_2010/sine", {"stack.gap.thickness": {"model": "LogNormal", "median": "3 um", "factor": 2}})
    >>> space.draw(1, 0, 2)["stack.gap.thickness"].round(8)
    array([1.32e-06, 5.54e-06])
    """
    found = read_scenario(scenario)
    if isinstance(source, Space):
        read = read_space(found, source.as_table())
        return dataclasses.replace(read, omitted={**source.omitted, **read.omitted})
    tables, folder = tables_of(source)
    return _Reading(found, folder).space(tables)


class _Reading:
    """The reading of one space: collects mistakes, sources and entries that are omitted."""

    def __init__(self, scenario: Scenario, folder: Path) -> None:
        self.scenario, self.folder = scenario, folder
        self.problems: list[str] = []
        self.origins: dict[str, Origin] = {}
        self.units: dict[str, str] = {}
        self.omitted: dict[str, str] = {}
        self.optional: set[str] = set()

    def space(self, tables: Mapping[str, Any]) -> Space:
        """Build the space; raise every mistake at once."""
        self._check_parts(tables)
        entries = self._entries(tables.get("space", {}), "")
        groupings = self._groupings(tables.get("groups", {}))
        correlations = self._correlations(tables.get("correlation", {}))
        relations = self._relations(tables.get("relations", ()))
        if not self.problems and not entries and not groupings:
            left = f"the scenario has none of the parameters {', '.join(self.omitted)}"
            self.problems.append(f"space: {left if self.omitted else 'it has no parameter'}")
        if self.problems:
            raise InputError(self.problems)
        found = Space(
            distributions=entries,
            correlations={pair: r for pair, r in correlations.items() if not {*pair} & self.omitted.keys()},
            relations=tuple(pair for pair in relations if not {*pair} & self.omitted.keys()),
            groupings=groupings,
            title=str(tables.get("title", "")),
            units=self.units,
            origins=self.origins,
            omitted=self.omitted,
        )
        check_relations(found)
        refused = self._refused(found)
        if not refused:
            return found
        again = _Reading(self.scenario, self.folder)
        again.omitted = self.omitted | refused
        return again.space(tables)

    def _refused(self, found: Space) -> dict[str, str]:
        """Try the medians of a space in the scenario; return the optional entries that it refuses, and why."""
        middle = {stream: np.array([0.5]) for stream in found.streams}
        medians = {path: float(value[0]) for path, value in found.values(middle).items()}
        try:
            self.scenario.replace(medians)
        except InputError as error:
            tried = {path: _reason(self.scenario, path, medians[path]) for path in self.optional & {*medians}}
            if refused := {path: tried[path] for path in medians if tried.get(path)}:
                return refused
            raise InputError(f"with the medians of the space, {each}" for each in error.problems) from None
        return {}

    def _check_parts(self, tables: Mapping[str, Any]) -> None:
        unknown: dict[str, list[str]] = {}
        for name in tables:
            if name not in PARTS:
                unknown.setdefault(nearest(str(name), PARTS), []).append(str(name))
        self.problems += [
            f"{', '.join(names)}: unknown part of a space.{near}" for near, names in unknown.items()
        ]
        if tables.get("schema", SCHEMA) != SCHEMA:
            self.problems.append(f"schema = {tables['schema']!r}: this version reads schema = {SCHEMA}")
        kinds = {
            "title": str,
            "space": Mapping,
            "correlation": Mapping,
            "groups": Mapping,
            "relations": (list, tuple),
        }
        for name, kind in kinds.items():
            if name in tables and not isinstance(tables[name], kind):  # type: ignore[arg-type]
                raise InputError(
                    f"{name} = {shortened(repr(tables[name]), LONGEST_QUOTED)}: expected a"
                    f" {'text' if kind is str else 'list of texts' if name == 'relations' else 'table'}"
                )

    def _entries(self, table: Any, where: str) -> dict[str, Distribution]:
        """Read the distributions of one table; where is the group, with a full stop at its end, or empty."""
        found = {}
        for path, content in flattened(table).items():
            origin = Origin()
            with gathered(self.problems):
                origin = read_origin(f"{where}{path}", content) if isinstance(content, Mapping) else origin
            if path in self.omitted:
                continue
            self.optional |= {path} if origin.optional else set()
            try:
                quantity = quantity_at(self.scenario, path)
            except InputError as error:
                if origin.optional:
                    self.omitted[path] = "the scenario has no such parameter"
                else:
                    self.problems += [
                        each.within(where.rstrip(".")) if where else each for each in error.problems
                    ]
                continue
            with gathered(self.problems):
                found[path] = read_distribution(f"{where}{path}", content, quantity, folder=self.folder)
                self.units[path] = quantity.unit
                if origin != Origin():
                    self.origins[f"{where}{path}"] = origin
        return found

    def _groupings(self, tables: Mapping[str, Any]) -> dict[str, Grouping]:
        found = {}
        for name, table in tables.items():
            groups: dict[str, Group] = {}
            if not isinstance(table, Mapping) or not table:
                self.problems.append(
                    f"groups.{name}: expected a table for each group, with its share and its space"
                )
                continue
            for label, content in table.items():
                with gathered(self.problems):
                    groups[label] = self._group(f"groups.{name}.{label}", content)
            if len(groups) == len(table):
                with gathered(self.problems):
                    found[name] = _named(f"groups.{name}", groups)
        for name in [name for name, each in found.items() if not each.paths]:
            del found[name]
            self.origins = {
                where: each for where, each in self.origins.items() if not where.startswith(f"groups.{name}.")
            }
        return found

    def _group(self, where: str, content: Any) -> Group:
        if not isinstance(content, Mapping):
            raise InputError(f"{where}: expected a table with the share and the space of the group")
        known = ("share", "space", *KEYS)
        for name in content:
            if name not in known:
                raise InputError(f"{where}.{name}: unknown part of a group.{nearest(str(name), known)}")
        share = content.get("share")
        if isinstance(share, bool) or not isinstance(share, (int, float)):
            raise InputError(f"{where}.share = {share!r}: expected a part of 1, for instance 0.5")
        origin = read_origin(where, content)
        if origin != Origin():
            self.origins[where] = origin
        return Group(share=float(share), distributions=self._entries(content.get("space", {}), f"{where}."))

    def _correlations(self, table: Mapping[str, Any]) -> dict[tuple[str, str], float]:
        found = {}
        for text, value in table.items():
            first, sign, second = (part.strip() for part in text.partition("~"))
            if not sign or isinstance(value, bool) or not isinstance(value, (int, float)):
                self.problems.append(
                    f'correlation: {text} = {value!r}: expected "PATH ~ PATH" = a number from -1 to 1'
                )
                continue
            found[first, second] = float(value)
        return found

    def _relations(self, texts: Any) -> list[tuple[str, str]]:
        found = []
        for text in texts:
            parts = [part.strip() for part in str(text).split("<")]
            if len(parts) == 1 or not all(parts):
                self.problems.append(f"relations: {text}: expected PATH < PATH")
                continue
            found += list(itertools.pairwise(parts))
        return found


def _named(where: str, groups: dict[str, Group]) -> Grouping:
    try:
        return Grouping(groups=groups)
    except InputError as error:
        raise InputError(f"{where}: {problem}" for problem in error.problems) from None


def flattened(table: Any, start: str = "") -> dict[str, Any]:
    """Return tables of distributions, or false for none, by dotted path, whether the path is one key or nested tables."""
    found: dict[str, Any] = {}
    for key, content in table.items():
        nested = isinstance(content, Mapping) and "model" not in content and content
        if nested and all(isinstance(each, Mapping) or each is False for each in content.values()):
            found |= flattened(content, f"{start}{key}.")
        else:
            found[f"{start}{key}"] = content
    return found


def _reason(scenario: Scenario, path: str, value: float) -> str:
    """Return why a scenario refuses a value; empty if it takes it."""
    try:
        scenario.replace({path: value})
    except InputError as error:
        return error.problems[0].reason
    return ""


LARGEST_OUTSIDE: Final = 1e-12
"""Probability of values outside the range of a parameter that is allowed; a study has fewer draws."""
KINDS: Final[dict[str, type[Distribution]]] = {
    kind.__name__: kind for kind in Distribution.__subclasses__() if kind is not Truncated
}
"""Distributions, by the name that a file gives them."""
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
        name: read_number(f"{path}.{name}", value, "1" if name in WITHOUT_UNIT else quantity.unit)
        for name, value in given.items()
    }
    try:
        found = _built(kind, numbers, names)
    except TypeError:
        missing = [name for name in names if name not in numbers]
        why = f".{missing[0]}: missing parameter of {kind.__name__}" if missing else ""
        raise InputError(f"{path}{why or ': expected numbers, not lists'}") from None
    except InputError as error:
        raise InputError(f"{path}: {problem}" for problem in error.problems) from None
    return _within(path, found, quantity)


def _kind(path: str, content: Any) -> type[Distribution]:
    name = content.get("model") if isinstance(content, Mapping) else content
    if not isinstance(content, Mapping) or str(name) not in KINDS:
        raise InputError(
            f"{path}: expected a table with the model of a distribution.{nearest(str(name), KINDS)}"
        )
    return KINDS[str(name)]


def _built(kind: type[Distribution], numbers: dict[str, Any], names: list[str]) -> Distribution:
    """Build a distribution, truncated at ends that are not parameters of its own."""
    found = kind(**{name: value for name, value in numbers.items() if name in names})
    ends = {name: value for name, value in numbers.items() if name not in names}
    if not ends:
        return found
    return found.truncated(ends.get("low", -math.inf), ends.get("high", math.inf))


def _with_measured(path: str, given: dict[str, Any], quantity: Quantity, folder: Path) -> dict[str, Any]:
    """Replace the name of a file by the values of its column."""
    from electrovib.data.registry import read_columns

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
    positive = isinstance(found, Truncated) and found.low == 0 and isinstance(found.distribution, Normal)
    if positive and quantity.low > 0:  # as a fit writes it
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


_LARGEST: Final = 1e100
"""Largest number of a distribution in SI, whose square a float still holds."""


def read_number(path: str, value: Any, unit: str) -> Any:
    """Read a finite number in SI or as a text with a unit, or a list of them as a tuple."""
    if isinstance(value, (list, tuple)):
        return tuple(read_number(path, each, unit) for each in value)
    if isinstance(value, str):
        try:
            value = parse_quantity(value, unit)
        except ValueError as error:
            raise InputError(f"{path} = {value}: {error}") from None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"{path} = {value!r}: expected a finite number, or a text with a unit")
    if abs(value) > _LARGEST:
        raise InputError(
            f"{path} = {value!r}: expected a number of the size of the parameter, at most {_LARGEST:g}"
        )
    return float(value)


PARTS: Final = ("schema", "title", "relations", "space", "correlation", "groups")
"""Tables and values at the top of the file of a space."""


def tables_of(source: object) -> tuple[Mapping[str, Any], Path]:
    """Return the tables of a TOML file or shipped population, and the folder to which their files are relative."""
    if isinstance(source, Mapping):
        whole = any(part in source for part in PARTS)
        return (source if whole else {"space": source}), Path()
    if not isinstance(source, (str, os.PathLike)):
        raise InputError(
            f"space = {shortened(repr(source), LONGEST_QUOTED)}: expected a .toml file, tables, a Space, or one of"
            f" {', '.join(shipped_names())}"
        )
    if str(source) in shipped_names():
        return read_shipped(str(source)), Path()
    path = Path(source)
    if path.suffix != ".toml" and not kind_of(path):
        raise InputError(
            f"'{source}' is neither a file nor a population of the package.{nearest(str(source), shipped_names())}"
        )
    return read_toml_file(path, kind="a space", advice="Give a .toml file of a space"), path.parent
