"""The fit of a scenario to recordings, from their files to a folder of results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.apps.recorded import described, listed, measured_of, with_own_names
from electrovib.core.errors import ElectrovibError, InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.recordings.fit import ScenarioFit, fit_scenario
from electrovib.recordings.fit.least_squares import require_lmfit
from electrovib.recordings.fit.of_scenario import Sampling, require_emcee, sample_posterior
from electrovib.recordings.fit.result import parameter_table
from electrovib.recordings.fit.sessions import compare_fits
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.view.documents import check_answer, save_answer
from electrovib.view.fitted import CHAINS, FitResult

if TYPE_CHECKING:
    from electrovib.apps.recorded import Recorded
    from electrovib.recordings.fit import CalibrationError, MeasuredTrace


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
    others: dict[str, Scenario] = {}
    with inputs_noted() as inputs:
        with gathered(problems):
            base = read_scenario(scenario)
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
    given = _FitRequest(
        measured=measured,
        free=free,
        varying=varying,
        signals=signals,
        start=start or {},
        keep=keep,
        progress=progress,
    )
    result = given.result(_named(scenario, 1), base, others, posterior)
    if output is not None:
        save_answer(result, output, force=force)
    return result


@dataclass(frozen=True, kw_only=True)
class _FitRequest:
    """What is fitted with each model."""

    measured: Sequence[MeasuredTrace]
    free: Sequence[str]
    varying: Sequence[str]
    signals: Sequence[str] | None
    start: Mapping[str, float]
    keep: Sequence[str]
    progress: Callable[[int, float], bool | None] | None

    def fit(self, scenario: Scenario, name: str = "") -> ScenarioFit:
        """Fit a model; another one than the first with those of the free parameters that it has."""
        own = _paths_of(scenario, self.free, name) if name else self.free
        return fit_scenario(
            scenario,
            self.measured,
            free=own,
            varying=[path for path in self.varying if path in own or not name],
            signals=self.signals,
            start={path: value for path, value in self.start.items() if path in own},
            keep=self.keep,
            progress=self.progress,
        )

    def result(
        self, name: str, scenario: Scenario, others: Mapping[str, Scenario], posterior: Sampling | None
    ) -> FitResult:
        """Fit the scenario and the other models, and compare them."""
        best = self.fit(scenario)
        fits = {name: best} | {other: self.fit(each, other) for other, each in others.items()}
        return FitResult(
            best=best,
            rows=parameter_table(best),
            others={other: fits[other] for other in others},
            comparison=compare_fits(fits) if others else None,
            posterior=None if posterior is None else sample_posterior(best, posterior),
        )


def _named(source: Source, number: int) -> str:
    if not isinstance(source, (str, Path)):
        return f"model {number}"
    return Path(source).name if Path(source).suffix else str(source)


def _paths_of(scenario: Scenario, free: Sequence[str], name: str) -> list[str]:
    """Return the free parameters that another scenario has."""
    from electrovib.core.paths import quantity_at

    found = []
    for path in free:
        try:
            quantity_at(scenario, path)
        except ElectrovibError:
            continue
        found.append(path)
    if not found:
        raise InputError(f"compare_with = {name}: has none of the free parameters {', '.join(free)}")
    return found
