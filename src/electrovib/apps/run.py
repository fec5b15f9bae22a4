"""The main job: a scenario in, a Trace and a report out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.apps.changes import readable_changes
from electrovib.apps.progress import tracked
from electrovib.core.errors import InputError, gathered
from electrovib.solve.scenario import DEFAULT, Scenario, load, scenario_of
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    import xarray


def run(
    scenario: str | Path | Scenario | Mapping[str, Any] = DEFAULT,
    *,
    set: Mapping[str, Any] | Sequence[str] = (),  # noqa: A002 - the name of the option
    over: Sequence[str] | Mapping[str, Sequence[float]] = (),
    output: str | Path | None = None,
    report: str | Path | None = None,
) -> xarray.Dataset:
    """Simulate a finger on a charged plate and write what came out.

    Parameters
    ----------
    scenario : str, Path, Scenario or mapping
        A TOML file, a paper's scenario (``"vezzoli_2014/fig6"``), or a Trace file, whose run is repeated.
    set : mapping of str to value, or sequence of str, optional
        Dotted path to value: ``{"drive.high": "150 V"}`` or ``["drive.high=150 V"]``.
    over : sequence of str, or mapping of str to sequence of float
        ``"path=from:to:n"`` or ``"path=from:to:nlog"``; each gives the Trace a dimension.
    output : str or Path, optional
        Where the Trace goes: ``.nc``, ``.csv`` or ``.mat``.
    report : str or Path, optional
        Where the HTML report goes.

    Returns
    -------
    xarray.Dataset
        The Trace.

    Raises
    ------
    ElectrovibError
        For anything a user can mend, all at once as far as it can be told; nothing has been written then.
    """
    experiment, axes = _prepared(scenario, set, over, (output, report))
    with tracked("simulating") as progress:
        if axes:
            from electrovib.study.sweep import sweep

            trace = sweep(experiment, axes, progress=progress)
        else:
            trace = simulate(experiment)
    if output is not None:
        from electrovib.export.save import save

        save(trace, Path(output))
    if report is not None:
        from electrovib.view.report import report as write_report

        with tracked("drawing the report"):
            write_report(_named(trace, scenario), Path(report))
    return trace


def _named(
    trace: xarray.Dataset, source: str | Path | Scenario | Mapping[str, Any]
) -> xarray.Dataset | dict[str, xarray.Dataset]:
    """Give a Trace without a title the name of its file."""
    if trace.attrs["title"] or not isinstance(source, (str, Path)):
        return trace
    return {Path(source).stem: trace}


def _prepared(
    scenario: str | Path | Scenario | Mapping[str, Any],
    changes: Mapping[str, Any] | Sequence[str],
    over: Sequence[str] | Mapping[str, Sequence[float]],
    outputs: tuple[str | Path | None, str | Path | None],
) -> tuple[Scenario, dict[str, Any]]:
    """Find scenario and sweep; list what is wrong with file, options and outputs at once."""
    found, problems = readable_changes(changes)
    experiment, axes = None, {}
    with gathered(problems):
        experiment, axes = _experiment(scenario, found)
    if experiment is not None and over:
        with gathered(problems):
            axes = _axes(experiment, over)
    with gathered(problems):
        _check_outputs(*outputs, axes)
    if problems or experiment is None:
        raise InputError(problems)
    return experiment, axes


def _check_outputs(output: str | Path | None, report: str | Path | None, axes: Mapping[str, Any]) -> None:
    """Find out before the work whether its results can be written."""
    from electrovib.data.atomic import check_writable
    from electrovib.export.save import check_output

    problems: list[str] = []
    if output is not None:
        with gathered(problems):
            check_output(Path(output), dict.fromkeys(("time", "frequency", "layer", *axes), 1))
    if report is not None and Path(report).suffix not in {".html", ".htm"}:
        problems.append(f"--report {report}: a report is an .html file")
    elif report is not None:
        with gathered(problems):
            check_writable([Path(report)])
    if problems:
        raise InputError(problems)


def _axes(experiment: Scenario, over: Sequence[str] | Mapping[str, Sequence[float]]) -> dict[str, Any]:
    if isinstance(over, Mapping):
        return dict(over)
    from electrovib.study.sweep import parse_over

    return dict(parse_over(experiment, over))


def _experiment(
    source: str | Path | Scenario | Mapping[str, Any], changes: Mapping[str, Any]
) -> tuple[Scenario, dict[str, Any]]:
    """Find the scenario, and the sweep if a swept Trace is to be repeated."""
    if isinstance(source, Scenario):
        return source.replace(changes) if changes else source, {}
    if isinstance(source, Mapping) or Path(source).suffix not in {".nc", ".csv", ".mat"}:
        found = load(source, changes=changes)
        assert isinstance(found, Scenario)
        return found, {}
    trace = load(source)
    experiment = scenario_of(trace)
    axes = json.loads(trace.attrs.get("over", "{}"))
    return experiment.replace(changes) if changes else experiment, axes
