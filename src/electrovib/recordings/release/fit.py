"""Release of a clutch from the record of its load cell: its delay, and the damped oscillation of the loaded assembly."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.drive.readback import OneOfTwoInAntiphase, WholeVoltage
from electrovib.physics.drive.sampled import Refuse
from electrovib.recordings.interval import line
from electrovib.recordings.recording import increasing, without_missing
from electrovib.recordings.release.model import (
    Extremum,
    Release,
    damped_sine,
    drive_end,
    find_extrema,
    uncertainties,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.readback import Readback
    from electrovib.physics.drive.sampled import StampTreatment
    from electrovib.recordings.interval import Interval
    from electrovib.recordings.transitions.modes import RingSection

_REMAINS = 0.05
"""Fraction of its initial amplitude to which the fitted oscillation has fallen at the end of the fit."""
_CLEAR = 5.0
"""Smallest change of the force at a release, in standard errors."""
_DRIFTS = 3.0
"""Slope before the release, in standard errors, above which it counts as a drift that continues."""
_FEWEST = 8
"""Smallest number of samples before and after the release from which a standard error is computed."""
_LATER = 0.75
"""Start of the second fitted decay after the first, in periods."""
_PERIODS = 4.0
"""Length of a fitted decay, in periods."""


def fit_release(
    time: Real,
    force: Real,
    voltage: Real,
    *,
    duration: float = 20e-3,
    readback: Readback | None = None,
    enabled: Real | None = None,
    stamps: StampTreatment | None = None,
    missing_rows: int = 0,
) -> FittedRelease:
    """Fit a release and one resonance of the loaded assembly to a recorded force, with the residual.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Times [s], increasing; the sampling may jitter.
    force : ndarray, shape (n,)
        Force of the load cell [N].
    voltage : ndarray, shape (n,)
        Drive as read back [V]; it may be aliased as long as its end is visible.
    duration : float
        Longest time after the end of the drive that is evaluated [s].
    readback : Readback, optional
        Relation of `voltage` to the drive: the whole drive (if not given), or one of two electrodes in antiphase.
    enabled : ndarray, shape (n,), optional
        1 while the high voltage is on, else 0, if the rig records it; the drive then ends where it falls to 0,
        regardless of `voltage`.
    stamps : StampTreatment, optional
        Treatment of time stamps that do not increase; they are refused if not given.
    missing_rows : int
        Largest number of rows with a NaN that may be omitted.

    Returns
    -------
    FittedRelease
        Fit with its uncertainty, the turning points and the misfit.

    Raises
    ------
    InputError
        If the columns are no record, the drive does not end within it, or the force does not fall when the drive ends.

    Notes
    -----
    The attraction ends with the drive. The force f stays constant for a dead time and then decays exponentially; the load
    cell responds with y'' + (w/Q) y' + w^2 y = w^2 f. If the time constant of the decay is short compared with a period,
    dead time and time constant have nearly the same effect on the record; their sum is the `delay`, and an interval is
    returned for the time constant. The levels before and after are found by linear least squares. The fit ends where
    the fitted oscillation has fallen to 5 %.

    The resonance is that of the load cell together with its load. On the rig of Rauf and Follmer (2025) the bare cell
    oscillates at 643 to 648 Hz with a quality factor of about 10; loaded with clutches of several widths, at 314 to
    609 Hz.
    """
    columns = {"time": time, "force": force, "voltage": voltage}
    columns |= {} if enabled is None else {"enabled": enabled}
    since, measured, end, missing = _checked(
        columns, duration, readback or WholeVoltage(), stamps or Refuse(), missing_rows
    )
    scatter = _scatter(since, measured, duration)
    best, here, window = _fitted(since, measured, duration)
    plain = Release.of(since[here], measured[here], window, resonant=False)
    period = 1 / best.frequency
    extrema = find_extrema(
        since, measured, start=best.delay, period=period, level=best.after, scatter=scatter, end=duration
    )
    early, late = _decays(since, measured, extrema, period)
    uncertainty, interval = uncertainties(best, (early, late))
    words = statements_on_fit(
        best, uncertainty, falls=interval, without=plain.misfit, extrema=extrema, decays=(early, late)
    )
    words += statements_on_record(readback if enabled is None else None, missing)
    own = ("delay", "fall_time", "held", "after", "frequency", "quality", "misfit", "model")
    return FittedRelease(
        **{name: getattr(best, name) for name in own},
        drive_end=end,
        fall_time_interval=interval,
        uncertainty=uncertainty,
        misfit_without=plain.misfit,
        scatter=scatter,
        missing=missing,
        extrema=tuple(extrema),
        early=early,
        late=late,
        time=since[here],
        force=measured[here],
        model_without=plain.model,
        words=words,
    )


def _fitted(since: Real, measured: Real, duration: float) -> tuple[Release, NDArray[np.bool_], float]:
    """Fit the release within a window that ends where the fitted oscillation has fallen to `_REMAINS`."""
    window, best = duration, None
    for _ in range(6):
        here = (since > -duration / 2) & (since < window)
        best = Release.of(since[here], measured[here], window)
        wanted = min(duration, best.start + np.log(1 / _REMAINS) * best.quality / (np.pi * best.frequency))
        if abs(wanted - window) < 0.02 * window:
            break
        window = float(wanted)
    assert best is not None
    return best, here, window


def _checked(
    given: Mapping[str, Real],
    duration: float,
    readback: Readback,
    stamps: StampTreatment,
    missing_rows: int,
) -> tuple[Real, Real, float, int]:
    """Refuse what is no record; return the times after the end of the drive, the forces, that end, and the rows omitted."""
    columns = {name: np.asarray(values, float) for name, values in given.items()}
    problems = []
    if len({values.shape for values in columns.values()}) > 1 or columns["time"].ndim != 1:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in columns.items())
        *first, last = columns
        problems.append(
            f"{', '.join(first)} and {last}: expected one-dimensional arrays of equal length, not {shapes}"
        )
    if not 0 < duration < np.inf:
        problems.append(f"duration = {duration}: expected a positive time in seconds, for instance 20e-3")
    if problems:
        raise InputError(problems)
    whole = without_missing(columns, missing_rows, "the record")
    missing = int(np.count_nonzero(~whole))
    columns = {name: values[whole] for name, values in columns.items()}
    kept = increasing(columns["time"], stamps, "time")
    columns = {name: values[kept] for name, values in columns.items()}
    when, measured = columns["time"], columns["force"]
    if "enabled" in columns:
        end = drive_end(time=when, voltage=columns["enabled"], name="enabled")
    else:
        try:
            volts = readback.driving(when - when[0], columns["voltage"])
        except ValueError as error:
            raise InputError(f"voltage: {error}") from None
        end = drive_end(time=when, voltage=volts, name="voltage")
    counted = when - end
    near = (counted > -duration / 2) & (counted < duration)
    if counted[-1] < duration / 2 or counted[0] > -duration / 4 or np.count_nonzero(near) < 40:
        raise InputError(
            f"the drive ends at {end:.6g} s, but there are only {np.count_nonzero(near)} samples from"
            f" {duration / 2:g} s before to {duration:g} s after; record longer or change duration"
        )
    return counted, measured, end, missing


def _scatter(stamps: Real, force: Real, duration: float) -> float:
    """Refuse a force that does not fall at the release; return its standard deviation before the release [N]."""
    before, after = (stamps > -duration / 2) & (stamps < 0), (stamps > duration / 2) & (stamps < duration)
    if min(np.count_nonzero(before), np.count_nonzero(after)) < _FEWEST:
        raise InputError(
            f"fewer than {_FEWEST} samples lie before the end of the drive, or later than {duration / 2:g} s after it;"
            " record longer or change duration"
        )
    held, of_held, slope, of_slope = line(time=stamps[before], values=force[before])
    left, of_left, _, _ = line(time=stamps[after], values=force[after])
    fall, error = held - left, np.hypot(of_held, of_left)
    drifts = abs(slope) > _DRIFTS * of_slope
    if drifts:
        # a drift before the release is continued after it; only the change beyond it is a release
        apart = float(np.mean(stamps[after]) - np.mean(stamps[before]))
        fall, error = fall + slope * apart, np.hypot(error, of_slope * apart)
    if not abs(fall) > _CLEAR * error:
        beyond = " beyond its drift" if drifts else ""
        raise InputError(
            f"the force does not fall when the drive ends: its mean changes by {abs(fall):.3g} N{beyond}, with a standard"
            f" error of {error:.3g} N. Is force the right column? If voltage is one of two electrodes in antiphase, the drive"
            " may have ended later: pass enabled, or a readback with its stop"
        )
    return float(np.std(force[before]))


def _decays(
    stamps: Real, force: Real, extrema: list[Extremum], period: float
) -> tuple[RingSection | None, RingSection | None]:
    if not extrema:
        return None, None
    starts = (extrema[0].time, extrema[0].time + _LATER * period)
    early, late = (damped_sine(stamps, force, start=start, end=start + _PERIODS * period) for start in starts)
    return early, late


@dataclass(frozen=True, kw_only=True, repr=False)
class FittedRelease:
    """A fitted release and the damped oscillation after it; times are after the end of the drive unless stated otherwise.

    - `drive_end`: end of the drive on the clock of the record: mean of its last sample and the next.
    - `delay`: mean delay of the fall of the force: the dead time plus the time constant of the exponential
      decay after it. A record rarely determines the two separately.
    - `fall_time`: time constant of the decay that fits best; `fall_time_interval` has the lowest and highest
      one that fit as well, 95 % on either side, the lowest 0 if a discontinuity fits as well.
    - `frequency`, `quality`: of the one resonance that fits best. It is that of the load cell with its load,
      which is lower than that of the bare cell.
    - `misfit`, `misfit_without`: rms of the residual over the rms of the force about its last level, after
      the end of the drive: with the resonance, and for the best exponential release recorded by a sensor
      without resonance.
    - `held`, `after`, `scatter`: force before the release, long after it, and its standard deviation before
      it.
    - `missing`: number of rows that were omitted because they held a NaN.
    - `early`, `late`: damped sines fitted from the first turning point on, and from three quarters of a
      period later, or None.
    """

    drive_end: float
    delay: float
    fall_time: float
    fall_time_interval: tuple[float, float]
    held: float
    after: float
    frequency: float
    quality: float
    uncertainty: Mapping[str, Interval]
    misfit: float
    misfit_without: float
    scatter: float
    missing: int
    extrema: tuple[Extremum, ...]
    early: RingSection | None
    late: RingSection | None
    time: Real
    force: Real
    model: Real
    model_without: Real
    words: tuple[str, ...]

    @property
    def half_periods(self) -> tuple[float, ...]:
        """Frequencies from the intervals between successive turning points [Hz]."""
        times = [extremum.time for extremum in self.extrema]
        return tuple(1 / (2 * (later - earlier)) for earlier, later in itertools.pairwise(times))

    def __repr__(self) -> str:
        return "\n".join(self.words)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and texts for JSON, in SI, without the samples."""
        plain = (
            "drive_end", "delay", "fall_time", "held", "after", "frequency", "quality", "misfit", "misfit_without",
            "scatter", "missing",
        )  # fmt: skip
        return {name: getattr(self, name) for name in plain} | {
            "fall_time_interval": list(self.fall_time_interval),
            "uncertainty": {
                name: {**found.components, "total": found.standard_error}
                for name, found in self.uncertainty.items()
            },
            "extrema": [{"time": extremum.time, "force": extremum.force} for extremum in self.extrema],
            "half_periods": list(self.half_periods),
            "early": _plain(self.early),
            "late": _plain(self.late),
            "words": list(self.words),
        }


def _plain(decay: RingSection | None) -> dict[str, float] | None:
    """Return plain numbers for JSON."""
    if decay is None:
        return None
    found = {"start": decay.start, "misfit": decay.misfit}
    for name in ("frequency", "quality"):
        number = getattr(decay, name)
        found |= {name: number.value, f"{name}_uncertainty": number.standard_error}
    return found


_APART = 3.0
"""Distance of two numbers in standard uncertainties above which they differ."""
_KNOWN = 0.3
"""Relative uncertainty of the frequency from which on the resonance counts as not determined."""
_CALLED = {
    "noise": "noise",
    "window": "start of the fit",
    "fall time": "fall times that fit as well",
    "end": "end of the drive",
    "change": "change during the decay",
}
"""Name of each component of an uncertainty in a sentence."""


def statements_on_fit(
    best: Release,
    uncertainty: Mapping[str, Interval],
    *,
    falls: tuple[float, float],
    without: float,
    extrema: Sequence[Extremum],
    decays: tuple[RingSection | None, RingSection | None],
) -> tuple[str, ...]:
    """Write what a fitted release determines: on the resonance, the delay, and the change of the frequency."""
    return (
        *_resonance(best, uncertainty, without),
        *_delay(best, uncertainty["delay"], falls),
        *_change(extrema, decays),
    )


def statements_on_record(readback: Readback | None, missing: int) -> tuple[str, ...]:
    """Write how many rows were omitted from a record, and what its drive column does not determine."""
    said = []
    if missing:
        rows = "1 row that holds" if missing == 1 else f"{missing} rows that hold"
        said.append(f"{rows} a NaN {'was' if missing == 1 else 'were'} omitted.")
    if isinstance(readback, OneOfTwoInAntiphase) and readback.stop is None:
        said.append(
            "The drive is taken to end at the last fall of the electrode that was read back. If the other electrode was"
            " driven after that, the drive ended later and the delay is shorter by the same time; readback.stop states when."
        )
    return tuple(said)


def _resonance(best: Release, uncertainty: Mapping[str, Interval], without: float) -> tuple[str, ...]:
    frequency, quality = uncertainty["frequency"], uncertainty["quality"]
    if not frequency.standard_error < _KNOWN * best.frequency:
        return (
            f"The record does not determine a resonance: the best fit, {best.frequency:.0f} Hz, has a standard uncertainty"
            f" of {frequency.standard_error:.2g} Hz.",
        )
    return (
        f"One resonance of the loaded assembly (load cell with its load) is fitted: {best.frequency:.0f} Hz with a"
        f" standard uncertainty of {frequency.standard_error:.2g} Hz ({_parts(frequency, 1, 'Hz')}), quality factor"
        f" {best.quality:.1f} with {quality.standard_error:.2g} ({_parts(quality, 1, '')}). Its residual is"
        f" {best.misfit:.1%} of the force after the end of the drive; without the resonance the residual is {without:.1%}.",
    )


def _delay(best: Release, uncertainty: Interval, falls: tuple[float, float]) -> tuple[str, ...]:
    said = (
        f"The force falls {best.delay * 1e3:.2f} ms after the end of the drive, with a standard uncertainty of"
        f" {uncertainty.standard_error * 1e3:.2g} ms ({_parts(uncertainty, 1e3, 'ms')})."
    )
    low, high = falls
    if low == 0:
        return (
            said,
            f"The time constant of the fall is not determined: any value up to {high * 1e3:.2g} ms fits as well.",
        )
    return said, (
        f"The time constant of the fall is {best.fall_time * 1e3:.2g} ms; values between {low * 1e3:.2g} and"
        f" {high * 1e3:.2g} ms fit as well."
    )


def _parts(uncertainty: Interval, factor: float, unit: str) -> str:
    return ", ".join(
        f"{_CALLED[name]} {value * factor:.2g} {unit}".rstrip()
        for name, value in uncertainty.components.items()
    )


def _change(extrema: Sequence[Extremum], decays: tuple[RingSection | None, RingSection | None]) -> list[str]:
    said = []
    times = [extremum.time for extremum in extrema]
    halves = [1 / (2 * (later - earlier)) for earlier, later in itertools.pairwise(times)]
    if len(halves) >= 2:
        said.append(f"Successive turning points give {', '.join(f'{value:.0f}' for value in halves)} Hz.")
    early, late = decays
    if early and late:
        first, last = early.frequency, late.frequency
        said.append(
            f"A damped sine fitted from the first turning point on has {first.value:.0f} ± {first.standard_error:.2g} Hz"
            f" (quality factor {early.quality.value:.1f}); fitted from three quarters of a period later,"
            f" {last.value:.0f} ± {last.standard_error:.2g} Hz (quality factor {late.quality.value:.1f})."
        )
        error = float(np.hypot(first.standard_error, last.standard_error))
        if abs(last.value - first.value) > max(_APART * error, 0.01 * first.value):
            change = "falls" if last.value < first.value else "rises"
            said.append(
                f"The frequency {change} during the decay, which no single linear resonance reproduces: part of the"
                " misfit is due to it and not to noise."
            )
    return said
