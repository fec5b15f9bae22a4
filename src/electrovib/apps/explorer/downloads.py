"""What a visitor can take away: the scenario, its numbers, its figures, a report, the references."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
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


def _saved(shown: Computed, name: str) -> bytes:
    """Return the file as which a Trace is saved under this name."""
    from electrovib.exports.save import save

    with tempfile.TemporaryDirectory(prefix="electrovib-") as folder:
        (path,) = save(shown.trace, Path(folder) / name)
        return path.read_bytes()


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
    *(
        Download(label, name, kind, functools.partial(_saved, name=name))
        for label, name, kind in (
            ("Numbers over time (CSV)", "trace.csv", "text/csv"),
            ("Trace (netCDF)", "trace.nc", "application/x-netcdf"),
            ("Figures (PNG)", "figures.png", "image/png"),
            ("Figures (SVG)", "figures.svg", "image/svg+xml"),
            ("Figures (PDF)", "figures.pdf", "application/pdf"),
            ("Report (HTML)", "report.html", "text/html"),
        )
    ),
    Download("References (BibTeX)", "references.bib", "application/x-bibtex", _bibliography),
)
