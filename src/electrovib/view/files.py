"""Documents as files: the suffix says which, a page, a figure, a table, a text; without one a folder with all of them."""

from __future__ import annotations

from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from electrovib.core.answer import Answer, as_latex
from electrovib.core.errors import InputError
from electrovib.core.files import kind_of
from electrovib.data.atomic import (
    Form,
    check_folder,
    check_writable,
    csv_text,
    output_path,
    unsigned,
    write_folder,
    writing,
)
from electrovib.view.pages import drawn, html, parts
from electrovib.view.style import one_column

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from matplotlib.figure import Figure

    from electrovib.core.answer import Document, Shown

    Content = Callable[[str], str | bytes]

NO_FILES: Final[Mapping[str, str | None]] = MappingProxyType({})
PAGE: Final = "report.html"
"""Name of the page in a folder."""
FIGURES: Final = (".pdf", ".svg", ".png")
"""Suffixes of a figure."""
SUFFIXES: Final = (
    {".html": Form.PAGE, ".htm": Form.PAGE}
    | dict.fromkeys(FIGURES, Form.FIGURE)
    | {".tex": Form.LATEX, ".txt": Form.TEXT}
)
"""Suffixes of files that every document has, and their forms."""
_MARKS: Final = {".svg": "<!-- {} -->\n", ".pdf": "% {}\n", ".png": "{}"}
"""What carries the mark after the end of a figure."""
STYLES: Final[Mapping[str, Callable[[Figure], object]]] = {"journal": one_column}
"""Name of a style to what puts a figure into it."""
_STYLE: Final[ContextVar[str]] = ContextVar("style", default="")


@contextmanager
def in_style(name: str, outputs: Iterable[str | Path]) -> Iterator[None]:
    """Write the figures of a ``with`` block in a style of `STYLES`, if one is named; it is refused if no output has figures."""
    if name and name not in STYLES:
        raise InputError(f"expected {' or '.join(STYLES)}", path="--style", value=name)
    if name and not any(Path(each).suffix.lower() in {"", *FIGURES} for each in outputs):
        why = f"belongs to a figure, '-o figure.pdf' or {' or '.join(FIGURES[1:])}, or to a folder; omit it"
        raise InputError(why, path="--style", value=name)
    before = _STYLE.set(name or _STYLE.get())
    try:
        yield
    finally:
        _STYLE.reset(before)


def check_document(
    path: str | Path,
    files: Mapping[str, str | None] = NO_FILES,
    *,
    inputs: Iterable[Path] = (),
    force: bool = False,
) -> None:
    """Check, before a long computation, that a document with these files of its own can be written."""
    place = output_path(path)
    if not is_file(place):
        check_folder(place, _forms(files), inputs=inputs, force=force)
    else:
        check_writable({place: _single(files, place)[1]}, inputs=inputs, force=force)


def save_document(
    document: Document,
    path: str | Path,
    files: Mapping[str, str | None] = NO_FILES,
    content: Content = str.encode,
    *,
    force: bool = False,
) -> list[Path]:
    """Write a document: the suffix of `SUFFIXES`, of one of its own files, or of a table; without a suffix a folder with all.

    All files are written, or none.
    """
    place = output_path(path)
    check_document(place, files, force=force)
    if not is_file(place):
        shown = [each for whole in document.figures for each in parts(whole)]
        figures = {f"{each.id}.pdf": picture(each, ".pdf") for each in shown}
        contents = {PAGE: html(document)} | {name: content(name) for name in files} | figures
        forms = _forms(files) | dict.fromkeys(figures, Form.FIGURE)
        return write_folder(place, contents, forms, force=force)
    name, form = _single(files, place)
    written = content(name) if name else _of_document(document, place)
    with writing({place: form}, force=force) as temporary:
        temporary[place].write_bytes(written.encode() if isinstance(written, str) else written)
    return [place]


def check_answer(
    kind: type[Answer],
    path: str | Path,
    *,
    more: Mapping[str, str | None] | None = None,
    inputs: Iterable[Path] = (),
    force: bool = False,
) -> None:
    """Check, before a long computation, that an answer of this kind can be written; `more` are files of what was asked for."""
    check_document(path, {**kind.FILES, **(more or {})}, inputs=inputs, force=force)


def save_answer(found: Answer, path: str | Path, *, force: bool = False) -> list[Path]:
    """Write an answer as `save_document` does."""
    return save_document(found.document, path, found.files, found.content, force=force)


def written(path: str | Path, document: Callable[[], Document], files: Iterable[str] = NO_FILES) -> str:
    """Say that a document with these files of its own was written, and how many figures or tables where a file holds one."""
    suffix, count, what = Path(path).suffix.lower(), 1, "figures; a folder has all of them"
    if suffix in FIGURES:
        count = sum(len(parts(each)) for each in document().figures)
    elif suffix == ".csv" and not any(each.endswith(suffix) for each in files):
        shown = document()
        count, what = len([*shown.numbers, *shown.tables]), "tables; .tex, .html and .txt have all of them"
    return f"written: {path}" + (f", one of {count} {what}" if count > 1 else "")


def is_file(place: Path) -> bool:
    """Return whether a path names a file: it has the suffix of one, and is not there as a folder."""
    return place.suffix[1:].isalpha() and kind_of(place) != "folder"


def _forms(files: Mapping[str, str | None]) -> dict[str, Form | None]:
    """Return the names of the files of a folder, and their forms."""
    return {PAGE: Form.PAGE} | {name: None if form is None else Form(form) for name, form in files.items()}


def _single(files: Mapping[str, str | None], place: Path) -> tuple[str, Form | None]:
    """Return the name in the folder, empty for what every document has, and the form of a file with this suffix."""
    known: dict[str, tuple[str, Form | None]] = {suffix: ("", form) for suffix, form in SUFFIXES.items()}
    known[".csv"] = "", Form.TABLE
    for name, form in reversed(_forms(files).items()):  # of several files of a suffix the first
        known[Path(name).suffix] = ("" if name == PAGE else name), form
    suffix = place.suffix.lower()
    if suffix not in known:
        listed = ", ".join(each for each in known if each != ".htm")
        why = f"this result is written as {listed}, or without a suffix as a folder, not as '{place.suffix}'"
        raise InputError(why, path=place)
    return known[suffix]


def _of_document(document: Document, place: Path) -> str | bytes:
    """Return the content of a file that every document has, by its suffix."""
    suffix = place.suffix.lower()
    if suffix in {".html", ".htm"}:
        return html(document)
    if suffix == ".txt":
        return f"{document.title}\n\n{document.shown(everything=document.brief)}\n\n{unsigned(Form.TEXT)}\n"
    tables = [*document.numbers, *document.tables]
    if not (document.figures if suffix in FIGURES else tables):
        what = "figure" if suffix in FIGURES else "table"
        raise InputError(f"this result has no {what}; write it as .html", path=place)
    if suffix in FIGURES:
        return picture(parts(document.main)[0], suffix)
    if suffix == ".csv":
        return csv_text(tables[0].headings, tables[0].rows, remarks=[tables[0].title, tables[0].caption])
    return "".join([f"% {unsigned(Form.LATEX)}\n", *map(as_latex, tables)])


def picture(shown: Shown, suffix: str) -> bytes:
    """Draw a figure as a file, with the mark by which a later one may replace it."""
    from electrovib.view.pages import to_pdf, to_png, to_svg

    figure = drawn(shown)
    if _STYLE.get():
        STYLES[_STYLE.get()](figure)
    write = {".pdf": to_pdf, ".png": to_png}.get(suffix, lambda each: to_svg(each).encode())
    return write(figure) + _MARKS[suffix].format(unsigned(Form.FIGURE)).encode()
