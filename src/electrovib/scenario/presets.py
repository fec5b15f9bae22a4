"""A ready-made scenario as a base and changes to it, with the source of each value."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, Final

from electrovib.core.errors import InputError, Problem, nearest, refuse
from electrovib.core.tables import Changed
from electrovib.scenario.experiment import Scenario
from electrovib.scenario.files import read_part, sources_of_offers
from electrovib.scenario.reading import read_scenario
from electrovib.scenario.sources import is_default

NONE: Final[Mapping[str, str]] = {}
_PLAIN_SOURCES: Final = dict.fromkeys(
    ("friction.coefficient", "contact.area", "load.normal_force", "circuit.return_path.resistance"),
    "a choice",
)


@functools.cache
def plain() -> Scenario:
    """Return the default base of a preset: 0.5 N on 1 cm2, Coulomb friction with a coefficient of 0.5, 1 kohm."""
    return Scenario.model_validate({**Scenario.example, "sources": _PLAIN_SOURCES})


def preset(
    base: Scenario | str | None = None,
    *,
    title: str,
    changes: Mapping[str, Any],
    sources: Mapping[str, str] = NONE,
    unchanged: str = "",
) -> Scenario:
    """Make a ready-made scenario, with the source of each value, from another one; `plain` if `base` is absent.

    `sources` maps the path of a value, or of a table, to where it is from: the source of a table holds for those of its values
    that have none of their own. `unchanged` is the source of the unchanged values of the base; each keeps its own if absent.
    """
    start = plain() if base is None else read_scenario(base)
    known = {path.removesuffix(".model"): "" for path in changes} | dict(sources)
    known |= {path: sources[table] for path in known if (table := _nearest_table(path, sources)) is not None}
    put = Changed(start)
    content = put.within(changes, start)
    refuse(put.problems)
    beside = {path.rpartition(".")[0]: known[path] for path in changes if path in known}
    known |= {path: beside.get(path.rpartition(".")[0], "") for path in put.stored if path not in changes}
    offered = sources_of_offers(put)
    built = read_part(Scenario, content | {"title": title, "sources": {}})
    kept = {path: unchanged or source for path, source in start.sources.items()}
    paths = [path for path, _, _ in built.parameters()]
    if wrong := [
        path for path in sources if not any(f"{each}.".startswith(f"{path}.") for each in (*paths, *changes))
    ]:
        raise InputError(
            Problem(f"no parameter has this path.{nearest(path, paths)}", path=f"sources.{path}")
            for path in wrong
        )
    found = {}
    for path, value, _ in built.parameters():
        table = _nearest_table(path, known)
        if table is None:
            found[path] = kept.get(path, "")
        elif table == path or not is_default(built, path, value):
            found[path] = known[table] or offered.get(path, "")
    return built.model_copy(update={"sources": {path: source for path, source in found.items() if source}})


def _nearest_table(path: str, known: Mapping[str, str]) -> str | None:
    """Find the path itself, or the innermost table around it, among the entries."""
    parts = path.split(".")
    tables = (".".join(parts[:length]) for length in range(len(parts), -1, -1))
    return next((table for table in tables if table in known), None)
