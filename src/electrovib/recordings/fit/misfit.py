"""Whether a fit describes its data: what of the residuals noise does not explain, where, and by how much."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.paths import quantity_at
from electrovib.recordings.fit.components import STATED, Components, Sign
from electrovib.recordings.fit.sessions import BetweenSessions, spread_of

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.prediction import Prediction
    from electrovib.recordings.fit.problem import WeightedProblem
    from electrovib.recordings.fit.residuals import Residuals

LEVEL: Final = 0.003
"""Probability that noise makes residuals of the right model count as a misfit, over all tests of a fit."""
MISFIT: Final = "misfit"
"""State of every parameter of a model that does not describe the recordings."""
_MOST: Final = 3
"""Reasons that are told."""
_VANISHES: Final = 1e-6


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """What of the residuals of a fit noise does not explain.

    - `reasons`: why the model does not describe the recordings, the clearest first; empty where it does.
    - `inflation`: variances of the estimates over those by independent noise, 1 or more.
    - `independent`: number of independent residuals to which the slow components of all residuals correspond.
    - `computed`: whether all residuals are those of rounding, so that the data were computed by this model.
    - `between`: how parameters differ between recordings by more than noise explains.
    """

    reasons: tuple[str, ...]
    inflation: float
    independent: float
    computed: bool
    between: Mapping[str, BetweenSessions]
    recordings: int

    @property
    def verdict(self) -> str:
        """State that the model does not describe the recordings; empty where it does."""
        return f"the model does not describe {self._these}" if self.reasons else ""

    @property
    def sentence(self) -> str:
        """State what the residuals show; empty where nothing is to be said."""
        if self.reasons:
            more = f"; and {len(self.reasons) - _MOST} more" if len(self.reasons) > _MOST else ""
            return f"{self.verdict}: {'; '.join(self.reasons[:_MOST])}{more}"
        if self.computed:
            return (
                "these data were computed by this model: what is left is rounding, and the intervals describe no"
                " measurement"
            )
        if self.inflation > 1:
            return (
                f"successive residuals are correlated and count as {self.independent:.2g} independent ones; the intervals include"
                " that"
            )
        return ""

    @property
    def _these(self) -> str:
        return "these recordings" if self.recordings > 1 else "this recording"


def misfit_of(
    problem: WeightedProblem, values: Mapping[str, float], residuals: Sequence[Residuals]
) -> Misfit:
    """Test whether the residuals of a fit are noise; the right model has a reason against it in about 3 of 1000 fits.

    The residuals of each signal are decomposed by a discrete cosine transform in the order of its samples.
    Noise, also where it is correlated over up to about a hundredth of the record, gives neighbouring
    components the same variance. Tested are the slowest 8 components against the following 24 (F), each
    component against the median of its neighbours, which a misfit under a repeating drive exceeds, the means
    of short spans, which one beside an edge exceeds, and where the noise is stated the sum of squares and
    that of the slow components (chi-squared, for a noise up to 5 % above the stated one). Several recordings
    are tested for parameters that differ between them by the sum of squares that parameters of their own
    would remove (F). The degrees of freedom are less those that the estimates take. Of a signal that is
    rounded more coarsely than its noise only what exceeds half a step counts.
    """
    slopes = problem.derivatives(values)
    parts = _parts(slopes, residuals)
    recordings = len(problem.prediction.measured)
    if all(each.is_computed for each in parts):
        return Misfit(
            reasons=(), inflation=1.0, independent=math.inf, computed=True, between={}, recordings=recordings
        )
    real = [each for each in parts if not each.is_computed]
    between, scatter = _between(problem, values, slopes, parts)
    tests = [sign for each in real for sign in each.signs()] + scatter
    signs = significant(tests)
    inflation = max([*(each.ratio for each in signs), *(each.correlated for each in real)])
    first = {each.subject: each for each in reversed(signs)}
    return Misfit(
        reasons=tuple(f"{each.subject}: {each.reason}" for each in signs if each is first[each.subject]),
        inflation=max(inflation, 1.0),
        independent=sum(each.residual.size for each in real) / max(inflation, 1.0),
        computed=False,
        between=between if any(each in signs for each in scatter) else {},
        recordings=recordings,
    )


def significant(tests: Sequence[Sign]) -> list[Sign]:
    """Return what noise does not explain, the clearest first: all tests together find something in noise at `LEVEL`."""
    total = sum(each.weight for each in tests)
    found = [each for each in tests if each.chance / each.weight * total < LEVEL]
    return sorted(found, key=lambda each: each.chance)


def _basis(columns: Real) -> Real:
    """Return an orthonormal basis of what some columns span, shape (n, rank)."""
    scale = np.linalg.norm(columns, axis=0)
    used = columns[:, scale > 0] / scale[scale > 0]
    if not used.size:
        return np.zeros((len(columns), 0))
    left, singular, _ = np.linalg.svd(used, full_matrices=False)
    return np.asarray(left[:, singular > _VANISHES * singular[0]])


def _parts(slopes: Real, residuals: Sequence[Residuals]) -> list[Components]:
    basis, at, found = _basis(slopes), 0, []
    for each in residuals:
        size = each.observed.x.size * each.observed.parts
        found.append(Components(of=each, sloped=basis[at : at + size]))
        at += size
    return found


def _between(
    problem: WeightedProblem, values: Mapping[str, float], slopes: Real, parts: Sequence[Components]
) -> tuple[dict[str, BetweenSessions], list[Sign]]:
    """Test whether parameters differ between recordings, by the values of each recording alone to first order."""
    from scipy.stats import f as fisher

    prediction = problem.prediction
    left = np.concatenate([each.residual.ravel() for each in parts])
    ends = np.cumsum([sum(each.x.size * each.parts for each in group) for group in prediction.columns])
    own = list(zip(np.split(slopes, ends[:-1]), np.split(left, ends[:-1]), strict=True))
    removed = [_basis(sloped) for sloped, _ in own]
    joint = _basis(slopes)
    more = sum(each.shape[1] for each in removed) - joint.shape[1]
    free = left.size - more - joint.shape[1]
    explained = sum(float(np.sum((each.T @ rest) ** 2)) for each, (_, rest) in zip(removed, own, strict=True))
    unexplained = float(left @ left) - explained
    if more < 1 or free < 3 or unexplained <= 0:
        return {}, []
    noise = unexplained / free * max(each.correlated for each in parts)
    if all(each.of.observed.noise is not None for each in parts):
        noise = max(noise, STATED)
    ratio = (explained - float(np.sum((joint.T @ left) ** 2))) / more / noise
    spreads = _spreads(prediction, values, [_step(*each) for each in own], noise)
    chance = float(fisher.sf(ratio, more, free))
    why = "values of their own for each recording would remove more of the residuals than noise explains"
    if not spreads:
        return {}, [Sign(chance=chance, ratio=ratio, subject="free parameters", reason=why)]
    worst = max(spreads, key=lambda name: spreads[name].between / spreads[name].within)
    unit = quantity_at(prediction.prepared[0].base, worst).unit
    words = f"{spreads[worst].in_words(unit)}; let it vary between them"
    return spreads, [Sign(chance=chance, ratio=ratio, subject=worst, reason=words)]


def _step(sloped: Real, left: Real) -> tuple[Real, Real]:
    """Return by how much the unknowns of one recording alone differ, and their standard deviations for noise of variance 1."""
    scale = np.linalg.norm(sloped, axis=0)
    scale[scale == 0] = np.inf
    _, singular, rows = np.linalg.svd(sloped / scale, full_matrices=False)
    lost = singular <= _VANISHES * max(singular[0], 1e-300)
    inverse = np.linalg.pinv(sloped / scale, rcond=_VANISHES)
    deviation = np.linalg.norm(inverse, axis=1) / scale
    open_ones = np.isinf(scale) | (np.sum(rows[lost] ** 2, axis=0) > _VANISHES)
    return inverse @ left / scale, np.where(open_ones, np.inf, deviation)


def _spreads(
    prediction: Prediction, values: Mapping[str, float], steps: Sequence[tuple[Real, Real]], noise: float
) -> dict[str, BetweenSessions]:
    """Summarise how parameters that at least two recordings determine differ between them."""
    found = {}
    for at, unknown in enumerate(prediction.unknowns):
        value = values[unknown.name]
        own = {
            measured.name: (value + float(step[at]), float(deviation[at]) * math.sqrt(noise))
            for measured, (step, deviation) in zip(prediction.measured, steps, strict=True)
            if deviation[at] * math.sqrt(noise) < abs(value)
        }
        if len(own) > 1 and not unknown.is_offset and not unknown.session:
            found[unknown.path] = spread_of(
                {name: each for name, (each, _) in own.items()},
                [deviation for _, deviation in own.values()],
                group="recording",
            )
    return found
