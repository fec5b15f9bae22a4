"""Fits of many recordings one by one, as a folder: a page, one table as CSV and a space of parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel, Table
from electrovib.core.paths import words_at
from electrovib.data.marks import Form, csv_text, unsigned
from electrovib.recordings.fit.sessions import FAILED
from electrovib.view.fitted import DETERMINED, REFERENCES, by_calibration
from electrovib.view.tables import references
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from electrovib.recordings.fit.sessions import SeparateFits
    from electrovib.recordings.interval import EstimatedParameter

_COLUMNS: Final = {"value": "value", "deviation": "standard_error", "lower": "lower", "upper": "upper"}


@dataclass(frozen=True, kw_only=True, repr=False)
class SeparateAnswer(Answer):
    """Fits of many recordings one by one."""

    FILES: ClassVar = {"parameters.csv": Form.TABLE, "space.toml": Form.SPACE}
    found: SeparateFits

    @property
    def document(self) -> Document:
        """One figure for each parameter and one table over all recordings."""
        found = self.found
        return Document(
            title=f"Separate fits: {found.scenario.titled() or 'a scenario'}",
            sentences=[separate_answer(found)],
            diagnostics=found.diagnostics,
            figures=[_panel(found, path) for path in found.free],
            tables=[_estimates(found), *([_means(found)] if found.spreads else [])],
            references=[*dict(references({"": found.scenario})), *REFERENCES[:1]],
        )

    def content(self, name: str) -> str:
        """Write the table as CSV, or the space of the estimates."""
        return separate_csv(self.found) if name.endswith(".csv") else _space_toml(self.found)


def separate_csv(found: SeparateFits) -> str:
    """Write the table of separate fits as CSV, in SI units, with full precision: a row for each recording and parameter."""
    cells = [_cells(each.record, row, each.reduced_chi_square) for each in found.fits for row in each.rows]
    cells += [
        _cells(f"mean of {len(found.spreads[row.name].values)} recordings", row, math.nan)
        for row in found.means
    ]
    headings = (
        "record", "parameter", "unit", *_COLUMNS, "method", "status", "systematic", "reduced_chi_square", "note",
    )  # fmt: skip
    return csv_text(headings, cells, diagnostics=found.diagnostics)


def _cells(record: str, row: EstimatedParameter, chi_square: float) -> list[object]:
    name = row.name.removeprefix(f"{record}: ")
    numbers = (float(getattr(row, column)) for column in _COLUMNS.values())
    return [record, name, row.unit, *numbers, row.method, row.state, row.systematic, chi_square, row.note]


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


def _panel(found: SeparateFits, path: str) -> Panel:
    """Make the figure of a parameter over the numbered recordings, with 95 % intervals and the mean."""
    own = [next((row for row in each.rows if row.name == path), None) for each in found.fits]
    rows = [row for row in own if row is not None]
    numbers = np.array([number for number, row in enumerate(own, start=1) if row is not None], dtype=float)
    gap = np.full(numbers.size, math.nan)
    ends = np.array([[row.lower, row.upper, math.nan] for row in rows]).ravel()
    curves = [
        Curve(
            label="95 % interval",
            x=np.column_stack([numbers, numbers, gap]).ravel(),
            y=np.where(np.isfinite(ends), ends, math.nan),
            look=0,
        ),
        Curve(label="estimate", x=numbers, y=np.array([row.value for row in rows]), kind="points", look=0),
    ]
    if path in found.spreads:
        spread = found.spreads[path]
        across = np.array([0.5, len(own) + 0.5])
        curves.append(Curve(label="mean", x=across, y=np.full(2, spread.mean), kind="dashed", look=REFERENCE))
    names = ", ".join(f"{number}: {each.record}" for number, each in enumerate(found.fits, start=1))
    return Panel(
        id=f"parameter-{path.replace('.', '-')}",
        title=f"{words_at(found.scenario, path)} over the recordings",
        caption=f"Recordings {names}. An interval that has no end is not drawn.",
        x=("recording", "1"),
        y=(words_at(found.scenario, path), rows[0].unit if rows else "1"),
        curves=tuple(curves),
    )
