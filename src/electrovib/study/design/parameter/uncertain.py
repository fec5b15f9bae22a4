"""How the value that was found depends on the other parameters: elasticities, and its distribution over a space."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.changes import stored_changes, stored_path
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.study.design.parameter.evaluation import Evaluation
from electrovib.study.design.parameter.roots import solutions
from electrovib.study.design.parameter.scale import coordinate, first_values
from electrovib.study.design.parameter.search import Function, explore
from electrovib.study.elasticity import Elasticity, slope

if TYPE_CHECKING:
    from electrovib.scenario import Scenario
    from electrovib.scenario.space import Space
    from electrovib.study.design.parameter.wanted import Wanted

PERCENTILES: Final = (5, 25, 50, 75, 95)
"""Percentiles of the distribution that are stated."""
EXACT: Final = 1e-7
"""Relative deviation of the quantity from the wanted value, up to which a draw counts as solved."""
_STEPS: Final = 25
"""Largest number of steps of the secant method for a draw."""
_LONGEST_STEP: Final = 2.0
"""Largest change of the logarithm of the free parameter in one step."""
_NO_INPUTS: Final = ("time", "frequency", "limits")
"""Parts of a scenario that are no inputs of the model."""


@dataclass(frozen=True)
class NeededValues:
    """Distribution of the value that is needed, over draws from a space.

    `values` has NaN where a draw has none in the range; `remarks` state what of the space is unverified or
    was not drawn.
    """

    title: str
    values: Real
    seed: int
    is_linear: bool
    remarks: tuple[str, ...]

    @property
    def unsolved(self) -> int:
        """Number of draws without a value."""
        return int(np.sum(~np.isfinite(self.values)))

    def to_dict(self) -> dict[str, Any]:
        """Return percentiles, draws and method as a table; a draw without a value is None."""
        return {
            "space": self.title,
            "method": "linear propagation from the medians" if self.is_linear else "each draw solved anew",
            "seed": self.seed,
            "percentiles": {
                str(each): value for each, value in self.percentiles().items() if math.isfinite(value)
            },
            "without_a_value": self.unsolved,
            "draws": [value if math.isfinite(value) else None for value in self.values.tolist()],
            "remarks": list(self.remarks),
        }

    def percentiles(self) -> dict[int, float]:
        """Return the percentiles of the draws that have a value, in the SI unit of the free parameter."""
        known = self.values[np.isfinite(self.values)]
        if not len(known):
            return dict.fromkeys(PERCENTILES, math.nan)
        return {each: float(np.percentile(known, each)) for each in PERCENTILES}


def inputs_of(scenario: Scenario, free: str) -> tuple[str, ...]:
    """Return the parameters other than the free one that an elasticity can be computed of: those that are not 0."""
    value = value_at(scenario, free)
    moved, _ = stored_changes(scenario, {free: 0.9 * value or 1.0})
    own = {*moved, stored_path(scenario, free)}
    return tuple(
        path
        for path, value, _ in scenario.parameters()
        if value and path not in own and path.partition(".")[0] not in _NO_INPUTS
    )


def influences(
    evaluation: Evaluation, at: Mapping[str, float], paths: tuple[str, ...]
) -> tuple[Elasticity, ...]:
    """Compute how the free parameter follows others, the largest first; empty where its own derivative is 0 or not known.

    With the quantity q(x, p), d ln x / d ln p = -(dq / d ln p) / (dq / d ln x).
    """
    free = evaluation.wanted.free
    own = slope(evaluation, at, free)
    scale = abs(evaluation.wanted.value)
    if not math.isfinite(own) or abs(own) <= 1e-9 * scale:
        return ()
    scenario = evaluation.prepared.base
    found = []
    for path in paths:
        by_other = slope(evaluation, at, path)
        if math.isfinite(by_other):
            unit = quantity_at(scenario, path).unit
            found.append(Elasticity(path=path, at=at[path], unit=unit, value=-by_other / own + 0.0))
    return tuple(sorted(found, key=lambda each: -abs(each.value)))


def propagated(
    scenario: Scenario,
    wanted: Wanted,
    space: Space,
    *,
    start: float,
    n: int,
    seed: int,
    linear: bool,
    report: Callable[[int, int], None],
) -> NeededValues:
    """Compute the value that is needed for each draw.

    With `linear` its logarithm is taken as linear in those of the parameters, from their medians.
    """
    paths = tuple(path for path in space.paths if path != wanted.free)
    remarks = list(space.remarks)
    if len(paths) < len(space.paths):
        remarks.append(f"{wanted.free} is not drawn: it is the parameter that is sought")
    drawn = space.draw(seed, 0, n)
    evaluation = Evaluation(scenario, wanted, (wanted.free, *paths))
    middle = space.values({stream: np.array([0.5]) for stream in space.streams})
    medians = {path: float(middle[path][0]) for path in paths}
    center = _solved(evaluation, wanted, medians, start)
    if math.isfinite(center):
        at = medians | {wanted.free: center}
        found = {
            each.path: each.value
            for each in influences(evaluation, at, tuple(p for p in paths if medians[p]))
        }
    elif linear:
        raise InputError(
            f"space: with the medians of its parameters no value of {wanted.free} from {wanted.parameter(wanted.low)} to"
            f" {wanted.parameter(wanted.high)} gives {wanted.quantity(wanted.value)}; omit linear, or widen the range"
            " (--free PATH=LOW:HIGH)"
        )
    else:
        center, found = start, {}
    logs = sum(
        (
            e * np.log(drawn[path] / medians[path])
            for path, e in found.items()
            if np.all(drawn[path] / medians[path] > 0)
        ),
        start=np.zeros(n),
    )
    guesses = center * np.exp(np.clip(logs, -50, 50))
    inside = (guesses >= wanted.low) & (guesses <= wanted.high)
    values = np.where(inside, guesses, math.nan) if linear else np.empty(n)
    for i in range(0 if linear else n):
        report(i, n)
        values[i] = _solved(evaluation, wanted, {path: float(drawn[path][i]) for path in paths}, guesses[i])
    return NeededValues(space.title, values, seed, linear, tuple(remarks))


def _solved(evaluation: Evaluation, wanted: Wanted, others: Mapping[str, float], guess: float) -> float:
    """Return the value of the free parameter for given other parameters, near a first guess; NaN if there is none."""
    function = Function(lambda at: evaluation({**others, wanted.free: at}))
    found = _secant(function, wanted, guess)
    if math.isfinite(found):
        return found
    explore(
        function,
        first_values(wanted.low, wanted.high, guess if wanted.low < guess < wanted.high else wanted.high),
    )
    several = [each.value for each in solutions(function, wanted.value)[0]]
    return min(several, key=lambda each: _distance(each, guess), default=math.nan)


def _distance(value: float, other: float) -> float:
    return abs(math.log(value / other)) if coordinate(value, other) else 1e6 + abs(value - other)


def _secant(function: Function, wanted: Wanted, guess: float) -> float:
    """Return a solution by the secant method in logarithms where these exist; NaN where it leaves the range."""
    target = wanted.value
    sign = math.copysign(1.0, guess)
    u, before = math.log(abs(guess)) if guess else 0.0, math.nan
    off_before = math.nan
    for _ in range(_STEPS):
        at = sign * math.exp(u)
        if not wanted.low <= at <= wanted.high:
            return math.nan
        value = function(at)
        if not math.isfinite(value):
            return math.nan
        if abs(value - target) <= EXACT * abs(target):
            return at
        off = (
            math.log(value / target) if coordinate(value, target) else (value - target) / (abs(target) or 1.0)
        )
        if math.isnan(off_before):
            step = -0.5 * off if abs(off) < 1 else -0.5 * math.copysign(1.0, off)
        elif off == off_before:
            return math.nan
        else:
            step = -off * (u - before) / (off - off_before)
        before, off_before = u, off
        u += max(-_LONGEST_STEP, min(_LONGEST_STEP, step))
    return math.nan
