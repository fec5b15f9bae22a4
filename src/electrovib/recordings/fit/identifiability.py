"""What the data of a fit determine: each parameter well, weakly or only combined with others."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real


WELL: Final = 0.1
"""Largest standard deviation of the logarithm of a parameter that counts as well determined. The bias that curvature gives an
estimate is of the order of this number times its standard deviation, and symmetric intervals hold up to there."""
NOT: Final = 1.0
"""Standard deviation of the logarithm from which on a parameter or a combination counts as not determined: a factor of e."""
_MEMBER: Final = 0.1
"""Smallest exponent, relative to the largest, with which a parameter counts as a member of a combination."""
_SLIGHT: Final = 0.01
"""The same where the data do not depend on the combination: nothing limits how far it moves each of its members."""
VANISHES: Final = 1e-6
"""Singular value over the largest one that cannot be told from the error of derivatives taken by differences."""

_INFLATED: Final = 10.0
"""Factor by which undetermined parameters increase the standard deviation of a zero that they leave undetermined."""
_TRADES: Final = 1.25
"""Factor by which a parameter on its bound, if it were free, would increase the standard deviation of one that trades with it."""


@dataclass(frozen=True, kw_only=True)
class UndeterminedCombination:
    """A product of powers of parameters that the data do not determine.

    The largest of the `exponents` is 1. `deviation` is the standard deviation of the logarithm of the
    product; infinite where the data do not depend on it.
    """

    exponents: Mapping[str, float]
    deviation: float

    @property
    def sentence(self) -> str:
        """Statement of what the data do not determine, and what they determine instead."""
        names = list(self.exponents)
        if len(names) == 1:
            return f"the data do not determine {names[0]}: {self._how}"
        product = " * ".join(_power(name, value) for name, value in self.exponents.items())
        words = f"the data do not determine {product}: {self._how}"
        if len(names) == 2:
            first, second = self.exponents.values()
            kept = {names[0]: abs(second), names[1]: -abs(first) * math.copysign(1, first * second)}
            largest = max(abs(value) for value in kept.values())
            kept = {name: value / largest for name, value in kept.items()}
            determined = " * ".join(_power(name, value) for name, value in kept.items())
            return f"{words}; of {names[0]} and {names[1]} they determine {determined} only"
        return f"{words}; fix one of {', '.join(names)} at a value known from elsewhere"

    @property
    def _how(self) -> str:
        if not math.isfinite(self.deviation) or self.deviation > 1e3:
            return "changing it at constant other combinations changes no prediction within the noise"
        return f"its logarithm has the standard deviation {self.deviation:.2g}, and {NOT:g} or more counts as not determined"


@dataclass(frozen=True, kw_only=True)
class Identifiability:
    """How well the data determine each parameter: ``"well"``, ``"weakly"`` or ``"not"``.

    `undetermined` begins with the worst combination. `covariance` is in the units of the parameters, with
    infinite variance and NaN covariances for those that are not determined.
    """

    states: Mapping[str, str]
    undetermined: tuple[UndeterminedCombination, ...]
    covariance: Real


def identifiability(
    derivatives: Real, values: Mapping[str, float], *, zeros: Sequence[str] = ()
) -> Identifiability:
    """Judge which parameters the data determine.

    `derivatives` (n, parameters) are those of the residuals over their standard deviation; `zeros` are
    parameters without a natural scale. With the derivatives J after the logarithms of the parameters, J = U S
    V', each column v of V is a combination sum(v_i ln p_i) with the standard deviation 1/s. A combination
    with 1/s above 1 is not determined. A parameter is not determined if it is a member of such a combination;
    else it is well determined if the standard deviation of its logarithm is at most 0.1, and weakly
    determined otherwise. A parameter estimated as 0 has no logarithm and is judged by the standard deviation
    alone. A zero is not determined where the parameters that are not determined make its standard deviation
    more than ten times larger than if they were known.
    """
    names = list(values)
    judged = [at for at, name in enumerate(names) if name not in zeros]
    other = [at for at in range(len(names)) if at not in judged]
    scale = np.array([abs(values[name]) or 1.0 for name in names])
    sloped = np.asarray(derivatives, dtype=float) * scale
    basis = np.linalg.qr(sloped[:, other])[0] if other else np.zeros((len(sloped), 0))
    own = sloped[:, judged] - basis @ (basis.T @ sloped[:, judged])
    _, singular, rows = np.linalg.svd(own, full_matrices=False)
    deviations = [
        math.inf if each <= VANISHES * singular[0] or each == 0 else 1 / float(each) for each in singular
    ]
    bad = [at for at, deviation in enumerate(deviations) if deviation > NOT]
    found = [_combination([names[j] for j in judged], rows[at], deviations[at]) for at in reversed(bad)]
    lost = {name for each in found for name in each.exponents}
    lost |= {names[at] for at in other if _is_lost(sloped, at, [names.index(name) for name in lost])}
    kept = [at for at in range(len(names)) if names[at] not in lost]
    covariance = np.full((len(names), len(names)), np.nan)
    if kept:
        moved = response(sloped)[kept] * scale[kept, None]
        covariance[np.ix_(kept, kept)] = moved @ moved.T
    for at, name in enumerate(names):
        if name in lost:
            covariance[at, at] = math.inf
    return Identifiability(
        states={
            name: "not"
            if name in lost
            else "well"
            if name in zeros or math.sqrt(covariance[at, at]) <= WELL * scale[at]
            else "weakly"
            for at, name in enumerate(names)
        },
        undetermined=tuple(found),
        covariance=covariance,
    )


def trades(derivatives: Real, at: int, bound: int) -> bool:
    """State whether a parameter would have a standard deviation more than a quarter larger if one on its bound were free."""
    norms = np.linalg.norm(derivatives, axis=0)
    return bool(norms[bound]) and _is_lost(
        derivatives / np.where(norms, norms, 1.0), at, [bound], factor=_TRADES
    )


def _is_lost(sloped: Real, at: int, lost: Sequence[int], *, factor: float = _INFLATED) -> bool:
    """Return whether some parameters would increase the standard deviation of another by more than a factor."""
    own, others = sloped[:, at], [each for each in range(sloped.shape[1]) if each != at]
    known = [each for each in others if each not in lost]
    alone, beside = (
        np.linalg.norm(own - sloped[:, each] @ np.linalg.lstsq(sloped[:, each], own, rcond=VANISHES)[0])
        for each in (known, others)
    )
    return bool(beside * factor < alone)


def response(derivatives: Real) -> Real:
    """Return the change of estimates, shape (unknowns, n), by that of weighted data: (J'J)^-1 J', without what has no effect."""
    scale = np.linalg.norm(derivatives, axis=0)
    scale[scale == 0] = 1.0
    return np.asarray(np.linalg.pinv(derivatives / scale, rcond=VANISHES) / scale[:, None])


def _combination(names: Sequence[str], row: Real, deviation: float) -> UndeterminedCombination:
    largest = int(np.argmax(np.abs(row)))
    exponents = row / row[largest]
    least = _MEMBER if math.isfinite(deviation) else _SLIGHT
    return UndeterminedCombination(
        exponents={
            name: float(value) for name, value in zip(names, exponents, strict=True) if abs(value) >= least
        },
        deviation=deviation,
    )


def _power(name: str, exponent: float) -> str:
    rounded = round(exponent, 1) or float(f"{exponent:.1g}")
    return name if rounded == 1 else f"{name}^{rounded:g}"


STEPS: Final = 50
"""Successive accepted steps whose common gain is judged; searches that converge take fewer."""
GAIN: Final = 0.01
"""Decrease of the sum of squares over these steps, in variances of a residual, below which it is none: the estimate that the
search would reach is no more likely than the present one by a factor of exp(0.005)."""


@dataclass
class Stall:
    """Judgement, at each accepted step of a search, whether further steps can change the result.

    `variance` is that of the weighted residuals; None takes their scatter at the present step.
    """

    variance: float | None
    zeros: Sequence[str] = ()
    _squares: list[float] = field(default_factory=list, init=False)

    def is_reached(self, values: Mapping[str, float], residual: Real, derivatives: Real) -> bool:
        """Record an accepted step, and state whether the search has stalled there.

        It has where the last steps together have decreased the sum of squares by less than `GAIN` variances
        while a combination of the unknowns is not determined.
        """
        squares = float(residual @ residual)
        self._squares.append(squares)
        variance = squares / max(residual.size - len(values), 1) if self.variance is None else self.variance
        if len(self._squares) <= STEPS or not np.isfinite(derivatives).all():
            return False
        if not 0 <= self._squares[-1 - STEPS] - squares < GAIN * variance:
            return False
        return bool(identifiability(derivatives / np.sqrt(variance), values, zeros=self.zeros).undetermined)
