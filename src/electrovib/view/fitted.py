"""The result of a fit: data, model, residuals and table, and its parameters as CSV and TOML."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel, Table
from electrovib.core.diagnostics import warning_lines
from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity
from electrovib.core.versions import versions
from electrovib.data.atomic import WRITTEN_BY, Form, csv_text, unsigned
from electrovib.recordings.fit.misfit import LEVEL
from electrovib.recordings.fit.result import omitted_from_space, space_correlations, space_tables
from electrovib.recordings.fit.weighing import PRIOR
from electrovib.recordings.interval import MISFIT, UNCLEAR
from electrovib.view.style import MOST, pretty_quantity
from electrovib.view.summary import references

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.recordings.fit.of_scenario import Posterior
    from electrovib.recordings.fit.prediction import Residuals
    from electrovib.recordings.fit.result import ScenarioFit
    from electrovib.recordings.fit.weighing import FitComparison, MarginalLikelihood
    from electrovib.recordings.interval import EstimatedParameter
    from electrovib.scenario import Scenario

CHAINS: Final[dict[str, str | None]] = {"posterior.nc": Form.NETCDF}
"""Further file of a fit with a posterior distribution."""
DETERMINED: Final = {
    "well": "well",
    "weakly": "weakly",
    "not": "not determined",
    "bound": "on its bound",
    MISFIT: "the model does not describe the data",
    UNCLEAR: "not shown to be well",
}
REFERENCES: Final = (
    "M. Newville et al., LMFIT: non-linear least-square minimization and curve-fitting for Python, Zenodo",
    "K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed., Springer, 2002",
)


@dataclass(frozen=True, kw_only=True, repr=False)
class FitResult(Answer):
    """Parameters of a scenario estimated from recordings, with the models compared.

    Parameters
    ----------
    best : ScenarioFit
        Fit of the scenario that was asked for.
    rows : tuple of EstimatedParameter
        Its table: estimates in SI with 95 % intervals, or the reason why there is none.
    others : mapping of str to ScenarioFit
        Fits of the other models.
    comparison : FitComparison or None
        Of all models; None without others.
    posterior : Posterior or None
        Posterior distribution of the parameters of `best`; None unless it was asked for.
    """

    FILES: ClassVar = {
        "parameters.csv": Form.TABLE,
        "correlations.csv": Form.TABLE,
        "parameters.toml": Form.SCENARIO,
        "space.toml": Form.SPACE,
        "fit.txt": Form.TEXT,
    }
    best: ScenarioFit
    rows: tuple[EstimatedParameter, ...]
    others: Mapping[str, ScenarioFit]
    comparison: FitComparison | None
    posterior: Posterior | None = None

    @property
    def scenario(self) -> Scenario:
        """The scenario with the estimated parameters."""
        return self.best.scenario

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of that scenario."""
        return self.best.diagnostics

    @property
    def files(self) -> Mapping[str, str | None]:
        """Files of the numbers, with the chains of a posterior distribution."""
        return self.FILES | (CHAINS if self.posterior is not None else {})

    @property
    def document(self) -> Document:
        """What the data determine, data with model, residuals, and every table."""
        found, rows, comparison = self.best, self.rows, self.comparison
        fitted = [each.path for each in found.unknowns]
        numbers, figures, tables = list[Table](), fit_panels(found.residuals), [_estimates(rows)]
        cited = [*dict(references({"": found.scenario})), *REFERENCES]
        if self.posterior is not None:
            numbers.append(posterior_table(self.posterior, rows))
            cited.append(EMCEE)
        if comparison is not None and comparison.is_weighed:
            figures += model_panels(comparison, self.others, found)
            tables = [*_compared(comparison), *tables]
            cited.append(DYNESTY)
        elif comparison is not None:
            tables += _compared(comparison)
        return Document(
            title=f"Fit: {found.scenario.titled(without=fitted) or 'a scenario'}",
            sentences=fit_sentences(found, rows, comparison=comparison),
            numbers=numbers,
            brief=True,
            diagnostics=found.diagnostics,
            figures=figures,
            tables=[*tables, _correlations(found), _residuals(found.residuals)],
            references=cited,
        )

    def content(self, name: str) -> str | bytes:
        """Write estimates or correlations as CSV, the scenario with them, the space of them, all as a text, or the chains."""
        found, rows = self.best, self.rows
        if name == "parameters.csv":
            return parameters_csv(rows, found.diagnostics, found.misfit.sentence, *found.prescribed)
        if name == "correlations.csv":
            estimate = found.estimate
            numbers = zip(estimate.values, estimate.correlation.tolist(), strict=True)
            cells = ([each, *(one if math.isfinite(one) else None for one in line)] for each, line in numbers)
            return csv_text(("", *estimate.values), cells, diagnostics=found.diagnostics)
        if name == "fit.txt":
            return fit_text(found, rows)
        if name == "parameters.toml":
            return scenario_toml(found)
        if self.posterior is not None and name in CHAINS:
            return chains_bytes(self.posterior, rows)
        return space_toml(found, rows)


def fit_sentences(
    found: ScenarioFit, rows: Sequence[EstimatedParameter], *, comparison: FitComparison | None = None
) -> list[str]:
    """State which model the data support, whether it describes them, each estimate, and what they do not determine."""
    estimate = found.estimate
    lines = [comparison.sentence] if comparison is not None and comparison.sentence else []
    lines += [f"warning: {found.misfit.sentence}"] if found.misfit.sentence else []
    lines += ["; ".join(found.prescribed)] if found.prescribed else []
    if estimate.stalled:
        lines.append("warning: the search was ended, because further steps made the estimate no more likely")
    elif not estimate.converged:
        lines.append("warning: the search ended without having converged")
    noted: set[str] = set()
    for row in sorted(rows, key=lambda row: row.method != "sessions"):  # means over sessions first
        lines.append(row_sentence(row, noted))
    return lines


def row_sentence(row: EstimatedParameter, noted: set[str] | None = None) -> str:
    """Write one estimate with its interval, or why it has none; a note that was `noted` before is left out."""
    line = f"{row.name}: {row.in_words(row.unit, why=row.note)}"
    if not row.method:
        return line
    if math.isfinite(row.systematic):
        line += f", by calibration {by_calibration(row)}"
    noted = set() if noted is None else noted
    note = "" if row.note in noted else row.note
    noted.add(row.note)
    return f"{line}\n  {note}" if note else line


def fit_text(found: ScenarioFit, rows: Sequence[EstimatedParameter]) -> str:
    """Write a fit as a short text to paste: law, data, each parameter with its interval, what makes it doubtful, version."""
    data: dict[str, list[str]] = {}
    for each in found.residuals:
        data.setdefault(each.recording, []).append(each.observed.signal.replace("_", " "))
    recorded = "; ".join(f"{name} ({', '.join(signals)})" for name, signals in data.items())
    law, count = type(found.scenario.force).__name__, found.estimate.count
    of = found.scenario.titled(without=[each.path for each in found.unknowns]) or "A scenario"
    lines = [
        f"{of}, force law {law}, fitted to {count} numbers of {recorded}. Intervals of 95 %.",
        *(f"{row.name} = {with_interval(row)}" for row in rows),
        *_remarks(found.misfit.sentence, *found.prescribed),
        *warning_lines(found.diagnostics, brief=True),
        f"electrovib {versions()['electrovib']}; {unsigned(Form.TEXT)}",
    ]
    return "\n".join([*lines, ""])


def with_interval(row: EstimatedParameter) -> str:
    """Write an estimate with its 95 % interval, or the reason why it has none."""
    value, ends = row.texts(row.unit, write=pretty_quantity)
    return f"{value} ({ends})" if ends else f"{value}, without an interval: {row.note}"


def by_calibration(row: EstimatedParameter) -> str:
    """Write the interval of an estimate by calibration errors alone; ``not stated`` without any."""
    ends = row.systematic_ends
    if not math.isfinite(row.systematic):
        return "not stated"
    return " to ".join(format_quantity(end, row.unit, digits=row.digits) for end in ends)


def _estimates(rows: Sequence[EstimatedParameter]) -> Table:
    shown = []
    for row in rows:
        error, (value, ends) = row.standard_error, row.texts(row.unit)
        deviation = format_quantity(error, row.unit, digits=2) if math.isfinite(error) else "none"
        of_method = (row.method or "none", by_calibration(row), DETERMINED[row.state])
        shown.append((row.name, value, deviation, ends or "none", *of_method, row.note))
    headings = (
        "Parameter", "Estimate", "Standard deviation", "95 % interval", "Interval from", "95 % by calibration", "Determined",
        "Note",
    )  # fmt: skip
    caption = (
        "Well determined: the standard deviation of the logarithm is at most 0.1, and the bias by the curvature of the model at"
        " most 0.05 standard deviations. Not determined: a member of a combination"
        " whose logarithm has a standard deviation above 1, or one that trades with a parameter on its bound. The model does not"
        f" describe the data: noise would leave such residuals in {1000 * LEVEL:g} of 1000 fits of the right model; the"
        " intervals are widened by what is left. Not shown to be well: the residuals are correlated, by"
        " noise with a memory or by a model that is wrong, and the intervals include the correlation. By calibration: interval by"
        " the stated systematic errors of the signals alone, which do not average out."
    )
    return Table("Parameters", headings, tuple(shown), caption=caption)


def _compared(comparison: FitComparison) -> list[Table]:
    """Make the table of the models, and that of those that could not be fitted."""
    candidates, words = comparison.candidates, comparison.sentence
    columns = {
        "Model": [each.name for each in candidates],
        "AICc above the best": [f"{each.aicc:.4g}" for each in candidates],
        "BIC above the best by AICc": [f"{each.bic:.4g}" for each in candidates],
    }
    if comparison.is_weighed:
        known = [each.evidence for each in candidates if each.evidence]
        highest, words = max(each.log for each in known), f"{words}. {PRIOR}"
        columns["ln evidence below the best"] = [_evidence(each, highest) for each in known]
        columns["Probability"] = [per_cent(each.probability) for each in candidates]
    columns["What speaks against it"] = [each.against or "nothing" for each in candidates]
    found = [Table("Models", tuple(columns), tuple(zip(*columns.values(), strict=True)), caption=words)]
    if comparison.refused:
        found.append(Table("Models not fitted", ("Model", "Why"), tuple(comparison.refused.items())))
    return found


def _evidence(each: MarginalLikelihood, highest: float) -> str:
    below = f"{highest - each.log:.4g}" if each.log > -math.inf else f"> {highest - each.peak:.3g}"
    return f"{below}{f' +- {each.error:.1g}' if each.error else ''} ({each.method})"


def per_cent(probability: float) -> str:
    """Write a probability; very small ones are not told apart."""
    return f"{100 * probability:.3g} %" if probability >= 1e-4 else "< 0.01 %"


def _correlations(found: ScenarioFit) -> Table:
    names = list(found.estimate.values)
    rows = tuple(
        (name, *("" if not math.isfinite(each) else f"{each:+.2f}" for each in row))
        for name, row in zip(names, found.estimate.correlation, strict=True)
    )
    caption = "Empty where a parameter is not determined or lies on a bound."
    return Table("Correlation of the estimates", ("", *names), rows, caption=caption)


def _residuals(residuals: Sequence[Residuals]) -> Table:
    rows = []
    for each in residuals:
        unit = "" if each.observed.relative else SIGNALS[each.observed.signal].unit
        noise, rms = (
            format_quantity(number, unit, digits=3) if unit else f"{100 * number:.3g} %"
            for number in (each.noise, each.root_mean_square)
        )
        stated = "stated" if each.observed.noise is not None else "estimated"
        rows.append(
            (each.recording, each.observed.signal, str(each.observed.x.size), rms, f"{noise} ({stated})")
        )
    headings = ("Recording", "Signal", "Samples", "Root mean square residual", "Noise")
    return Table("Residuals", headings, tuple(rows))


def parameters_csv(rows: Sequence[EstimatedParameter], diagnostics: Sequence[Diagnostic], *said: str) -> str:
    """Write the table of a fit as CSV, in SI units, with full precision, below what is said about model and residuals."""
    names = ("name", "unit", "value", "deviation", "lower", "upper", "method", "state", "systematic", "note")
    cells = [
        [row.standard_error if name == "deviation" else getattr(row, name) for name in names] for row in rows
    ]
    return csv_text(names, cells, remarks=said, diagnostics=diagnostics)


def scenario_toml(found: ScenarioFit) -> str:
    """Write the scenario with the estimated parameters as a TOML file, which `electrovib.load` reads."""
    from electrovib.scenario.toml import to_toml

    lines = (unsigned(Form.SCENARIO), *_remarks(found.misfit.sentence, *found.prescribed))
    return "".join(f"# {line}\n" for line in lines) + to_toml(found.scenario)


def _remarks(*said: str) -> list[str]:
    """Return sentences as lines of a comment; those that say nothing are omitted."""
    return [" ".join(each.split()) for each in said if each]


def space_toml(found: ScenarioFit, rows: Sequence[EstimatedParameter]) -> str:
    """Write the estimates as the tables ``space`` and ``correlation`` of a TOML file, and why parameters are omitted."""
    import tomlkit

    means = {f"{path} (mean of {len(each.values)} sessions)": path for path, each in found.sessions.items()}
    paths = {each.name: each.path for each in found.unknowns if not each.is_offset and not each.session}
    between = {path: each.between for path, each in found.sessions.items()}
    tables = space_tables(rows, paths | means, between=between)
    pairs = space_correlations(found, tables)
    remarks = [
        f"{path} is omitted: {why}" for path, why in omitted_from_space(rows, paths | means, tables).items()
    ]
    remarks += [
        f"{path} varies between sessions: no correlation with the others is stated"
        for path in found.sessions
        if path in tables and len(tables) > 1
    ]
    content: dict[str, object] = {"space": tables}
    if pairs:
        content["correlation"] = {f"{first} ~ {second}": value for (first, second), value in pairs.items()}
    lines = [unsigned(Form.SPACE), *_remarks(found.misfit.sentence, *remarks)]
    return "".join(f"# {line}\n" for line in lines) + tomlkit.dumps(content)


_MOST_POINTS: Final = 600
"""Samples of a recording that a figure shows."""
_BOTH: Final = "Points: data. Lines: model with the estimated parameters."


def fit_panels(residuals: Sequence[Residuals]) -> list[Panel]:
    """Make the figures of a fit: data with model, and residuals, one figure for all recordings of a signal."""
    panels: list[Panel] = []
    for signal in dict.fromkeys(each.observed.signal for each in residuals):
        panels += _of_signal(signal, [each for each in residuals if each.observed.signal == signal])
    return panels


def _of_signal(signal: str, own: Sequence[Residuals]) -> list[Panel]:
    words, unit = signal.replace("_", " "), SIGNALS[signal].unit
    both: list[tuple[str, str, str, Any]] = [(f"{words[0].upper()}{words[1:]}", words, unit, np.real)]
    if own[0].observed.parts == 2:
        both = [
            (both[0][0], f"modulus of the {words}", unit, np.abs),
            (f"Phase of the {words}", "phase", "rad", np.angle),
        ]
    found = [
        Panel(
            id=f"{'phase' if part is np.angle else 'data'}-{signal}",
            title=f"{what}: data and model",
            caption=_BOTH,
            y=(label, of),
            curves=_both(own, part),
            log_y=part is np.abs,
            **_along(own[0]),
        )
        for what, label, of, part in both
    ]
    left = [
        (each.recording, *_left(each, each.noise * each.observed.scale), at) for at, each in enumerate(own)
    ]
    caption = "Data less model over the standard deviation of the noise; of complex data the real part."
    return [*found, _of_residuals(f"residuals-{signal}", f"Residuals of the {words}", caption, left, own[0])]


def model_panels(
    comparison: FitComparison, others: Mapping[str, ScenarioFit], best: ScenarioFit
) -> list[Panel]:
    """Make a figure for each signal of what the first models leave of it, over the noise of the most probable one."""
    names = [each.name for each in comparison.candidates[:MOST]]
    caption = f"Data less model over the noise of {names[0]}; of complex data the real part."
    panels = []
    for signal in dict.fromkeys(each.observed.signal for each in best.residuals):
        first, *more = (
            [each for each in others.get(name, best).residuals if each.observed.signal == signal]
            for name in names
        )
        noises = [each.noise * each.observed.scale for each in first]
        rows = [[_left(*each) for each in zip(own, noises, strict=True)] for own in (first, *more)]
        left = [
            (name, *(np.concatenate(each) for each in zip(*row, strict=True)), at)
            for at, (name, row) in enumerate(zip(names, rows, strict=True))
        ]
        title = f"Residuals of the {signal.replace('_', ' ')} by each model"
        panels.append(_of_residuals(f"models-{signal}", title, caption, left, first[0]))
    return panels


def _left(each: Residuals, noise: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return abscissa and residual over noise of some samples."""
    few = _few(each)
    return each.observed.x[few], np.real(each.values / noise)[few]


def _of_residuals(id: str, title: str, caption: str, left: Sequence[Any], of: Residuals) -> Panel:  # noqa: A002
    """Draw residuals, each as label, abscissa, values and look."""
    curves = tuple(Curve(label=label, x=x, y=y, kind="points", look=look) for label, x, y, look in left)
    return Panel(
        id=id, title=title, caption=caption, y=("residual over noise", "1"), curves=curves, **_along(of)
    )


def _along(of: Residuals) -> dict[str, Any]:
    axis = of.observed.axis
    return {"x": (axis, SIGNALS[axis].unit), "log_x": axis == "frequency"}


def _both(own: Sequence[Residuals], part: Callable[..., NDArray[np.float64]]) -> tuple[Curve, ...]:
    curves = []
    for at, each in enumerate(own):
        x, few = each.observed.x, _few(each)
        data = np.asarray(part(each.observed.y))
        shade = at if own[1:] else REFERENCE  # a line over points of its own colour hides them
        curves += [
            Curve(label=f"{each.recording}, data", x=x[few], y=data[few], kind="points", look=shade),
            Curve(label=f"{each.recording}, model", x=x, y=np.asarray(part(each.predicted)), look=at),
        ]
    return tuple(curves)


def _few(each: Residuals) -> NDArray[np.int64]:
    """Indices of at most `_MOST_POINTS` samples, evenly over the recording."""
    size = each.observed.x.size
    return np.unique(np.linspace(0, size - 1, min(size, _MOST_POINTS)).astype(np.int64))


DYNESTY: Final = (
    "J. S. Speagle, dynesty: a dynamic nested sampling package for estimating Bayesian posteriors and evidences,"
    " Mon. Not. R. Astron. Soc. 493, 3132 (2020)"
)
EMCEE: Final = (
    "D. Foreman-Mackey, D. W. Hogg, D. Lang, J. Goodman, emcee: The MCMC Hammer,"
    " Publ. Astron. Soc. Pac. 125, 306 (2013)"
)


def posterior_table(posterior: Posterior, rows: Sequence[EstimatedParameter]) -> Table:
    """Make the table of a posterior distribution, with its diagnostics of convergence."""
    known = {row.name: row for row in rows}
    shown = []
    for name, samples in posterior.samples.items():
        row = known[name]
        median, lower, upper = (
            format_quantity(float(each), row.unit, digits=row.digits)
            for each in (np.median(samples), *posterior.interval(name))
        )
        time = f"{posterior.autocorrelation_time[name]:.3g}"
        shown.append((name, median, f"{lower} to {upper}", time))
    first = next(iter(posterior.chains.values()))
    caption = (
        f"{first.shape[1]} chains of {posterior.steps} steps, the first {posterior.burn_in} omitted; seed {posterior.seed};"
        f" {100 * posterior.acceptance:.0f} % of the proposals accepted. "
    )
    caption += (
        f"The samples may not represent the distribution: {'; '.join(posterior.problems)}."
        if posterior.problems
        else "The diagnostics of convergence raise no objection."
    )
    headings = ("Parameter", "Median", "95 % interval", "Autocorrelation time in steps")
    return Table("Posterior distribution", headings, tuple(shown), caption=caption)


def chains_bytes(posterior: Posterior, rows: Sequence[EstimatedParameter]) -> bytes:
    """Return the chains of a posterior distribution as a netCDF file, with the mark by which a later fit may replace it."""
    from electrovib.data.traces import in_memory
    from electrovib.recordings.fit.of_scenario import chains_of

    chains = chains_of(posterior, {row.name: row.unit for row in rows})
    chains.attrs = {WRITTEN_BY: unsigned(Form.NETCDF)} | chains.attrs
    return in_memory(chains, {}).getvalue()
