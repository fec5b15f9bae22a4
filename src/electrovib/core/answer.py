"""What an answer of the package says, as data: sentences, warnings, tables, figures, explanations, files.

Every kind of result states its `Document`; how terminal, notebook, page and files show it is written once for all.
"""

from __future__ import annotations

import html
import re
import shutil
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, Final, TypeAlias, TypeVar

from electrovib.core.arrays import Real
from electrovib.core.diagnostics import Diagnostic, warning_lines
from electrovib.core.unchangeable import Unchangeable

T = TypeVar("T")
REFERENCE: Final = -1
"""Look of a curve that is a reference or a range."""
NARROWEST: Final = 36
"""Least width of the last column of a table in a terminal, characters."""


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A line, or a band from `y` to `upper`, in SI; a NaN leaves a gap.

    `kind` is ``"line"``, ``"bold"``, ``"dashed"``, ``"dotted"``, ``"points"`` or ``"band"``. `look` is the place
    in the palette, `REFERENCE` for a reference in grey, by default the place in the panel. A curve of the
    background is drawn thin and pale; the legend has the words `background` once for all of them. The table of
    the curves has it even if it is not `drawn`.
    """

    label: str
    x: Real
    y: Real
    upper: Real | None = None
    kind: str = "line"
    look: int | None = None
    background: str = ""
    drawn: bool = True


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One figure as data.

    `id` is the file name without suffix, `x` and `y` are label and SI unit of the axes, and the curves are in
    drawing order. Nothing is drawn below `floor`; the curves themselves go on. Panels `below` share its
    horizontal axis and its picture, whose first is half as high. A `folded` panel is opened by a click.
    """

    id: str
    title: str
    caption: str
    x: tuple[str, str]
    y: tuple[str, str]
    curves: tuple[Curve, ...]
    log_x: bool = False
    log_y: bool = False
    floor: float | None = None
    below: tuple[Panel, ...] = ()
    folded: bool = False


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """A figure that a plot of `electrovib.plot` draws of a result: `plot` is its name, `of` and `options` are what it takes.

    `plot` may also be a function that fills an empty matplotlib figure of width and height `size`, in inches.
    `words` describe the figure to somebody who does not see it, by default its title.
    """

    id: str
    title: str
    plot: str | Callable[[Any], None]
    of: Any = None
    options: Mapping[str, Any] = field(default_factory=dict)
    caption: str = ""
    size: tuple[float, float] | None = None
    words: str = ""


Shown: TypeAlias = Panel | Drawing
"""A figure as data, or by the name of a plot."""


@dataclass(frozen=True, repr=False)
class Table:
    """A table in words; the file `id`, if there is one, holds all of it, and the page the columns `shown`, or all.

    On a page a column looks as `looks` says: ``"code"``, ``"number"``, ``"hash"``, ``"what"`` and ``"words"`` (wide
    enough for a sentence), ``"state"`` (a word such as ok in its colour), ``"formula"`` (mathtext). Lines of a cell
    after its first are quieter. A `folded` table is opened by a click.
    """

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    _: KW_ONLY
    caption: str = ""
    id: str = ""
    shown: tuple[int, ...] = ()
    looks: Mapping[int, str] = field(default_factory=dict)
    folded: bool = False
    on_page: bool = True

    @classmethod
    def of(
        cls, title: str, items: Iterable[T], columns: Mapping[str, Callable[[T], str]], **how: Any
    ) -> Table:
        """Make a table with a row for each item and a column for each heading, whose function writes the cell of an item."""
        rows = tuple(tuple(cell(each) for cell in columns.values()) for each in items)
        return cls(title, tuple(columns), rows, **how)

    def __repr__(self) -> str:
        return laid_out(self).rstrip()

    def _repr_html_(self) -> str:
        return as_html(self)


@dataclass(frozen=True)
class Page:
    """Explanations, which the file `id`, if there is one, holds in full, and the page in the paragraphs of `brief`.

    Those of a `listing` are the content of a text file, shown as it is.
    """

    title: str
    paragraphs: tuple[str, ...]
    _: KW_ONLY
    id: str = ""
    brief: tuple[str, ...] = ()
    listing: bool = False
    folded: bool = False

    def __str__(self) -> str:
        return "\n\n".join((self.title, *self.paragraphs))


@dataclass(frozen=True, kw_only=True)
class Document:
    """What an answer shows, its sentences first, the diagnostics of what it was computed from beside them.

    - `sentences`, `numbers`: the answer, each sentence or group of sentences a line of a terminal, and its tables.
    - `diagnostics`: by a label where several results are judged; `note`: what they do not cover.
    - `figures`, `tables`: the first figure stands before the tables of a page, the others after them.
    - `one_screen`: whether a page shows sentences and figures on one screen, and the rest by a click; `brief`: whether a
      terminal shows sentences, `numbers` and warnings, and the rest where all is asked for.
    - `alone`: `id` of the figure that is written where one is asked for, by default the first.
    - `remarks`: what was assumed and what is not stated, shown everywhere; `pages`: explanations at length, and
      tables and figures to look things up, on a page alone and in this order.
    """

    title: str
    sentences: Sequence[str]
    numbers: Sequence[Table] = ()
    diagnostics: Sequence[Diagnostic] | Mapping[str, Sequence[Diagnostic]] = ()
    note: str = ""
    figures: Sequence[Shown] = ()
    tables: Sequence[Table] = ()
    remarks: Sequence[str] = ()
    pages: Sequence[Page | Table | Shown] = ()
    references: Sequence[str] = ()
    alone: str = ""
    one_screen: bool = False
    brief: bool = False

    @property
    def main(self) -> Shown:
        """The figure that stands for all."""
        return next((each for each in self.figures if each.id == self.alone), self.figures[0])

    @property
    def judged(self) -> Mapping[str, Sequence[Diagnostic]]:
        """The diagnostics by label, an empty one where a single result is judged."""
        return self.diagnostics if isinstance(self.diagnostics, Mapping) else {"": self.diagnostics}

    @property
    def warnings(self) -> list[str]:
        """One line for each different warning, and one that names what could not be judged."""
        return warning_lines((each for found in self.judged.values() for each in found), brief=True)

    @property
    def text(self) -> str:
        """Write the answer, the tables, then warnings and remarks, as a terminal shows them."""
        return self.shown()

    def shown(self, *, everything: bool = False) -> str:
        """Write it as a terminal shows it; with `everything` what a brief one omits too, and the explanations."""
        others = everything or not self.brief
        tables = [*self.numbers, *(self.tables if others else ())]
        lines = [*self.sentences, *([""] if tables else []), *map(laid_out, tables), *self.warnings]
        lines += self.remarks if others else ()
        explained = [f"\n{each}" for each in self.pages if everything and isinstance(each, Page | Table)]
        return "\n".join([*lines, *explained]).strip("\n")

    @property
    def html(self) -> str:
        """Write the answer, the tables, then further sentences and warnings, as a notebook shows them."""
        first, *others = (f"<p>{html.escape(line)}</p>" for line in (*self.sentences, *self.warnings))
        return "".join([first, *map(as_html, (*self.numbers, *self.tables)), *others])


class Answer(Unchangeable, ABC):
    """A result that says what it is as a `Document`; `electrovib.save` writes it as a page, and its `FILES`."""

    __slots__ = ()
    FILES: ClassVar[Mapping[str, str | None]] = {}
    """Names of the files that hold its numbers, and their forms as in `electrovib.data.atomic`."""

    @property
    def files(self) -> Mapping[str, str | None]:
        """Its own files, where they depend on what it holds."""
        return self.FILES

    @property
    @abstractmethod
    def document(self) -> Document:
        """What it says."""

    def content(self, name: str) -> str | bytes:
        """Return the content of one of `FILES`."""
        raise KeyError(name)

    def __repr__(self) -> str:
        return self.document.text

    def _repr_html_(self) -> str:
        return self.document.html


def as_sentence(text: str) -> str:
    """Begin a text with a capital letter, and end it with one full stop."""
    return f"{text[:1].upper()}{text[1:].removesuffix('.')}."


def laid_out(table: Table) -> str:
    """Lay a table out in columns; the last column takes the rest of the line and is wrapped."""
    lines = [table.headings, *table.rows]
    widths = [max(len(line[column]) for line in lines) for column in range(len(table.headings))]
    room = terminal_width()
    taken = sum(widths[:-1]) + 2 * (len(widths) - 1)
    widths[-1] = max(min(widths[-1], room - taken), NARROWEST)
    shown = [table.title, "-" * len(table.title)] if table.title else []
    for line in lines:
        last = textwrap.wrap(line[-1], widths[-1]) or [""]
        first = "  ".join(cell.ljust(width) for cell, width in zip(line[:-1], widths[:-1], strict=True))
        shown.append(f"{first}  {last[0]}".rstrip())
        shown += [" " * taken + part for part in last[1:]]
    if table.caption:
        shown += ["", *textwrap.wrap(table.caption, room)]
    return "\n".join(shown) + "\n"


def as_html(table: Table) -> str:
    """Write a table as HTML, without styles of its own."""
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in table.headings)
    rows = "".join(
        f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in table.rows
    )
    title = f"<caption>{html.escape(table.title)}</caption>" if table.title else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


_TO_LATEX: Final = str.maketrans(
    {each: f"\\{each}" for each in "&%#_{}"}
    | {
        "$": r"\$", "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": "$<$", ">": "$>$",
        "µ": r"$\mu$", "Ω": r"$\Omega$", "ε": r"$\varepsilon$", "σ": r"$\sigma$", "τ": r"$\tau$", "·": r"$\cdot$",
        "×": r"$\times$", "≤": r"$\leq$", "≥": r"$\geq$", "≈": r"$\approx$", "−": "$-$", "–": "--", "°": r"$^\circ$",
        "²": "$^2$", "³": "$^3$", "…": r"\ldots{}",
    }
)  # fmt: skip
_NARROW: Final = 40
"""Characters from which on a column of LaTeX is broken into lines."""


def as_latex(table: Table) -> str:
    """Write a table as LaTeX, below its title and its caption as a comment; formulas stay formulas."""

    def line(cells: Sequence[str]) -> str:
        parts = (re.split(r"(\$[^$]+\$)", " ".join(cell.split())) for cell in cells)
        escaped = (
            "".join(p if p[:1] == "$" == p[-1:] and p[1:] else p.translate(_TO_LATEX) for p in each)
            for each in parts
        )
        return " & ".join(escaped) + r" \\"

    wide = [max(map(len, column)) > _NARROW for column in zip(table.headings, *table.rows, strict=True)]
    columns = "".join(rf"p{{{0.8 / sum(wide):.2g}\linewidth}}" if each else "l" for each in wide)
    said = [f"% {' '.join(text.split())}" for text in (table.title, table.caption) if text]
    body = [r"\hline", line(table.headings), r"\hline", *map(line, table.rows), r"\hline"]
    return "\n".join([*said, rf"\begin{{tabular}}{{{columns}}}", *body, r"\end{tabular}", ""])


def terminal_width() -> int:
    """Return the width of the terminal in characters, 120 where there is none and 80 at least."""
    return max(shutil.get_terminal_size((120, 24)).columns, 80)
