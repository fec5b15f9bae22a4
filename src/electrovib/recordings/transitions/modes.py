"""Least squares of a model that is linear in its amplitudes, and damped oscillations fitted by it to a section of a record."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate, least_squares
from electrovib.recordings.interval import Interval, NumberRow, autocovariance, covariance

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from electrovib.core.arrays import Real

_STEP: Final = 1e-5
"""Step of a derivative, relative to a logarithmic parameter, or to the range of another one."""
_CONVERGED: Final = 1e-10
_MOST: Final = 300
_FEWEST: Final = 50
"""Samples of noise from which its correlation is determined."""


@dataclass(frozen=True)
class Whitening:
    """A filter that makes noise of a second-order autoregression independent.

    `coefficients` are a1, a2 of e_k = y_k + a1 y_(k-1) + a2 y_(k-2); zeros leave independent noise as it is, less the
    two samples that every filter takes, so that both kinds of fits have the same samples.
    """

    coefficients: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, noise: Real) -> Whitening:
        """Determine the filter from noise without signal; fewer than 50 samples give one without effect."""
        if len(noise) < _FEWEST:
            return cls()
        lags = autocovariance(noise - np.mean(noise), fitted=1)[:3]
        if not lags[0] > 0:
            return cls()
        matrix = np.array([[lags[0], lags[1]], [lags[1], lags[0]]])
        found = np.linalg.lstsq(matrix, -lags[1:3], rcond=None)[0]
        return cls((float(found[0]), float(found[1])))

    def __call__(self, values: Real) -> Real:
        """Apply the filter along the first axis, shape (n, ...) to (n - 2, ...)."""
        first, second = self.coefficients
        return np.asarray(values[2:] + first * values[1:-1] + second * values[:-2])


@dataclass(frozen=True, kw_only=True)
class Separable:
    """A model y = sum of amplitudes times columns that depend on nonlinear parameters.

    `columns` maps these parameters to shape (n, k); `names` are those of the k amplitudes; `ranges` is the
    step scale of a parameter that is not logarithmic.
    """

    columns: Callable[[Mapping[str, float]], Real]
    data: Real
    free: Mapping[str, FreeParameter]
    names: Sequence[str]
    ranges: Mapping[str, float]

    def holding(self, **held: float) -> Separable:
        """Return the problem with some nonlinear parameters held at values, in their units."""
        free = {name: each for name, each in self.free.items() if name not in held}
        return dataclasses.replace(self, columns=lambda at: self.columns({**at, **held}), free=free)

    def best_starts(self, grid: Sequence[Mapping[str, float]], count: int) -> list[Mapping[str, float]]:
        """Return those of many starts, moved between the bounds, that have the least sums of squares over the amplitudes."""
        inside: list[Mapping[str, float]] = [
            {name: each.starting_at(start[name]).start for name, each in self.free.items()} for start in grid
        ]
        left = [self._solved(start, None)[2] for start in inside]
        return [inside[at] for at in np.argsort([float(each @ each) for each in left])[:count]]

    def minimum(
        self, starts: Sequence[Mapping[str, float]], *, whitening: Whitening | None = None
    ) -> LeastSquaresEstimate:
        """Search the nonlinear parameters from several starts, and return the best values of all parameters."""
        found = [self._minimum(start, whitening) for start in starts]
        best = min(found, key=lambda each: each.sum_of_squares)
        _, amplitudes, _ = self._solved(best.values, whitening)
        values = {**best.values, **dict(zip(self.names, map(float, amplitudes), strict=True))}
        return dataclasses.replace(best, values=values)

    def solve(
        self, starts: Sequence[Mapping[str, float]], *, whitening: Whitening | None = None
    ) -> LeastSquaresEstimate:
        """Return the same with the covariance, which contains the correlation of the residuals."""
        best = self.minimum(starts, whitening=whitening)
        left = _filtered(self.predicted(best.values) - self.data, whitening)
        slopes = self.jacobian(best.values, whitening)
        estimate = best.judged(left, slopes, self.free)
        return dataclasses.replace(estimate, covariance=_with_correlation(estimate, slopes, left))

    def _minimum(self, start: Mapping[str, float], whitening: Whitening | None) -> LeastSquaresEstimate:
        """Search from one start; the derivatives are those of Kaufman 1975, projected beside the columns."""
        solved = functools.lru_cache(maxsize=1)(lambda *at: self._solved(dict(at), whitening))

        def sloped(values: Mapping[str, float]) -> Real:
            phi, amplitudes, _ = solved(*values.items())
            slopes = self._slopes(values, amplitudes, whitening)
            basis = np.linalg.qr(phi)[0]
            return np.asarray(slopes - basis @ (basis.T @ slopes))

        return least_squares(
            lambda values: solved(*values.items())[2],
            {name: each.starting_at(start[name]) for name, each in self.free.items()},
            derivatives=sloped,
            noise_is_known=False,
            converged=_CONVERGED,
            most_evaluations=_MOST,
            judged=False,
        )

    def _solved(self, values: Mapping[str, float], whitening: Whitening | None) -> tuple[Real, Real, Real]:
        """Return the columns, the best amplitudes and the residual at values of the nonlinear parameters."""
        phi, data = _filtered(self.columns(values), whitening), _filtered(self.data, whitening)
        amplitudes = np.asarray(np.linalg.lstsq(phi, data, rcond=None)[0], dtype=float)
        return phi, amplitudes, phi @ amplitudes - data

    def jacobian(self, values: Mapping[str, float], whitening: Whitening | None = None) -> Real:
        """Differentiate the model after the nonlinear parameters, then the amplitudes, shape (n, parameters)."""
        amplitudes = np.array([values[name] for name in self.names])
        slopes = self._slopes(values, amplitudes, whitening)
        return np.column_stack([slopes, _filtered(self.columns(values), whitening)])

    def inflation(
        self, values: Mapping[str, float], name: str, alike: Real, without: Collection[str] = ()
    ) -> float:
        """Return by how much noise of an autocovariance increases the variance of a parameter, at least 1.

        Parameters `without` uncertainty, such as those on a bound, are taken as known.
        """
        kept = [each for each in (*self.free, *self.names) if each not in without]
        if name not in kept:
            return 1.0
        rows = [at for at, each in enumerate((*self.free, *self.names)) if each in kept]
        slopes, own = self.jacobian(values)[:, rows], kept.index(name)
        whole, alone = (covariance(jacobian=slopes, autocovariance=of)[own, own] for of in (alike, alike[:1]))
        return max(float(whole / alone), 1.0) if math.isfinite(whole) and alone > 0 else 1.0

    def predicted(self, values: Mapping[str, float]) -> Real:
        """Return the model, shape (n,), at all parameters."""
        return np.asarray(self.columns(values) @ [values[name] for name in self.names])

    def _slopes(self, values: Mapping[str, float], amplitudes: Real, whitening: Whitening | None) -> Real:
        """Return the derivatives of the filtered model after the nonlinear parameters, shape (n, parameters)."""
        steps = {
            name: _STEP * (values[name] if each.logarithmic else self.ranges[name])
            for name, each in self.free.items()
        }
        found = central_differences(lambda at: self.columns(at) @ amplitudes, values, steps)
        return _filtered(np.column_stack([np.zeros((len(self.data), 0)), *found.values()]), whitening)


def central_differences(
    function: Callable[[Mapping[str, float]], Any], values: Mapping[str, float], steps: Mapping[str, float]
) -> dict[str, Any]:
    """Differentiate what a function gives after those of its values that have a step."""

    def at(name: str, shift: float) -> Any:
        return function({**values, name: values[name] + shift})

    return {name: (at(name, step) - at(name, -step)) / (2 * step) for name, step in steps.items()}


def resonance_parameters(window: float, step: float) -> dict[str, FreeParameter]:
    """Natural frequency and quality factor of a resonance that samples `step` apart within a `window` resolve."""
    slow, fast = 0.5 / window, 1 / (6 * step)
    if fast <= slow:
        raise InputError(
            f"samples {step:g} s apart are too few to resolve an oscillation within {window:g} s"
        )
    return {
        "frequency": FreeParameter(start=math.sqrt(slow * fast), lower=slow, upper=fast, logarithmic=True),
        "quality": FreeParameter(start=2.0, lower=0.6, upper=100.0, logarithmic=True),
    }


def _filtered(values: Real, whitening: Whitening | None) -> Real:
    return values if whitening is None else whitening(values)


def _with_correlation(found: LeastSquaresEstimate, slopes: Real, left: Real) -> Real | None:
    """Return the covariance for residuals that are correlated, by the noise or because the model is not exact."""
    if found.covariance is None:
        return None
    inside = [at for at, name in enumerate(found.values) if name not in found.on_bound]
    alike = covariance(jacobian=slopes[:, inside], autocovariance=autocovariance(left, fitted=len(inside)))
    if not np.isfinite(alike).all():
        return found.covariance
    whole = np.zeros_like(found.covariance)
    whole[np.ix_(inside, inside)] = alike
    return whole


Name = TypeVar("Name")

SUPPORTED: Final = 2.0
"""Difference of the criterion up to which a form has substantial support (Burnham and Anderson 2002)."""


def chosen_form(criterion: Mapping[Name, float]) -> Name:
    """Choose the first form, from the simplest on, whose criterion is at most 2 above the lowest."""
    lowest = min(criterion.values())
    return next(
        name for name, value in criterion.items() if value <= lowest + SUPPORTED or not math.isfinite(lowest)
    )


def above_lowest(criterion: Mapping[str, float]) -> dict[str, float]:
    """Return the differences of a criterion from the lowest, dimensionless."""
    lowest = min(criterion.values())
    return {name: value - lowest if math.isfinite(lowest) else 0.0 for name, value in criterion.items()}


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


REFERENCES: Final = (
    "IEEE Std 181-2011, Transitions, Pulses, and Related Waveforms",
    "K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed., Springer, 2002",
)
MOST_FIGURES: Final = 3
"""Most edges or oscillations that are drawn."""
UNITS: Final = {
    "delay": "s",
    "time constant": "s",
    "level time constant": "s",
    "frequency": "Hz",
    "early frequency": "Hz",
    "drift": "Hz/s",
}
"""Units of parameters; those that are absent are dimensionless."""
MISFIT: Final = 1.5
"""Rms residual over the noise above which a form does not reproduce what was recorded."""


def parameter_row(group: str, name: str, number: Interval, form: str, note: str) -> NumberRow:
    """Make the row of one parameter of a fitted form."""
    words = name.replace("_", " ")
    unit = next((unit for key, unit in UNITS.items() if words.startswith(key)), "1")
    return NumberRow(group=group, name=f"{words} ({form})", unit=unit, number=number, note=note)


def misfit_note(misfit: float) -> str:
    """Write how far a residual is beyond the noise; empty where it is not."""
    if math.isinf(misfit):
        return "error not known: the record has no noise without signal"
    return f"error beyond the interval: residual {misfit:.2g} times the noise" if misfit > MISFIT else ""
