"""The reference, written before the pages are read: models, papers, functions, commands, and the laws against measurements."""

from __future__ import annotations

import shutil
from pathlib import Path

import commands
import evidence_pages
import functions
import models
import papers_pages
from sphinx.application import Sphinx

FOLDER = "reference/generated"
PARTS = (models, papers_pages, functions, commands, evidence_pages)
LISTED = {"index", "api", "tutorial", "architecture", "materials", "nomenclature"}
"""Pages in `docs/` that are listed elsewhere than among the guides."""


def write(app: Sphinx) -> None:
    """Write all pages; a page whose text is as before keeps its time, so that it is not built again."""
    folder = Path(app.srcdir) / FOLDER
    pages: dict[str, str] = {}
    for part in PARTS:
        pages |= part.pages()
    wanted = {folder / name for name in pages}
    for old in set(folder.rglob("*.*")) - wanted:
        old.unlink()
    for name, text in pages.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
    for empty in [path for path in folder.iterdir() if path.is_dir() and not any(path.iterdir())]:
        shutil.rmtree(empty)


def list_guides(app: Sphinx, docname: str, source: list[str]) -> None:
    """List the guides in `docs/` that no other page lists."""
    if docname == "how_to/index":
        guides = (path.stem for path in sorted(Path(app.srcdir).glob("*.md")) if path.stem not in LISTED)
        source[0] = source[0].replace("{guides}", "\n".join(f"/{name}" for name in guides))


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the reference before the pages are collected."""
    app.connect("builder-inited", write)
    app.connect("source-read", list_guides)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
