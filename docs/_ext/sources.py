"""Links of the texts into the source, which lead to the pages that are written from it while the site is built.

A reader of the repository, which has no such pages, follows the link to the source.
"""

from __future__ import annotations

import functools
import inspect
import re
from pathlib import Path
from typing import Final

import models
from sphinx.application import Sphinx

import electrovib
from electrovib.studies.catalogue.items import everything, paper_items

PACKAGE: Final = Path(electrovib.__file__).parent
PAGES: Final = {
    "examples": "gallery/index",
    "src/electrovib/__init__.pyi": "reference/generated/functions/index",
    "src/electrovib/apps/cli": "reference/generated/commands",
    "src/electrovib/papers": "reference/generated/papers/index",
    "src/electrovib/papers#bibliography": "reference/generated/bibliography",
    "src/electrovib/papers#scenarios": "reference/generated/scenarios",
    "src/electrovib/physics": "reference/generated/models/index",
    "src/electrovib/studies/evidence": "reference/generated/evidence",
}
"""Pages that are written from many files."""
LINK: Final = re.compile(r"\]\((?:\.\./)+((?:src|examples)\b[^)\s]*)\)")


@functools.cache
def pages() -> dict[str, str]:
    """Return the page of each place in the source: of a paper by its file or folder, of a model by its file and name."""
    found = dict(PAGES)
    for item in paper_items(own=True):
        file = _file(item.thing)
        place = file.removesuffix("/__init__.py")
        found[place] = f"reference/generated/papers/{item.name}"
    for item in filter(models.is_model, everything(own=True)):
        page = models.place(item.thing, item.kind)
        found[f"{_file(item.thing)}#{item.name}"] = f"reference/generated/models/{page}"
    return found


def _file(thing: object) -> str:
    return f"src/electrovib/{Path(inspect.getfile(thing)).relative_to(PACKAGE).as_posix()}"  # type: ignore[arg-type]


def linked(text: str, docname: str) -> str:
    """Let the links of a text lead to pages of the site; one into a source without a page is a mistake."""
    up = "../" * docname.count("/")
    return LINK.sub(lambda found: f"]({up}{pages()[found[1].rstrip('/')]}.rst)", text)


def show(app: Sphinx, docname: str, source: list[str]) -> None:
    """Change the links of a text as it is read."""
    if Path(app.env.doc2path(docname)).suffix == ".md":
        source[0] = linked(source[0], docname)


def setup(app: Sphinx) -> dict[str, bool]:
    """Change the links before a text is parsed."""
    app.connect("source-read", show)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
