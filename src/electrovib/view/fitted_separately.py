"""Fits of many recordings one by one, as a folder: a page, one table as CSV and a space of parameters."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel, Table
from electrovib.core.paths import quantity_at, words_at
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form, csv_text, unsigned
from electrovib.recordings.fit.result import FAILED
from electrovib.recordings.interval import MISFIT
from electrovib.view.fitted import DETERMINED, REFERENCES, by_calibration, row_sentence
from electrovib.view.summary import references

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.recordings.fit.misfit import BetweenSessions
    from electrovib.recordings.fit.result import RecordedFit
    from electrovib.recordings.interval import EstimatedParameter
    from electrovib.scenario import Scenario

_MOST: Final = 2
"""Most recordings that are named before they are counted."""
_STOPPED: Final = "warning: the search ended without having converged"
_COLUMNS: Final = {"value": "value", "deviation": "standard_error", "lower": "lower", "upper": "upper"}


@dataclass(frozen=True, kw_only=True, repr=False)
class SeparateFits(Answer):
    """Parameters of a scenario estimated from each of several recordings alone, and their spread between these."""

    FILES: ClassVar = {"parameters.csv": Form.TABLE, "space.toml": Form.SPACE}
    scenario: Scenario
    free: tuple[str, ...]
    fits: tuple[RecordedFit, ...]
    spreads: Mapping[str, BetweenSessions]

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with the parameters estimated from each recording."""
        return tuple(
            dict.fromkeys(
                one for each in self.fits if each.found is not None for one in each.found.diagnostics
            )
        )

    @property
    def failures(self) -> dict[str, str]:
        """Name of each recording that could not be fitted, and why."""
        return {each.record: each.problem for each in self.fits if each.found is None}

    @property
    def misfits(self) -> dict[str, str]:
        """Name of each recording that the model does not describe, and what its residuals show."""
        found = {each.record: each.found.misfit for each in self.fits if each.found is not None}
        return {record: each.sentence for record, each in found.items() if each.reasons}

    @property
    def means(self) -> tuple[EstimatedParameter, ...]:
        """Mean of each parameter over the recordings that determine it, with its interval by Student's t.

        Its systematic error is the mean of theirs: the sensors are the same, and their error does not average
        out.
        """
        found = []
        for path, spread in self.spreads.items():
            missed = [record for record in self.misfits if record in spread.values]
            counted = f"{len(missed)} of the {len(spread.values)} recordings"
            why = f"the model does not describe {counted}" if missed else ""
            errors = [
                row.systematic
                for each in self.fits
                for row in each.rows
                if row.name == path and each.record in spread.values
            ]
            mean = spread.estimated(path, quantity_at(self.scenario, path), why, MISFIT if why else "well")
            found.append(replace(mean, systematic=statistics.fmean(errors)))
        return tuple(found)

    @property
    def document(self) -> Document:
        """One figure for each parameter and one table over all recordings."""
        return Document(
            title=f"Separate fits: {self.scenario.titled() or 'a scenario'}",
            sentences=_sentences(self),
            diagnostics=self.diagnostics,
            figures=[_panel(self, path) for path in self.free],
            tables=[_estimates(self), *([_means(self)] if self.spreads else [])],
            remarks=[
                f"{each.record}: {text}"
                for each in self.fits
                if each.found is not None
                for text in (*each.found.prescribed, *([] if each.found.estimate.converged else [_STOPPED]))
            ],
            references=[*dict(references({"": self.scenario})), *REFERENCES[:1]],
            brief=True,
        )

    def content(self, name: str) -> str:
        """Write the table as CSV, or the space of the estimates."""
        return _csv(self) if name.endswith(".csv") else _space_toml(self)


def _csv(found: SeparateFits) -> str:
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


def _sentences(found: SeparateFits) -> list[str]:
    """State which recordings were not fitted or are not described, and the mean of each parameter with its scatter."""
    failed, misfits = found.failures, found.misfits
    lines = [f"warning: {record}: {why}" for record, why in misfits.items()]
    lines += [f"{record}: failed: {why}" for record, why in failed.items()]
    if len(lines) > _MOST:
        counted = f"{len(misfits)} of {len(found.fits)} recordings, and {len(failed)} could not be fitted"
        lines = [lines[0], f"warning: the model does not describe {counted}: the table names them"]
    lines.append(f"{len(found.fits) - len(failed)} of {len(found.fits)} recordings were fitted, each alone")
    for row in found.means:
        counted = f"mean of {len(found.spreads[row.name].values)} recordings"
        lines.append(row_sentence(row).replace(row.name, f"{row.name}, {counted}", 1))
    if not found.means:
        own = ((each.record, row) for each in found.fits if each.found is not None for row in each.rows)
        lines += [f"{record}: {row_sentence(row)}" for record, row in own]
    return lines


def _estimates(found: SeparateFits) -> Table:
    shown = []
    for each in found.fits:
        chi_square = each.reduced_chi_square
        for row in each.rows:
            value, ends = row.texts(row.unit) if math.isfinite(row.value) else ("none", "")
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
        numbers = (format_quantity(each, row.unit, digits=3) for each in (spread.within, spread.between))
        rows.append((row.name, str(len(spread.values)), *row.texts(row.unit), *numbers))
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
