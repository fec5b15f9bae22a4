"""Resonance, quality factor and drift of the oscillation after impacts or a release."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel
from electrovib.core.budget import one_thread
from electrovib.core.deprecation import former_attribute
from electrovib.core.errors import InputError, refuse
from electrovib.data.atomic import Form
from electrovib.recordings.interval import (
    Interval,
    NumberRow,
    averages,
    mean_of,
    numbers_csv,
    numbers_table,
    with_ends,
)
from electrovib.recordings.transitions.edges import (
    LONGER,
    Columns,
    Impact,
    columns_of,
    end_of_ring,
    find_impacts,
    in_few,
    reference_times,
)
from electrovib.recordings.transitions.modes import (
    CONSTANT,
    DRIFTING,
    LEVELS,
    LINEAR,
    MISFIT,
    MOST_FIGURES,
    ONE,
    REFERENCES,
    TWO,
    FittedModes,
    RingSection,
    above_lowest,
    chosen_form,
    fit_modes,
    misfit_note,
    parameter_row,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.readback import Readback

_FEWEST: Final = 20
"""Fewest samples of a section."""
_SECTIONS: Final = 6
_KNOWN: Final = 0.5
"""Relative standard error of the quality factor beyond which a section is not shown."""
_LAST: Final = 1.5
"""Periods of oscillation above the noise that the last section contains at least."""
_PER_PERIOD: Final = 20
"""Averages of neighbouring samples, in a period, to which forms are fitted."""
_TURNS: Final = 1.5
"""Quality factor above which a faint oscillation is known from a change that a filter makes swing."""
_IN_BAND: Final = 0.4
"""Largest distance of its frequency from that of the band, relative."""
_AT_LEAST: Final = 500
"""Averages of a section, where it has so many samples."""


@one_thread(with_scipy=True)
def measure_ring(
    record: xarray.Dataset | str | Path,
    *,
    quantity: str | None = None,
    at: float | None = None,
    by: str | None = None,
    readback: Readback | None = None,
    start: float | None = None,
    window: float | None = None,
) -> MeasuredRing:
    """Measure resonance, quality factor and their drift from the oscillation after an impact or a release.

    Parameters
    ----------
    record : xarray.Dataset, str or Path
        Trace or its file.
    quantity : str, optional
        Signal that oscillates; by default the only one besides `by`.
    at : float, optional
        Time of the impact or release [s]; by default the last switching of `by`, or else the largest deviation of the signal
        from its level, a moving median; of several impacts that of the largest. All of them: `measure_rings`.
    by : str, optional
        Signal of the drive.
    readback : Readback, optional
        Relation of `by` to the drive.
    start : float, optional
        Time after `at` from which on the oscillation is free [s]; by default 0 where the impact is found, and else the first
        turning point beyond the last level.
    window : float, optional
        Time after `at` up to which it is evaluated [s]; by default until it has fallen into the noise.

    Returns
    -------
    ring : MeasuredRing
        Frequency and quality factor with intervals, and their change.

    Raises
    ------
    InputError
        If an argument cannot be used, or if there is no oscillation above the noise.

    Notes
    -----
    One mode, one mode whose frequency changes linearly, and two modes, each about a level that is constant, linear or
    exponential in time, are compared by BIC, after the correlation of the noise has been filtered out; the simplest within 2
    of the lowest is chosen. AICc would often choose a second mode for noise, because its frequency is searched over a wide
    band. The sections fit one mode about the level of the chosen form from later and later starts, half a period apart: where
    a higher mode decays sooner, their frequency falls towards that of the mode that remains. The intervals follow from the
    noise of this one oscillation; sections overlap and are not independent of each other.
    """
    chosen = columns_of(record, quantity=quantity, by=by, readback=readback)
    _check(start=start, window=window)
    time, values = chosen.time, chosen.values
    if at is None and chosen.drive is not None:
        at = reference_times(time, values, chosen.drive)[-1]
    if at is None:
        largest = max(_impacts(chosen), key=lambda each: each.size)
        return _measured(chosen, largest, start=start, window=window)
    if not time[0] <= at < time[-1]:
        raise InputError(f"at = {at:g}: expected a time within the record, {time[0]:.6g} to {time[-1]:.6g} s")
    since = Impact(at=at, begin=0, end=time.size, rest=time.size, size=0.0, returns=True)
    return _measured(chosen, since, start=start, window=window, released=start is None)


@one_thread(with_scipy=True)
def measure_rings(
    record: xarray.Dataset | str | Path, *, quantity: str | None = None, window: float | None = None
) -> MeasuredRings:
    """Find the impacts or releases of a record, and measure the oscillation after each of them.

    Parameters
    ----------
    record : xarray.Dataset, str or Path
        Trace or its file.
    quantity : str, optional
        Signal that oscillates; by default the only one over time.
    window : float, optional
        Time after each impact up to which it is evaluated [s]; by default until it has fallen into the noise.

    Returns
    -------
    rings : MeasuredRings
        Each oscillation in the order of time, as `measure_ring` measures it, and why others were not measured.

    Raises
    ------
    InputError
        If an argument cannot be used, or if there is no oscillation above the noise.
    """
    chosen = columns_of(record, quantity=quantity)
    _check(start=None, window=window)
    found: list[MeasuredRing] = []
    skipped: list[str] = []
    for each in _impacts(chosen):
        try:
            found.append(_measured(chosen, each, start=None, window=window))
        except InputError as error:
            skipped += error.problems
    if not found:
        raise InputError(in_few(skipped))
    return MeasuredRings(rings=tuple(found), skipped=tuple(skipped))


def _impacts(chosen: Columns) -> list[Impact]:
    found = find_impacts(chosen.time, chosen.values, faint=True)
    if not found:
        raise InputError(
            f"the signal {chosen.signal} never leaves the noise around its level, so that there is no oscillation"
        )
    return found


def _measured(
    chosen: Columns, impact: Impact, *, start: float | None, window: float | None, released: bool = False
) -> MeasuredRing:
    """Measure the oscillation after one impact, within the samples up to the next."""
    at, own = impact.at, slice(impact.begin, impact.rest)
    since, values = chosen.time[own] - at, chosen.values[own]
    quarter = since > 0.75 * since[-1]
    if np.count_nonzero(quarter) < 4:
        raise InputError(f"the oscillation after {at:.6g} s has no section at rest after it")
    seen = values if impact.seen is None else impact.seen[own]
    seen = seen - float(np.mean(seen[quarter]))
    begin = _turning_point(since, seen) if released else (start or 0.0)
    span = end_of_ring(since, seen, float(np.std(seen[quarter])), begin)
    end = span.end if window is None else window
    step = float(np.median(np.diff(since)))
    count = max(1, int(min(span.period / _PER_PERIOD, (end - begin) / _AT_LEAST) / step))
    first = int(np.searchsorted(since, begin))
    since, values = (averages(part[first:], count) for part in (since, values))
    quarter = since > max(0.75 * since[-1], end)
    part = since <= end
    if np.count_nonzero(part) < _FEWEST:
        raise InputError(
            f"the oscillation after {at:.6g} s has {np.count_nonzero(part)} samples above the noise; {_FEWEST} are needed"
        )
    rest = values[quarter] if np.count_nonzero(quarter) >= _FEWEST else values[since > 0.75 * since[-1]]
    noise = float(np.std(rest))
    fitted, criteria, best = _fitted(since[part] - begin, values[part], rest)
    if not math.isfinite(fitted[best].bic):
        raise InputError(f"the record after {at:.6g} s holds no damped oscillation: {fitted[ONE].rejected}")
    of = fitted[best].parameters()
    if impact.seen is not None and not (
        of["quality"].lower > _TURNS and abs(of["frequency"].value * span.period - 1) < _IN_BAND
    ):
        raise InputError(
            f"what stands out of the noise after {at:.6g} s, of about {1 / span.period:.3g} Hz, is no oscillation with a"
            f" frequency and a quality factor above {_TURNS:g}"
        )
    level_change = fitted[best].level_change(since - begin)
    left = float(np.std(fitted[best].model - values[part]))
    return MeasuredRing(
        signal=chosen.signal, unit=chosen.unit, reference=at, form=best, fitted=fitted, criteria=above_lowest(criteria),
        sections=_sections(since, values - level_change, begin, end, fitted[ONE], rest),
        time=since[part], values=values[part], misfit=left / noise if noise else math.inf,
    )  # fmt: skip


def _fitted(time: Real, values: Real, noise: Real) -> tuple[dict[str, FittedModes], dict[str, float], str]:
    """Return the forms about the level that fits best, the criteria of all about their best levels, and the form chosen."""
    constant = fit_modes(time, values, noise=noise)
    by_level = {CONSTANT: constant}
    for level in LEVELS[1:]:
        by_level[level] = fit_modes(time, values, noise=noise, level=level, fitted=constant)
    every = {(form, level): by_level[level][form].bic for form in constant for level in LEVELS}
    form, level = chosen_form(every)
    lowest = {each: min(every[each, one] for one in LEVELS) for each in constant}
    return by_level[level], {**lowest, form: every[form, level]}, form


def _turning_point(since: Real, deviation: Real) -> float:
    """Return the time of the largest deviation beyond the last level after the change of a release."""
    after = np.flatnonzero(since >= 0)
    side = math.copysign(1.0, float(np.median(deviation[max(after[0] - 20, 0) : after[0] + 1])))
    beyond = after[side * deviation[after] < 0]
    if not beyond.size:
        raise InputError(
            "the signal does not pass its last level after the release, so that it does not oscillate"
        )
    first = int(beyond[0])
    back = np.flatnonzero(side * deviation[first:] > 0)
    # the deepest point before the signal returns through its level for longer than a sample or two of noise
    reach = first + 3 * (int(back[np.searchsorted(back, 3)]) if back.size > 3 else len(deviation) - first - 1)
    part = slice(first, min(max(reach, first + 4), len(deviation)))
    return float(since[first + int(np.argmin(side * deviation[part]))])


def _sections(
    since: Real, values: Real, begin: float, end: float, one: FittedModes, noise: Real
) -> tuple[RingSection, ...]:
    """Fit one mode from later and later starts, half a period apart."""
    period = 1 / one.estimate.values["damped_frequency"]
    found = []
    for number in range(_SECTIONS):
        start = begin + number * period / 2
        part = (since >= start) & (since <= end)
        if np.count_nonzero(part) < _FEWEST or (end - start) / LONGER < _LAST * period:
            break
        fitted = fit_modes(since[part] - start, values[part], (ONE,), noise=noise)[ONE]
        if fitted.rejected:
            break
        of = fitted.parameters()
        if not of["quality"].standard_error < _KNOWN * of["quality"].value:
            break
        found.append(RingSection(start, of["frequency"], of["quality"]))
    return tuple(found)


def _check(*, start: float | None, window: float | None) -> None:
    problems = [
        f"{name} = {value:g}: expected a time in seconds of at least 0"
        for name, value in (("start", start), ("window", window))
        if value is not None and not 0 <= value < math.inf
    ]
    refuse(problems)


@dataclass(frozen=True, kw_only=True, repr=False)
class MeasuredRing(Answer):
    """Resonance, quality factor and drift of a damped oscillation after an impact or a release, at the time `reference`.

    - `form`: ``one mode``, ``one drifting mode`` or ``two modes``: the simplest whose criterion is at most 2
      above the lowest.
    - `level`: level about which the signal oscillates: ``constant``, ``linear`` or ``exponential`` in time,
      chosen likewise.
    - `criteria`: BIC of each form over the lowest; infinite for a form that was rejected.
    - `parameters`: of the best form: ``frequency`` [Hz] and ``quality`` of the mode that lasts longer, at the
      start of the section for a drifting one; ``drift`` [Hz/s] of a drifting mode; ``level_time_constant``
      [s] of an exponential level; ``early_frequency`` and ``early_quality`` of the mode that decays sooner.
    - `drift`: rate of change of the frequency of one drifting mode [Hz/s], whichever form is best.
    - `sections`: one mode fitted from later and later starts.
    - `misfit`: rms of the residual over the noise at the end of the record.
    """

    FILES: ClassVar = {"times.csv": Form.TABLE}
    signal: str
    unit: str
    reference: float
    form: str
    fitted: Mapping[str, FittedModes]
    criteria: Mapping[str, float]
    sections: tuple[RingSection, ...]
    time: Real
    values: Real
    misfit: float

    level = property(lambda self: self.fitted[self.form].level)
    model = property(lambda self: self.fitted[self.form].model)
    drift = property(lambda self: self.fitted[DRIFTING].parameters()["drift"])
    words = former_attribute("words", "document", lambda self: self.remarks)

    @property
    def parameters(self) -> Mapping[str, Interval]:
        """Parameters of the best form with their intervals."""
        return self.fitted[self.form].parameters()

    @property
    def document(self) -> Document:
        """Frequency and quality factor, what limits them, and the record with the best form."""
        return MeasuredRings(rings=(self,)).document

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        return MeasuredRings(rings=(self,)).content(name)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What limits the numbers, warnings first, and how the frequency changes."""
        said = []
        if self.misfit > MISFIT:
            said.append(
                f"Warning: the form '{self.form}' leaves a residual of {self.misfit:.2g} times the noise at the end of the"
                " record, so the choice of the form is uncertain, and frequency and quality factor have an error beyond their"
                " intervals."
            )
        if self.level != CONSTANT:
            said.append(_of_level(self.fitted[self.form], self.unit))
        if self.form == TWO:
            of = self.parameters
            which = "higher" if of["early_frequency"].value > of["frequency"].value else "lower"
            said.append(
                f"Two modes reproduce the record best: a {which} one of {of['early_frequency'].value:.4g} Hz that decays sooner,"
                f" and {of['frequency'].value:.4g} Hz that remains."
            )
        elif self.form == DRIFTING:
            said.append(
                f"A mode whose frequency {'falls' if self.drift.value < 0 else 'rises'} reproduces the record best; no single"
                " linear resonance does."
            )
        if len(self.sections) > 1:
            first, last = self.sections[0], self.sections[-1]
            said.append(
                f"One mode fitted from {first.start * 1e3:.3g} ms on has {first.frequency.value:.4g} Hz and quality factor"
                f" {first.quality.value:.3g}, from {last.start * 1e3:.3g} ms on {last.frequency.value:.4g} Hz and"
                f" {last.quality.value:.3g}."
            )
        return tuple(said)


def _of_level(found: FittedModes, unit: str) -> str:
    values = found.estimate.values
    if found.level == LINEAR:
        slope = f"{values['level_slope']:.3g} {unit}/s"
        return f"The level about which the signal oscillates changes linearly, by {slope}."
    return (
        f"The level about which the signal oscillates relaxes exponentially by {-values['level_change']:.3g} {unit} with a time"
        f" constant of {values['level_time'] * 1e3:.3g} ms."
    )


@dataclass(frozen=True, kw_only=True, repr=False)
class MeasuredRings(Answer):
    """Damped oscillations after all impacts of a record, at least one, and why other impacts were not measured."""

    FILES: ClassVar = {"times.csv": Form.TABLE}
    words = former_attribute("words", "document", lambda self: self.remarks)
    rings: tuple[MeasuredRing, ...]
    skipped: tuple[str, ...] = ()

    @property
    def frequency(self) -> Interval:
        """Natural frequency [Hz]: mean over the impacts by Student's t, or that of the only one."""
        return self._mean("frequency")

    @property
    def quality(self) -> Interval:
        """Quality factor, dimensionless: mean over the impacts by Student's t, or that of the only one."""
        return self._mean("quality")

    def _mean(self, name: str) -> Interval:
        return mean_of([each.parameters[name] for each in self.rings], of="impact")

    @property
    def document(self) -> Document:
        """Frequency and quality factor, what limits them, and the first records with the best form."""
        after = f"after {len(self.rings)} impacts" if len(self.rings) > 1 else "after the edge or impact"
        said = (
            f"The signal oscillates {after} with {with_ends(self.frequency, 'Hz')} and a quality factor of"
            f" {with_ends(self.quality, '1')}."
        )
        return Document(
            title=f"Oscillations of {self.rings[0].signal.replace('_', ' ')}",
            sentences=[said, *(text for text in self.remarks if text.startswith("Warning"))],
            figures=[_panel(each, number) for number, each in enumerate(self.rings[:MOST_FIGURES])],
            numbers=[numbers_table("Frequency and quality factor", ring_rows(self))],
            remarks=[text for text in self.remarks if not text.startswith("Warning")],
            references=REFERENCES,
        )

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        del name
        return numbers_csv(ring_rows(self))

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences about the results, those of several impacts with the time of each in front."""
        if len(self.rings) == 1:
            return (*self.rings[0].remarks, *in_few(self.skipped))
        said = [
            f"{'Warning: ' * text.startswith('Warning')}impact at {each.reference:.6g} s: {text.removeprefix('Warning: ')}"
            for each in self.rings
            for text in each.remarks
        ]
        return (*sorted(said, key=lambda text: not text.startswith("Warning")), *in_few(self.skipped))


def ring_rows(rings: MeasuredRings) -> list[NumberRow]:
    """List the numbers of measured oscillations as rows of a table."""
    if len(rings.rings) == 1:
        return _of_ring(rings.rings[0])
    rows = [
        parameter_row("ring", name, number, f"mean of {number.count} impacts", "")
        for name, number in (("frequency", rings.frequency), ("quality", rings.quality))
    ]
    for ring in rings.rings:
        rows += _parameters(f"impact at {ring.reference:.6g} s", ring)
    return rows


def _parameters(group: str, ring: MeasuredRing) -> list[NumberRow]:
    note = misfit_note(ring.misfit)
    return [parameter_row(group, name, each, ring.form, note) for name, each in ring.parameters.items()]


def _of_ring(ring: MeasuredRing) -> list[NumberRow]:
    rows = _parameters("ring", ring)
    if "drift" not in ring.parameters:
        rows.append(
            parameter_row("ring", "drift", ring.drift, "one drifting mode", f"{ring.form} fits better")
        )
    for each in ring.sections:
        start = f"one mode from {each.start * 1e3:.3g} ms on"
        rows += [
            parameter_row("ring", "frequency", each.frequency, start, ""),
            parameter_row("ring", "quality", each.quality, start, ""),
        ]
    return rows


def _panel(ring: MeasuredRing, number: int) -> Panel:
    """Make the figure of one oscillation with its best form."""
    return Panel(
        id=f"ring{number or ''}",
        title=f"Oscillation from {ring.reference:.6g} s on",
        caption=f"Points: record, averaged where it is dense. Line: {ring.form}.",
        x=("time after the reference", "s"),
        y=(ring.signal.replace("_", " "), ring.unit),
        curves=(
            Curve(label="record", x=ring.time, y=ring.values, kind="points", look=REFERENCE),
            Curve(label=ring.form, x=ring.time, y=ring.model),
        ),
    )
