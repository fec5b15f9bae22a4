"""The fit of a scenario to recordings, from their files to a folder of results."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from electrovib.core.errors import ElectrovibError, InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.core.paths import quantity_at
from electrovib.data.traces import open_trace
from electrovib.recordings.fit import (
    CalibrationError,
    CancelledError,
    MeasuredTrace,
    ScenarioFit,
    fit_scenario,
)
from electrovib.recordings.fit.least_squares import require_lmfit
from electrovib.recordings.fit.of_scenario import Sampling, require_emcee, sample_posterior
from electrovib.recordings.fit.result import parameter_table
from electrovib.recordings.fit.sessions import RecordedFit, SeparateFits, failed_rows, spreads_of
from electrovib.recordings.fit.weighing import LawCase, cases_of, compare_fits, weigh
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.view.files import check_answer, save_answer
from electrovib.view.fitted import CHAINS, FitResult

if TYPE_CHECKING:
    import xarray

    Recorded: TypeAlias = str | Path | MeasuredTrace | xarray.Dataset


def fit(
    scenario: Source,
    recordings: Sequence[Recorded] | Recorded,
    *,
    free: Sequence[str],
    varying: Sequence[str] = (),
    signals: Sequence[str] | None = None,
    start: Mapping[str, float] | None = None,
    keep: Sequence[str] = (),
    stated: Mapping[str, Any] | None = None,
    noise: Mapping[str, float] | None = None,
    offsets: Sequence[str] = (),
    calibration: Mapping[str, float | CalibrationError] | None = None,
    sessions: Mapping[str, str] | None = None,
    compare_with: Sequence[Source] = (),
    laws: str | Sequence[str] | None = None,
    seed: int = 0,
    posterior: Sampling | None = None,
    output: str | Path | None = None,
    force: bool = False,
    progress: Callable[[int, float], bool | None] | None = None,
) -> FitResult:
    """Estimate parameters of a scenario from recordings, with intervals, and compare models.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        The experiment, as for `electrovib.load`; its values of the free parameters are where the search begins.
    recordings : str, Path, MeasuredTrace or xarray.Dataset, or a sequence of them
        Files of Traces, or Traces, with signals over time or frequency. They are fitted jointly.
    free : sequence of str
        Dotted paths of the unknown parameters; their bounds are those that the models declare.
    varying : sequence of str
        Those of them that differ between the sessions of the recordings.
    signals : sequence of str, optional
        Only these signals; by default all that the recordings hold and the scenario predicts.
    start : mapping of str to float, optional
        Initial values by path, in SI.
    keep : sequence of str
        ``"drive"``, ``"load"`` and ``"motion"``: parts that are taken from the scenario although a recording holds its own.
    stated : mapping of str to value, optional
        Settings of all recordings by dotted path; a recording that contradicts one is refused.
    noise : mapping of str to float, optional
        Standard deviation of a signal in its unit, of an impedance relative to its modulus; it is estimated where absent.
    offsets : sequence of str
        Signals whose zero is unknown.
    calibration : mapping of str to float or CalibrationError, optional
        Signal to the relative standard uncertainty of its gain, or of gain and zero: gives each estimate a systematic error
        beside the statistical one. By default that of the attributes of an imported signal.
    sessions : mapping of str to str, optional
        File of a recording to the session to which it belongs; by default each file is a session of its own where
        parameters vary.
    compare_with : sequence
        Other scenarios of the same experiment, fitted with those of the free parameters that they have.
    laws : str or sequence of str, optional
        Names of force laws, or ``"all"``: which one made the recordings, each with and without the gap and the leaks of the
        scenario, by their evidence. They are weighed together with the scenario and with `compare_with`.
    seed : int
        Of the nested sampling of the evidence.
    posterior : Sampling, optional
        Sample the posterior distribution of the parameters with this seed and number of steps.
    output : str or Path, optional
        Folder for ``report.html``, ``parameters.csv``, ``parameters.toml`` and ``space.toml``, and ``posterior.nc`` with a
        posterior; all are written, or none.
    force : bool
        Whether files that this package did not write may be replaced.
    progress : callable, optional
        Called with the number of evaluations and the sum of squares; the fit ends with an error when it returns True.

    Returns
    -------
    result : FitResult
        Estimates, table and comparison.

    Raises
    ------
    ElectrovibError
        For mistakes, all at once as far as possible; nothing has been written then.
    """
    require_lmfit()
    if posterior is not None:
        require_emcee()
    problems: list[str] = []
    base: Scenario | None = None
    measured: list[MeasuredTrace] = []
    cases: dict[str, LawCase] = {}
    refused: dict[str, str] = {}
    others: dict[str, Scenario] = {}
    with inputs_noted() as inputs:
        with gathered(problems):
            base = read_scenario(scenario)
            cases, refused = cases_of(base, laws)
        for other in compare_with:
            with gathered(problems):
                others[_named(other, len(others) + 2)] = read_scenario(other)
        for number, each in enumerate(listed(recordings)):
            with gathered(problems):
                measured.append(measured_of(each, number))
    measured = with_own_names(measured)
    with gathered(problems):
        measured = described(
            measured, noise or {}, offsets, sessions,
            varying=bool(varying), calibration=calibration, stated=stated,
        )  # fmt: skip
    with gathered(problems):
        if output is not None:
            check_answer(FitResult, output, more=CHAINS if posterior else {}, inputs=inputs, force=force)
    if problems or base is None:
        raise InputError(problems)
    result = _compared(
        _named(scenario, 1), base, others, posterior, cases, refused, seed, recordings=measured, free=free,
        varying=varying, signals=signals, start=start or {}, keep=keep, progress=progress,
    )  # fmt: skip
    if output is not None:
        save_answer(result, output, force=force)
    return result


def _compared(
    name: str, scenario: Scenario, others: Mapping[str, Scenario], posterior: Sampling | None,
    cases: Mapping[str, LawCase], refused: dict[str, str], seed: int, **asked: Any,
) -> FitResult:  # fmt: skip
    """Fit the scenario, the other models and the cases, and compare them; another model counts as a law of its own."""
    best = _fitted(scenario, **asked)
    fits = {other: _fitted(each, f"compare_with = {other}", **asked) for other, each in others.items()}
    fits |= _tried(cases, refused, **asked)
    named = {next(iter(cases), name): best} | fits
    comparison = compare_fits(named) if fits else None
    if cases:
        laws = {each: cases[each].law if each in cases else each for each in named}
        comparison = weigh(named, laws, scenario, seed=seed, refused=refused)
    sampled = None if posterior is None else sample_posterior(best, posterior)
    rows = parameter_table(best)
    return FitResult(best=best, rows=rows, others=fits, comparison=comparison, posterior=sampled)


def _tried(
    cases: Mapping[str, LawCase], refused: dict[str, str], *, free: Sequence[str], **shared: Any
) -> dict[str, ScenarioFit]:
    """Fit all cases but the first, which is the scenario, and add to `refused` why others cannot be fitted."""
    found = {}
    for name, case in [*cases.items()][1:]:
        own = [path for path in free if path not in case.zero]
        try:
            found[name] = _fitted(case.scenario, name, free=own, **shared)
        except CancelledError:
            raise
        except ElectrovibError as error:
            why = "; ".join(error.problems).removeprefix(f"{name}: ")
            refused |= {name: why} if refused.get(case.law) != why else {}
    return found


def _fitted(
    scenario: Scenario,
    name: str = "",
    *,
    free: Sequence[str],
    varying: Sequence[str],
    start: Mapping[str, float],
    **shared: Any,
) -> ScenarioFit:
    """Fit a model; another one than the first, which is named, with those of the free parameters that it has."""
    own = _paths_of(scenario, free, name) if name else free
    return fit_scenario(
        scenario,
        free=own,
        varying=[path for path in varying if path in own or not name],
        start={path: value for path, value in start.items() if path in own},
        **shared,
    )


def _named(source: Source, number: int) -> str:
    if not isinstance(source, (str, Path)):
        return f"model {number}"
    return Path(source).name if Path(source).suffix else str(source)


def _paths_of(scenario: Scenario, free: Sequence[str], name: str) -> list[str]:
    """Return the free parameters that another scenario has."""
    found = []
    for path in free:
        with contextlib.suppress(ElectrovibError):
            quantity_at(scenario, path)
            found.append(path)
    if not found:
        raise InputError(f"{name}: has none of the free parameters {', '.join(free)}")
    return found


def fit_separately(
    scenario: Source,
    recordings: Sequence[Recorded] | Recorded,
    *,
    free: Sequence[str],
    signals: Sequence[str] | None = None,
    start: Mapping[str, float] | None = None,
    keep: Sequence[str] = (),
    stated: Mapping[str, Any] | None = None,
    noise: Mapping[str, float] | None = None,
    offsets: Sequence[str] = (),
    calibration: Mapping[str, float | CalibrationError] | None = None,
    output: str | Path | None = None,
    force: bool = False,
    progress: Callable[[int, int], bool | None] | None = None,
) -> SeparateFits:
    """Estimate parameters of a scenario from each of several recordings alone.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        The experiment, as for `electrovib.load`; its values of the free parameters are where each search begins.
    recordings : str, Path, MeasuredTrace or xarray.Dataset, or a sequence of them
        Files of Traces, or Traces, with signals over time or frequency.
    free : sequence of str
        Dotted paths of the unknown parameters; their bounds are those that the models declare.
    signals, start, keep, stated, offsets, calibration
        As for `electrovib.fit`.
    noise : mapping of str to float, optional
        Standard deviation of a signal in its unit, of an impedance relative to its modulus; it is estimated for each
        recording where absent.
    output : str or Path, optional
        Folder for ``report.html``, ``parameters.csv`` and ``space.toml``; all are written, or none.
    force : bool
        Whether files that this package did not write may be replaced.
    progress : callable, optional
        Called with the number of recordings done and that of all, also during the fit of each; the fits end with an
        error when it returns True.

    Returns
    -------
    fits : SeparateFits
        One table for all recordings, and the scatter of each parameter within and between them. A recording that cannot
        be read or fitted has the status ``"failed"`` and the reason in the table.

    Raises
    ------
    ElectrovibError
        For a wrong scenario, path or output folder, or if no recording could be fitted; nothing has been written then.
    CancelledError
        If `progress` ends the fits; nothing has been written then.
    """
    from electrovib.view.fitted_separately import SeparateAnswer

    require_lmfit()
    problems: list[str] = []
    base: Scenario | None = None
    units: dict[str, str] = {}
    with inputs_noted() as inputs:
        with gathered(problems):
            base = read_scenario(scenario)
        opened = [_opened(each, number) for number, each in enumerate(listed(recordings))]
    if base is not None:
        for path in free:
            with gathered(problems):
                units[path] = quantity_at(base, path).unit
    if not opened or not free:
        problems.append("a fit needs at least one recording" if free else "free: name at least one parameter")
    if output is not None:
        with gathered(problems):
            check_answer(SeparateAnswer, output, inputs=inputs, force=force)
    measured = [each for each in opened if not isinstance(each, tuple)]
    with gathered(problems):
        own = with_own_names(measured)
        measured = described(
            own, noise or {}, offsets, None, varying=False, calibration=calibration, stated=stated
        )
    if problems or base is None:
        raise InputError(problems)
    ordered = iter(measured)
    fits = _fitted_alone(
        base, [each if isinstance(each, tuple) else next(ordered) for each in opened], units, progress,
        signals=signals, start=start or {}, keep=keep,
    )  # fmt: skip
    found = SeparateFits(scenario=base, free=tuple(free), fits=tuple(fits), spreads=spreads_of(free, fits))
    if len(found.failures) == len(found.fits):
        raise InputError([f"{record}: {why}" for record, why in found.failures.items()])
    if output is not None:
        save_answer(SeparateAnswer(found=found), output, force=force)
    return found


def _fitted_alone(
    scenario: Scenario,
    recordings: Sequence[MeasuredTrace | tuple[str, str]],
    units: Mapping[str, str],
    progress: Callable[[int, int], bool | None] | None,
    **options: Any,
) -> list[RecordedFit]:
    """Fit each recording, or state why it cannot be fitted."""
    fits: list[RecordedFit] = []

    def cancelled(*_: float) -> bool:
        return progress is not None and bool(progress(len(fits), len(recordings)))

    for each in recordings:
        if cancelled():
            raise CancelledError("the fits were cancelled")
        name, why = each if isinstance(each, tuple) else (each.name, "")
        found = None
        try:
            if not isinstance(each, tuple):
                found = fit_scenario(scenario, each, free=list(units), progress=cancelled, **options)
        except CancelledError:
            raise
        except ElectrovibError as error:
            why = "; ".join(error.problems)
        rows = failed_rows(units, why) if found is None else parameter_table(found)
        fits.append(RecordedFit(record=name, found=found, rows=rows))
    cancelled()
    return fits


def _opened(recording: Recorded, number: int) -> MeasuredTrace | tuple[str, str]:
    """Open a recording; of one that cannot be read the name and the reason."""
    try:
        return measured_of(recording, number)
    except ElectrovibError as error:
        name = Path(recording).name if isinstance(recording, (str, Path)) else f"recording {number + 1}"
        return name, "; ".join(error.problems)


def listed(recordings: Sequence[Recorded] | Recorded) -> list[Recorded]:
    """Return one recording, or a sequence of them, as a list."""
    if isinstance(recordings, (str, Path)) or not isinstance(recordings, Sequence):
        return [recordings]
    return list(recordings)


def measured_of(recording: Recorded, number: int) -> MeasuredTrace:
    """Open a recording, and name it by its file or by its place among the recordings."""
    if isinstance(recording, MeasuredTrace):
        return recording
    if isinstance(recording, (str, Path)):
        return MeasuredTrace(trace=open_trace(recording), name=Path(recording).name)
    return MeasuredTrace(trace=recording, name=f"recording {number + 1}")


def with_own_names(measured: Sequence[MeasuredTrace]) -> list[MeasuredTrace]:
    """Number the recordings that have the same name, such as files of different folders."""
    names = [each.name for each in measured]
    return [
        dataclasses.replace(each, name=f"{each.name} ({number})") if names.count(each.name) > 1 else each
        for number, each in enumerate(measured, start=1)
    ]


def described(
    measured: Sequence[MeasuredTrace],
    noise: Mapping[str, float],
    offsets: Sequence[str],
    sessions: Mapping[str, str] | None,
    *,
    varying: bool,
    calibration: Mapping[str, float | CalibrationError] | None = None,
    stated: Mapping[str, Any] | None = None,
) -> list[MeasuredTrace]:
    """Put settings, noise, zeros, sessions and calibration errors into the recordings that have these signals."""
    names = [each.name for each in measured]
    by_name = {Path(file).name: session for file, session in (sessions or {}).items()}
    unknown = [name for name in by_name if name not in names]
    if unknown:
        raise InputError(f"session: '{unknown[0]}' is none of the recordings: {', '.join(names)}")
    held = {str(name) for each in measured for name in each.trace.data_vars}
    errors = {
        name: each if isinstance(each, CalibrationError) else CalibrationError(gain=each)
        for name, each in (calibration or {}).items()
    }
    absent = [name for name in (*noise, *offsets, *errors) if measured and name not in held]
    if absent:
        raise InputError(f"'{absent[0]}': no recording has this signal; they have {', '.join(sorted(held))}")
    found = []
    for each in measured:
        own = set(map(str, each.trace.data_vars))
        given = each.session or (each.name if varying else "")
        told = dataclasses.replace(
            each,
            changes=dict(stated or {}) | dict(each.changes),
            noise={name: value for name, value in noise.items() if name in own} | dict(each.noise),
            offsets=list(dict.fromkeys([*each.offsets, *(name for name in offsets if name in own)])),
            session=by_name.get(each.name, given),
            calibration={name: one for name, one in errors.items() if name in own} | dict(each.calibration),
        )
        found.append(told)
    return found
