"""Spaces from TOML files, tables and the populations that the package ships."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from electrovib.core.errors import LONGEST_QUOTED, InputError, gathered, nearest, shortened
from electrovib.core.paths import quantity_at
from electrovib.scenario.reading import Source, read_scenario
from electrovib.scenario.space.acceptance import accepted
from electrovib.scenario.space.entries import read_distribution
from electrovib.scenario.space.groups import Group, Grouping
from electrovib.scenario.space.origin import KEYS, Origin, read_origin
from electrovib.scenario.space.relations import check_relations
from electrovib.scenario.space.space import Space
from electrovib.scenario.space.tables import PARTS, tables_of
from electrovib.scenario.space.writing import SCHEMA

if TYPE_CHECKING:
    from electrovib.scenario.distributions import Distribution
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

    def space(self, tables: Mapping[str, Any]) -> Space:
        """Build the space; raise every mistake at once."""
        self._check_parts(tables)
        entries = self._entries(tables.get("space", {}), "")
        groupings = self._groupings(tables.get("groups", {}))
        correlations = self._correlations(tables.get("correlation", {}))
        relations = self._relations(tables.get("relations", ()))
        if not self.problems and not entries and not groupings:
            left = ", ".join(self.omitted)
            self.problems.append(
                f"space: the scenario has none of the parameters {left}"
                if left
                else "space: it has no parameter"
            )
        if self.problems:
            raise InputError(self.problems)
        found = Space(
            distributions=entries,
            correlations={
                pair: value for pair, value in correlations.items() if not set(pair) & set(self.omitted)
            },
            relations=tuple(pair for pair in relations if not set(pair) & set(self.omitted)),
            groupings=groupings,
            title=str(tables.get("title", "")),
            units=self.units,
            origins=self.origins,
            omitted=self.omitted,
        )
        check_relations(found)
        return accepted(found, self.scenario)

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
        for path, content in _flattened(table).items():
            origin = Origin()
            with gathered(self.problems):
                origin = read_origin(f"{where}{path}", content) if isinstance(content, Mapping) else origin
            if path in self.omitted:
                continue
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
        kept = {name: each for name, each in found.items() if each.paths}
        for name in set(found) - set(kept):
            dropped = [where for where in self.origins if where.startswith(f"groups.{name}.")]
            self.origins = {where: each for where, each in self.origins.items() if where not in dropped}
        return kept

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


def _flattened(table: Any, start: str = "") -> dict[str, Any]:
    """Return tables of distributions by dotted path, whether the path is one key or nested tables."""
    found: dict[str, Any] = {}
    for key, content in table.items():
        nested = isinstance(content, Mapping) and "model" not in content and content
        if nested and all(isinstance(each, Mapping) for each in content.values()):
            found |= _flattened(content, f"{start}{key}.")
        else:
            found[f"{start}{key}"] = content
    return found
