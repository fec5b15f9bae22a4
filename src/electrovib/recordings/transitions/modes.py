"""Damped oscillations of one or two modes, or of a mode whose frequency drifts, fitted to a section of a record."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.fit.separable import Separable, Whitening
from electrovib.recordings.interval import Interval

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.least_squares import LeastSquaresEstimate

ONE: Final = "one mode"
DRIFTING: Final = "one drifting mode"
TWO: Final = "two modes"
_PARTS: Final = {ONE: ("",), DRIFTING: ("",), TWO: ("", "early_")}
_BEST_STARTS: Final = 3
CONSTANT: Final = "constant"
LINEAR: Final = "linear"
RELAXING: Final = "exponential"
LEVELS: Final = (CONSTANT, LINEAR, RELAXING)
"""Forms of the level about which a signal oscillates, from the simplest on."""
_LEVEL_TIMES: Final = (0.2, 3.0)
"""Bounds of the time constant of an exponential level, in lengths of the section."""


@dataclass(frozen=True, kw_only=True)
class FittedModes:
    """One form of a damped oscillation, such as ``one mode``, fitted to a section about a level, such as ``linear``.

    `estimate` has frequencies of the damped oscillation [Hz], rates of decay [1/s] and amplitudes; `rejected`
    says why the fit has not this form; `criterion` is the BIC of this form fitted to samples without the
    correlation of the noise.
    """

    form: str
    level: str
    estimate: LeastSquaresEstimate
    model: Real
    rejected: str
    criterion: float

    @property
    def bic(self) -> float:
        """Criterion of Schwarz, dimensionless; infinite if the form was rejected."""
        return math.inf if self.rejected else self.criterion

    def parameters(self) -> dict[str, Interval]:
        """Return natural frequencies, quality factors, drift and the time constant of the level with their intervals."""
        found: dict[str, Interval] = {}
        for part in _PARTS[self.form]:
            frequency, quality = self._mode(part)
            found |= {f"{part}frequency": frequency, f"{part}quality": quality}
        if self.form == DRIFTING:
            found["drift"] = self.estimate.parameter("drift")
        if self.level == RELAXING:
            found["level_time_constant"] = self.estimate.parameter("level_time")
        return found

    def level_change(self, time: Real) -> Real:
        """Compute how far the level is from that which the constant part of the fit gives, at times after the start."""
        values, time = self.estimate.values, np.maximum(time, 0.0)
        if self.level == LINEAR:
            return np.asarray(values["level_slope"] * time)
        if self.level == RELAXING:
            return np.asarray(values["level_change"] * np.exp(-time / values["level_time"]))
        return np.zeros_like(time)

    def _mode(self, part: str) -> tuple[Interval, Interval]:
        """Natural frequency sqrt(f_d^2 + (r/2 pi)^2) and quality factor pi f/r of a mode with rate of decay r."""
        names = (f"{part}damped_frequency", f"{part}rate")
        damped, rate = (self.estimate.values[name] for name in names)
        frequency = math.hypot(damped, rate / (2 * math.pi))
        quality = math.pi * frequency / rate
        of_frequency = np.array([damped / frequency, rate / (4 * math.pi**2 * frequency)])
        of_quality = math.pi * of_frequency / rate - np.array([0.0, quality / rate])
        return (
            self.estimate.derived(frequency, dict(zip(names, of_frequency.tolist(), strict=True))),
            self.estimate.derived(quality, dict(zip(names, of_quality.tolist(), strict=True))),
        )


@dataclass(frozen=True)
class RingSection:
    """One damped oscillation, fitted from `start` after the reference on, by frequency [Hz] and quality factor."""

    start: float
    frequency: Interval
    quality: Interval


def fit_modes(
    time: Real,
    values: Real,
    names: Sequence[str] = (ONE, DRIFTING, TWO),
    *,
    noise: Real,
    level: str = CONSTANT,
    fitted: Mapping[str, FittedModes] | None = None,
) -> dict[str, FittedModes]:
    """Fit forms of a damped oscillation about a level to a section, with the correlation of the residuals.

    A sum of e^(-r t) [a cos(phase) + b sin(phase)] and a level; phase = 2 pi (f t + d t^2/2) with the drift d
    of a drifting mode. The time constant of an exponential level is between 1/5 and 3 lengths of the section.
    Estimates and criterion are found as in `fit_forms`. `noise` are samples without oscillation; `fitted` the
    same forms about a simpler level, where the search begins.
    """
    white = Whitening.of(noise)
    found: dict[str, FittedModes] = {}
    one: LeastSquaresEstimate | None = None
    for name in names:
        problem = _problem(time, values, name, level)
        if fitted is None:
            starts = _starts(problem, name, one, time)
        else:
            starts = _with_level(problem, [dict(fitted[name].estimate.values)], time)
        estimate = problem.solve(starts, whitening=Whitening())
        if name == TWO and estimate.values["early_rate"] < estimate.values["rate"]:
            estimate = problem.solve([_swapped(estimate.values)], whitening=Whitening())
        one = one or estimate
        found[name] = FittedModes(
            form=name,
            level=level,
            estimate=estimate,
            model=problem.predicted(estimate.values),
            rejected=_rejected(name, estimate),
            criterion=problem.minimum([estimate.values], whitening=white).bic,
        )
    return found


def _with_level(
    problem: Separable, starts: Sequence[Mapping[str, float]], time: Real
) -> list[Mapping[str, float]]:
    """Add to each start a short and a long time constant of an exponential level, where it has one."""
    if "level_time" not in problem.free:
        return list(starts)
    whole = float(time[-1] - time[0])
    return [{**start, "level_time": part * whole} for start in starts for part in (0.3, 1.0)]


def _rejected(name: str, estimate: LeastSquaresEstimate) -> str:
    if estimate.on_bound:
        return f"{next(iter(estimate.on_bound))} lies on a bound"
    if estimate.covariance is None:
        return estimate.why_no_covariance
    if name == TWO:
        for part in ("", "early_"):
            frequency, error = (
                of[f"{part}damped_frequency"] for of in (estimate.values, estimate.standard_deviations)
            )
            if not error < 0.3 * frequency:
                return "the frequency of one of its modes is not determined"
    return ""


def _swapped(values: Mapping[str, float]) -> dict[str, float]:
    """Return the same two modes with the one that lasts longer first."""
    found = dict(values)
    for name in ("damped_frequency", "rate"):
        found[name], found[f"early_{name}"] = values[f"early_{name}"], values[name]
    return found


def _problem(time: Real, values: Real, name: str, level: str) -> Separable:
    step, whole = float(np.median(np.diff(time))), float(time[-1] - time[0])
    slow, fast = 0.5 / whole, 1 / (4 * step)
    free = {}
    for part in _PARTS[name]:
        free[f"{part}damped_frequency"] = FreeParameter(
            start=math.sqrt(slow * fast), lower=slow, upper=fast, logarithmic=True
        )
        free[f"{part}rate"] = FreeParameter(
            start=3 / whole, lower=0.01 / whole, upper=5 * fast, logarithmic=True
        )
    if name == DRIFTING:
        free["drift"] = FreeParameter(start=0.0, lower=-fast / whole, upper=fast / whole)

    if level == RELAXING:
        shortest, longest = (part * whole for part in _LEVEL_TIMES)
        free["level_time"] = FreeParameter(start=whole, lower=shortest, upper=longest, logarithmic=True)

    def columns(at: Mapping[str, float]) -> Real:
        waves = []
        for part in _PARTS[name]:
            phase = 2 * np.pi * (at[f"{part}damped_frequency"] * time + at.get("drift", 0.0) * time**2 / 2)
            decay = np.exp(-at[f"{part}rate"] * time)
            waves += [decay * np.cos(phase), decay * np.sin(phase)]
        if level == LINEAR:
            waves.append(time)
        elif level == RELAXING:
            waves.append(np.exp(-time / at["level_time"]))
        return np.column_stack([*waves, np.ones_like(time)])

    amplitudes = [f"{part}{kind}" for part in _PARTS[name] for kind in ("cosine", "sine")]
    amplitudes += {LINEAR: ["level_slope"], RELAXING: ["level_change"]}.get(level, [])
    return Separable(
        columns=columns, data=values, free=free, names=(*amplitudes, "level"), ranges={"drift": 1 / whole**2}
    )


def _starts(
    problem: Separable, name: str, one: LeastSquaresEstimate | None, time: Real
) -> list[Mapping[str, float]]:
    if one is not None and name == DRIFTING:
        return [{**one.values, "drift": 0.0}]
    low, high = (getattr(problem.free["damped_frequency"], end) for end in ("lower", "upper"))
    whole = float(time[-1] - time[0])
    grid: list[Mapping[str, float]] = []
    for frequency in np.geomspace(1.05 * low, high / 1.05, 48):
        for quality in (1.5, 4.0, 12.0):
            mode = {"damped_frequency": float(frequency), "rate": float(np.pi * frequency / quality)}
            if name == ONE:
                grid.append(mode)
            elif one is not None:
                grid.append({**one.values, **{f"early_{key}": each for key, each in mode.items()}})
                grid.append(
                    {**one.values, "rate": 4 / whole, **{f"early_{key}": each for key, each in mode.items()}}
                )
    grid = _with_level(problem, grid, time)
    return problem.best_starts(grid, _BEST_STARTS)
