"""A fit as a folder: a page with data, model, residuals and table, and its parameters as CSV and TOML."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.core.signals import SIGNALS
from electrovib.data.marks import Form
from electrovib.recordings.fit.misfit import LEVEL
from electrovib.recordings.interval import MISFIT
from electrovib.study.reproduction import Table
from electrovib.view.fitted_files import parameters_csv, scenario_toml, space_toml
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from electrovib.recordings.fit import ScenarioFit
    from electrovib.recordings.fit.posterior import Posterior
    from electrovib.recordings.fit.prediction import Residuals
    from electrovib.recordings.fit.separate import FitComparison
    from electrovib.recordings.interval import EstimatedParameter
    from electrovib.scenario import Scenario

FILES: Final[dict[str, Form]] = {
    "report.html": Form.PAGE,
    "parameters.csv": Form.TABLE,
    "parameters.toml": Form.SCENARIO,
    "space.toml": Form.SPACE,
}
"""Files of a fit and their forms."""
CHAINS: Final[dict[str, Form]] = {"posterior.nc": Form.NETCDF}
"""Further file of a fit with a posterior distribution."""
DETERMINED: Final = {
    "well": "well",
    "weakly": "weakly",
    "not": "not determined",
    "bound": "on its bound",
    MISFIT: "the model does not describe the data",
}
REFERENCES: Final = (
    "M. Newville et al., LMFIT: non-linear least-square minimization and curve-fitting for Python, Zenodo",
    "K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed., Springer, 2002",
)


def write_fit(
    folder: Path,
    found: ScenarioFit,
    rows: Sequence[EstimatedParameter],
    *,
    comparison: FitComparison | None = None,
    posterior: Posterior | None = None,
    force: bool = False,
) -> list[Path]:
    """Write a fit into a folder, all files or none."""
    from electrovib.data.atomic import writing
    from electrovib.view.fitted_posterior import chains_bytes

    texts = {
        "report.html": fit_page(found, rows, comparison=comparison, posterior=posterior),
        "parameters.csv": parameters_csv(rows, found.diagnostics, found.misfit.sentence, *found.prescribed),
        "parameters.toml": scenario_toml(found),
        "space.toml": space_toml(found, rows),
    }
    contents = {name: text.encode() for name, text in texts.items()}
    if posterior is not None:
        contents |= dict.fromkeys(CHAINS, chains_bytes(posterior, rows))
    folder.mkdir(parents=True, exist_ok=True)
    outputs = {folder / name: (FILES | CHAINS)[name] for name in contents}
    with writing(outputs, force=force) as temporary:
        for path, content in zip(outputs, contents.values(), strict=True):
            temporary[path].write_bytes(content)
    return list(outputs)


def fit_page(
    found: ScenarioFit,
    rows: Sequence[EstimatedParameter],
    *,
    comparison: FitComparison | None = None,
    posterior: Posterior | None = None,
) -> str:
    """Write the page of a fit."""
    from electrovib.view import summary
    from electrovib.view.few_curves import few_curves
    from electrovib.view.fitted_panels import fit_panels
    from electrovib.view.fitted_posterior import EMCEE, posterior_table
    from electrovib.view.pages import page
    from electrovib.view.reproduced_page import drawn, page_figures
    from electrovib.view.svg import to_svg

    panels = [part for panel in fit_panels(found.residuals) for part in few_curves(panel)]
    drawings = {}
    for panel in panels:
        figure = drawn(panel)
        figure.axes[0].set_title("", loc="left")  # on the page it is a heading
        drawings[panel.id] = to_svg(figure)
    return page(
        "comparison.html.jinja",
        judged={"": found.diagnostics},
        title=f"Fit: {found.scenario.title or 'a scenario'}",
        answer=fit_answer(found, rows, comparison=comparison),
        figures=page_figures(panels, drawings),
        tables=[
            _estimates(rows),
            *([posterior_table(posterior, rows)] if posterior is not None else []),
            *([_compared(comparison)] if comparison is not None else []),
            _correlations(found),
            _residuals(found.residuals),
        ],
        pages=[],
        references=[*cited_of(found.scenario), *REFERENCES, *([EMCEE] if posterior is not None else [])],
        versions=summary.versions(),
    )


def fit_answer(
    found: ScenarioFit, rows: Sequence[EstimatedParameter], *, comparison: FitComparison | None = None
) -> str:
    """State in a few sentences what the data determine, what they do not, and which model they support."""
    counted = found.estimate.count
    known = [row for row in rows if row.method and row.state in {"well", "weakly", MISFIT}]
    parts = [f"{row.name} = {with_interval(row)}" for row in known[:6]]
    told = found.misfit.sentence
    text = f"{told[0].upper()}{told[1:]}. " if told else ""
    text += f"Fitted to {counted} numbers: {'; '.join(parts) or 'no parameter is determined'}."
    text += "".join(f" {each}." for each in found.prescribed)
    for each in found.undetermined:
        text += f" {each.sentence[0].upper()}{each.sentence[1:]}."
    if found.rounding is not None:
        text += f" {found.rounding.sentence[0].upper()}{found.rounding.sentence[1:]}."
    if comparison is not None and comparison.sentence:
        text += f" {comparison.sentence[0].upper()}{comparison.sentence[1:]}."
    if found.estimate.stalled:
        text += " The search was ended there, because further steps made the estimate no more likely."
    elif not found.estimate.converged:
        text += " The search ended without having converged."
    return text


def with_interval(row: EstimatedParameter) -> str:
    """Write an estimate with its 95 % interval, or the reason why it has none."""
    value, ends = row.shown(pretty_quantity)
    return f"{value} ({ends})" if ends else f"{value}, without an interval: {row.note}"


def by_calibration(row: EstimatedParameter) -> str:
    """Write the interval of an estimate by calibration errors alone; ``not stated`` without any."""
    ends = row.systematic_ends
    if not math.isfinite(row.systematic):
        return "not stated"
    return " to ".join(pretty_quantity(end, row.unit, digits=max(row.digits, 4)) for end in ends)


def _estimates(rows: Sequence[EstimatedParameter]) -> Table:
    shown = []
    for row in rows:
        error, (value, ends) = row.standard_error, row.shown(pretty_quantity)
        deviation = pretty_quantity(error, row.unit, digits=2) if math.isfinite(error) else "none"
        told = (row.method or "none", by_calibration(row), DETERMINED[row.state])
        cells = (value, deviation, ends or "none", *told)
        shown.append((row.name, *cells, row.note))
    headings = (
        "Parameter", "Estimate", "Standard deviation", "95 % interval", "Interval from", "95 % by calibration", "Determined",
        "Note",
    )  # fmt: skip
    caption = (
        "Well determined: the standard deviation of the logarithm is at most 0.1, and the bias by the curvature of the model at"
        " most 0.05 standard deviations. Not determined: a member of a combination"
        " whose logarithm has a standard deviation above 1, or one that trades with a parameter on its bound. The model does not"
        f" describe the data: noise would leave such residuals in {1000 * LEVEL:g} of 1000 fits of the right model; the"
        " intervals are widened by what is left. By calibration: interval by the stated systematic errors of the"
        " signals alone, which do not average out."
    )
    return Table("Parameters", headings, tuple(shown), caption=caption)


def _compared(comparison: FitComparison) -> Table:
    rows = tuple(
        (name, f"{aicc:.4g}", f"{bic:.4g}")
        for name, aicc, bic in zip(comparison.names, comparison.aicc, comparison.bic, strict=True)
    )
    return Table(
        "Models",
        ("Model", "AICc above the best", "BIC above the best by AICc"),
        rows,
        caption=comparison.sentence,
    )


def _correlations(found: ScenarioFit) -> Table:
    names = list(found.estimate.values)
    rows = tuple(
        (name, *("" if not math.isfinite(each) else f"{each:+.2f}" for each in row))
        for name, row in zip(names, found.correlation, strict=True)
    )
    caption = "Empty where a parameter is not determined or lies on a bound."
    return Table("Correlation of the estimates", ("", *names), rows, caption=caption)


def _residuals(residuals: Sequence[Residuals]) -> Table:
    rows = []
    for each in residuals:
        unit = "" if each.observed.relative else SIGNALS[each.observed.signal].unit
        noise, rms = (
            pretty_quantity(number, unit, digits=3) if unit else f"{100 * number:.3g} %"
            for number in (each.noise, each.root_mean_square)
        )
        stated = "stated" if each.observed.noise is not None else "estimated"
        rows.append(
            (each.recording, each.observed.signal, str(each.observed.x.size), rms, f"{noise} ({stated})")
        )
    headings = ("Recording", "Signal", "Samples", "Root mean square residual", "Noise")
    return Table("Residuals", headings, tuple(rows))


def cited_of(scenario: Scenario) -> list[str]:
    """Return the citations of the papers whose models or values a scenario takes."""
    from electrovib.core.discovery import paper_of, papers
    from electrovib.core.model import Model

    owners = {paper_of(type(part)) for _, part in scenario if isinstance(part, Model)}
    named = " ".join(scenario.sources.values())
    return [str(module.CITATION) for name, module in papers().items() if name in owners or name in named]
