"""What a paper states compared with what its equations give: rows, panels and words, as data."""

from __future__ import annotations

import functools
import json
import math
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from pathlib import Path
from typing import Any, Final

from electrovib.core.answer import Answer, Curve, Document, Drawing, Page, Panel, Shown, Table
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import KINDS
from electrovib.data.atomic import csv_text

VERDICTS: Final = ("reproduced", "consistent", "disagrees", "open", "ours", "check")
"""In the order in which rows are shown. The first four compare a row with the paper; ``ours`` is a quantity of which the paper
states nothing, and a check an identity or a control."""
INPUTS: Final = ("printed", "published", "constructed", "drawn", "chosen")
"""What a number is computed from: the paper's own inputs alone, skins of other publications, skins constructed through a
number of the paper, values drawn at random, or values of our choice."""
COMPARED: Final = VERDICTS[:4]
SHOWN_UNITS: Final = {"pF": 1e-12, "nF": 1e-9, "mN": 1e-3, "ms": 1e-3}
"""Units of a row besides SI, and their size."""
_VERDICTS: Final = (
    "Reproduced: the number that the paper prints follows from its own inputs. Consistent: ours agrees with a statement of it."
    " Disagrees: its own inputs give another number. Open: the paper does not print what the comparison needs. Notes in full:"
    " numbers.json; curves of a figure: the .csv of its name"
)


@dataclass(frozen=True)
class Row:
    """One number of a paper beside ours, or a check of ours.

    - `id`, `what`: names for programs and for people.
    - `paper`: what is printed, in `unit`, which is SI or one of `SHOWN_UNITS`; None where nothing is.
    - `ours`: our number, or the lowest and highest over skins, fingers or causes, all under one law.
    - `verdict`: ``disagrees`` only where ours follows from the inputs that the paper prints and does not reach its
      number; ``reproduced`` only where it prints the number; ``consistent`` and ``open`` only with something that it
      states, ``open`` where the note says what it does not give; ``ours`` and ``check`` where it says nothing.
    - `note`, `brief`: explanation for ``numbers.json``, and on the page where that is shorter.
    - `stated`: what the paper states in words; `leads`: the paper's own reading of its main result, shown
      first.
    - `place`: section, equation or figure of the paper; `inputs`: one of `INPUTS`.
    - `agrees`: the lowest and highest number that agrees with what is stated in words; ``consistent`` needs it.
    """

    id: str
    what: str
    paper: float | tuple[float, float] | None
    ours: float | tuple[float, float]
    unit: str
    verdict: str
    note: str
    stated: str = ""
    brief: str = ""
    leads: bool = False
    place: str = ""
    inputs: str = "printed"
    agrees: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Refuse a verdict that the row does not support."""
        verdict, compared = self.verdict, self.paper is not None or bool(self.stated)
        known = (self.unit in SHOWN_UNITS or self.unit in KINDS) and self.inputs in INPUTS
        reached = self.paper is None or overlap(self.paper, self.ours)
        of_inputs = f"what {self.inputs} inputs give neither reproduces the paper nor disagrees with it"
        digits = "only a printed number that ours has in its digits, rounded or cut off, is reproduced"
        what = f"{verdict}, compared with what? Give the number or the words of the paper, or call it ours"
        of_ours = "a quantity or a check of ours is not compared with the paper"
        printed, of_range = (
            self.inputs == "printed",
            "what is consistent lies in the range that agrees with the paper",
        )
        needed = {  # what has to be true of a row with this verdict, and what is said where it is not
            "reproduced": {of_inputs: printed, digits: self._has_digits},
            "disagrees": {
                of_inputs: printed,
                "only a printed number that ours does not reach disagrees with it": not reached,
            },
            "consistent": {of_range: self._is_within, what: compared},
            "open": {
                what: compared,
                "an open verdict needs a note on what the paper does not give": bool(self.note),
            },
            "ours": {of_ours: not compared},
            "check": {of_ours: not compared},
        }
        allowed = f"verdict '{verdict}', unit '{self.unit}' or inputs '{self.inputs}' is not allowed"
        told = {allowed: known and verdict in needed} | needed.get(verdict, {})
        if wrong := [words for words, is_so in told.items() if not is_so]:
            msg = f"row {self.id}: {wrong[0]}"
            raise ValueError(msg)

    @property
    def _has_digits(self) -> bool:
        if isinstance(self.paper, tuple | None) or isinstance(self.ours, tuple):
            return False
        last = Decimal(f"{self.paper:g}").as_tuple().exponent
        return abs(self.ours - self.paper) < 10.0 ** int(last)

    @property
    def _is_within(self) -> bool:
        agrees = self.agrees if self.paper is None else self.paper
        if agrees is None:
            return False
        (low, high), (least, most) = map(_ends, (agrees, self.ours))
        return low <= least and most <= high

    @property
    def here(self) -> str:
        """Our number or range with its unit."""
        return shown(self.ours, self.unit)

    @property
    def said(self) -> str:
        """What the paper states, as a number or else in its words."""
        return (
            f"in words: {self.stated}" if self.stated and self.paper is None else shown(self.paper, self.unit)
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the row for ``numbers.json``."""
        kept = {name: value for name, value in vars(self).items() if name not in {"brief", "leads", "agrees"}}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in kept.items()}


def shown(value: float | tuple[float, float] | None, unit: str) -> str:
    """Write a number or an interval in the unit of its row."""
    if value is None:
        return "not printed"
    numbers, digits = (value, 3) if isinstance(value, tuple) else ((value,), 4)
    text = " to ".join(f"{number:.{digits}g}" for number in numbers)
    return text if unit == "1" else f"{text} {unit}"


def overlap(one: float | tuple[float, float], other: float | tuple[float, float]) -> bool:
    """Return whether two numbers or ranges have a value in common."""
    (low, high), (least, most) = map(_ends, (one, other))
    return low <= most and least <= high


def _ends(value: float | tuple[float, float]) -> tuple[float, float]:
    return value if isinstance(value, tuple) else (value, value)


@dataclass(frozen=True)
class GroupOfRows:
    """Rows that one sentence sums up, and what is concluded of all of them."""

    words: str
    verdict: str
    rows: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """A part of a report: words, figures by their `id`, and groups of rows."""

    title: str
    words: str
    groups: tuple[GroupOfRows, ...]
    panels: tuple[str, ...] = ()


def group(words: str, rows: Mapping[str, Row], ids: str, **numbers: object) -> GroupOfRows:
    """Sum up rows in words, in which ``{id.here}`` and ``{id.said}`` are numbers of a row, and other names those of `numbers`."""
    named = tuple(ids.split())
    verdicts = [rows[name].verdict for name in named]
    compared = [each for each in verdicts if each in COMPARED] or verdicts
    verdict = "disagrees" if "disagrees" in compared else max(compared, key=VERDICTS.index)
    return GroupOfRows(words.format_map({**rows, **numbers}), verdict, named)


@dataclass(frozen=True, kw_only=True, repr=False)
class Reproduction(Answer):
    """Everything a reproduction of one paper shows.

    - `paper`, `citation`: ``author_year``, and as in a list of references.
    - `rows`: for ``numbers.json`` and the first table.
    - `panels`, `pages`, `tables`: figures, explanations such as what is left open, further tables.
    - `equations`: number to mathtext; `references`: sources used.
    - `title`: heading of the page; made from the paper's name if empty.
    - `findings`: main results, before any table.
    - `diagnostics`: warnings of the paper's scenarios.
    - `parts`: the report in its order; without them findings and rows are shown.
    """

    paper: str
    citation: str
    rows: tuple[Row, ...]
    panels: tuple[Shown, ...]
    pages: tuple[Page, ...] = ()
    tables: tuple[Table, ...] = ()
    equations: Mapping[str, str] = field(default_factory=dict)
    references: tuple[str, ...] = ()
    title: str = ""
    findings: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    parts: tuple[Part, ...] = ()

    @property
    def ordered(self) -> tuple[Row, ...]:
        """Rows as they are shown: the paper's own reading, then the others in the order of `VERDICTS`."""
        return tuple(sorted(self.rows, key=lambda row: (not row.leads, VERDICTS.index(row.verdict))))

    def count(self) -> str:
        """Count the rows of each verdict; empty without rows."""
        of = Counter(row.verdict for row in self.rows)
        words = {"disagrees": "disagree", "ours": "quantities of ours", "check": "checks"}
        return ", ".join(f"{of[name]} {words.get(name, name)}" for name in VERDICTS if of[name])

    @property
    def document(self) -> Document:
        """Say what was found: the paper's numbers beside ours, figures, tables, explanations, equations.

        One with `parts` has these first, and all else folded.
        """
        first = {name for part in self.parts for name in part.panels}
        panels = {each.id: each for each in self.panels}
        formulas = tuple((f"({number})", text) for number, text in self.equations.items())
        title = f"Warnings on the paper's own scenarios: {len(self.diagnostics)}"
        told = tuple((each.state, each.text) for each in self.diagnostics)
        warnings = [Table(title, ("", ""), told, looks={0: "state"})] if told else []
        further: list[Page | Table | Shown] = [
            *_rows(self, "Numbers of the paper", COMPARED, caption=_VERDICTS),
            *warnings,
            *(each for name, each in panels.items() if name not in first),
            *(each for each in self.tables if each.on_page),
            *self.pages,
            *([Table("Equations", ("", ""), formulas, looks={1: "formula"})] if formulas else []),
            *_rows(self, "Quantities of which the paper states nothing", ("ours",)),
            *_rows(self, "Checks of this software", ("check",)),
        ]
        shown = [item for part in self.parts for item in _shown(part, panels)]
        count = [f"{self.count()}."] if self.rows and not self.parts else []
        return Document(
            title=self.title or f"{self.paper}: the paper, reproduced",
            sentences=[*count, *self.findings, self.citation],
            pages=[*shown, *map(_folded, further)] if self.parts else further,
            numbers=_in_terminal(self, warnings),
            references=self.references,
        )

    @property
    def files(self) -> Mapping[str, str | None]:
        """Curves of each figure, whole tables, explanations in full, and the numbers."""
        return dict.fromkeys(
            [
                *(f"{name}.csv" for name in self._curves),
                *(f"{each.id}.csv" for each in self.tables if each.id),
                *(f"{each.id}.md" for each in self.pages if each.id),
                "numbers.json",
            ]
        )

    @property
    def _curves(self) -> dict[str, Panel]:
        panels = [each for each in self.panels if isinstance(each, Panel)]
        return {part.id: part for each in panels for part in (each, *each.below)}

    def content(self, name: str) -> str:
        """Write curves or a table as CSV, an explanation as Markdown, or all rows as JSON."""
        stem, _, suffix = name.rpartition(".")
        if suffix == "json":
            rows = [row.to_dict() for row in self.ordered]
            return f"{json.dumps(rows, indent=2, ensure_ascii=False)}\n"
        if suffix == "md":
            (page,) = (each for each in self.pages if each.id == stem)
            return "\n\n".join((f"# {page.title}", *page.paragraphs)) + "\n"
        if stem in self._curves:
            return to_csv(self._curves[stem])
        (table,) = (each for each in self.tables if each.id == stem)
        return csv_text(table.headings, table.rows, marked=False)


def _in_terminal(found: Reproduction, warnings: Sequence[Table]) -> list[Table]:
    """Return what a terminal shows: the groups of each part, or the rows, and the warnings."""
    count = f"Numbers: {found.count()}."
    columns: dict[str, Callable[[Row], str]] = {
        "verdict": lambda row: row.verdict,
        "quantity": lambda row: row.what,
        "here": lambda row: row.here,
        "paper": lambda row: row.said if row.verdict in COMPARED else "",
    }
    tables = [replace(_groups(part), title=part.title, caption=part.words) for part in found.parts]
    if found.rows and not tables:
        tables = [Table.of("", found.ordered, columns)]
    if found.parts:  # of rows alone the count is the first sentence
        tables[-1] = replace(tables[-1], caption=" ".join(filter(None, [tables[-1].caption, count])))
    return [replace(each, on_page=False) for each in (*tables, *warnings)]


def _shown(part: Part, panels: Mapping[str, Shown]) -> list[Page | Table | Shown]:
    """Return what a page shows of a part: its groups of rows, then its figures."""
    return [
        Page(part.title, (part.words,) if part.words else ()),
        _groups(part),
        *(panels[name] for name in part.panels if name in panels),
    ]


def _groups(part: Part) -> Table:
    return Table("", ("", ""), tuple((each.verdict, each.words) for each in part.groups), looks={0: "state"})


def _folded(item: Page | Table | Shown) -> Page | Table | Shown:
    return item if isinstance(item, Drawing) else replace(item, folded=True)


def _rows(found: Reproduction, title: str, verdicts: Sequence[str], *, caption: str = "") -> list[Table]:
    """Return the rows with these verdicts as a table with the columns that they fill, or nothing."""
    compared = verdicts == COMPARED
    columns: dict[str, Callable[[Row], str]] = {
        "verdict": lambda row: row.verdict if compared else "",
        "place": lambda row: row.place,
        "quantity": lambda row: row.what,
        "paper": lambda row: row.said if compared else "",
        "here": lambda row: row.here,
        "from inputs": lambda row: row.inputs if row.place else "",
        "note": lambda row: row.brief or row.note,
    }
    rows = [row for row in found.ordered if row.verdict in verdicts]
    filled = tuple(place for place, cell in enumerate(columns.values()) if any(map(cell, rows)))
    looks = {0: "state", 2: "what", 3: "words", 4: "number"}
    return [Table.of(title, rows, columns, caption=caption, shown=filled, looks=looks)] if rows else []


def to_csv(panel: Panel) -> str:
    """Write every curve of a panel, drawn or not, one point a line, in SI; numbers read back to the last bit."""
    banded = any(curve.upper is not None for curve in panel.curves)
    names = [f"{what} [{unit}]" for what, unit in (panel.x, panel.y)]
    rows = []
    for curve in panel.curves:
        columns = [curve.x, curve.y] + ([] if curve.upper is None else [curve.upper])
        for point in zip(*columns, strict=True):
            numbers = [None if math.isnan(value) else float(value) for value in point]
            rows.append([curve.label, *numbers, *([None] if banded and curve.upper is None else [])])
    headings = ["curve", *names, *([f"{names[1]}, upper edge"] if banded else [])]
    return csv_text(headings, rows, marked=False)


@dataclass(frozen=True, eq=False)
class Words:
    """Rows, figures and tables of a report whose words are data: `file` has them by name, and numbers are put into them.

    `rows` has entries of `Row`, where `paper` names one of `values` [SI], which is printed, or is it; `panels` those of
    `electrovib.core.answer.Panel`, over time where none says otherwise, and `tables` those of `Table`; `texts` are lists
    of sentences.
    """

    file: Path
    values: Mapping[str, float | tuple[float, float]] = field(default_factory=dict)

    @functools.cached_property
    def _entries(self) -> dict[str, Any]:
        return tomllib.loads(self.file.read_text(encoding="utf-8"))

    def _filled(self, kind: str, name: str, numbers: Mapping[str, Any]) -> dict[str, Any]:
        """Put numbers into the words, and make lists tuples."""
        item = self._entries[kind][name]
        texts = {key: item[key].format_map(numbers) for key in ("what", "note", "caption") if key in item}
        return {key: tuple(each) if isinstance(each, list) else each for key, each in item.items()} | texts

    def texts(self, name: str, **numbers: object) -> tuple[str, ...]:
        """Return sentences or paragraphs; a row among the numbers is named as ``{id.here}`` or ``{id.ours[0]:.2g}``."""
        return tuple(each.format_map(numbers) for each in self._entries["texts"][name])

    def row(self, name: str, ours: float | Iterable[float], *, verdict: str = "", **numbers: Any) -> Row:
        """Return a row with our number, or the least and the largest of several, in SI; `verdict` where it depends on them."""
        item = {"note": "", "paper": None} | self._filled("rows", name, numbers)
        item |= {"verdict": verdict} if verdict else {}
        size, paper = SHOWN_UNITS.get(item["unit"], 1.0), item.pop("paper")
        printed = self.values[paper] if isinstance(paper, str) else paper
        return Row(
            id=name, paper=None if printed is None else _sized(printed, size), ours=_sized(ours, size), **item
        )

    def panel(self, name: str, *curves: Curve, below: tuple[Panel, ...] = (), **numbers: Any) -> Panel:
        """Return a figure of these curves."""
        item = {"title": "", "caption": "", "x": ("time", "s")} | self._filled("panels", name, numbers)
        return Panel(id=name, curves=curves, below=below, **item)

    def table(
        self, name: str, rows: Iterable[tuple[str, ...]], *, headings: tuple[str, ...] = (), **numbers: Any
    ) -> Table:
        """Return a table of these rows; `headings` where its file has none."""
        return Table(
            rows=tuple(rows), **{"headings": headings, "id": name} | self._filled("tables", name, numbers)
        )


def _sized(value: float | Iterable[float], size: float) -> float | tuple[float, float]:
    if isinstance(value, Iterable):
        several = [each / size for each in value]
        return min(several), max(several)
    return value / size
