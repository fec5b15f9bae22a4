"""The report of one run or several, as one HTML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from electrovib.core.errors import ElectrovibError, InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.core.trace import is_study_result, is_trace
from electrovib.data.atomic import write_text
from electrovib.data.marks import Form
from electrovib.view.pages import check_page
from electrovib.view.report_figures import figures

if TYPE_CHECKING:
    import xarray

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
        from electrovib.view.studied import study_page

        text = study_page(studied, title=title)
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
    from electrovib.study.population import open_study

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
    from electrovib.view.residuals import residual_rows
    from electrovib.view.swept import swept_texts

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
