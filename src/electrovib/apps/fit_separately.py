"""The fit of a scenario to many recordings one by one, from their files to one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.apps.recorded import described, listed, measured_of, with_own_names
from electrovib.core.errors import ElectrovibError, InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.core.paths import quantity_at
from electrovib.recordings.fit import CancelledError, fit_scenario
from electrovib.recordings.fit.least_squares import require_lmfit
from electrovib.recordings.fit.result import parameter_table
from electrovib.recordings.fit.sessions import RecordedFit, SeparateFits, failed_rows, spreads_of
from electrovib.scenario import Scenario, Source, read_scenario

if TYPE_CHECKING:
    from electrovib.apps.recorded import Recorded
    from electrovib.recordings.fit import CalibrationError, MeasuredTrace


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
    signals : sequence of str, optional
        Only these signals; by default all that a recording holds and the scenario predicts.
    start : mapping of str to float, optional
        Initial values by path, in SI.
    keep, stated
        As for `electrovib.fit`.
    noise : mapping of str to float, optional
        Standard deviation of a signal in its unit, of an impedance relative to its modulus; it is estimated for each
        recording where absent.
    offsets : sequence of str
        Signals whose zero is unknown.
    calibration : mapping of str to float or CalibrationError, optional
        Signal to the relative standard uncertainty of its gain, or of gain and zero: gives each estimate a systematic error
        beside the statistical one. By default that of the attributes of an imported signal.
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
    from electrovib.view.documents import check_answer, save_answer
    from electrovib.view.fitted_separately import SeparateAnswer

    require_lmfit()
    problems: list[str] = []
    opened: list[MeasuredTrace | tuple[str, str]] = []
    base: Scenario | None = None
    units: dict[str, str] = {}
    with inputs_noted() as inputs:
        with gathered(problems):
            base = read_scenario(scenario)
        for number, each in enumerate(listed(recordings)):
            opened.append(_opened(each, number))
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
    task = _Task(base, units, signals, start or {}, keep, progress, len(opened))
    prepared = iter(measured)
    for recording in opened:
        task.add(recording if isinstance(recording, tuple) else next(prepared))
    found = SeparateFits(
        scenario=base, free=tuple(free), fits=tuple(task.fits), spreads=spreads_of(free, task.fits)
    )
    if len(found.failures) == len(found.fits):
        raise InputError([f"{record}: {why}" for record, why in found.failures.items()])
    if output is not None:
        save_answer(SeparateAnswer(found=found), output, force=force)
    return found


class _Task:
    """The fits of one call of `fit_separately`, recording by recording."""

    def __init__(
        self,
        scenario: Scenario,
        units: Mapping[str, str],
        signals: Sequence[str] | None,
        start: Mapping[str, float],
        keep: Sequence[str],
        progress: Callable[[int, int], bool | None] | None,
        count: int,
    ) -> None:
        self.scenario, self.units, self.signals, self.start = scenario, units, signals, start
        self.keep, self.progress, self.count = keep, progress, count
        self.fits: list[RecordedFit] = []

    def cancelled(self, *_: float) -> bool:
        """Report the recordings that are done, and return whether the fits have to end."""
        return self.progress is not None and bool(self.progress(len(self.fits), self.count))

    def add(self, recording: MeasuredTrace | tuple[str, str]) -> None:
        """Fit one recording, or note why it cannot be fitted."""
        if self.cancelled():
            raise CancelledError("the fits were cancelled")
        if isinstance(recording, tuple):
            name, why = recording
            self.fits.append(RecordedFit(record=name, found=None, rows=failed_rows(self.units, why)))
            return
        try:
            found = fit_scenario(
                self.scenario, recording, free=list(self.units), signals=self.signals, start=self.start,
                keep=self.keep, progress=self.cancelled,
            )  # fmt: skip
            fitted = RecordedFit(record=recording.name, found=found, rows=parameter_table(found))
        except CancelledError:
            raise
        except ElectrovibError as error:
            rows = failed_rows(self.units, "; ".join(error.problems))
            fitted = RecordedFit(record=recording.name, found=None, rows=rows)
        self.fits.append(fitted)
        self.cancelled()


def _opened(recording: Recorded, number: int) -> MeasuredTrace | tuple[str, str]:
    """Open a recording; of one that cannot be read the name and the reason."""
    try:
        return measured_of(recording, number)
    except ElectrovibError as error:
        name = Path(recording).name if isinstance(recording, (str, Path)) else f"recording {number + 1}"
        return name, "; ".join(error.problems)
