"""The report of one run or several, as one HTML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from electrovib.core.errors import ElectrovibError, InputError, gathered
from electrovib.core.files import inputs_noted
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
        Computed or measured; several are overlaid. A scenario, or the name of its file, is simulated. Or one study: the
        result of `electrovib.study`, or its store.
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
    output = Path(path)
    studied = _study(traces)
    if studied is not None:
        from electrovib.view.studied import study_page

        check_page(output, force=force)
        write_text(output, study_page(studied, title=title), Form.PAGE, force=force)
        return output
    problems: list[str] = []
    found: dict[str, Any] = {}
    with inputs_noted() as inputs, gathered(problems):
        found = _loaded(traces)
    with gathered(problems):
        check_page(output, inputs=inputs, force=force)
    if problems:
        raise InputError(problems)
    known = _simulated(found)
    write_text(output, page_of(known, title=title), Form.PAGE, force=force)
    return output


def _study(source: Any) -> xarray.Dataset | None:
    """Return the result of a study, if it is one or its store; several, or one beside Traces, are refused."""
    from electrovib.core.trace import is_study_result

    items = list(source) if isinstance(source, (list, tuple)) else [source]
    stores = [each for each in items if isinstance(each, (str, Path)) and Path(each).is_dir()]
    studies = [each for each in items if is_study_result(each)]
    if not stores and not studies:
        return None
    if len(items) > 1:
        raise InputError("a report shows one study, or Traces; give them one at a time")
    if studies:
        found: xarray.Dataset = studies[0]
        return found
    from electrovib.study.population import open_study

    return open_study(stores[0])


def collect(traces: Any) -> dict[str, xarray.Dataset]:
    """Load or simulate the sources, and label each Trace by the caller's label, its title or its file name.

    Raises
    ------
    InputError
        For everything that cannot be loaded, together.
    """
    return _simulated(_loaded(traces))


def _loaded(traces: Any) -> dict[str, Any]:
    """Load the sources; label to Trace or Scenario."""
    import xarray

    from electrovib.core.trace import is_trace
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
            found[label] = opened if is_trace(opened := open_if_trace(item)) else read_scenario(opened)
    if problems:
        raise InputError(problems)
    return found


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


def page_of(traces: Mapping[str, xarray.Dataset], *, title: str | None = None) -> str:
    """Write the page.

    Parameters
    ----------
    traces : mapping of str to Trace
        Label to Trace.
    title : str, optional
        Of the page.

    Returns
    -------
    str
        HTML.
    """
    from electrovib.view import summary, tables
    from electrovib.view.lines import scenario_or_none
    from electrovib.view.pages import page
    from electrovib.view.residuals import residual_rows

    scenarios = {label: found for label, trace in traces.items() if (found := scenario_or_none(trace))}
    swept = {label: texts for label, trace in traces.items() if (texts := summary.swept_texts(trace))}
    return page(
        "report.html.jinja",
        title=title or _title(traces),
        labels=list(traces),
        openings={label: line for label, trace in traces.items() if (line := summary.opening(trace))},
        diagnostics={
            label: shown for label, trace in traces.items() if (shown := summary.diagnostics(trace))
        },
        unreadable=[
            label for label, trace in traces.items() if "scenario" in trace.attrs and label not in scenarios
        ],
        numbers=side_by_side([summary.key_numbers(trace) for trace in traces.values()]),
        swept=swept,
        figures=figures(traces, scenarios),
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
