"""Which model made the recordings: force laws with and without gap and leak, their evidence, and how probable each is."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import one_thread
from electrovib.core.discovery import find_members
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.mistakes import near_members
from electrovib.core.paths import quantity_at, value_at
from electrovib.physics.force import ForceLaw
from electrovib.physics.stack import roles_of
from electrovib.recordings.fit.least_squares import FreeParameter, required
from electrovib.recordings.fit.problem import least_noise

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.prediction import Unknown
    from electrovib.recordings.fit.result import ScenarioFit
    from electrovib.scenario import Scenario

ALL: Final = "all"
"""Stands for every force law."""
REACH: Final = 100.0
"""Factor from the value of the scenario up to which the prior of a parameter reaches."""
CLOSE: Final = 150.0
"""Odds of the most probable candidate up to which the evidence of another one is sampled."""
LIKELY: Final = 0.05
"""Probability above which a recording does not rule a candidate out."""
CLEAR: Final = 10.0
"""Difference of AICc from which on the worse model has essentially no support (Burnham and Anderson 2002)."""
_SOME: Final = 2.0
PRIOR: Final = (
    f"Prior of a parameter: uniform, of its logarithm where its range has decades, within the declared bounds and a factor of"
    f" {REACH:g} from the value of the scenario, the same for all models. Each law is as probable as another one before the"
    " recording, and its variants share that. The errors of nested sampling are standard errors."
)
LIVE: Final = 200
"""Live points of nested sampling: its error is sqrt(information/points), near 0.2 in ln evidence."""
_ENDS: Final = 0.05
"""Part of ln evidence that is left when nested sampling ends."""
_MANY: Final = 5
"""Unknowns from which on points are drawn by random walks, not from the ellipsoid of the live ones."""
_FLAT: Final = 10.0
"""Standard deviation over the width of the prior of a combination on which the data do not depend."""
_NEVER: Final = -1e300


@dataclass(frozen=True, kw_only=True)
class LawCase:
    """A set-up with one force law, `scenario`, whose conductivities `zero` were set to 0; the variants of a `law` are alike."""

    law: str
    scenario: Scenario
    zero: tuple[str, ...] = ()


def cases_of(
    scenario: Scenario, laws: str | Sequence[str] | None
) -> tuple[dict[str, LawCase], dict[str, str]]:
    """Return the set-up with each law, and without gap and leaks where it has them, by name, and why others cannot be.

    There are none where none are asked for. The law of the scenario comes first. A law replaces the layers that
    it stands for. Leaks are those of the plate and the gap; the skin keeps its conductivity.
    """
    if laws is None:
        return {}, {}
    _require_dynesty()
    known, own = find_members(ForceLaw), type(scenario.force).__name__
    asked = list(known) if laws == ALL else [laws] if isinstance(laws, str) else list(laws)
    asked = [each for name in asked for each in (known if name == ALL else [name])]
    wrong = [
        f"laws: '{name}' is not a force law.{near_members(ForceLaw, name)}"
        for name in asked
        if name not in known
    ]
    if wrong or not asked:
        raise InputError(wrong or f"laws: names no force law. Known: {', '.join(sorted(known))}.")
    found: dict[str, LawCase] = {}
    refused: dict[str, str] = {}
    for law in dict.fromkeys([own, *asked]):
        made: list[Scenario] = []
        for words, changes in _variants(scenario, getattr(known[law], "replaces", ())).items():
            force = {} if law == own else {"force": {"model": law}}
            try:
                case = scenario.replace(changes | force) if changes or force else scenario
            except ElectrovibError as error:
                why = "; ".join(error.problems)
                refused |= {law + words: why} if refused.get(law) != why else {}
                continue
            if case not in made:
                made.append(case)
                zero = tuple(path for path, value in changes.items() if value == 0.0)
                found[law + words] = LawCase(law=law, scenario=case, zero=zero)
    return found, refused


def _variants(scenario: Scenario, replaced: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return words and changes of the set-up: less the layers that a law replaces, also without gap, and without leak."""
    layers = scenario.stack.layers
    roles = roles_of(layers)

    def less(left_out: Sequence[str]) -> dict[str, Any]:
        kept = {name: layer for name, layer in layers.items() if name not in left_out}
        return {"stack": kept} if len(kept) < len(layers) else {}

    leaks: dict[str, Any] = {}
    for name, layer in layers.items():
        if roles[name] != "finger" and name not in replaced:
            leaks |= {f"stack.{name}.material.conductivity": 0.0} if layer.material.conductivity else {}
            leaks |= {f"stack.{name}.leak": None} if layer.leak is not None else {}
    gaps = [name for name, role in roles.items() if role == "gap"]
    found = {"": less(replaced)}
    if gaps:
        found[" without gap"] = less([*replaced, *gaps])
    if leaks:
        found[" without leak"] = less(replaced) | leaks
    return found


@dataclass(frozen=True, kw_only=True)
class MarginalLikelihood:
    """Logarithm of the likelihood averaged over the prior, up to a constant of the data, and its standard error.

    `method` is ``"Laplace"`` or ``"nested sampling"``. `peak` is the logarithm of the largest likelihood, which
    no evidence exceeds;
    `holds` is false where Laplace's approximation may be off, because the data do not determine a parameter
    or its estimate is not within the prior.
    """

    log: float
    peak: float
    method: str = "Laplace"
    error: float = 0.0
    holds: bool = True


class Likelihood:
    """Logarithm of the likelihood of a fit over the unit cube, which the prior of its unknowns fills evenly.

    The prior is uniform in the coordinates of the search, within `REACH` of the values of a `reference` and
    the declared bounds; that of a zero reaches up to the largest recorded value. Noise that is not stated is
    integrated out with the prior 1/noise: n data of a signal give -n/2 times the logarithm of their sum of
    squares.
    """

    def __init__(self, found: ScenarioFit, reference: Scenario) -> None:
        self.found, self.problem = found, found.problem
        self.parameters = {each.name: _prior(found, each, reference) for each in found.unknowns}
        ends = [
            [each.coordinate(each.lower), each.coordinate(each.upper)] for each in self.parameters.values()
        ]
        self.low, self.high = np.array(ends).T
        best = [each.coordinate(found.estimate.values[name]) for name, each in self.parameters.items()]
        self.best: Real = (np.array(best) - self.low) / (self.high - self.low)
        weights, self.constant = self.problem.weights, 0.0
        self.pieces: list[tuple[slice, float | None, float]] = []
        for (_, _, column, rows), noise in zip(
            self.problem.prediction.pieces(), self.problem.noise, strict=True
        ):
            is_stated = column.noise is not None
            self.constant += float(np.sum(np.log(weights[rows] * (1.0 if is_stated else noise))))
            least = column.size * least_noise(column) ** 2
            self.pieces.append((rows, None if is_stated else noise, least))

    @property
    def beyond(self) -> str:
        """State which estimates are beyond their prior; empty where none is."""
        off = np.abs(self.best - 0.5) > 0.5 + 1e-9
        names = [name for name, is_beyond in zip(self.parameters, off, strict=True) if is_beyond]
        return f"the estimate of {', '.join(names)} is beyond the prior" if names else ""

    def values(self, place: Real) -> dict[str, float]:
        """Return the values of the unknowns, in their units, at a place of the unit cube."""
        at = self.low + place * (self.high - self.low)
        return {
            name: each.value(float(one))
            for (name, each), one in zip(self.parameters.items(), at, strict=True)
        }

    def __call__(self, place: Real) -> float:
        """Logarithm of the likelihood, up to a constant of the data; very low where the models refuse the values."""
        return self._of(self.problem.residual(self.values(place)))

    def _of(self, left: Real) -> float:
        total = self.constant
        for rows, noise, least in self.pieces:
            squares = float(left[rows] @ left[rows])
            half = 0.5 if noise is None else 0.5 * left[rows].size
            total -= half * (squares if noise is None else math.log(max(squares * noise**2, least)))
        return total if math.isfinite(total) else _NEVER

    def alike(self) -> tuple[Any, ...]:
        """Return what equal functions have in common: the names of the unknowns, and the likelihood at three places."""
        places = np.random.default_rng(0).random((3, self.low.size))
        return tuple(self.parameters), *(f"{self(place):.9g}" for place in places)

    def laplace(self) -> MarginalLikelihood:
        """Integrate the quadratic function that has value, slope and curvature of the logarithm at the estimate.

        The curvature is that of Gauss and Newton. The integral is over the unit cube alone.
        """
        from scipy.stats import multivariate_normal

        width, inside = self.high - self.low, np.clip(self.best, 0, 1)
        values = self.values(inside)
        scale = [values[name] if each.logarithmic else 1.0 for name, each in self.parameters.items()]
        slopes, left = self.problem.derivatives(values) * scale * width, self.problem.residual(values)
        top, peak = self._of(left), self._of(self.problem.residual(self.found.estimate.values))
        if not (np.isfinite(slopes).all() and top > _NEVER):
            return MarginalLikelihood(log=-math.inf, peak=peak, holds=False)
        factors = np.ones(left.size)
        for rows, noise, least in self.pieces:
            if noise is not None:
                factors[rows] = left[rows].size / max(float(left[rows] @ left[rows]), least / noise**2)
        curvature = (slopes.T * factors) @ slopes + np.eye(width.size) / _FLAT**2
        covariance = np.linalg.inv(curvature)
        slope = -(slopes.T * factors) @ left
        centre = inside + covariance @ slope
        share = multivariate_normal(centre, covariance, allow_singular=True, seed=0)
        share.abseps, share.releps = 1e-9, 1e-4
        within = float(share.cdf(np.ones(width.size), lower_limit=np.zeros(width.size)))
        volume = 0.5 * (width.size * math.log(2 * math.pi) - float(np.linalg.slogdet(curvature)[1]))
        height = top + 0.5 * float(slope @ covariance @ slope)
        log = height + volume + (math.log(within) if within > 0 else -math.inf)
        holds = not self.beyond and "not" not in self.found.determined.values() and math.isfinite(log)
        return MarginalLikelihood(log=log, peak=peak, holds=holds)

    def sampled(self, *, seed: int, live: int = LIVE) -> MarginalLikelihood:
        """Average the likelihood over the prior by nested sampling, with its standard error."""
        sampler = _require_dynesty().NestedSampler(
            self, lambda place: place, self.low.size, nlive=live, rstate=np.random.default_rng(seed), bound="multi",
            sample="unif" if self.low.size < _MANY else "rwalk", first_update={"min_eff": 50.0, "min_ncall": live},
        )  # fmt: skip
        sampler.run_nested(dlogz=_ENDS, print_progress=False)
        found = sampler.results
        return MarginalLikelihood(
            log=float(found["logz"][-1]),
            error=float(found["logzerr"][-1]),
            peak=float(np.max(found["logl"])),
            method="nested sampling",
        )


_require_dynesty: Final = functools.partial(required, "dynesty", "the evidence of laws")


def _prior(found: ScenarioFit, unknown: Unknown, reference: Scenario) -> FreeParameter:
    """Return an unknown between the ends of its prior, which are the same for every candidate."""
    prediction = found.problem.prediction
    if unknown.is_offset:
        largest = float(np.max(np.abs(prediction.columns[unknown.record][unknown.column].y)))
        return FreeParameter(start=0.0, lower=-largest, upper=largest)
    own, declared = prediction.free[unknown.name], quantity_at(reference, unknown.path)
    value = float(value_at(reference, unknown.path) or own.start)
    low, high = declared.low, declared.high
    if value:
        low = max(low, value / REACH if low >= 0 else -abs(value) * REACH)
        high = min(high, abs(value) * REACH)
    return replace(own, start=min(max(value, low), high), lower=low, upper=high)


@dataclass(frozen=True, kw_only=True)
class ComparedFit:
    """One of the models that are compared; `aicc` and `bic` are above those of the best.

    `against` is the clearest of what the residuals show; `evidence` is None, and `probability` NaN, where they were not asked
    for.
    """

    name: str
    aicc: float
    bic: float
    against: str
    evidence: MarginalLikelihood | None = None
    probability: float = math.nan


@dataclass(frozen=True, kw_only=True)
class FitComparison:
    """Models fitted to the same data, the most probable or that of the lowest AICc first, and why others are not `refused`."""

    candidates: tuple[ComparedFit, ...]
    sentence: str
    refused: Mapping[str, str] = field(default_factory=dict)

    @property
    def is_weighed(self) -> bool:
        """Whether the candidates have a probability."""
        return self.candidates[0].evidence is not None


def compare_fits(fits: Mapping[str, ScenarioFit]) -> FitComparison:
    """Compare models that were fitted to the same data.

    A difference of AICc below 2 does not distinguish two models, one above 10 leaves the worse one without
    support (Burnham and Anderson 2002). The criteria compare models with each other; none of them may be
    adequate.
    """
    sizes = {name: each.estimate.count for name, each in fits.items()}
    if len(set(sizes.values())) > 1:
        sizes_listed = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(
            f"models are compared on the same data, but these were fitted to different numbers: {sizes_listed}"
        )
    names = sorted(fits, key=lambda name: (fits[name].aicc, name))
    best = fits[names[0]]
    found = tuple(
        ComparedFit(
            name=name,
            aicc=fits[name].aicc - best.aicc if math.isfinite(best.aicc) else math.nan,
            bic=fits[name].bic - best.bic,
            against="".join(fits[name].misfit.reasons[:1]),
        )
        for name in names
    )
    return FitComparison(candidates=found, sentence=_by_criteria(found))


@one_thread(with_scipy=True)
def weigh(
    fits: Mapping[str, ScenarioFit],
    laws: Mapping[str, str],
    reference: Scenario,
    *,
    seed: int = 0,
    live: int = LIVE,
    refused: Mapping[str, str] | None = None,
) -> FitComparison:
    """Weigh models that were fitted to the same data by their evidence; `laws` has the law of each by its name.

    Every law is as probable as another one before the recording, and its variants share that. The evidence is
    Laplace's, and of those within the odds `CLOSE` of the best one, if they are several, that of nested
    sampling.
    """
    compared = compare_fits(fits)
    likelihoods = {name: Likelihood(each, reference) for name, each in fits.items()}
    evidence = {name: each.laplace() for name, each in likelihoods.items()}
    best = max((each.log for each in evidence.values() if each.holds), default=-math.inf)
    close = [
        name
        for name, each in evidence.items()
        if (each.log if each.holds else each.peak) > best - math.log(CLOSE)
    ]
    sampled: dict[tuple[Any, ...], MarginalLikelihood] = {}
    for name in close if len(close) > 1 else ():
        key = likelihoods[name].alike()
        if key not in sampled:
            sampled[key] = likelihoods[name].sampled(seed=seed, live=live)
        evidence[name] = sampled[key]
    odds = probabilities({name: each.log for name, each in evidence.items()}, laws)
    top = max(fits, key=lambda name: evidence[name].peak)
    found = [
        replace(
            each,
            evidence=evidence[each.name],
            probability=odds[each.name],
            against=each.against
            or likelihoods[each.name].beyond
            or _less_likely(evidence[top].peak - evidence[each.name].peak, top),
        )
        for each in compared.candidates
    ]
    found.sort(key=lambda each: (-each.probability, each.name))
    return FitComparison(candidates=tuple(found), sentence=_by_odds(found, fits), refused=refused or {})


def probabilities(evidence: Mapping[str, float], laws: Mapping[str, str]) -> dict[str, float]:
    """Return how probable each candidate is, by ln evidence, with the same share for each law before the recording."""
    counts = [*laws.values()]
    logs = {name: log - math.log(counts.count(laws[name])) for name, log in evidence.items()}
    largest = max(logs.values())
    parts = {name: math.exp(log - largest) if log > -math.inf else 0.0 for name, log in logs.items()}
    total = math.fsum(parts.values())
    return {name: part / total for name, part in parts.items()}


def _less_likely(log: float, top: str) -> str:
    """State by how much the largest likelihood is below that of the candidate `top`."""
    return f"its best fit is {_times(log)} times less likely than that of {top}" if log > 1 else ""


def _times(log: float) -> str:
    return f"{math.exp(log):.3g}" if log < math.log(1e6) else "more than a million"


def _by_odds(found: Sequence[ComparedFit], fits: Mapping[str, ScenarioFit]) -> str:
    these = next(iter(fits.values())).misfit.recordings
    this = "these recordings" if these > 1 else "this recording"
    likely = [each.name for each in found if each.probability > LIKELY]
    if len(likely) > 1:
        text = f"cannot be told apart by {this}: {', '.join(likely)}"
    elif len(found) == 1:
        text = f"{found[0].name} is the only one that could be fitted"
    else:
        odds = math.log(found[0].probability) - math.log(max(found[1].probability, 1e-300))
        text = f"{found[0].name} is {_times(odds)} times as probable as the next, {found[1].name}"
    if all(each.misfit.reasons for each in fits.values()):
        return f"no law describes {this}; of those that do not, {text}"
    return text


def _by_criteria(found: Sequence[ComparedFit]) -> str:
    if len(found) == 1:
        return ""
    first, second, apart = found[0].name, found[1].name, found[1].aicc
    if not math.isfinite(apart):
        return f"there are too few data to compare {first} with {second} by AICc"
    if apart < _SOME:
        text = f"the data do not distinguish {first} from {second} (AICc differs by {apart:.2g})"
    elif apart < CLEAR:
        text = f"the data favour {first} over {second}, but not clearly (AICc lower by {apart:.2g})"
    else:
        text = f"the data support {first}; {second} has an AICc higher by {apart:.3g}, which leaves it no support"
    simplest = min(found, key=lambda each: each.bic)
    if simplest.bic < 0:
        text += f"; BIC prefers {simplest.name}, which has fewer parameters"
    return text
