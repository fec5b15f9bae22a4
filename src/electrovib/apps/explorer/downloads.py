"""What a visitor can take away: the scenario, its numbers, its figures, a report, the references."""

from __future__ import annotations

import functools
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed


@dataclass(frozen=True)
class Download:
    """One kind of file; `make` takes a `Computed` and returns the bytes."""

    label: str
    name: str
    media_type: str
    make: Callable[[Computed], bytes]


def _saved(shown: Computed, name: str) -> dict[str, bytes]:
    """Return the files as which a Trace is saved, by their names."""
    from electrovib.exports.save import save

    with tempfile.TemporaryDirectory(prefix="electrovib-") as folder:
        return {path.name: path.read_bytes() for path in save(shown.trace, Path(folder) / name)}


def _alone(shown: Computed, name: str) -> bytes:
    return _saved(shown, name)[name]


def _csv(shown: Computed) -> bytes:
    """Return the tables over time and over frequency as one archive."""
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in _saved(shown, "trace.csv").items():
            packed.writestr(name, content)
    return archive.getvalue()


def _bibliography(shown: Computed) -> bytes:
    """Write the papers whose models and values the scenario has, as BibTeX, and the other sources as comments."""
    from electrovib.core.discovery import paper_of, papers
    from electrovib.studies.catalogue import bibtex
    from electrovib.view.tables import references, walk_models

    known = papers()
    models = {paper_of(type(model)) for _, model in walk_models(shown.scenario)}
    named = {name for name in known if any(name in text for text in shown.scenario.sources.values())}
    entries = [bibtex(module, name) for name, module in known.items() if name in models | named]
    remarks = [f"% {reference} ({what})" for reference, what in references({"": shown.scenario})]
    return "\n\n".join([*entries, "\n".join(remarks)]).encode() + b"\n"


DOWNLOADS: Final = (
    Download(
        "Scenario (TOML)",
        "scenario.toml",
        "application/toml",
        lambda shown: shown.scenario.to_toml().encode(),
    ),
    Download("Numbers (CSV, zipped)", "trace.zip", "application/zip", _csv),
    *(
        Download(label, name, kind, functools.partial(_alone, name=name))
        for label, name, kind in (
            ("Trace (netCDF)", "trace.nc", "application/x-netcdf"),
            ("Figures (PNG)", "figures.png", "image/png"),
            ("Figures (SVG)", "figures.svg", "image/svg+xml"),
            ("Figures (PDF)", "figures.pdf", "application/pdf"),
            ("Report (HTML)", "report.html", "text/html"),
        )
    ),
    Download("References (BibTeX)", "references.bib", "application/x-bibtex", _bibliography),
)
