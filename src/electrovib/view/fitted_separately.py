"""Fits of many recordings one by one, as a folder: a page, one table as CSV and a space of parameters."""

from __future__ import annotations

import csv
import io
import math
from typing import TYPE_CHECKING, Final

from electrovib.core.diagnostics import comment_lines
from electrovib.data.marks import Form, unsigned
from electrovib.recordings.fit.separate import FAILED
from electrovib.study.reproduction import Table
from electrovib.view.fitted import DETERMINED, REFERENCES, by_calibration, cited_of
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from pathlib import Path

    from electrovib.recordings.fit.separate import SeparateFits
    from electrovib.recordings.interval import EstimatedParameter

FILES: Final[dict[str, Form]] = {
    "report.html": Form.PAGE,
    "parameters.csv": Form.TABLE,
    "space.toml": Form.SPACE,
}
"""Files of separate fits and their forms."""
_COLUMNS: Final = {"value": "value", "deviation": "standard_error", "lower": "lower", "upper": "upper"}


def write_separate_fits(folder: Path, found: SeparateFits, *, force: bool = False) -> list[Path]:
    """Write separate fits into a folder, all files or none."""
    from electrovib.data.atomic import writing

    texts = {
        "report.html": separate_page(found),
        "parameters.csv": separate_csv(found),
        "space.toml": _space_toml(found),
    }
    folder.mkdir(parents=True, exist_ok=True)
    outputs = {folder / name: FILES[name] for name in texts}
    with writing(outputs, force=force) as temporary:
        for path, text in zip(outputs, texts.values(), strict=True):
            temporary[path].write_text(text, encoding="utf-8")
    return list(outputs)


def separate_csv(found: SeparateFits) -> str:
    """Write the table of separate fits as CSV, in SI units, with full precision: a row for each recording and parameter."""
    text = io.StringIO()
    text.write(f"# {unsigned(Form.TABLE)}\n{comment_lines(found.diagnostics)}")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        (
            "record",
            "parameter",
            "unit",
            *_COLUMNS,
            "method",
            "status",
            "systematic",
            "reduced_chi_square",
            "note",
        )
    )
    for each in found.fits:
        for row in each.rows:
            writer.writerow(_cells(each.record, row, each.reduced_chi_square))
    for row in found.means:
        writer.writerow(_cells(f"mean of {len(found.spreads[row.name].values)} recordings", row, math.nan))
    return text.getvalue()


def _cells(record: str, row: EstimatedParameter, chi_square: float) -> list[str]:
    name = row.name.removeprefix(f"{record}: ")
    numbers = [repr(float(getattr(row, column))) for column in _COLUMNS.values()]
    return [
        record,
        name,
        row.unit,
        *numbers,
        row.method,
        row.state,
        repr(row.systematic),
        repr(chi_square),
        row.note,
    ]


def separate_page(found: SeparateFits) -> str:
    """Write the page of separate fits: one figure and one table over all recordings."""
    from electrovib.view import summary
    from electrovib.view.fitted_over_recordings import parameter_panels
    from electrovib.view.pages import page
    from electrovib.view.reproduced_page import drawn, page_figures
    from electrovib.view.svg import to_svg

    panels = parameter_panels(found)
    drawings = {}
    for panel in panels:
        figure = drawn(panel)
        figure.axes[0].set_title("", loc="left")  # on the page it is a heading
        drawings[panel.id] = to_svg(figure)
    return page(
        "comparison.html.jinja",
        judged={"": found.diagnostics},
        title=f"Separate fits: {found.scenario.title or 'a scenario'}",
        answer=separate_answer(found),
        figures=page_figures(panels, drawings),
        tables=[_estimates(found), *([_means(found)] if found.spreads else [])],
        pages=[],
        references=[*cited_of(found.scenario), *REFERENCES[:1]],
        versions=summary.versions(),
    )


def separate_answer(found: SeparateFits) -> str:
    """State how many recordings were fitted, the mean of each parameter, and its scatter within and between recordings."""
    failed = found.failures
    text = f"{len(found.fits) - len(failed)} of {len(found.fits)} recordings were fitted, each alone."
    if failed:
        text += f" Not fitted: {'; '.join(f'{record} ({why})' for record, why in failed.items())}."
    for record, why in found.misfits.items():
        text += f" {record}: {why}."
    for row in found.means:
        mean, ends = row.shown(pretty_quantity)
        counted = len(found.spreads[row.name].values)
        text += f" {row.name}: mean of {counted} recordings {mean} ({ends}); {row.note}."
    return text


def _estimates(found: SeparateFits) -> Table:
    shown = []
    for each in found.fits:
        chi_square = each.reduced_chi_square
        for row in each.rows:
            value, ends = row.shown(pretty_quantity) if math.isfinite(row.value) else ("none", "")
            status = DETERMINED.get(row.state, row.state)
            shown.append(
                (
                    each.record, row.name.removeprefix(f"{each.record}: "), value, ends or "none", row.method or "none",
                    by_calibration(row), status,
                    f"{chi_square:.3g}" if math.isfinite(chi_square) else "", row.note,
                )
            )  # fmt: skip
    headings = (
        "Recording", "Parameter", "Estimate", "95 % interval", "Interval from", "95 % by calibration", "Determined",
        "Reduced chi-square", "Note",
    )  # fmt: skip
    caption = (
        "Reduced chi-square: weighted sum of squares over the degrees of freedom; empty where the noise is estimated from the"
        f" residuals, which makes it 1. A recording that could not be fitted is marked '{FAILED}'."
    )
    return Table("Parameters of each recording", headings, tuple(shown), caption=caption)


def _means(found: SeparateFits) -> Table:
    rows = []
    for row in found.means:
        spread = found.spreads[row.name]
        numbers = (pretty_quantity(each, row.unit, digits=3) for each in (spread.within, spread.between))
        rows.append((row.name, str(len(spread.values)), *row.shown(pretty_quantity), *numbers))
    headings = (
        "Parameter", "Recordings", "Mean", "95 % interval of the mean",
        "Standard deviation within a recording", "Standard deviation between recordings",
    )  # fmt: skip
    caption = "Recordings count alike; those that do not determine the parameter are omitted. Interval by Student's t."
    return Table("Means over the recordings", headings, tuple(rows), caption=caption)


def _space_toml(found: SeparateFits) -> str:
    """Write the distribution of each parameter over recordings as the table ``space`` of a TOML file, in SI."""
    import tomlkit

    from electrovib.recordings.fit.result import space_tables

    between = {path: each.between for path, each in found.spreads.items()}
    tables = space_tables(found.means, {path: path for path in found.spreads}, between=between)
    text = tomlkit.dumps({"space": tables})
    remark = (
        "The distributions of the parameters over the recordings; correlations between them are not stated."
    )
    return f"# {unsigned(Form.SPACE)}\n# {remark}\n{text}"
