"""The fit of a scenario to recordings, from their files to a folder of results: joint, with force laws weighed, or one by one."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.apps.recorded import FailedRecording, Recordings, as_recordings
from electrovib.core.errors import ElectrovibError, InputError, gathered, refuse
from electrovib.core.files import inputs_noted
from electrovib.core.paths import quantity_at
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import Sampling, fit_scenario, require_emcee, sample_posterior
from electrovib.recordings.fit.problem import CancelledError
from electrovib.recordings.fit.result import (
    RecordedFit,
    ScenarioFit,
    failed_rows,
    parameter_table,
    spreads_of,
)
from electrovib.recordings.fit.weighing import ALL, LawCase, cases_of, compare_fits, weigh
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.view.files import check_answer, save_answer
from electrovib.view.fitted import CHAINS, FitResult
from electrovib.view.fitted_separately import SeparateFits

if TYPE_CHECKING:
    from electrovib.apps.recorded import Recorded
    from electrovib.recordings.fit.of_scenario import Posterior
    from electrovib.recordings.fit.weighing import FitComparison


def fit(
    scenario: Source,
    recordings: Recordings | Sequence[Recorded] | Recorded,
    *,
    free: Sequence[str],
    varying: Sequence[str] = (),
    compare_with: Sequence[Source] = (),
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
    recordings : Recordings, str, Path, MeasuredTrace or xarray.Dataset, or a sequence of these
        Files of Traces, or Traces, which are fitted jointly; as `electrovib.Recordings` with their noise, the errors of the
        sensors and the sessions.
    free : sequence of str
        Dotted paths of the unknown parameters; their bounds are those that the models declare.
    varying : sequence of str
        Those of them that differ between the sessions of the recordings.
    compare_with : sequence
        Other scenarios of the same experiment, fitted with those of the free parameters that they have.
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
    if posterior is not None:
        require_emcee()
    more = {} if posterior is None else CHAINS
    asked = _Asked(free=free, varying=varying, progress=progress)
    asked.read(scenario, recordings, compare_with, output=output, more=more, force=force)
    named = asked.fits()
    comparison = compare_fits(named) if len(named) > 1 else None
    sampled = None if posterior is None else sample_posterior(next(iter(named.values())), posterior)
    return _saved(named, comparison, sampled, output, force=force)


def fit_laws(
    scenario: Source,
    recordings: Recordings | Sequence[Recorded] | Recorded,
    *,
    free: Sequence[str],
    varying: Sequence[str] = (),
    laws: Sequence[str] = (ALL,),
    compare_with: Sequence[Source] = (),
    seed: int = 0,
    output: str | Path | None = None,
    force: bool = False,
    progress: Callable[[int, float], bool | None] | None = None,
) -> FitResult:
    """Fit force laws to recordings, and weigh which of them made these, by their evidence.

    Parameters
    ----------
    scenario, recordings, free, varying, output, force, progress
        As for `electrovib.fit`.
    laws : sequence of str
        Names of force laws, or ``"all"``; each with and without the gap and the leaks of the scenario. The law of the scenario
        is among them.
    compare_with : sequence
        Other scenarios of the same experiment, which are weighed too, each as a law of its own.
    seed : int
        Of the nested sampling of the evidence.

    Returns
    -------
    result : FitResult
        Estimates with the law of the scenario, and in `comparison` the probability of each law and what speaks against it.

    Raises
    ------
    ElectrovibError
        For mistakes, all at once as far as possible; nothing has been written then.
    """
    asked = _Asked(free=free, varying=varying, progress=progress)
    asked.read(scenario, recordings, compare_with, output=output, force=force, laws=laws)
    named = asked.fits()
    by_law = {each: asked.cases[each].law if each in asked.cases else each for each in named}
    comparison = weigh(named, by_law, next(iter(asked.models.values())), seed=seed, refused=asked.refused)
    return _saved(named, comparison, None, output, force=force)


@dataclass(kw_only=True)
class _Asked:
    """What is fitted to which recordings: models by name, the scenario first, and the cases of force laws.

    A model beside the first has those of the free parameters that it has; `refused` says why a case cannot be fitted.
    """

    free: Sequence[str]
    varying: Sequence[str]
    progress: Callable[[int, float], bool | None] | None
    known: Recordings = field(init=False)
    measured: Sequence[MeasuredTrace] = field(init=False)
    models: dict[str, Scenario] = field(default_factory=dict)
    cases: dict[str, LawCase] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)

    def read(
        self,
        scenario: Source,
        recordings: Recordings | Sequence[Recorded] | Recorded,
        compare_with: Sequence[Source],
        *,
        output: str | Path | None,
        force: bool,
        more: Mapping[str, str | None] | None = None,
        laws: Sequence[str] | None = None,
    ) -> None:
        """Read scenarios and recordings, and check the output; all mistakes are reported at once."""
        self.known, problems = as_recordings(recordings), list[str]()
        with inputs_noted() as inputs:
            with gathered(problems):
                base = read_scenario(scenario)
                self.cases, self.refused = cases_of(base, laws)
                self.models[next(iter(self.cases), _named(scenario, 1))] = base
            for number, other in enumerate(compare_with, start=2):
                with gathered(problems):
                    self.models[_named(other, number)] = read_scenario(other)
            opened = self.known.opened
        problems += [why for each in opened if isinstance(each, FailedRecording) for why in each.problems]
        with gathered(problems):
            measured = [each for each in opened if isinstance(each, MeasuredTrace)]
            self.measured = self.known.described(measured, varying=bool(self.varying))
        with gathered(problems):
            if output is not None:
                check_answer(FitResult, output, more=more or {}, inputs=inputs, force=force)
        refuse(problems)

    def fits(self) -> dict[str, ScenarioFit]:
        """Fit the scenario, the other models, and all cases but the first, which is the scenario."""
        (name, scenario), *others = self.models.items()
        found = {name: self._fitted(scenario, self.free)}
        for other, each in others:
            found[other] = self._fitted(each, _paths_of(each, self.free, f"compare_with = {other}"))
        for name, case in [*self.cases.items()][1:]:
            own = [path for path in self.free if path not in case.zero]
            try:
                found[name] = self._fitted(case.scenario, _paths_of(case.scenario, own, name))
            except CancelledError:
                raise
            except ElectrovibError as error:
                why = "; ".join(error.problems).removeprefix(f"{name}: ")
                if self.refused.get(case.law) != why:
                    self.refused[name] = why
        return found

    def _fitted(self, scenario: Scenario, free: Sequence[str]) -> ScenarioFit:
        varying = self.varying if free is self.free else [path for path in self.varying if path in free]
        return fit_scenario(
            scenario, self.measured, free=free, varying=varying, signals=self.known.quantity,
            keep=self.known.keep, progress=self.progress,
        )  # fmt: skip


def _saved(
    named: Mapping[str, ScenarioFit],
    comparison: FitComparison | None,
    posterior: Posterior | None,
    output: str | Path | None,
    *,
    force: bool,
) -> FitResult:
    """Collect the result, and write it where it is asked for."""
    best, *others = named
    found = FitResult(
        best=named[best], rows=parameter_table(named[best]), others={name: named[name] for name in others},
        comparison=comparison, posterior=posterior,
    )  # fmt: skip
    if output is not None:
        save_answer(found, output, force=force)
    return found


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
    recordings: Recordings | Sequence[Recorded] | Recorded,
    *,
    free: Sequence[str],
    output: str | Path | None = None,
    force: bool = False,
    progress: Callable[[int, int], bool | None] | None = None,
) -> SeparateFits:
    """Estimate parameters of a scenario from each of several recordings alone.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        The experiment, as for `electrovib.load`; its values of the free parameters are where each search begins.
    recordings : Recordings, str, Path, MeasuredTrace or xarray.Dataset, or a sequence of these
        Files of Traces, or Traces; as `electrovib.Recordings` with their noise and the errors of the sensors.
    free : sequence of str
        Dotted paths of the unknown parameters; their bounds are those that the models declare.
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
    known, problems = as_recordings(recordings), list[str]()
    base: Scenario | None = None
    units: dict[str, str] = {}
    with inputs_noted() as inputs:
        with gathered(problems):
            base = read_scenario(scenario)
        opened = known.opened
    for path in free if base is not None else ():
        with gathered(problems):
            units[path] = quantity_at(base, path).unit
    if not opened or not free:
        problems.append("a fit needs at least one recording" if free else "free: name at least one parameter")
    if known.session:
        problems.append("session: each recording is fitted alone; only a joint fit has sessions")
    if output is not None:
        with gathered(problems):
            check_answer(SeparateFits, output, inputs=inputs, force=force)
    measured = [each for each in opened if isinstance(each, MeasuredTrace)]
    with gathered(problems):
        measured = known.described(measured)
    if problems or base is None:
        raise InputError(problems)
    ordered = iter(measured)
    each_alone = [each if isinstance(each, FailedRecording) else next(ordered) for each in opened]
    options = {"signals": known.quantity, "keep": known.keep}
    fits = _fitted_alone(base, each_alone, units, progress, **options)
    found = SeparateFits(scenario=base, free=tuple(free), fits=tuple(fits), spreads=spreads_of(free, fits))
    if len(found.failures) == len(found.fits):
        raise InputError([f"{record}: {why}" for record, why in found.failures.items()])
    if output is not None:
        save_answer(found, output, force=force)
    return found


def _fitted_alone(
    scenario: Scenario,
    recordings: Sequence[MeasuredTrace | FailedRecording],
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
        found, why = None, "; ".join(getattr(each, "problems", ()))
        try:
            if isinstance(each, MeasuredTrace):
                found = fit_scenario(scenario, each, free=list(units), progress=cancelled, **options)
        except CancelledError:
            raise
        except ElectrovibError as error:
            why = "; ".join(error.problems)
        rows = failed_rows(units, why) if found is None else parameter_table(found)
        fits.append(RecordedFit(record=each.name, found=found, rows=rows))
    cancelled()
    return fits
