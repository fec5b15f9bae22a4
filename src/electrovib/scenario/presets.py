"""A ready-made scenario as a base and changes to it, each value with its source beside it."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, Final

from electrovib.core.errors import refuse
from electrovib.core.model import Model
from electrovib.core.tables import changed
from electrovib.scenario.experiment import Scenario
from electrovib.scenario.files import read_part, sources_of_offers
from electrovib.scenario.reading import read_scenario
from electrovib.scenario.sources import is_default

AIR: Final = ({"model": "Constant", "permittivity": 1.0}, "air")
"""Material of a gap of air, with its source."""
_PLAIN_SOURCES: Final = dict.fromkeys(
    ("friction.coefficient", "contact.area", "load.normal_force", "circuit.return_path.resistance"),
    "a choice",
)


@functools.cache
def plain() -> Scenario:
    """Return the default base of a preset: 0.5 N on 1 cm2, Coulomb friction with a coefficient of 0.5, 1 kohm."""
    return Scenario.model_validate({**Scenario.example, "sources": _PLAIN_SOURCES})


def preset(
    base: Scenario | str | None = None, *, title: str, changes: Mapping[str, Any], unchanged: str = ""
) -> Scenario:
    """Make a ready-made scenario, with the source of each value, from another one; `plain` if `base` is absent.

    A change may be a pair ``(value, source)``, at any depth: the source of a table holds for those of its
    values that have none of their own. `unchanged` is the source of the unchanged values of the base; each
    keeps its own if absent.
    """
    start = plain() if base is None else read_scenario(base)
    told: dict[str, str] = {path.removesuffix(".model"): "" for path in changes}
    values = {path: _without_sources(given, path, told) for path, given in changes.items()}
    found = changed(start, values)
    refuse(found.problems)
    beside = {path.rpartition(".")[0]: told[path] for path in values if path in told}
    told |= {path: beside.get(path.rpartition(".")[0], "") for path in found.stored if path not in values}
    offered = sources_of_offers(found)
    built = read_part(Scenario, found.content | {"title": title, "sources": {}})
    kept = {path: unchanged or source for path, source in start.sources.items()}
    sources = {}
    for path, value, _ in built.parameters():
        table = _nearest_table(path, told)
        if table is None:
            sources[path] = kept.get(path, "")
        elif table == path or not is_default(built, path, value):
            sources[path] = told[table] or offered.get(path, "")
    return built.model_copy(update={"sources": {path: source for path, source in sources.items() if source}})


def _without_sources(given: Any, path: str, told: dict[str, str]) -> Any:
    """Separate a value from its sources, and note these by path."""
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str):
        given, told[path] = given
    if isinstance(given, Model):
        given = given.to_dict()
    if isinstance(given, Mapping):
        return {key: _without_sources(item, f"{path}.{key}", told) for key, item in given.items()}
    if isinstance(given, (list, tuple)):
        return [_without_sources(item, f"{path}.{place}", told) for place, item in enumerate(given)]
    return given


def _nearest_table(path: str, told: Mapping[str, str]) -> str | None:
    """Find the path itself, or the innermost table around it, among the entries."""
    parts = path.split(".")
    tables = (".".join(parts[:length]) for length in range(len(parts), -1, -1))
    return next((table for table in tables if table in told), None)


def sourced(scenario: Scenario, sources: Mapping[str, str]) -> Scenario:
    """Return a copy in which every parameter has a source, defaults and absent ones included.

    `sources` maps the path of a table, ``""`` for the whole scenario, to the source of its values; an empty
    source adds none: ``{"": "table 2", "time": ""}``.
    """
    found = dict(scenario.sources)
    for path, _, _ in scenario.parameters():
        table = _nearest_table(path, sources)
        if table is not None and sources[table]:
            found.setdefault(path, sources[table])
    return scenario.model_copy(update={"sources": found})
