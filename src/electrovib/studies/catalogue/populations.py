"""The populations of fingers that the package ships: each with its distributions and their sources."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from electrovib.core.answer import Table, laid_out, terminal_width
from electrovib.core.citation import UNVERIFIED, status_text
from electrovib.core.errors import InputError, nearest
from electrovib.scenario.space.shipped import read_shipped, shipped_names
from electrovib.scenario.space.writing import KEYS
from electrovib.studies.catalogue.items import Listed, Listing

USE: Final = (
    "'electrovib list NAME' shows its distributions with their sources; a study, a sensitivity analysis and"
    " ev.read_space(SCENARIO, NAME) take it by its name."
)
HEADINGS: Final = ("parameter", "group", "distribution", "status", "confidence", "source")
_OF_ALL: Final = "all"


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
        status = status_text(self.status) if self.status else "a choice"
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
    return str(read_shipped(name)["title"])


def caption_of(entries: list[PopulationEntry]) -> str:
    """State which distributions are unverified and which a scenario may lack."""
    unverified = [each.name for each in entries if each.status == UNVERIFIED]
    needed = [each.name for each in entries if not each.optional and each.group == _OF_ALL]
    text = f"A scenario needs {', '.join(needed)}; other parameters that it lacks are omitted, and the omission is reported."
    return text + (f" {status_text(UNVERIFIED).capitalize()}: {', '.join(unverified)}." if unverified else "")


def entries_of(name: str) -> Iterator[PopulationEntry]:
    """Yield the distributions of a population as declared: of all fingers, then of each group after its share."""
    tables = read_shipped(name)
    for path, table in tables["space"].items():
        yield _entry(path, _OF_ALL, table)
    for division, groups in tables.get("groups", {}).items():
        for label, group in groups.items():
            where = f"{division}: {label}"
            yield _entry("share", where, group, f"{group['share']:g} of all fingers")
            for path, table in group["space"].items():
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
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)
