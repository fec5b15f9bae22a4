"""Simulate or sweep a scenario, and write its Trace and report."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.apps.progress import tracked
from electrovib.core.budget import listening
from electrovib.core.diagnostics import Diagnostic, diagnostics_of
from electrovib.core.errors import InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.core.paths import value_at
from electrovib.core.signals import is_trace
from electrovib.core.tables import read_changes, stored_changes
from electrovib.data.atomic import VERIFIED
from electrovib.data.traces import open_if_trace
from electrovib.scenario import DEFAULT, Scenario, Source, changed_models, read_scenario, sweep_of
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    import xarray


def run(
    scenario: Source = DEFAULT,
    *,
    set: Mapping[str, Any] | Sequence[str] = (),  # noqa: A002 - the name of the option
    over: Sequence[str] | Mapping[str, Sequence[float]] = (),
    quantity: Sequence[str] = (),
    records: bool = False,
    output: str | Path | None = None,
    report: str | Path | None = None,
    force: bool = False,
) -> xarray.Dataset:
    """Simulate or sweep a scenario and write its result.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`; of a Trace the run or the sweep is repeated.
    set : mapping of str to value, or sequence of str, optional
        Dotted path to value: ``{"drive.high": "150 V"}`` or ``["drive.high=150 V"]``.
    over : sequence of str, or mapping of str to sequence of float
        ``"path=from:to:n"`` or ``"path=from:to:nlog"``: a sweep, which gives numbers for each case. A repeated sweep
        keeps its parameters; values that are given again replace the former ones.
    quantity : sequence of str, optional
        Names of quantities, as for `electrovib.sweep`; without `over`, those of one case.
    records : bool
        Keep the signals over time of each case of a sweep too.
    output : str or Path, optional
        File of the result: ``.nc``, ``.csv`` or ``.mat``; the CSV of a sweep has one row for each case.
    report : str or Path, optional
        File of the report, as for `electrovib.report`.
    force : bool
        Whether files that electrovib did not write may be replaced; a file that is read never is.

    Returns
    -------
    trace : xarray.Dataset
        Trace of the run, or table of the sweep as from `electrovib.sweep`.

    Raises
    ------
    ElectrovibError
        For mistakes of the user, all at once as far as possible; nothing has been written then.
    """
    problems: list[str] = []
    changes = read_changes(set, problems)
    experiment: Scenario | None = None
    earlier = _Wanted({}, (), records=False)
    with inputs_noted() as inputs, gathered(problems):
        source = open_if_trace(scenario)
        experiment = read_scenario(source, changes=changes, before_sweep=True)
        earlier = _earlier(source)
    asked = _Wanted(earlier.axes, quantity or earlier.quantities, records=records)
    wanted = _wanted(experiment, changes, over, asked, problems, source=scenario)
    wanted = replace(wanted, records=records or earlier.records)
    _check_outputs(wanted, (output, report), inputs, problems, force=force)
    if problems or experiment is None:
        raise InputError(problems)
    with tracked("simulating") as progress:
        if not wanted.is_sweep:
            trace = simulate(experiment)
        else:
            from electrovib.studies.sweep import sweep

            with listening(None):  # progress counts cases
                trace = sweep(
                    experiment,
                    wanted.axes,
                    quantity=wanted.quantities or None,
                    records=wanted.records,
                    progress=progress,
                )
    if is_trace(source):
        _warn_of_changed_models(trace, source, experiment)
    if output is not None:
        from electrovib.exports.save import save

        save(trace, Path(output), force=force)
    if report is not None:
        from electrovib.view.report import report as write_report

        with tracked("drawing the report"):
            write_report(_named(trace, scenario), Path(report), force=force)
    return trace


def _warn_of_changed_models(trace: xarray.Dataset, found: xarray.Dataset, experiment: Scenario) -> None:
    """Add to a repeated run that the Trace it repeats was not verified, and each own model that is not the one of it."""
    warnings = [Diagnostic("own models", "warning", text) for text in changed_models(found, experiment)]
    warnings += [each for each in diagnostics_of(found) if each.name == VERIFIED]
    if warnings:
        validity = [*json.loads(trace.attrs["validity"]), *(each.to_dict() for each in warnings)]
        trace.attrs["validity"] = json.dumps(validity)


def _named(trace: xarray.Dataset, source: Source) -> xarray.Dataset | dict[str, xarray.Dataset]:
    """Return a Trace without a title under the name of its file."""
    if trace.attrs["title"] or not isinstance(source, (str, Path)):
        return trace
    return {Path(source).stem: trace}


@dataclass(frozen=True)
class _Wanted:
    """Parameters and quantities of a sweep."""

    axes: Mapping[str, Any]
    quantities: Sequence[str]
    records: bool

    @property
    def is_sweep(self) -> bool:
        """Whether there is a case or a quantity to list, not one run over time."""
        return bool(self.axes or self.quantities)

    @property
    def dimensions(self) -> list[str]:
        """Dimensions of the result."""
        if not self.is_sweep:
            return ["time", "frequency", "layer"]
        return [*self.axes, *(("sample", "frequency", "layer") if self.records else ())]


def _wanted(
    experiment: Scenario | None,
    changes: Mapping[str, Any],
    over: Sequence[str] | Mapping[str, Sequence[float]],
    asked: _Wanted,
    problems: list[str],
    *,
    source: Source,
) -> _Wanted:
    """Read what a sweep is over, beside what is repeated, and its quantities; add what is wrong to the problems."""
    axes = asked.axes
    if experiment is not None:
        if over:
            from electrovib.studies.sweep import parse_over

            with gathered(problems):
                axes = {**axes, **parse_over(experiment, over)}
        if asked.quantities:
            from electrovib.studies.sweep import read_quantities

            with gathered(problems):
                read_quantities(experiment, asked.quantities)
    if axes:
        problems += _set_and_swept(changes, axes, asked.axes, source)
        if experiment is not None and not problems:
            axes = _set_levels(experiment, changes, axes) | dict(axes)
    elif asked.records:
        problems.append("--records: keeps the records of a sweep; add --over")
    return replace(asked, axes=axes)


def _check_outputs(
    wanted: _Wanted,
    outputs: tuple[str | Path | None, str | Path | None],
    inputs: Sequence[Path],
    problems: list[str],
    *,
    force: bool,
) -> None:
    """Add what is wrong with the outputs, which replace no file of the user, to the problems."""
    output, report = outputs
    if output is not None:
        from electrovib.exports.save import check_output

        with gathered(problems):
            check_output(output, dict.fromkeys(wanted.dimensions, 1), inputs=inputs, force=force)
    if report is not None:
        from electrovib.view.files import check_document

        with gathered(problems):
            check_document(report, inputs=inputs, force=force)


def _set_and_swept(
    changes: Mapping[str, Any], axes: Mapping[str, Any], earlier: Mapping[str, Any], source: object
) -> list[str]:
    """List parameters that are set although each case of the sweep has its own value of them."""
    return [
        f"{path}: is set, but swept {f'in {source}' if path in earlier else 'with --over'} as well, so the set value"
        " would have no effect; omit one of the two"
        + (f", or take the scenario without its sweep: 'electrovib init {source}'" if path in earlier else "")
        for path in changes
        if path in axes
    ]


def _set_levels(
    experiment: Scenario, changes: Mapping[str, Any], axes: Mapping[str, Any]
) -> dict[str, list[Any]]:
    """Return as axes of one value the set parameters that would otherwise follow a swept one, as low follows high."""
    found = {}
    for path in (path for path in changes if path not in axes):
        ends = ((swept, values[at]) for swept, values in axes.items() if len(values) for at in (0, -1))
        points = [{swept: value} for swept, value in ends]
        if any(_follows(experiment, path, point) for point in points):
            found[path] = [value_at(experiment, path)]
    return found


def _follows(experiment: Scenario, path: str, point: Mapping[str, Any]) -> bool:
    """Tell whether a parameter changes with another one, or whether that can be changed only together with it."""
    stored, problems = stored_changes(experiment, point)
    if not problems:
        return path in stored and path not in point
    return not stored_changes(experiment, {**point, path: value_at(experiment, path)})[1]


def _earlier(source: Source) -> _Wanted:
    """Return the sweep that is repeated, if one is."""
    if not is_trace(source):
        return _Wanted({}, (), records=False)
    axes, names = sweep_of(source)
    return _Wanted(axes, names, records=bool(source.attrs.get("records", 0)))
