"""The fit of a scenario's parameters to recordings of one or several sessions."""

from __future__ import annotations

import dataclasses
import functools
import json
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import one_thread
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import value_at
from electrovib.recordings.fit.identifiability import identifiability, trades
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate, required
from electrovib.recordings.fit.measured import MeasuredTrace, as_recorded
from electrovib.recordings.fit.misfit import between_sessions, misfit_of
from electrovib.recordings.fit.prediction import Prediction, residuals_of
from electrovib.recordings.fit.problem import Callback, CancelledError, WeightedProblem, first_noise, weighted
from electrovib.recordings.fit.result import ScenarioFit
from electrovib.recordings.fit.rounding import rounding_of
from electrovib.scenario import Source, read_scenario
from electrovib.solve.meter import Meter

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real


_FEW: Final = 400
"""Samples of each recording with which a search begins; the last steps take all of them."""
_ROUGH: Final = 1e-3


@one_thread(with_scipy=True)
def fit_scenario(
    scenario: Source,
    recordings: Sequence[MeasuredTrace | xarray.Dataset] | MeasuredTrace | xarray.Dataset,
    *,
    free: Sequence[str],
    varying: Sequence[str] = (),
    signals: Sequence[str] | None = None,
    start: Mapping[str, float] | None = None,
    keep: Sequence[str] = (),
    progress: Callback | None = None,
) -> ScenarioFit:
    """Estimate parameters of a scenario from recordings.

    Weighted least squares. The search begins at the values of the scenario, or at `start`, in SI; the bounds
    of the `free` parameters are those that the models declare, and `varying` ones differ between the sessions
    of the recordings. `keep` names the parts (``"drive"``, ``"load"``, ``"motion"``) that are taken from the
    scenario although a recording holds them. Noise that is not stated is estimated for each signal of each
    recording from its residuals, in turn with the parameters, until it changes by less than 0.1 %: the
    estimate of largest likelihood, with the degrees of freedom that the parameters take shared among the
    signals by their number of data. Combinations that the data do not determine are named, and their
    parameters have no interval: see `identifiability`.
    """
    measured = _measured(recordings)
    if not free:
        raise InputError("free: name at least one parameter, for instance stack.gap.thickness")
    base = read_scenario(scenario)
    measured, said = as_recorded(base, measured, free, keep)
    predicted = functools.partial(Prediction, base, free=free, varying=varying, signals=signals)
    prediction, few = predicted(measured, start=start), None
    thinned = [dataclasses.replace(each, trace=_thinned(each.trace)) for each in measured]
    if any(after.trace is not before.trace for after, before in zip(thinned, measured, strict=True)):
        few = predicted(thinned)
        few.free = prediction.free
    begin = _roughly(few, prediction, progress)
    noise, estimate, problem = weighted(prediction, begin, progress)
    found = _judged(problem, WeightedProblem(few or prediction, noise), estimate, noise)
    if not said:
        return found
    own = {path: value_at(found.scenario, path) for path in free}
    return dataclasses.replace(found, scenario=base.replace(own), prescribed=tuple(said))


def _measured(
    recordings: Sequence[MeasuredTrace | xarray.Dataset] | MeasuredTrace | xarray.Dataset,
) -> list[MeasuredTrace]:
    given = [recordings] if not isinstance(recordings, Sequence) else list(recordings)
    return [
        each if isinstance(each, MeasuredTrace) else MeasuredTrace(trace=each, name=f"recording {at + 1}")
        for at, each in enumerate(given)
    ]


def _judged(
    problem: WeightedProblem, few: WeightedProblem, estimate: LeastSquaresEstimate, noise: Sequence[float]
) -> ScenarioFit:
    """Judge what the data determine, and collect the result."""
    prediction, values = problem.prediction, estimate.values
    inside = [name for name in values if name not in estimate.on_bound]
    rows = [list(values).index(name) for name in inside]
    zeros = [each.name for each in prediction.unknowns if each.is_offset]
    residuals = tuple(residuals_of(prediction, values, noise))
    misfit = misfit_of(problem, values, residuals)
    variance = misfit.inflation * estimate.variance_of_noise
    judged = identifiability(
        problem.derivatives(values)[:, rows] / np.sqrt(variance or 1.0),
        {name: values[name] for name in inside},
        zeros=zeros,
    )
    traded = _traded(problem.derivatives(values), list(values), estimate.on_bound)
    estimate = dataclasses.replace(
        estimate,
        covariance=_whole(judged.covariance, list(values), rows, traded),
        why_no_covariance="; ".join(each.sentence for each in judged.undetermined),
    )
    kept = [name for name in inside if judged.states[name] != "not" and name not in traded]
    at = [inside.index(name) for name in kept]
    bias = curvature_bias(few, values, kept, judged.covariance[np.ix_(at, at)]) if kept else {}
    rounding = rounding_of(residuals, problem.derivatives(values)[:, rows], problem.weights, inside)
    states = {
        name: "weakly"
        if state == "well"
        and name not in traded
        and (abs(bias[name]) > BIASED or (rounding is not None and rounding.is_coarse(name, values[name])))
        else state
        for name, state in judged.states.items()
    }
    sessions: dict[str, dict[str, str]] = {}
    shared: dict[str, float] = {}
    for each in prediction.unknowns:
        if each.session:
            sessions.setdefault(each.path, {})[each.session] = each.name
        elif not each.is_offset:
            shared[each.path] = values[each.name]
    means = {path: between_sessions(estimate, names) for path, names in sessions.items()}
    return ScenarioFit(
        estimate=estimate,
        unknowns=prediction.unknowns,
        scenario=prediction.prepared[0].scenario(shared | {path: each.mean for path, each in means.items()}),
        sessions=means,
        residuals=residuals,
        determined=states | dict.fromkeys(traded, "not") | dict.fromkeys(estimate.on_bound, "bound"),
        traded=traded,
        bias=bias,
        undetermined=judged.undetermined,
        problem=problem,
        rounding=rounding,
        misfit=misfit,
    )


def _whole(covariance: Real, names: Sequence[str], rows: Sequence[int], traded: Collection[str]) -> Real:
    """Return the covariance of all unknowns: 0 of those on a bound, infinite of those that trade with one."""
    found = np.zeros((len(names), len(names)))
    found[np.ix_(rows, rows)] = covariance
    for at in map(names.index, traded):
        found[at, :] = found[:, at] = np.nan
        found[at, at] = np.inf
    return found


def _traded(slopes: Real, names: Sequence[str], on_bound: Mapping[str, str]) -> dict[str, str]:
    """Return the unknowns that trade with one on its bound, each with that one."""
    return {
        name: other
        for at, name in enumerate(names)
        for other in on_bound
        if name not in on_bound and trades(slopes, at, names.index(other))
    }


def _roughly(
    few: Prediction | None, whole: Prediction, progress: Callback | None
) -> dict[str, FreeParameter]:
    """Search with few samples of long recordings, and return where the search with all of them begins."""
    if few is None:
        return whole.free
    noise = [first_noise(each) for group in few.columns for each in group]
    try:
        found = WeightedProblem(few, noise, progress).minimum(whole.free, known=True, converged=_ROUGH)
    except CancelledError:
        raise
    except ElectrovibError:
        return whole.free
    return {name: each.starting_at(found.values[name]) for name, each in whole.free.items()}


def _thinned(trace: xarray.Dataset) -> xarray.Dataset:
    steps = {name: size // _FEW for name, size in trace.sizes.items() if name in {"time", "frequency"}}
    wide = {name: slice(None, None, step) for name, step in steps.items() if step > 1}
    return trace.isel(wide) if wide else trace


BIASED: Final = 0.05
"""Bias over standard deviation above which a parameter does not count as well determined."""


def curvature_bias(
    problem: WeightedProblem, values: Mapping[str, float], names: Sequence[str], covariance: Real
) -> dict[str, float]:
    """Compute the bias over standard deviation of estimates from the curvature of the predictions.

    To second order the bias is the solution b of J b = -d/2 by least squares, with J the derivatives and d
    the sum of the second differences of the predictions along the columns of the Cholesky factor of the
    covariance (Box 1971). It is infinite where the models refuse values one standard deviation away. A
    representative part of the samples suffices.
    """
    deviations = np.sqrt(np.diag(covariance))
    scaled = covariance / np.outer(deviations, deviations)
    try:
        factor = np.linalg.cholesky(scaled) * deviations[:, None]
        base = problem.prediction(values)
        second = np.zeros(base.size)
        for column in factor.T:
            for side in (1, -1):
                moved = {name: values[name] + side * each for name, each in zip(names, column, strict=True)}
                second += problem.prediction(dict(values) | moved) - base
    except (ElectrovibError, np.linalg.LinAlgError):
        return dict.fromkeys(names, math.inf)
    slopes = problem.derivatives(values, names=names) * deviations
    found, *_ = np.linalg.lstsq(slopes, -0.5 * second * problem.weights)
    return {name: float(each) for name, each in zip(names, found, strict=True)}


LONG_ENOUGH: Final = 50.0
"""Steps over autocorrelation time from which the estimate of that time can be trusted (Foreman-Mackey et al. 2013)."""
ACCEPTED: Final = (0.2, 0.8)
"""Share of accepted proposals outside which a chain does not explore the distribution."""
_WIDEST: Final = 1e6
_START: Final = 0.5


@dataclass(frozen=True, kw_only=True)
class Posterior:
    """Samples of the posterior distribution of the parameters.

    - `samples`: values in SI, shape (n,), after burn-in and thinned by half the autocorrelation time.
    - `chains`, `log_density`: values in SI, and logarithm of the posterior density up to a constant, along
      each whole chain, shape (steps, walkers), burn-in included.
    - `autocorrelation_time`: integrated, in steps.
    - `problems`: why the samples may not represent the distribution; empty where the diagnostics raise no
      objection.
    """

    samples: Mapping[str, Real]
    chains: Mapping[str, Real]
    log_density: Real
    burn_in: int
    autocorrelation_time: Mapping[str, float]
    acceptance: float
    steps: int
    seed: int
    problems: tuple[str, ...]

    def interval(self, name: str, *, level: float = 0.95) -> tuple[float, float]:
        """Interval between the quantiles of the samples."""
        lower, upper = np.quantile(self.samples[name], [0.5 - level / 2, 0.5 + level / 2])
        return float(lower), float(upper)


FEWEST: Final = 20
"""Least length of a chain."""


@dataclass(frozen=True, kw_only=True)
class Sampling:
    """How a posterior distribution is sampled.

    Parameters
    ----------
    seed : int
        Of the random numbers, 0 or more; the same seed gives the same samples.
    steps : int
        Length of each chain, at least 20.
    walkers : int, optional
        Number of chains, even and at least twice the number of unknowns; by default four times that.
    progress : callable, optional
        Called with the steps done and all steps; sampling ends with an error when it returns True.
    """

    seed: int
    steps: int = 2000
    walkers: int | None = None
    progress: Callable[[int, int], bool | None] | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be sampled, before anything is computed."""
        if self.steps < FEWEST:
            raise InputError(f"steps = {self.steps}: expected at least {FEWEST}")
        if not 0 <= self.seed < 2**32:
            raise InputError(f"seed = {self.seed}: expected a whole number from 0 to {2**32 - 1}")


def sample_posterior(found: ScenarioFit, how: Sampling) -> Posterior:
    """Sample the posterior distribution of the unknowns of a fit, whose noise is taken as known.

    Gaussian likelihood. The prior is uniform between the bounds of a parameter; for a parameter that is
    searched by its logarithm it is uniform in the logarithm, within a factor of 1e6 of the estimate. Half of
    each chain is burn-in.
    """
    emcee = require_emcee()
    density = _Density(found)
    count = len(density.free)
    chains = 4 * count if how.walkers is None else how.walkers
    if chains < 2 * count or chains % 2:
        raise InputError(f"walkers = {chains}: expected an even number of at least {2 * count}")
    meter = Meter.of_cases(
        "this posterior",
        f"{how.steps:.6g} steps",
        how.steps,
        numbers=chains * (count + 1),
        remedy="take fewer steps (-n)",
    )
    sampler = emcee.EnsembleSampler(chains, count, density)
    legacy = np.random.RandomState(how.seed)  # emcee takes the state of no other generator
    begin = density.begin(np.random.default_rng(how.seed), chains)
    state = emcee.State(begin, random_state=legacy.get_state())
    for done, _ in enumerate(sampler.sample(state, iterations=how.steps), start=1):
        meter.count(done)
        if how.progress is not None and how.progress(done, how.steps):
            raise CancelledError("the sampling was cancelled")
    return _summary(sampler, density.free, how)


class _Density:
    """Logarithm of the posterior density in the coordinates of the search."""

    def __init__(self, found: ScenarioFit) -> None:
        self.problem, self.found = found.problem, found
        self.free: Mapping[str, FreeParameter] = found.problem.prediction.free
        self.variance = 1.0 if found.estimate.noise_is_known else found.estimate.variance
        if not self.variance > 0:
            raise InputError(
                "the recordings are those of the model to the last digit, without noise; state one: --noise"
            )
        self.best = np.array(
            [each.coordinate(found.estimate.values[name]) for name, each in self.free.items()]
        )
        wide = [math.log(_WIDEST) if each.logarithmic else math.inf for each in self.free.values()]
        bounds = np.array(
            [(each.coordinate(each.lower), each.coordinate(each.upper)) for each in self.free.values()]
        )
        self.low = np.maximum(bounds[:, 0], self.best - wide)
        self.high = np.minimum(bounds[:, 1], self.best + wide)

    def __call__(self, place: Real) -> float:
        """Logarithm of the density, up to a constant; minus infinity outside the bounds."""
        if (place < self.low).any() or (place > self.high).any():
            return -math.inf
        values = {
            name: each.value(float(at)) for (name, each), at in zip(self.free.items(), place, strict=True)
        }
        left = self.problem.residual(values)
        found = -0.5 * float(left @ left) / self.variance
        return found if math.isfinite(found) else -math.inf

    def begin(self, rng: np.random.Generator, chains: int) -> Real:
        """Starting points about the estimate, half a standard deviation away, within the bounds."""
        deviations = []
        for name, each in self.free.items():
            own = self.found.estimate.standard_deviations[name]
            value = self.found.estimate.values[name]
            scale = own / abs(value) if each.logarithmic and value else own
            deviations.append(min(scale, 1.0) if math.isfinite(scale) and scale > 0 else 0.1)
        points = self.best + _START * np.array(deviations) * rng.normal(size=(chains, self.best.size))
        return np.asarray(np.clip(points, self.low, self.high))


def _summary(sampler: Any, free: Mapping[str, FreeParameter], how: Sampling) -> Posterior:
    steps, half = how.steps, how.steps // 2
    times = sampler.get_autocorr_time(discard=half, tol=0)
    known = np.where(np.isfinite(times), times, float(steps))
    thin = max(int(known.max() / 2), 1)
    whole = sampler.get_chain()
    chains = {
        name: np.vectorize(each.value, otypes=[float])(whole[:, :, number])
        for number, (name, each) in enumerate(free.items())
    }
    acceptance = float(np.mean(sampler.acceptance_fraction))
    problems = []
    if steps - half < LONG_ENOUGH * known.max():
        problems.append(
            f"the chains are {(steps - half) / known.max():.0f} autocorrelation times long after burn-in, and"
            f" {LONG_ENOUGH:g} are needed: take {math.ceil(2 * LONG_ENOUGH * known.max())} steps"
        )
    if not ACCEPTED[0] <= acceptance <= ACCEPTED[1]:
        problems.append(
            f"{100 * acceptance:.0f} % of the proposals were accepted; {100 * ACCEPTED[0]:.0f} to {100 * ACCEPTED[1]:.0f} %"
            " are expected of chains that explore the distribution"
        )
    return Posterior(
        samples={name: each[half + thin - 1 :: thin].ravel() for name, each in chains.items()},
        chains=chains,
        log_density=np.asarray(sampler.get_log_prob()),
        burn_in=half,
        autocorrelation_time={name: float(each) for name, each in zip(free, known, strict=True)},
        acceptance=acceptance,
        steps=steps,
        seed=how.seed,
        problems=tuple(problems),
    )


require_emcee: Final = functools.partial(required, "emcee", "a posterior")


def chains_of(posterior: Posterior, units: Mapping[str, str]) -> xarray.Dataset:
    """Return the chains of a posterior distribution over ``parameter``, ``step`` and ``chain``, with their diagnostics."""
    import xarray

    names = list(posterior.chains)
    return xarray.Dataset(
        {
            "value": (("parameter", "step", "chain"), np.stack([posterior.chains[name] for name in names])),
            "log_density": (("step", "chain"), posterior.log_density),
            "autocorrelation_time": ("parameter", [posterior.autocorrelation_time[name] for name in names]),
        },
        coords={"parameter": names, "unit": ("parameter", [units[name] for name in names])},
        attrs={
            "title": "samples of a posterior distribution",
            "burn_in": posterior.burn_in,
            "acceptance": posterior.acceptance,
            "seed": posterior.seed,
            "problems": json.dumps(list(posterior.problems)),
        },
    )
