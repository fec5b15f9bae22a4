"""A reproduced paper as files: a page, its numbers, figures, curves and tables."""

from __future__ import annotations

import hashlib
import json
import math
import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.answer import Document, Drawing, Page, Panel, Table
from electrovib.core.budget import each_item
from electrovib.core.errors import InputError, gathered, refuse
from electrovib.core.files import inputs_noted
from electrovib.data.atomic import (
    check_folder,
    check_writable,
    left_by_a_kill,
    make_folder,
    output_path,
    writing,
)
from electrovib.data.marks import Form, csv_text, is_ours
from electrovib.studies.reproduction import COMPARED
from electrovib.view.documents import drawn, html

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.answer import Shown
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.reproduction import Part, Reproduction

_PAGE: Final = "report.html"
_VERDICTS: Final = (
    "Reproduced: the number that the paper prints follows from its own inputs. Consistent: ours agrees with a statement of it."
    " Disagrees: its own inputs give another number. Open: the paper does not print what the comparison needs. Notes in full:"
    " numbers.json; curves of a figure: the .csv of its name"
)


def reproduce(
    paper: str = "vezzoli_2014",
    output: str | Path = "reproduction",
    *,
    skin: str | None = None,
    force: bool = False,
) -> Reproduction:
    """Compute everything that a paper states, and write it beside the printed values.

    Parameters
    ----------
    paper : str
        ``author_year``.
    output : str or Path
        Folder; made if it is not there. Files of an earlier reproduction in it are replaced, others are left.
    skin : str, optional
        File with a table of one's own skin, for papers that take one.
    force : bool
        Whether files of the same names that we did not write, or that were changed since, may be replaced.

    Returns
    -------
    Reproduction
        Rows, panels and words, as they were written.

    Raises
    ------
    InputError
        If there is no such paper, if it has nothing to reproduce, if the table cannot be used, if the folder
        cannot be written, or if a file in it would be replaced that is read or not ours; nothing has been written then.
    """
    folder = output_path(output)
    check_folder(folder, {_PAGE: Form.PAGE}, force=force)
    with inputs_noted() as inputs:
        found = _found(paper, skin)
    _write(found, folder, inputs=inputs, force=force)
    return found


def _found(paper: str, skin: str | None) -> Reproduction:
    from electrovib.core.discovery import paper as find
    from electrovib.core.discovery import papers
    from electrovib.solve.quantities.answer import validity

    module = find(paper)
    if not hasattr(module, "reproduce"):
        able = ", ".join(name for name, other in papers().items() if hasattr(other, "reproduce"))
        raise InputError(f"'{paper}' has nothing to reproduce. Papers that have: {able or 'none'}.")
    found: Reproduction = module.reproduce(skin=skin)
    own: Mapping[str, Scenario] = module.scenarios() if hasattr(module, "scenarios") else {}
    told: dict[str, tuple[Diagnostic, list[str]]] = {}
    for name, scenario in own.items():
        for each in validity(scenario):
            if each.state == "warning":
                told.setdefault(each.text, (each, []))[1].append(name)
    stated = (
        replace(each, text=f"{text} (scenario {', '.join(names)})") for text, (each, names) in told.items()
    )
    return replace(found, diagnostics=tuple(stated)) if told else found


def _write(found: Reproduction, folder: Path, *, inputs: Sequence[Path] = (), force: bool = False) -> None:
    contents = contents_of(found)
    if folder.exists():
        _refuse_to_replace(contents, folder, inputs, force=force)
    made = not folder.exists()
    make_folder(folder)
    try:
        forms = {folder / name: Form.PAGE if name == _PAGE else None for name in contents}
        with writing(forms, force=True) as temporaries:
            for place, temporary in temporaries.items():
                temporary.write_bytes(contents[place.name])
    except BaseException:
        if made:
            with suppress(OSError):
                folder.rmdir()
        raise


def _refuse_to_replace(
    contents: Mapping[str, bytes], folder: Path, inputs: Sequence[Path], *, force: bool
) -> None:
    """Refuse to replace what is read, and what an earlier reproduction did not write here."""
    problems: list[str] = []
    with gathered(problems):
        check_writable({folder / _PAGE: Form.PAGE}, inputs=inputs, force=force)
    others = {folder / name: content for name, content in contents.items() if name != _PAGE}
    with gathered(problems):
        check_writable(dict.fromkeys(others), inputs=inputs, force=True)
    page = folder / _PAGE  # a process that was killed has left its page beside that of an earlier one
    earlier = {entry for one in (page, *left_by_a_kill(page)) for entry in _listed(one).items()}
    for place, content in others.items():
        if place.is_file() and not force:
            there = place.read_bytes()
            if there != content and (place.name, _checksum(there)) not in earlier:
                problems.append(
                    f"{place}: exists already and is not of an earlier reproduction, or was changed since; give another"
                    " folder, or replace it with --force (force=True)."
                )
    refuse(problems)


def _listed(page: Path) -> dict[str, str]:
    """Return the checksums of the files written beside a page of ours."""
    if not is_ours(page, Form.PAGE):
        return {}
    found = re.search(r"<!-- beside this page: (\{.*\}) -->", page.read_text(encoding="utf-8"))
    return dict(json.loads(found[1])) if found else {}


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:32]


def contents_of(found: Reproduction) -> dict[str, bytes]:
    """Make the files of a reproduction, figures, curves, whole tables and explanations, with ``report.html`` last."""
    from electrovib.view.pages import to_png, to_svg

    contents: dict[str, bytes] = {}
    pictures = {}
    names = each_item([f"drawing of {panel.id}" for panel in found.panels])
    for _, panel in zip(names, found.panels, strict=True):
        figure = pictures[panel.id] = drawn(panel)
        contents[f"{panel.id}.svg"] = to_svg(figure).encode()
        contents[f"{panel.id}.png"] = to_png(figure)
        parts = (panel, *panel.below) if isinstance(panel, Panel) else ()
        contents |= {f"{part.id}.csv": to_csv(part).encode() for part in parts}
    contents |= {
        f"{table.id}.csv": csv_text(table.headings, table.rows, marked=False).encode()
        for table in found.tables
        if table.id
    }
    for words in (each for each in found.pages if each.id):
        contents[f"{words.id}.md"] = ("\n\n".join((f"# {words.title}", *words.paragraphs)) + "\n").encode()
    numbers = json.dumps([row.to_dict() for row in found.ordered], indent=2, ensure_ascii=False)
    contents["numbers.json"] = f"{numbers}\n".encode()
    beside = json.dumps({name: _checksum(content) for name, content in contents.items()})
    page = html(document_of(found), pictures=pictures)
    contents[_PAGE] = f"{page}\n<!-- beside this page: {beside} -->\n".encode()
    return contents


def document_of(found: Reproduction) -> Document:
    """Say what a reproduction has found: the paper's numbers beside ours, figures, tables, explanations, equations.

    One with `parts` has these first, and all else folded.
    """
    first = {name for part in found.parts for name in part.panels}
    panels = {each.id: each for each in found.panels}
    formulas = tuple((f"({number})", text) for number, text in found.equations.items())
    warnings = tuple((each.state, each.text) for each in found.diagnostics)
    heading = f"Warnings on the paper's own scenarios: {len(warnings)}"
    further: list[Page | Table | Shown] = [
        *_rows(found, "Numbers of the paper", COMPARED, caption=_VERDICTS),
        *([Table(heading, ("", ""), warnings, looks={0: "state"})] if warnings else []),
        *(each for name, each in panels.items() if name not in first),
        *(each for each in found.tables if each.on_page),
        *found.pages,
        *([Table("Equations", ("", ""), formulas, looks={1: "formula"})] if formulas else []),
        *_rows(found, "Quantities of which the paper states nothing", ("ours",)),
        *_rows(found, "Checks of this software", ("check",)),
    ]
    shown = [item for part in found.parts for item in _shown(part, panels)]
    count = [f"{found.count()}."] if found.rows and not found.parts else []
    return Document(
        title=found.title or f"{found.paper}: the paper, reproduced",
        sentences=[*count, *found.findings, found.citation],
        pages=[*shown, *map(_folded, further)] if found.parts else further,
        references=found.references,
    )


def _shown(part: Part, panels: Mapping[str, Shown]) -> list[Page | Table | Shown]:
    """Return what a page shows of a part: its groups of rows, then its figures."""
    groups = tuple((each.verdict, each.words) for each in part.groups)
    return [
        Page(part.title, (part.words,) if part.words else ()),
        Table("", ("", ""), groups, looks={0: "state"}),
        *(panels[name] for name in part.panels if name in panels),
    ]


def _folded(item: Page | Table | Shown) -> Page | Table | Shown:
    return item if isinstance(item, Drawing) else replace(item, folded=True)


def _rows(found: Reproduction, title: str, verdicts: Sequence[str], *, caption: str = "") -> list[Table]:
    """Return the rows with these verdicts as a table with the columns that they fill, or nothing."""
    compared = verdicts == COMPARED
    rows = tuple(
        (
            row.verdict if compared else "",
            row.place,
            row.what,
            row.said if compared else "",
            row.here,
            row.inputs if row.place else "",
            row.brief or row.note,
        )
        for row in found.ordered
        if row.verdict in verdicts
    )
    headings = ("verdict", "place", "quantity", "paper", "here", "from inputs", "note")
    filled = tuple(column for column in range(len(headings)) if any(row[column] for row in rows))
    looks = {0: "state", 2: "what", 3: "words", 4: "number"}
    return [Table(title, headings, rows, caption=caption, shown=filled, looks=looks)] if rows else []


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
