"""The catalogue as a user asks for it: everything on one screen, one entry, what a word finds, the populations."""

from __future__ import annotations

import functools
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from electrovib.core.answer import Table, laid_out, terminal_width
from electrovib.core.citation import UNVERIFIED, status_text
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError, nearest
from electrovib.core.model import Model
from electrovib.core.parsing import read_toml
from electrovib.core.search import ALIAS, NAME, SPELLING, WORDS, Match, as_question, search, suggestions
from electrovib.studies.catalogue import items
from electrovib.studies.catalogue.items import Listed, Listing
from electrovib.studies.catalogue.pages import labelled, page

USE: Final = (
    "'electrovib list NAME' shows its distributions with their sources; a study, a sensitivity analysis and"
    " ev.read_space(SCENARIO, NAME) take it by its name."
)
HEADINGS: Final = ("parameter", "group", "distribution", "status", "confidence", "source")
_OF_ALL: Final = "all"
SHARE: Final = "share"
_MOST_SHOWN: Final = 12
"""Numbers of a list that are written out."""


@dataclass(frozen=True, kw_only=True)
class PopulationEntry(Listed):
    """One distribution of a population, or the share of a group, as texts.

    - `name`: dotted path; ``share`` for the share of a group; `meaning`: its model with the numbers as declared.
    - `group`: division and group, ``moisture: dry``; ``all`` for every finger.
    - `confidence`: how far the numbers are those of fingertips, as the author of the population judges.
    - `source`: where the numbers are from; `choice`: what no source gives.
    - `optional`: whether scenarios without the parameter can be used.
    """

    confidence: str
    source: str
    choice: str
    optional: bool

    @property
    def row(self) -> tuple[str, ...]:
        """Cells of the table of a population."""
        words = "; ".join(filter(None, (self.source, f"a choice: {self.choice}" if self.choice else "")))
        status = status_text(self.status) if self.status else "a choice" if self.choice else "not stated"
        return self.name, self.group, self.meaning, status, self.confidence, words


def spaces(name: str = "") -> Listing:
    """List the populations of fingers that the package ships, or the distributions of one.

    Parameters
    ----------
    name : str
        Name of a population; all of them if empty.

    Returns
    -------
    Listing
        One record for each population, or for each distribution of the one that is named. Printed, it is what
        ``electrovib list spaces`` prints; in a notebook a table.

    Raises
    ------
    InputError
        If there is no population of this name.

    Examples
    --------
    >>> [each.name for each in ev.spaces()]
    ['fingers']
    """
    from electrovib.scenario.space.shipped import shipped_names

    if not name:
        records = [Listed(name=each, kind="population", meaning=title_of(each)) for each in shipped_names()]
        rows = tuple((each.name, each.meaning) for each in records)
        table = Table("", ("population", "what it is"), rows, caption=USE)
        return Listing(records, text=lambda: laid_out(table), table=lambda: table)
    if name not in shipped_names():
        raise InputError(f"'{name}': no population has this name.{nearest(name, shipped_names())}")
    found = list(entries_of(name))
    whole = Table(
        f"{name}: {title_of(name)}", HEADINGS, tuple(each.row for each in found), caption=caption_of(found)
    )
    return Listing(found, text=lambda: _with_sources(whole), table=lambda: whole)


def title_of(name: str) -> str:
    """Return the title of a population."""
    from electrovib.scenario.space.shipped import read_shipped

    return str(read_shipped(name)["title"])


def caption_of(entries: list[PopulationEntry]) -> str:
    """State which distributions are unverified and which a scenario may lack."""
    unverified = [each.name for each in entries if each.status == UNVERIFIED]
    needed = [each.name for each in entries if not each.optional and each.group == _OF_ALL]
    text = f"A scenario needs {', '.join(needed)}; other parameters that it lacks are omitted, and the omission is reported."
    return text + (f" {status_text(UNVERIFIED).capitalize()}: {', '.join(unverified)}." if unverified else "")


def entries_of(name: str) -> Iterator[PopulationEntry]:
    """Yield the distributions of a population that the package ships, as declared."""
    from electrovib.scenario.space.shipped import read_shipped

    return distributions_in(read_shipped(name))


def distributions_in(tables: Mapping[str, Any]) -> Iterator[PopulationEntry]:
    """Yield the distributions of the tables of a space: of all fingers, then of each group after its share."""
    for path, table in tables.get("space", {}).items():
        yield _entry(path, _OF_ALL, table)
    for division, groups in tables.get("groups", {}).items():
        for label, group in groups.items():
            where = f"{division}: {label}"
            yield _entry(SHARE, where, group, f"{group['share']:g} of all fingers")
            for path, table in group.get("space", {}).items():
                yield _entry(path, where, table)


def _with_sources(table: Table) -> str:
    """Write the distributions one below the other, each with its source in the lines after it."""
    room, lines = terminal_width(), [table.title, "-" * len(table.title)]
    for parameter, group, distribution, status, confidence, source in table.rows:
        where = "" if group == _OF_ALL else f" ({group})"
        lines += textwrap.wrap(f"{parameter}{where}: {distribution}", room)
        text = f"{status}, {confidence} confidence: {source.removeprefix('a choice: ')}"
        lines += textwrap.wrap(text, room, initial_indent="    ", subsequent_indent="    ")
    return "\n".join([*lines, "", *textwrap.wrap(table.caption, room)]) + "\n"


def _entry(parameter: str, group: str, table: Mapping[str, Any], distribution: str = "") -> PopulationEntry:
    from electrovib.scenario.space.writing import KEYS

    numbers = [f"{key} {_shown(value)}" for key, value in table.items() if key not in {"model", *KEYS}]
    texts: dict[str, Any] = {
        key: str(table.get(key, "")) for key in ("status", "confidence", "source", "choice")
    }
    return PopulationEntry(
        name=parameter,
        kind="distribution",
        group=group,
        meaning=distribution or f"{table['model']}, {', '.join(numbers)}",
        optional=bool(table.get("optional")),
        **texts,
    )


def _shown(value: object) -> str:
    if isinstance(value, list):
        return ", ".join(map(str, value)) if len(value) <= _MOST_SHOWN else f"{len(value)} values"
    return str(value)


@functools.cache
def meanings() -> dict[str, list[dict[str, Any]]]:
    """Read the table: ``here`` and ``missing``, each with its words, a sentence, and the names that belong to it."""
    return read_toml(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))


def missing() -> str:
    """Name what is not modelled."""
    return ", ".join(each["words"][0] for each in meanings()["missing"])


def meaning(query: str, *, within: bool = False) -> tuple[str, list[str]]:
    """Say what a query means that has exactly the words of an entry, or with `within` some; empty if nothing has them.

    Beside the sentence are the names that belong to it.
    """
    asked = _words(query)
    for label, kind in (("", "here"), ("not modelled: ", "missing")):
        for each in meanings()[kind]:
            known = set(map(_words, each["words"]))
            if asked in known or (within and any(words <= asked for words in known)):
                return f"{query}: {label}{each['says']}.", each["see"]
    return "", []


def _words(text: str) -> frozenset[str]:
    """Split a text into words in small letters, without the s of a plural."""
    return frozenset(word.removesuffix("s") for word in re.findall(r"[^\W_]+", text.casefold()))


MOST: Final = 15
"""Entries shown of a search; the number of the others is stated."""
WHOLE: Final = {NAME, ALIAS}
"""Stages of a search at which an entry has, or had, the whole name."""
RUN: Final = (
    "'electrovib run NAME' runs a scenario, 'electrovib init NAME -o my.toml' writes it as a file to change."
)


def models(query: str = "", *, complete: bool = False) -> Listing:
    """List models, papers, materials, skins and ready-made scenarios, or search them.

    Parameters
    ----------
    query : str
        A name, a part of a name, or words of a description; everything if empty.
    complete : bool
        Show every entry on a line of its own instead of an overview, or all that a search finds.

    Returns
    -------
    Listing
        One record for each entry, best first in a search, with the reason why it was found. Printed, it is what
        ``electrovib list`` prints: an overview, one entry in full, or what was found; in a notebook a table.

    Raises
    ------
    InputError
        If nothing is found; the message has the three names that are spelled most similarly, and what they are.

    Examples
    --------
    >>> [each.name for each in ev.models("parylene") if each.kind == "material"]
    ['parylene_c']
    """
    entries = list(items.everything())
    if not query.strip():
        return Listing(
            entries,
            text=lambda: laid_out(all_table(entries)) if complete else overview(),
            table=lambda: all_table(entries, "Models, papers and scenarios"),
        )
    said, matches = _meant(query, entries)
    if not said:
        matches = _matches(query, entries, "model, material, skin, paper or scenario", "list' lists them")
    full = [] if said else _in_full(matches)
    records = _with_reasons(matches)
    return Listing(
        records,
        text=lambda: said + _as_text(query, full, records, complete=complete),
        table=lambda: replace(found_table(records, f"Found for '{query}'"), caption=said),
    )


def scenarios(query: str = "") -> Listing:
    """List the ready-made scenarios of all papers, or search them.

    Parameters
    ----------
    query : str
        A name, a part of it, or words: of the title, the figure, the device, the stack, the models, the sources; all
        scenarios if empty.

    Returns
    -------
    Listing
        One record for each scenario: its title as `meaning`, the figure or the statement of the paper as `reproduces`, and
        in a search the reason why it was found. Printed, it is what ``electrovib list scenarios`` prints; in a notebook a table.

    Raises
    ------
    InputError
        If nothing is found; the message has the three names that are spelled most similarly, and what they are.

    Examples
    --------
    >>> [each.name for each in ev.scenarios("bau_2010")]
    ['bau_2010/sine']
    """
    entries = list(items.scenario_items())
    title, full = "Ready-made scenarios", list[Listed]()
    if query.strip():
        matches = _matches(query, entries, "scenario", "list scenarios' lists all")
        title, full = f"Scenarios found for '{query}'", _in_full(matches)
        entries = _with_reasons(matches)
    return Listing(
        entries,
        text=lambda: page(full[0]) if len(full) == 1 else f"{laid_out(scenario_table(entries))}\n{RUN}\n",
        table=lambda: scenario_table(entries, title),
    )


def _meant(query: str, entries: Sequence[Listed]) -> tuple[str, tuple[Match, ...]]:
    """Say what a word of the field means here; find what belongs to it, and then what a search finds."""
    found = search(query, entries)
    close = not found or found[0].stage == SPELLING
    said, names = meaning(query, within=close)
    if not said:
        return "", ()
    named = {item.name: Match(item, WORDS, "belongs to it") for item in entries if item.name in names}
    others = () if close else (match for match in found if match.entry.name not in named)
    return f"{textwrap.fill(said, terminal_width())}\n\n", (*(named[name] for name in names), *others)


def _matches(query: str, entries: Sequence[Listed], kind: str, advice: str) -> tuple[Match, ...]:
    """Return what is found; a query that only resembles a name is refused with a question."""
    matches = search(query, entries)
    if not matches or matches[0].stage == SPELLING:
        question = as_question(suggestions(query, entries))
        raise InputError(
            f"'{query}': no {kind} has this name or these words.{question} 'electrovib {advice}."
        )
    return matches


def find(name: str) -> type[Model] | ModuleType:
    """Find a model or a paper by a name; capitals count only where two entries differ by nothing else."""
    entries = [item for item in items.everything() if isinstance(item.thing, (type, ModuleType))]
    matches = search(name, entries)
    if not matches or matches[0].stage not in WHOLE:
        question = as_question(suggestions(name, entries))
        raise InputError(f"'{name}' is neither a model nor a paper.{question}")
    thing: type[Model] | ModuleType = _found(matches)[0].thing
    return thing


def _found(matches: Iterable[Match]) -> list[Listed]:
    return [match.entry for match in matches if isinstance(match.entry, Listed)]


def _in_full(matches: tuple[Match, ...]) -> list[Listed]:
    """Choose what is shown in full: whatever has or had the name, or the only thing that was found."""
    named = _found(match for match in matches if match.stage in WHOLE)
    return named or (_found(matches) if len(matches) == 1 and matches[0].stage != SPELLING else [])


def _with_reasons(matches: tuple[Match, ...]) -> list[Listed]:
    """Put the reason why it was found into each record."""
    return [replace(item, reason=match.reason) for item, match in zip(_found(matches), matches, strict=True)]


def _as_text(query: str, full: list[Listed], records: list[Listed], *, complete: bool) -> str:
    """Write what was found: entries of the name in full, the others one line each."""
    shown_in_full = {(item.name, item.kind) for item in full}
    others = [record for record in records if (record.name, record.kind) not in shown_in_full]
    if full and not complete:
        others = [record for record in others if not record.reason.startswith(items.REMARKS)]
    pages = [page(item) for item in full]
    shown = others if complete else others[: MOST if not full else MOST // 2]
    if shown:
        title = f"Also found for '{query}'" if full else f"Found for '{query}'"
        pages.append(laid_out(found_table(shown, title)))
    if hidden := len(others) - len(shown):
        pages.append(f"and {hidden} more: 'electrovib list --all \"{query}\"' lists them\n")
    return "\n".join(pages)


def found_table(records: Iterable[Listed], title: str = "") -> Table:
    """Write the result of a search: what was found, what it is, and why it was found."""
    rows = [(record.name, record.kind, f"{record.meaning} [{record.reason}]") for record in records]
    return Table(title, ("name", "kind", "what it is [why it was found]"), tuple(rows))


def all_table(records: Iterable[Listed], title: str = "") -> Table:
    """Write every record on one line."""
    rows = [(record.name, record.kind, record.status or "definition", record.meaning) for record in records]
    return Table(title, ("name", "kind", "source status", "what it is"), tuple(rows))


def scenario_table(entries: Iterable[Listed], title: str = "") -> Table:
    """Write ready-made scenarios with what each reproduces; of a search also the stack, and why it was found."""
    rows = []
    for record in entries:
        why = f"; stack: {record.texts['stack']} [{record.reason}]" if record.reason else ""
        rows.append((record.name, record.reproduces or "-", f"{_without_paper(record)}{why}"))
    why = " [why it was found]" if rows and rows[0][-1].endswith("]") else ""
    return Table(title, ("scenario", "figure or statement", f"what it is{why}"), tuple(rows))


def _without_paper(record: Listed) -> str:
    """Omit from a title the author, year and figure that stand in the other columns."""
    author, _, year = record.paper.partition("_")
    start, colon, rest = record.meaning.partition(": ")
    return rest if colon and start.casefold().startswith(f"{author} {year}") else record.meaning


_MORE = (
    "'electrovib list NAME' shows one in full, 'electrovib list WORD' searches names, meanings, parameters, materials,"
    " papers and scenarios, --all lists every entry with its source status, --bibtex the citations."
)


def overview() -> str:
    """Write the names of everything by its place in a scenario, what is not modelled, and how to find out more."""
    found = list(items.parts_and_papers())
    held, labels = items.places(), (items.LIBRARY, "materials", "skins", "stacks", items.PAPERS)
    sections = {
        "Key of a scenario file, and the models to choose from:": {
            path: sorted(find_members(family)) for family, path in held.items()
        },
        "Outside a scenario:": {
            items.kind_of(family): sorted(find_members(family))
            for family in items.families()
            if family not in held
        },
        "Ready-made, used by name:": {
            label: [item.name for item in found if item.group == label] for label in labels
        }
        | {items.SCENARIOS: [f"{items.scenario_count()}, listed by 'electrovib list scenarios'"]},
    }
    width = max(len(label) for rows in sections.values() for label in rows) + 2
    lines = list[str]()
    for title, rows in sections.items():
        lines += [title, ""]
        lines += [line for label, names in rows.items() for line in labelled(label, ", ".join(names), width)]
        lines.append("")
    unverified = ", ".join(item.name for item in found if item.status == UNVERIFIED)
    for text in (
        f"{status_text(UNVERIFIED).capitalize()}: {unverified}.",
        f"Not modelled: {missing()}.",
        _MORE,
    ):
        lines += textwrap.wrap(text, terminal_width())
    return "\n".join(lines) + "\n"
