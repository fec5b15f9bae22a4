"""A release recorded by a resonant sensor, or by one without resonance, fitted by least squares, and its uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.fit.separable import Separable, resonance_parameters
from electrovib.recordings.interval import Interval, autocovariance, covariance, from_causes, profile_interval
from electrovib.recordings.transitions import modes
from electrovib.recordings.transitions.relaxation import EXPONENTIAL

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.recordings.transitions.modes import RingSection

JUDGED: Final = ("delay", "frequency", "quality")
_LATER_STARTS: Final = (0.25, 0.5, 0.75)
"""Alternative beginnings of the window after the release, in periods."""
_LEAST_FALL: Final = 0.1
"""Fall time, in periods, from which on the record depends on it linearly: near 0 it depends on its square."""
_INTERVAL: Final = 3.29
"""Standard deviations from one end of an interval to the other: 95 % on either side."""


@dataclass(frozen=True, kw_only=True)
class Release:
    """A fitted release, with times after the end of the drive: a relaxation seen by a sensor with a resonance, or without."""

    stamps: Real
    problem: Separable
    values: Mapping[str, float]

    @classmethod
    def of(cls, stamps: Real, force: Real, window: float, *, resonant: bool = True) -> Release:
        """Fit a release to times `stamps` after the end of the drive, from the best points of a grid."""
        step = float(np.median(np.diff(stamps)))
        # a fall faster than a tenth of the step cannot be distinguished from a discontinuity
        longest = window / 2 if resonant else window
        free = {
            "start": FreeParameter(start=0.0, lower=-step, upper=window / 2),
            "time_constant": FreeParameter(start=step, lower=step / 10, upper=longest, logarithmic=True),
            **(resonance_parameters(window, step) if resonant else {}),
        }
        problem = Separable(
            columns=lambda at: EXPONENTIAL.columns(
                stamps, at, (at["frequency"], at["quality"]) if resonant else None
            ),
            data=force,
            free=free,
            names=EXPONENTIAL.amplitudes,
            ranges={"start": window},
        )
        grid = _with_resonance(free["frequency"]) if resonant else _without_resonance(window)
        starts = problem.best_starts(grid, 4 if resonant else 6)
        return cls(stamps=stamps, problem=problem, values=problem.minimum(starts).values)

    def refined(self, *, kept: NDArray[np.bool_] | None = None, fall_time: float | None = None) -> Release:
        """Fit the same release to a part of the samples, or with a prescribed fall time."""
        problem, stamps = self.problem, self.stamps
        if kept is not None:
            problem, stamps = problem.part(kept), stamps[kept]
        start = dict(self.values)
        held = {}
        if fall_time is not None:
            held = {"time_constant": fall_time}
            start["start"] = max(self.delay - fall_time, 0.0)
        found = problem.holding(**held).minimum([start])
        return Release(stamps=stamps, problem=problem, values={**found.values, **held})

    @property
    def start(self) -> float:
        """Time at which the force begins to fall [s]."""
        return self.values["start"]

    @property
    def fall_time(self) -> float:
        """Time constant of the fall [s]."""
        return self.values["time_constant"]

    @property
    def delay(self) -> float:
        """Mean time of the fall of the force [s]: its start plus its time constant."""
        return self.start + self.fall_time

    @property
    def frequency(self) -> float:
        """Natural frequency of the resonance [Hz]."""
        return self.values["frequency"]

    @property
    def quality(self) -> float:
        """Quality factor of the resonance, dimensionless."""
        return self.values["quality"]

    @property
    def after(self) -> float:
        """Force long after the release [N]."""
        return self.values["after"]

    @property
    def held(self) -> float:
        """Force before the release [N]."""
        return self.after + self.values["change"]

    @property
    def model(self) -> Real:
        """Fitted force [N]."""
        return self.problem.predicted(self.values)

    @property
    def residual(self) -> Real:
        """Model less force [N]."""
        return self.model - self.problem.data

    @property
    def misfit(self) -> float:
        """Rms of the residual over that of the force about its last level, after the end of the drive; infinite of no change."""
        since = self.stamps >= 0
        moved = float(np.sqrt(np.mean((self.problem.data[since] - self.after) ** 2)))
        return float(np.sqrt(np.mean(self.residual[since] ** 2))) / moved if moved else math.inf


def _with_resonance(band: FreeParameter) -> list[dict[str, float]]:
    return [
        {"start": delay / f, "time_constant": part / f, "frequency": f, "quality": quality}
        for f in map(float, np.geomspace(1.2 * band.lower, band.upper / 1.2, 25))
        for quality in (1.0, 3.0, 10.0)
        for delay in (0.0, 0.15, 0.4)
        for part in (0.03, 0.2)
    ]


def _without_resonance(window: float) -> list[dict[str, float]]:
    return [
        {"start": delay * window, "time_constant": part * window}
        for delay in (0.02, 0.05, 0.1, 0.2)
        for part in (0.01, 0.05, 0.2)
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
    stamps, after = best.stamps, best.stamps >= 0
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
        rise,
        best.fall_time,
        deviation=0.25 * _LEAST_FALL / best.frequency,
        bounds=(free.lower, free.upper),
        allowed=(_INTERVAL / 2) ** 2,
        logarithmic=True,
    )
    return 0.0 if found.open_below else found.lower, found.upper


_STANDS_OUT = 3.0
"""Smallest distance of a turning point from the level, in standard deviations of the noise."""


@dataclass(frozen=True)
class Extremum:
    """A turning point of the force."""

    time: float
    force: float


def drive_end(*, time: Real, voltage: Real, name: str = "voltage") -> float:
    """Return the mean time of the last sample above half of the largest magnitude of a drive and of the next one."""
    on, peak = _on(voltage)
    if peak == 0 or len(on) == len(time):
        raise InputError(
            f"{name}: lies between {voltage.min():g} and {voltage.max():g} and is never switched on and off; is it the"
            " right column?"
        )
    if on[-1] == len(time) - 1:
        raise InputError(f"{name}: the drive is still on at the last sample, so the record holds no release")
    return float(time[on[-1]] + time[on[-1] + 1]) / 2


def _on(voltage: Real) -> tuple[NDArray[np.intp], float]:
    """Return the samples at which the drive is on, and its magnitude."""
    size = np.abs(voltage)
    # a median, because the read-back may have spikes
    peak = float(np.quantile(size[size >= size.max() / 2], 0.5))
    return np.flatnonzero(size > peak / 2), peak


def find_extrema(
    stamps: Real,
    force: Real,
    *,
    start: float,
    period: float,
    level: float,
    scatter: float,
    end: float,
) -> list[Extremum]:
    """Find the turning points after a release, on alternate sides of the level, as far as they exceed the noise `scatter`."""
    before = force[stamps < 0]
    side = -1.0 if np.mean(before[-20:]) > level else 1.0
    place, reach, found = start, (0.2, 0.9), []
    while place + reach[1] * period < end:
        part = np.flatnonzero((stamps > place + reach[0] * period) & (stamps < place + reach[1] * period))
        if len(part) < 5:
            break
        top = float(stamps[part[int(np.argmax(side * force[part]))]])
        extremum = _parabola(stamps, force, top, period / 8)
        if extremum is None or side * (extremum.force - level) < _STANDS_OUT * scatter:
            break
        found.append(extremum)
        place, side, reach = extremum.time, -side, (0.25, 0.8)
    return found


def _parabola(stamps: Real, force: Real, top: float, half: float) -> Extremum | None:
    for _ in range(3):
        near = np.abs(stamps - top) <= half
        if np.count_nonzero(near) < 4:
            return None
        square, slope, level = np.polyfit((stamps[near] - top) / half, force[near], 2)
        if square == 0:
            return None
        shift = float(np.clip(-slope / (2 * square), -1, 1))
        top += shift * half
    return Extremum(float(top), float(level - slope**2 / (4 * square)))


def damped_sine(stamps: Real, force: Real, *, start: float, end: float) -> RingSection | None:
    """Fit a damped sine about a level to a section of a record; None if it holds fewer than 12 samples."""
    part = (stamps >= start) & (stamps <= end)
    return modes.damped_sine(stamps[part], force[part], start=start) if np.count_nonzero(part) >= 12 else None
