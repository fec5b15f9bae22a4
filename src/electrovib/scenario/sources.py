"""Sources of the values of a scenario: which parameter each belongs to, which are in its paper, and what it shows of it."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.discovery import find_members, is_paper, offered_by, offers, papers
from electrovib.core.errors import Problem, closest, nearest, question
from electrovib.core.search import Searchable, as_question, suggestions
from electrovib.core.tables import place_of
from electrovib.core.units import format_quantity
from electrovib.physics.stack import IMPLIED, Stack

if TYPE_CHECKING:
    from electrovib.core.model import Model
    from electrovib.scenario.experiment import Scenario


BY_THE_USER = "set by the user"
"""Source of a value that the user has changed."""


def paper_named(text: str) -> str:
    """Return the paper, ``author_year``, with whose author and year a text begins, or that it names; empty where none."""
    begins = re.match(r"([a-zA-Z]+)(?: and \w+)?[ _](\d{4})\b", text)
    named = re.search(r"\b[a-z]+_\d{4}\b", text)
    name = f"{begins[1].lower()}_{begins[2]}" if begins else named[0] if named else ""
    return name if is_paper(name) else ""


@functools.cache
def ready_made(title: str) -> Scenario | None:
    """Find the scenario of a paper by its title."""
    name = paper_named(title)
    known = offered_by(name, "scenarios").values() if name else ()
    return next((each for each in known if each.title == title), None)


def is_default(model: Model, path: str, value: Any) -> bool:
    """Return whether a value is the default of its model."""
    owner: Any = model
    *parents, name = path.split(".")
    for part in parents:
        owner = owner[int(part)] if isinstance(owner, tuple) else getattr(owner, part)
    return bool(type(owner).model_fields[name].default == value)


def not_in_paper(scenario: Scenario, paper: str) -> dict[str, str]:
    """Find the values, as text by dotted path, of a paper's scenario that are not found in the paper.

    A value is found in the paper if its source begins with author and year, as in ``Vezzoli 2014, section
    4``. Values that the user has set, and defaults of 0, which switch an effect off, are left out.
    """
    author, _, year = paper.partition("_")
    printed = f"{author.capitalize()} {year}"
    found = {}
    for path, value, quantity in scenario.parameters():
        source = scenario.sources.get(path)
        if source is None or value is None or source.startswith((BY_THE_USER, printed)):
            continue
        if value != 0 or not is_default(scenario, path, value):
            found[path] = format_quantity(value, quantity.unit, digits=4)
    return found


_MOST: Final = 3
"""Most paths that are proposed."""


def wrong_sources(kind: type[Model], content: Mapping[str, Any]) -> list[Problem]:
    """Find the sources of a scenario whose dotted path no parameter can have.

    A path may lead to a table, to a parameter that is not given, to an optional part or layer that is not
    there, and to a parameter of another model than the chosen one: such sources remain where a table is
    changed or removed. Sources that electrovib wrote for values set by the user are not examined.
    """
    sources = content.get("sources")
    if not isinstance(sources, Mapping):
        return []
    problems = []
    for path, text in sources.items():
        if isinstance(text, Mapping):
            whole = next(_paths({path: text}), path)
            why = f'a path with full stops is one name in quotation marks: "{whole}" = "..."'
            problems.append(Problem(why, path=f"sources.{path}"))
        written_by_us = isinstance(text, str) and text.startswith(BY_THE_USER)
        if written_by_us or not isinstance(text, str):
            continue
        if why := _fault(kind, content, path):
            problems.append(Problem(f"no parameter has this path; {why}", path=f'sources."{path}"'))
    return problems


def _fault(kind: type[Model], content: Mapping[str, Any], path: str) -> str:
    """Explain why no parameter has a path; empty if one has, or where the tables do not state their model."""
    keys = path.split(".")
    table: Any = content
    kinds = [kind]
    for depth, key in enumerate(keys):
        where = ".".join(keys[:depth])
        if isinstance(table, (list, tuple)):
            place = place_of(table, key)
            if place is None:
                return f"'{where}' has entries 0 to {len(table) - 1}"
            parts, table = kinds, table[place]
        elif not kinds:
            return "" if isinstance(table, Mapping) else f"'{where}' is a single value"
        else:
            names = _names(kinds, table)
            if key not in names:
                owner = f"'{where}'" if where else "a scenario"
                return f"{owner} has no '{key}'.{_meant(content, keys, depth, names)}"
            parts = [part for each in kinds if (part := each.part(key)) is not None]
            table = table.get(key) if isinstance(table, Mapping) else None
        is_list = isinstance(table, (list, tuple))
        kinds = parts if is_list else [member for part in parts for member in _members(part, table)]
        if parts and not kinds:
            return ""  # an unknown model, which is a mistake of its own
    return ""


def _members(part: type[Model], table: Any) -> list[type[Model]]:
    """Return the models that a table can be of: every member of a family, because sources outlast a change of the model."""
    if not part.is_family:
        return [part]
    if isinstance(table, Mapping) and part.chosen(table) is None:
        return []
    return list(find_members(part).values())


def _names(kinds: list[type[Model]], table: Any) -> set[str]:
    if kinds[0] is Stack:
        return {*IMPLIED, *(table if isinstance(table, Mapping) else ())}
    own = (name for each in kinds for name in (*each.model_fields, *each.derived))
    return {"model", *own}


def _meant(content: Mapping[str, Any], keys: list[str], depth: int, names: set[str]) -> str:
    near = closest(keys[depth], names)
    if near is not None:
        return question([f"'{'.'.join([*keys[:depth], near, *keys[depth + 1 :]])}'"])
    same = [repr(path) for path in _paths(content) if path.rpartition(".")[2] == keys[-1]]
    return question(same[:_MOST]) or nearest(keys[depth], names)


def _paths(table: Any, start: str = "") -> Iterator[str]:
    for key, item in table.items():
        if isinstance(item, Mapping) and key != "sources":
            yield from _paths(item, f"{start}{key}.")
        else:
            yield f"{start}{key}"


@dataclass(frozen=True)
class PresetNote:
    """What a ready-made scenario shows, and words that a user may search for and that neither title nor stack has."""

    reproduces: str
    keywords: str = ""


def note_of(name: str) -> PresetNote:
    """Return what a paper declares of a ready-made scenario; empty words where it declares nothing."""
    author_year, _, key = name.partition("/")
    declared: dict[str, PresetNote] = getattr(papers()[author_year], "PRESETS", {})
    return declared.get(key, PresetNote(""))


def near_presets(name: str) -> str:
    """Ask for the three ready-made scenarios that a wrong name or word is most like, with the title of each."""
    entries = [
        Searchable(
            name=key, kind="scenario", meaning=scenario.title, texts={"keywords": note_of(key).keywords}
        )
        for key, scenario in offers(("scenarios",)).items()
    ]
    return f"{as_question(suggestions(name, entries))} 'electrovib list scenarios' lists all."
