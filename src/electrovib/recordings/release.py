"""Release of a clutch from the record of its load cell: its delay, and the damped oscillation of the loaded assembly."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, refuse
from electrovib.physics.drive.readback import OneOfTwoInAntiphase, WholeVoltage
from electrovib.physics.drive.sampled import Refuse
from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.fit.separable import Separable, resonance_parameters
from electrovib.recordings.interval import autocovariance, covariance, from_causes, line, profile_interval
from electrovib.recordings.recording import increasing, omitted_rows, without_missing
from electrovib.recordings.transitions.edges import drive_end
from electrovib.recordings.transitions.modes import damped_sine, find_extrema
from electrovib.recordings.transitions.relaxation import EXPONENTIAL, Sensor

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.readback import Readback
    from electrovib.physics.drive.sampled import StampTreatment
    from electrovib.recordings.interval import Interval
    from electrovib.recordings.transitions.modes import Extremum, RingSection

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
JUDGED: Final = ("delay", "frequency", "quality")
_LATER_STARTS: Final = (0.25, 0.5, 0.75)
"""Alternative beginnings of the window after the release, in periods."""
_LEAST_FALL: Final = 0.1
"""Fall time, in periods, from which on the record depends on it linearly: near 0 it depends on its square."""
_INTERVAL: Final = 3.29
"""Standard deviations from one end of an interval to the other: 95 % on either side."""


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
    best, plain = _fitted(since, measured, duration)
    period = 1 / best.frequency
    extrema = find_extrema(
        since, measured, start=best.delay, period=period, level=best.after, scatter=scatter, end=duration
    )
    begins = [extrema[0].time + later * period for later in (0.0, _LATER)] if extrema else []
    early, late = [
        damped_sine(since, measured, start=begin, end=begin + _PERIODS * period) for begin in begins
    ] or (None, None)
    uncertainty, interval = uncertainties(best, (early, late))
    remarks = omitted_rows(missing)
    if enabled is None and isinstance(readback, OneOfTwoInAntiphase) and readback.stop is None:
        remarks.append(
            "The drive is taken to end at the last fall of the electrode that was read back. If the other electrode was"
            " driven after that, the drive ended later and the delay is shorter by the same time; readback.stop states when."
        )
    return FittedRelease(
        **vars(best), plain=plain, drive_end=end, fall_time_interval=interval, uncertainty=uncertainty, scatter=scatter,
        missing=missing, extrema=tuple(extrema), early=early, late=late, remarks=tuple(remarks),
    )  # fmt: skip


def _fitted(since: Real, measured: Real, duration: float) -> tuple[Release, Release]:
    """Fit the release, with and without a resonance, up to where the fitted oscillation has fallen to `_REMAINS`."""
    window = duration
    for _ in range(6):
        here = (since > -duration / 2) & (since < window)
        best, used = Release.of(since[here], measured[here], window), window
        wanted = min(duration, best.start + np.log(1 / _REMAINS) * best.quality / (np.pi * best.frequency))
        if abs(wanted - window) < 0.02 * window:
            break
        window = float(wanted)
    return best, Release.of(since[here], measured[here], used, resonant=False)


def _checked(
    given: Mapping[str, Real], duration: float, readback: Readback, stamps: StampTreatment, missing_rows: int
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
    refuse(problems)
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


@dataclass(frozen=True, kw_only=True, repr=False)
class Release:
    """A fitted release, with times after the end of the drive: a relaxation seen by a sensor with a resonance, or without.

    - `start`, `fall_time`: when the force begins to fall, and the time constant of the exponential decay after it.
    - `delay`: mean delay of the fall: the start plus the time constant. A record rarely determines the two separately.
    - `frequency`, `quality`: of the one resonance that fits best. It is that of the load cell with its load,
      which is lower than that of the bare cell.
    - `held`, `after`: force before the release, and long after it.
    - `misfit`: rms of the residual over the rms of the force about its last level, after the end of the drive.
    """

    time: Real
    problem: Separable
    values: Mapping[str, float]

    start = property(lambda self: self.values["start"])
    fall_time = property(lambda self: self.values["time_constant"])
    delay = property(lambda self: self.start + self.fall_time)
    frequency = property(lambda self: self.values["frequency"])
    quality = property(lambda self: self.values["quality"])
    after = property(lambda self: self.values["after"])
    held = property(lambda self: self.after + self.values["change"])
    force = property(lambda self: self.problem.data)
    model = property(lambda self: self.problem.predicted(self.values))
    residual = property(lambda self: self.model - self.force)

    @property
    def misfit(self) -> float:
        """Infinite where the force does not change."""
        since = self.time >= 0
        moved = float(np.sqrt(np.mean((self.force[since] - self.after) ** 2)))
        return float(np.sqrt(np.mean(self.residual[since] ** 2))) / moved if moved else math.inf

    @classmethod
    def of(cls, time: Real, force: Real, window: float, *, resonant: bool = True) -> Release:
        """Fit a release to times after the end of the drive, from the best points of a grid."""
        step = float(np.median(np.diff(time)))
        # a fall faster than a tenth of the step cannot be distinguished from a discontinuity
        longest = window / 2 if resonant else window
        free = {
            "start": FreeParameter(start=0.0, lower=-step, upper=window / 2),
            "time_constant": FreeParameter(start=step, lower=step / 10, upper=longest, logarithmic=True),
            **(resonance_parameters(window, step) if resonant else {}),
        }

        def columns(at: Mapping[str, float]) -> Real:
            sensor = Sensor(frequency=at["frequency"], quality=at["quality"]) if resonant else None
            return EXPONENTIAL.columns(time, at, sensor)

        problem = Separable(
            columns=columns, data=force, free=free, names=EXPONENTIAL.amplitudes, ranges={"start": window}
        )
        starts = problem.best_starts(_grid(free, window), 4 if resonant else 6)
        return cls(time=time, problem=problem, values=problem.minimum(starts).values)

    def refined(self, *, kept: NDArray[np.bool_] | None = None, fall_time: float | None = None) -> Release:
        """Fit the same release to a part of the samples, or with a prescribed fall time."""
        problem, time = self.problem, self.time
        if kept is not None:
            problem, time = problem.part(kept), time[kept]
        start, held = dict(self.values), {}
        if fall_time is not None:
            held = {"time_constant": fall_time}
            start["start"] = max(self.delay - fall_time, 0.0)
        values = problem.holding(**held).minimum([start]).values
        return Release(time=time, problem=problem, values={**values, **held})


def _grid(free: Mapping[str, FreeParameter], window: float) -> list[dict[str, float]]:
    """Return the points at which the search begins."""
    if "frequency" not in free:
        starts = itertools.product((0.02, 0.05, 0.1, 0.2), (0.01, 0.05, 0.2))
        return [{"start": delay * window, "time_constant": part * window} for delay, part in starts]
    band = free["frequency"]
    return [
        {"start": delay / f, "time_constant": part / f, "frequency": f, "quality": quality}
        for f in map(float, np.geomspace(1.2 * band.lower, band.upper / 1.2, 25))
        for quality, delay, part in itertools.product((1.0, 3.0, 10.0), (0.0, 0.15, 0.4), (0.03, 0.2))
    ]


def uncertainties(
    best: Release, decays: tuple[RingSection | None, RingSection | None]
) -> tuple[dict[str, Interval], tuple[float, float]]:
    """Compute the uncertainty of a fitted release, and its lowest and highest fall time that fit as well within 95 %.

    The components are ``noise`` (of the fit, with the correlation of the residuals), ``window`` (rms change
    if the fit begins up to three quarters of a period after the release), ``fall time`` (of the other fall
    times that fit as well), for a delay ``end`` (of the drive, between two samples), for frequency and
    quality factor ``change`` (during the decay).
    """
    stamps, after = best.time, best.time >= 0
    # with the fall time held, an error of the start is one of the delay
    jacobian = best.problem.holding(time_constant=best.fall_time).jacobian(best.values)
    # the residual is noise before the end of the drive, and includes model error after it: the larger effect is taken
    kinds = (
        autocovariance(best.residual[~after], fitted=1),
        autocovariance(best.residual[after], fitted=jacobian.shape[1]),
    )
    alike = max(kinds, key=lambda of: float(covariance(jacobian=jacobian, autocovariance=of)[1, 1]))
    noise = np.sqrt(np.diag(covariance(jacobian=jacobian, autocovariance=alike)))
    lowest, highest = _falls(best, alike)
    falls = [best.refined(fall_time=each) for each in (lowest, highest) if each > 0]
    later = [
        best.refined(kept=(stamps < 0) | (stamps > best.delay + share / best.frequency))
        for share in _LATER_STARTS
    ]
    found = {}
    for place, name in enumerate(JUDGED):
        value = getattr(best, name)
        components = {
            "noise": float(noise[place]),
            "window": float(np.sqrt(np.mean([(getattr(fit, name) - value) ** 2 for fit in later]))),
            "fall time": float(np.ptp([value, *(getattr(fit, name) for fit in falls)]) / _INTERVAL),
        }
        if name == "delay":
            components["end"] = float(np.median(np.diff(stamps))) / math.sqrt(12)
        else:
            components |= _change(name, decays)
        found[name] = from_causes(value, components)
    return found, (lowest, highest)


def _change(name: str, decays: tuple[RingSection | None, RingSection | None]) -> dict[str, float]:
    """Return the change during the decay, uniformly distributed, beyond the noise of both fits."""
    early, late = (None if each is None else getattr(each, name) for each in decays)
    if early is None or late is None:
        return {}
    beyond: float = (late.value - early.value) ** 2 - early.standard_error**2 - late.standard_error**2
    return {"change": math.sqrt(max(0.0, beyond) / 12)}


def _falls(best: Release, alike: Real) -> tuple[float, float]:
    """Return the lowest and the highest fall time that fit as well: 0 and the longest that is tried where there is no end."""
    fall = max(best.fall_time, _LEAST_FALL / best.frequency)
    far = {**best.values, "time_constant": fall, "start": best.delay - fall}
    inflation = best.problem.inflation(far, "time_constant", alike)
    least = float(best.residual @ best.residual)

    def rise(fall: float) -> float:
        residual = best.refined(fall_time=fall).residual
        return (float(residual @ residual) - least) / (float(alike[0]) * inflation)

    free = best.problem.free["time_constant"]
    found = profile_interval(
        rise, best.fall_time, deviation=0.25 * _LEAST_FALL / best.frequency, bounds=(free.lower, free.upper),
        allowed=(_INTERVAL / 2) ** 2, logarithmic=True,
    )  # fmt: skip
    return 0.0 if found.open_below else found.lower, found.upper


@dataclass(frozen=True, kw_only=True, repr=False)
class FittedRelease(Release):
    """A fitted release and the damped oscillation after it; times are after the end of the drive unless stated otherwise.

    - `plain`: the best exponential release recorded by a sensor without resonance.
    - `drive_end`: end of the drive on the clock of the record: mean of its last sample and the next.
    - `fall_time_interval`: lowest and highest time constant that fit as well, 95 % on either side, the lowest
      0 if a discontinuity fits as well.
    - `scatter`: standard deviation of the force before the release.
    - `missing`: number of rows that were omitted because they held a NaN.
    - `early`, `late`: damped sines fitted from the first turning point on, and from three quarters of a
      period later, or None.
    """

    plain: Release
    drive_end: float
    fall_time_interval: tuple[float, float]
    uncertainty: Mapping[str, Interval]
    scatter: float
    missing: int
    extrema: tuple[Extremum, ...]
    early: RingSection | None
    late: RingSection | None
    remarks: tuple[str, ...] = ()

    misfit_without = property(lambda self: self.plain.misfit)
    model_without = property(lambda self: self.plain.model)

    @property
    def half_periods(self) -> tuple[float, ...]:
        """Frequencies from the intervals between successive turning points [Hz]."""
        pairs = itertools.pairwise(self.extrema)
        return tuple(1 / (2 * (later.time - earlier.time)) for earlier, later in pairs)

    @property
    def words(self) -> tuple[str, ...]:
        """What the record determines: the resonance, the delay, and the change of the frequency."""
        return (_resonance(self), *_delay(self), *_changes(self), *self.remarks)

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
            "extrema": [vars(each) for each in self.extrema],
            "half_periods": list(self.half_periods),
            "early": None if self.early is None else self.early.to_dict(),
            "late": None if self.late is None else self.late.to_dict(),
            "words": list(self.words),
        }


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


def _resonance(found: FittedRelease) -> str:
    frequency, quality = found.uncertainty["frequency"], found.uncertainty["quality"]
    if not frequency.standard_error < _KNOWN * found.frequency:
        return (
            f"The record does not determine a resonance: the best fit, {found.frequency:.0f} Hz, has a standard uncertainty"
            f" of {frequency.standard_error:.2g} Hz."
        )
    return (
        f"One resonance of the loaded assembly (load cell with its load) is fitted: {found.frequency:.0f} Hz with a"
        f" standard uncertainty of {frequency.standard_error:.2g} Hz ({_parts(frequency, 1, 'Hz')}), quality factor"
        f" {found.quality:.1f} with {quality.standard_error:.2g} ({_parts(quality, 1, '')}). Its residual is"
        f" {found.misfit:.1%} of the force after the end of the drive; without the resonance the residual is"
        f" {found.misfit_without:.1%}."
    )


def _delay(found: FittedRelease) -> tuple[str, str]:
    error, (low, high) = found.uncertainty["delay"], found.fall_time_interval
    fall = f"is {found.fall_time * 1e3:.2g} ms; values between {low * 1e3:.2g} and {high * 1e3:.2g} ms fit as well."
    if low == 0:
        fall = f"is not determined: any value up to {high * 1e3:.2g} ms fits as well."
    return (
        f"The force falls {found.delay * 1e3:.2f} ms after the end of the drive, with a standard uncertainty of"
        f" {error.standard_error * 1e3:.2g} ms ({_parts(error, 1e3, 'ms')}).",
        f"The time constant of the fall {fall}",
    )


def _parts(uncertainty: Interval, factor: float, unit: str) -> str:
    return ", ".join(
        f"{_CALLED[name]} {value * factor:.2g} {unit}".rstrip()
        for name, value in uncertainty.components.items()
    )


def _changes(found: FittedRelease) -> list[str]:
    said = []
    if len(found.half_periods) >= 2:
        shown = ", ".join(f"{value:.0f}" for value in found.half_periods)
        said.append(f"Successive turning points give {shown} Hz.")
    if found.early is None or found.late is None:
        return said
    first, last = found.early.frequency, found.late.frequency
    said.append(
        f"A damped sine fitted from the first turning point on has {first.value:.0f} ± {first.standard_error:.2g} Hz"
        f" (quality factor {found.early.quality.value:.1f}); fitted from three quarters of a period later,"
        f" {last.value:.0f} ± {last.standard_error:.2g} Hz (quality factor {found.late.quality.value:.1f})."
    )
    error = math.hypot(first.standard_error, last.standard_error)
    if abs(last.value - first.value) > max(_APART * error, 0.01 * first.value):
        change = "falls" if last.value < first.value else "rises"
        said.append(
            f"The frequency {change} during the decay, which no single linear resonance reproduces: part of the"
            " misfit is due to it and not to noise."
        )
    return said
