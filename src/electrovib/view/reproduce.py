"""A reproduced paper as files: a page, its numbers, figures, curves and tables."""

from __future__ import annotations

import hashlib
import json
import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.budget import each_item
from electrovib.core.errors import InputError, gathered, refuse
from electrovib.core.files import inputs_noted
from electrovib.data.atomic import (
    Form,
    check_folder,
    check_writable,
    is_ours,
    left_by_a_kill,
    make_folder,
    output_path,
    writing,
)
from electrovib.view.pages import drawn, html

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.reproduction import Reproduction

_PAGE: Final = "report.html"


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
    warned: dict[str, tuple[Diagnostic, list[str]]] = {}
    for name, scenario in own.items():
        for each in validity(scenario):
            if each.state == "warning":
                warned.setdefault(each.text, (each, []))[1].append(name)
    stated = (
        replace(each, text=f"{text} (scenario {', '.join(names)})") for text, (each, names) in warned.items()
    )
    return replace(found, diagnostics=tuple(stated)) if warned else found


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
    contents |= {name: found.content(name).encode() for name in found.files}
    beside = json.dumps({name: _checksum(content) for name, content in contents.items()})
    page = html(found.document, pictures=pictures)
    contents[_PAGE] = f"{page}\n<!-- beside this page: {beside} -->\n".encode()
    return contents
