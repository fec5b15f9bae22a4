"""What a visitor can take away: the scenario, its numbers, its figures, a report, the references."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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


def _csv(shown: Computed) -> bytes:
    """Return the tables over time and over frequency as one archive."""
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in _saved(shown, "trace.csv").items():
            packed.writestr(name, content)
    return archive.getvalue()


def _figure(shown: Computed) -> Figure:
    """Draw drive, attraction and friction over time, and the mean force over frequency, as printed figures."""
    from electrovib.view import plots
    from electrovib.view.style import new_figure, style

    figure = new_figure((9.0, 6.0))
    with style():
        axes = figure.subplots(2, 2).ravel()
    wanted = (
        (plots.drive, ("drive_voltage", "drive_current")),
        (plots.force, ("electrostatic_force",)),
        (plots.lateral_force, ("lateral_force",)),
        (plots.frequency_response, ("mean_force",)),
    )
    for ax, (draw, signals) in zip(axes, wanted, strict=True):
        if any(signal in shown.trace for signal in signals):
            draw(shown.trace, ax=ax)
        else:
            ax.set_axis_off()
    return figure


def _drawn(shown: Computed, kind: str) -> bytes:
    output = BytesIO()
    _figure(shown).savefig(output, format=kind, metadata={"Date": None} if kind == "svg" else None)
    return output.getvalue()


def _report(shown: Computed) -> bytes:
    from electrovib.view.report import report

    with tempfile.TemporaryDirectory(prefix="electrovib-") as folder:
        return report(shown.trace, Path(folder) / "report.html").read_bytes()


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
    Download(
        "Trace (netCDF)",
        "trace.nc",
        "application/x-netcdf",
        lambda shown: _saved(shown, "trace.nc")["trace.nc"],
    ),
    Download("Figures (PNG)", "figures.png", "image/png", lambda shown: _drawn(shown, "png")),
    Download("Figures (SVG)", "figures.svg", "image/svg+xml", lambda shown: _drawn(shown, "svg")),
    Download("Report (HTML)", "report.html", "text/html", _report),
    Download("References (BibTeX)", "references.bib", "application/x-bibtex", _bibliography),
)
