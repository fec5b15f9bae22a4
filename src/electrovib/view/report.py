"""The report of one run or several, with measured signals beside predictions of them, as one HTML file."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.answer import Document, Drawing, Page, Table
from electrovib.core.diagnostics import Diagnostic, diagnostics_of
from electrovib.core.errors import ElectrovibError, InputError, gathered, refuse
from electrovib.core.files import inputs_noted, kind_of
from electrovib.core.signals import SIGNALS, is_study_result, is_trace, signal
from electrovib.data.atomic import output_path
from electrovib.scenario import scenario_of
from electrovib.view import summary
from electrovib.view.files import check_document, save_document
from electrovib.view.lines import Line, draw, finish, scenario_or_none
from electrovib.view.report_figures import figures
from electrovib.view.style import COLOURS, NEUTRAL, pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray
    from matplotlib.figure import Figure

    from electrovib.core.arrays import Complex, Real
    from electrovib.scenario import Scenario

_IMPORTED: Final = "file_sha256"
"""Attribute of a Trace that was imported from a file of an instrument."""


@dataclass(frozen=True, kw_only=True)
class Compared:
    """One signal of a measurement and of a prediction, whose labels are given, at the times or frequencies of the measurement."""

    measurement: str
    prediction: str
    name: str
    predicted_name: str
    along: str
    axis: Real
    measured: Real | Complex
    predicted: Real | Complex

    @property
    def residual(self) -> Real | Complex:
        """Measured less predicted, shape (n,), in the SI unit of the signal."""
        return np.asarray(np.subtract(self.measured, self.predicted))

    @property
    def signal(self) -> str:
        """Name of the signal, and of what was predicted where that is another one."""
        words, other = (name.replace("_", " ") for name in (self.name, self.predicted_name))
        return words if other == words else f"{words} (predicted: {other})"

    @property
    def mean(self) -> float:
        """Mean of the residual, in the SI unit of the signal; of an impedance the mean of its real part."""
        return float(np.mean(self.residual).real)


def rms(values: Real | Complex) -> float:
    """Return a root mean square, in the unit of the values [1]."""
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def compare(traces: Mapping[str, xarray.Dataset]) -> list[Compared]:
    """Compare every measurement with every prediction, by label, for each signal that they share."""
    return [
        each
        for measurement, recorded in traces.items()
        for prediction, computed in traces.items()
        if _IMPORTED in recorded.attrs and _IMPORTED not in computed.attrs
        for each in _shared(measurement, recorded, prediction, computed)
    ]


def _shared(
    measurement: str, recorded: xarray.Dataset, prediction: str, computed: xarray.Dataset
) -> Iterator[Compared]:
    """Iterate over the signals of both whose axes overlap in two samples.

    A measured force is compared with the force as the tribometer reads it, or with the force itself where
    none is modelled.
    """
    for name in map(str, recorded.data_vars):
        plain = name.removesuffix("_measured")
        other = name if name in computed else plain if plain in SIGNALS else name
        along = str(recorded[name].dims[-1])
        if other not in computed or {recorded[name].dims, computed[other].dims} != {(along,)}:
            continue
        axis, grid = np.asarray(recorded[along].values), np.asarray(computed[along].values)
        own, values = np.asarray(recorded[name].values), np.interp(axis, grid, computed[other].values)
        known = (axis >= grid[0]) & (axis <= grid[-1]) & np.isfinite(values) & np.isfinite(own)
        if np.count_nonzero(known) > 1:
            yield Compared(
                measurement=measurement, prediction=prediction, name=name, predicted_name=other, along=along,
                axis=axis[known], measured=own[known], predicted=values[known],
            )  # fmt: skip


Source: TypeAlias = "xarray.Dataset | Scenario | str | Path"


def report(
    traces: Source | Sequence[Source] | Mapping[str, Source],
    path: str | Path,
    *,
    title: str | None = None,
    force: bool = False,
) -> Path:
    """Write a report: the result, its validity, the figures, the assumptions and their sources.

    Parameters
    ----------
    traces : Trace, file name, sequence of these, or mapping of label to these
        Computed or measured; several are overlaid, recordings as points under the others. A scenario, or the name of its
        file, is simulated. One study, the result of `electrovib.study` or its store, alone or with Traces, which are drawn
        over its bands.
    path : str or Path
        The HTML file, or a figure or its tables, as for `electrovib.save`; replaced as a whole.
    title : str, optional
        Of the page; by default that of the Trace.
    force : bool
        Whether a file that we did not write may be replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If something is not a Trace, or if the file cannot be written or would replace one that is read or not ours;
        nothing has been written then.

    Examples
    --------
    >>> ev.report(["vezzoli_2014/fig6", "vezzoli_2014/fig6_gap"], "two.html").name
    'two.html'
    """
    reported(traces, path, title=title, force=force)
    return Path(path)


def reported(traces: Any, path: str | Path, *, title: str | None = None, force: bool = False) -> Document:
    """Write a report as `report` does, and return what it says."""
    output = output_path(path)
    problems: list[str] = []
    found: dict[str, Any] = {}
    with inputs_noted() as inputs, gathered(problems):
        found = _loaded(traces)
    with gathered(problems):
        check_document(output, inputs=inputs, force=force)
    refuse(problems)
    studies = {label: found.pop(label) for label in list(found) if is_study_result(found[label])}
    if len(studies) > 1:
        raise InputError(f"a report shows one study, alone or with Traces; these are {len(studies)}")
    studied = next(iter(studies.values()), None)
    shown = _simulated(found) if found or studied is None else {}
    document = document_of(shown, title=title, studied=studied)
    save_document(document, output, force=force)
    return document


def _loaded(traces: Any) -> dict[str, Any]:
    """Load the sources; label to Trace or Scenario."""
    import xarray

    from electrovib.data.traces import open_if_trace
    from electrovib.scenario import read_scenario

    if isinstance(traces, Mapping) and not isinstance(traces, xarray.Dataset):  # a Dataset is a mapping too
        named = {str(label): item for label, item in traces.items()}
    else:
        items = list(traces) if isinstance(traces, (list, tuple)) else [traces]
        named = {}
        for number, item in enumerate(items, start=1):
            label = _label(item) or f"Trace {number}"
            named[label if label not in named else f"{label} ({number})"] = item
    found: dict[str, Any] = {}
    problems: list[str] = []
    for label, item in named.items():
        with gathered(problems):
            if (studied := _study(item)) is not None:
                found[label] = studied
                continue
            found[label] = opened if is_trace(opened := open_if_trace(item)) else read_scenario(opened)
    refuse(problems)
    return found


def _study(item: Any) -> xarray.Dataset | None:
    """Return the result of a study, if it is one or its store."""
    if is_study_result(item):
        result: xarray.Dataset = item
        return result
    if not isinstance(item, (str, Path)) or kind_of(item) != "folder":
        return None
    from electrovib.studies.population import open_study

    return open_study(item)


def _simulated(found: Mapping[str, Any]) -> dict[str, xarray.Dataset]:
    """Simulate the scenarios among what was loaded; Traces stay what they are."""
    from electrovib.scenario import Scenario
    from electrovib.solve.simulate import simulate
    from electrovib.view.lines import labelled

    traces: dict[str, xarray.Dataset] = {}
    problems: list[str] = []
    for label, item in found.items():
        try:
            traces[label] = simulate(item) if isinstance(item, Scenario) else item
        except ElectrovibError as error:
            problems += error.problems
    refuse(problems)
    return labelled(traces)


def _label(item: Any) -> str:
    if isinstance(item, (str, Path)):
        return Path(item).stem
    return str(getattr(item, "title", "") or getattr(item, "attrs", {}).get("title", ""))


_OF_SWEEP: Final = "Each diagnostic is that of the case nearest to its limit, or furthest beyond it."


def document_of(
    traces: Mapping[str, xarray.Dataset],
    *,
    title: str | None = None,
    studied: xarray.Dataset | None = None,
) -> Document:
    """Say what runs, sweeps and recordings show, side by side, and the bands of a study under them."""
    from electrovib.studies.population import answer as of_study

    if studied is not None and not traces:
        return of_study.study_document(studied, title=title)
    scenarios = {label: found for label, trace in traces.items() if (found := scenario_or_none(trace))}
    swept = {label: texts for label, trace in traces.items() if (texts := summary.swept_texts(trace))}
    bands = of_study.band_figures(studied, traces) if studied is not None else []
    compared = compare({label: each for label, each in traces.items() if not summary.is_sweep(each)})
    drawn = [*bands, *figures(traces, scenarios), *_residual_figures(compared)]
    return Document(
        title=title or _title(traces),
        sentences=_sentences(traces, swept),
        numbers=[
            *_side_by_side(
                "Key numbers", {label: summary.key_numbers(each) for label, each in traces.items()}, "number"
            ),
            *_residual_table(compared),
        ],
        diagnostics={label: _judged(trace, label) for label, trace in traces.items()},
        note=_OF_SWEEP if swept else "",
        figures=drawn,
        alone=next((each.id for each in drawn if each.plot != "stack"), ""),
        pages=[
            *summary.parameter_tables(scenarios, swept),
            *(summary.model_table(each, label) for label, each in _different(scenarios).items()),
            *_side_by_side(
                "Provenance", {label: summary.provenance(each) for label, each in traces.items()}, "hash"
            ),
            *(
                _listing(each, label if len(traces) > 1 else "", folded=len(scenarios) > 1)
                for label, each in scenarios.items()
            ),
        ],
        references=[f"{reference} ({used})" for reference, used in summary.references(scenarios)],
    )


def _sentences(traces: Mapping[str, xarray.Dataset], swept: Mapping[str, Mapping[str, str]]) -> list[str]:
    """Write the answer of each Trace, and what was swept."""
    of = {label: f"{label}: " if len(traces) > 1 else "" for label in traces}
    said = [f"{of[label]}{line}" for label, trace in traces.items() if (line := summary.opening(trace))]
    for label, texts in swept.items():
        over = ", ".join(f"{path} = {text}" for path, text in texts.items())
        said.append(
            f"{of[label]}Swept over {over}. The stack is drawn with the values of the scenario before the sweep."
        )
    return said


def _judged(trace: xarray.Dataset, label: str) -> list[Diagnostic]:
    """Return the diagnostics of a Trace, and why its parameters are not shown where its scenario cannot be read."""
    unread = []
    if "scenario" in trace.attrs:
        try:
            scenario_of(trace)
        except (InputError, ValueError) as error:
            text = f"{label} is shown without its parameters: {error}"
            unread.append(Diagnostic("scenario", "warning", text))
    return [*diagnostics_of(trace), *unread]


def _listing(scenario: Scenario, label: str, *, folded: bool) -> Page:
    title = f"Scenario{f' of {label}' if label else ''}, as a file that repeats the run"
    return Page(title, (summary.scenario_text(scenario),), listing=True, folded=folded)


def _title(traces: Mapping[str, xarray.Dataset]) -> str:
    if len(traces) == 1:
        label, trace = next(iter(traces.items()))
        return str(trace.attrs.get("title") or label)
    return f"{len(traces)} Traces compared"


def _different(scenarios: Mapping[str, Scenario]) -> dict[str, Scenario]:
    """Return one scenario of each set of models, under the labels of all that share it; a single one without a label."""
    groups: dict[str, list[str]] = {}
    for label, scenario in scenarios.items():
        groups.setdefault(str(summary.model_rows(scenario)), []).append(label)
    named = len(groups) > 1
    return {", ".join(labels) if named else "": scenarios[labels[0]] for labels in groups.values()}


def _side_by_side(title: str, columns: Mapping[str, Mapping[str, str]], look: str) -> list[Table]:
    """Combine the texts of several Traces into the rows of a table, a dash where one has none; no table without texts."""
    words = dict.fromkeys(word for column in columns.values() for word in column)
    rows = tuple((word, *(column.get(word, "–") for column in columns.values())) for word in words)
    headings = tuple(columns) if len(columns) > 1 else ("",)
    looks = dict.fromkeys(range(1, len(columns) + 1), look)
    return [Table(title, ("", *headings), rows, looks=looks)] if rows else []


_TITLE: Final = "Measured and predicted"
_NOT_FITTED: Final = (
    "Residual: measured less predicted, at the samples of the measurement; the prediction is interpolated linearly."
    " Nothing was fitted."
)
_SIZE: Final = (9.4, 3.6)
"""Width and height of a figure of residuals [inch]."""
_MOST: Final = 6
"""Residuals that are drawn."""


def _residual_table(compared: Sequence[Compared]) -> list[Table]:
    headings = (
        *("signal", "measured", "predicted", "rms residual", "over rms of the measurement", "mean residual"),
        "compared over",
    )
    rows = tuple(_residual_row(each) for each in compared)
    looks = dict.fromkeys((3, 4, 5), "number")
    return [Table(_TITLE, headings, rows, caption=_NOT_FITTED, looks=looks)] if rows else []


def _residual_row(found: Compared) -> tuple[str, ...]:
    unit, along = signal(found.name).unit, signal(found.along).unit
    first, last = (pretty_quantity(float(end), along, digits=4) for end in found.axis[[0, -1]])
    left, size = rms(found.residual), rms(found.measured)
    return (
        found.signal,
        found.measurement,
        found.prediction,
        pretty_quantity(left, unit, digits=4),
        f"{100 * left / size if size else math.nan:.3g} %",
        pretty_quantity(found.mean, unit, digits=4),
        f"{first} … {last}, {found.axis.size} samples",
    )


def _residual_figures(compared: Sequence[Compared]) -> list[Drawing]:
    drawn = []
    for number, each in enumerate(compared[:_MOST]):
        beside = f"{each.measurement} beside {each.prediction}"
        caption = f"{each.signal[:1].upper()}{each.signal[1:]}: {beside}; the residual below."
        words = f"{each.signal}: {beside}, and residual"
        plot = functools.partial(_draw, each)
        drawn.append(
            Drawing(id=f"residual{number}", title=_TITLE, plot=plot, size=_SIZE, caption=caption, words=words)
        )
    return drawn


def _draw(found: Compared, figure: Figure) -> None:
    """Draw prediction and measured points, and their residual below; of an impedance the moduli."""
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    words, unit = found.name.replace("_", " "), signal(found.name).unit
    is_complex = np.iscomplexobj(found.measured)
    part = np.abs if is_complex else np.real
    if is_complex:
        words = f"modulus of {words}"
        above.set_yscale("log")
    if found.along == "frequency":
        above.set_xscale("log")
    points = Line(
        x=found.axis, y=part(found.measured), label=found.measurement, colour=COLOURS[0], measured=True
    )
    line = Line(x=found.axis, y=part(found.predicted), label=found.prediction, colour=COLOURS[1])
    residual = Line(x=found.axis, y=part(found.residual), label="", colour=COLOURS[0])
    below.axhline(0.0, color=NEUTRAL, linewidth=0.8)
    for ax, what, drawn in ((above, words, [points, line]), (below, "residual", [residual])):
        draw(ax, drawn)
        finish(ax, x=(found.along, signal(found.along).unit), y=(what, unit), drawn=drawn)
        ax.label_outer()
