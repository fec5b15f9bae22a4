"""The report of one run or several, as one HTML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.core.signals import is_study_result, is_trace, signal
from electrovib.data.atomic import write_text
from electrovib.data.marks import Form
from electrovib.recordings.importing.merging import is_measured, residuals
from electrovib.view.lines import envelope
from electrovib.view.pages import check_page, inline, markup, to_svg
from electrovib.view.report_figures import figures
from electrovib.view.style import COLOURS, NEUTRAL, new_figure, style
from electrovib.view.units import label_axis, pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray
    from markupsafe import Markup
    from matplotlib.axes import Axes

    from electrovib.core.arrays import Real
    from electrovib.recordings.importing.merging import SignalResidual
    from electrovib.scenario import Scenario

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
        The HTML file; replaced as a whole.
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
    """
    reported(traces, path, title=title, force=force)
    return Path(path)


def reported(
    traces: Any, path: str | Path, *, title: str | None = None, force: bool = False
) -> dict[str, xarray.Dataset]:
    """Write a report as `report` does."""
    output = Path(path)
    problems: list[str] = []
    found: dict[str, Any] = {}
    with inputs_noted() as inputs, gathered(problems):
        found = _loaded(traces)
    with gathered(problems):
        check_page(output, inputs=inputs, force=force)
    if problems:
        raise InputError(problems)
    studies = {label: found.pop(label) for label in list(found) if is_study_result(found[label])}
    if len(studies) > 1:
        raise InputError(f"a report shows one study, alone or with Traces; these are {len(studies)}")
    studied = next(iter(studies.values()), None)
    shown = _simulated(found) if found or studied is None else {}
    if studied is not None and not shown:
        from electrovib.view.documents import html
        from electrovib.view.studied import study_document

        text = html(study_document(studied, title=title))
    else:
        text = page_of(shown, title=title, studied=studied)
    write_text(output, text, Form.PAGE, force=force)
    return {**studies, **shown}


def collect(traces: Any) -> dict[str, xarray.Dataset]:
    """Load or simulate the sources, and label each Trace by the caller's label, its title or its file name."""
    return _simulated(_loaded(traces))


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
    if problems:
        raise InputError(problems)
    return found


def _study(item: Any) -> xarray.Dataset | None:
    """Return the result of a study, if it is one or its store."""
    if is_study_result(item):
        result: xarray.Dataset = item
        return result
    if not isinstance(item, (str, Path)) or not Path(item).is_dir():
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
    if problems:
        raise InputError(problems)
    return labelled(traces)


def _label(item: Any) -> str:
    if isinstance(item, (str, Path)):
        return Path(item).stem
    return str(getattr(item, "title", "") or getattr(item, "attrs", {}).get("title", ""))


_OF_SWEEP: Final = "Each diagnostic is that of the case nearest to its limit, or furthest beyond it."


def page_of(
    traces: Mapping[str, xarray.Dataset],
    *,
    title: str | None = None,
    studied: xarray.Dataset | None = None,
) -> str:
    """Write the page."""
    from electrovib.view import summary, tables
    from electrovib.view.lines import scenario_or_none
    from electrovib.view.pages import page
    from electrovib.view.report import residual_rows
    from electrovib.view.summary import swept_texts

    drawn = []
    if studied is not None:
        from electrovib.view.studied import band_figures

        drawn = band_figures(studied, traces)
    scenarios = {label: found for label, trace in traces.items() if (found := scenario_or_none(trace))}
    swept = {label: texts for label, trace in traces.items() if (texts := swept_texts(trace))}
    return page(
        "report.html.jinja",
        title=title or _title(traces),
        labels=list(traces),
        openings={label: line for label, trace in traces.items() if (line := summary.opening(trace))},
        judged={label: summary.diagnostics(trace) for label, trace in traces.items()},
        judged_note=_OF_SWEEP if swept else "",
        unreadable=[
            label for label, trace in traces.items() if "scenario" in trace.attrs and label not in scenarios
        ],
        numbers=side_by_side([summary.key_numbers(trace) for trace in traces.values()]),
        swept=swept,
        figures=[*drawn, *figures(traces, scenarios)],
        residuals=residual_rows(traces),
        rows=tables.parameter_rows(scenarios, swept),
        with_scenario=list(scenarios),
        models={label: tables.model_rows(scenario) for label, scenario in _different(scenarios).items()},
        provenance=side_by_side([summary.provenance(trace) for trace in traces.values()]),
        scenarios={label: summary.scenario_text(scenario) for label, scenario in scenarios.items()},
        references=tables.references(scenarios),
        versions=summary.versions(),
    )


def _title(traces: Mapping[str, xarray.Dataset]) -> str:
    if len(traces) == 1:
        label, trace = next(iter(traces.items()))
        return str(trace.attrs.get("title") or label)
    return f"{len(traces)} Traces compared"


def _different(scenarios: Mapping[str, Scenario]) -> dict[str, Scenario]:
    """Return one scenario of each set of models, under the labels of all that share it."""
    from electrovib.view.tables import model_rows

    found: dict[str, Scenario] = {}
    seen: dict[str, list[str]] = {}
    for label, scenario in scenarios.items():
        key = str(model_rows(scenario))
        seen.setdefault(key, []).append(label)
        if len(seen[key]) == 1:
            found[label] = scenario
    return {
        ", ".join(next(group for group in seen.values() if group[0] == label)): found[label]
        for label in found
    }


def side_by_side(columns: Sequence[Mapping[str, str]]) -> dict[str, tuple[str, ...]]:
    """Combine the texts of several Traces into rows; a dash where one has none."""
    words = dict.fromkeys(word for column in columns for word in column)
    return {word: tuple(column.get(word, "–") for column in columns) for word in words}


_WIDTH: Final = 9.4
_HEIGHT: Final = 3.6
_MOST: Final = 6


@dataclass(frozen=True, kw_only=True)
class ResidualRow:
    """One row of the table: a measured signal beside a prediction of it."""

    measured: str
    predicted: str
    signal: str
    rms: str
    relative: str
    mean: str
    span: str
    svg: Markup | None


def residual_rows(traces: Mapping[str, xarray.Dataset]) -> list[ResidualRow]:
    """Compare every measurement of a report with every prediction, a row for each signal they share; sweeps are omitted."""
    plain = {label: trace for label, trace in traces.items() if "quantities" not in trace.attrs}
    rows: list[ResidualRow] = []
    for measured, recorded in plain.items():
        for predicted, computed in plain.items():
            if not is_measured(recorded) or is_measured(computed):
                continue
            for each in residuals(computed, recorded):
                rows.append(_row(each, measured, predicted, f"residual{len(rows)}", drawn=len(rows) < _MOST))
    return rows


def _row(found: SignalResidual, measured: str, predicted: str, name: str, *, drawn: bool) -> ResidualRow:
    unit = signal(found.name).unit
    along = signal(found.along).unit
    first, last = (pretty_quantity(float(end), along, digits=4) for end in found.axis[[0, -1]])
    words = found.name.replace("_", " ")
    if found.predicted_name != found.name:
        words += f" (predicted: {found.predicted_name.replace('_', ' ')})"
    return ResidualRow(
        measured=measured,
        predicted=predicted,
        signal=words,
        rms=pretty_quantity(found.rms, unit, digits=4),
        relative=f"{100 * found.relative_rms:.3g} %",
        mean=pretty_quantity(found.mean, unit, digits=4),
        span=f"{first} … {last}, {found.axis.size} samples",
        svg=_figure(found, measured, predicted, name) if drawn else None,
    )


def _figure(found: SignalResidual, measured: str, predicted: str, name: str) -> Markup:
    """Draw measurement and prediction, and their residual below; of an impedance the moduli."""
    figure = new_figure((_WIDTH, _HEIGHT))
    with style():
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
        words, unit = found.name.replace("_", " "), signal(found.name).unit
        complex_valued = np.iscomplexobj(found.measured)
        if complex_valued:
            words = f"modulus of {words}"
            above.set_yscale("log")
        if found.along == "frequency":
            above.set_xscale("log")
        _curve(above, found.axis, found.measured, COLOURS[0], measured)
        _curve(above, found.axis, found.predicted, COLOURS[1], predicted)
        _curve(below, found.axis, found.residual, COLOURS[0], "")
        below.axhline(0.0, color=NEUTRAL, linewidth=0.8)
        above.legend(loc="best")
        label_axis(above.yaxis, words, unit)
        label_axis(below.yaxis, "residual", unit)
        label_axis(below.xaxis, found.along, signal(found.along).unit)
    return markup(
        inline(to_svg(figure), name=name, words=f"{words}: {measured} beside {predicted}, and residual")
    )


def _curve(ax: Axes, axis: Real, values: np.ndarray, colour: str, label: str) -> None:
    x, y = envelope(axis, np.abs(values) if np.iscomplexobj(values) else np.asarray(values, dtype=float))
    ax.plot(x, y, color=colour, label=label or "_nolegend_")
