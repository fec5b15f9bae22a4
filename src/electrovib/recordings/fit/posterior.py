"""The posterior distribution of a fit, sampled by emcee, with diagnostics of convergence."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.fit.problem import CancelledError

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.least_squares import FreeParameter
    from electrovib.recordings.fit.result import ScenarioFit

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
    sampler = emcee.EnsembleSampler(chains, count, density)
    legacy = np.random.RandomState(how.seed)  # emcee takes the state of no other generator
    begin = density.begin(np.random.default_rng(how.seed), chains)
    state = emcee.State(begin, random_state=legacy.get_state())
    for done, _ in enumerate(sampler.sample(state, iterations=how.steps), start=1):
        if how.progress is not None and how.progress(done, how.steps):
            raise CancelledError("the sampling was cancelled")
    return _summary(sampler, density.free, how)


class _Density:
    """Logarithm of the posterior density in the coordinates of the search."""

    def __init__(self, found: ScenarioFit) -> None:
        self.problem, self.found = found.problem, found
        self.free: Mapping[str, FreeParameter] = found.problem.prediction.free
        self.variance = 1.0 if found.estimate.noise_is_known else found.estimate.variance
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


def require_emcee() -> Any:
    """Return emcee, or refuse with the line that installs it."""
    try:
        import emcee
    except ImportError:
        raise InputError("a posterior needs emcee: pip install 'electrovib[fit]'") from None
    return emcee


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
