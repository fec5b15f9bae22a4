"""How the value that was found depends on the other parameters: elasticities, and its distribution over a space."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.tables import stored_changes
from electrovib.scenario.space import read_space
from electrovib.scenario.space.relations import checked_seed
from electrovib.solve.meter import Meter
from electrovib.studies.design.search import (
    Function,
    explore,
    first_values,
    has_ratio,
    near_root,
    solutions,
)
from electrovib.studies.design.wanted import Evaluation
from electrovib.studies.elasticity import Elasticity, slope

if TYPE_CHECKING:
    from electrovib.scenario import Scenario
    from electrovib.scenario.space import Space, SpaceSource
    from electrovib.studies.design.wanted import Wanted

PERCENTILES: Final = (5, 25, 50, 75, 95)
"""Percentiles of the distribution that are stated."""
EXACT: Final = 1e-7
"""Relative deviation of the quantity from the wanted value, up to which a draw counts as solved."""
_DRAWS: Final = 200
"""Number of draws from a space."""
_NO_INPUTS: Final = ("time", "frequency", "limits")
"""Parts of a scenario that are no inputs of the model."""


@dataclass(frozen=True)
class Draws:
    """A space with the options of its draws."""

    space: Space
    n: int
    seed: int
    linear: bool
    meter: Meter


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

    @property
    def method(self) -> str:
        """How the value of each draw was found, in words."""
        return "linear propagation from the medians" if self.is_linear else "each draw solved anew"

    def percentiles(self) -> dict[int, float]:
        """Return the percentiles of the draws that have a value, in the SI unit of the free parameter."""
        known = self.values[np.isfinite(self.values)]
        return {each: float(np.percentile(known, each)) if len(known) else math.nan for each in PERCENTILES}

    def to_dict(self) -> dict[str, Any]:
        """Return percentiles, draws and method as a table."""
        known = {str(each): value for each, value in self.percentiles().items() if math.isfinite(value)}
        return {
            "space": self.title,
            "method": self.method,
            "seed": self.seed,
            "percentiles": known,
            "without_a_value": self.unsolved,
            "draws": self.values,
            "remarks": self.remarks,
        }


def read_draws(
    scenario: Scenario, space: SpaceSource | None, *, n: int | None, seed: int | None, linear: bool | None
) -> Draws | None:
    """Read the space and check its options before anything is computed."""
    if space is None:
        given = [name for name, value in (("n", n), ("seed", seed), ("linear", linear)) if value is not None]
        if given:
            raise InputError(
                "belongs to the draws from a space, and none is given; add space, or omit it", path=given[0]
            )
        return None
    count = _DRAWS if n is None else n
    if isinstance(count, bool) or not isinstance(count, int) or count < 2:
        raise InputError(
            "expected a whole number of draws, 2 or more, for instance 200", path="n", value=repr(n)
        )
    fingers = read_space(scenario, space)
    if seed is None:
        raise InputError(
            "missing: the draws from the space are those of a seed; add one, for instance 1", path="seed"
        )
    remedy = "choose a smaller n" if linear else "choose a smaller n, or --linear"
    numbers = len(fingers.paths)
    meter = Meter.of_cases("this design", f"{count} draws", count, numbers=numbers, remedy=remedy)
    return Draws(fingers, count, checked_seed(seed), bool(linear), meter)


def inputs_of(scenario: Scenario, free: str) -> tuple[str, ...]:
    """Return the parameters other than the free one that an elasticity can be computed of: those that are not 0."""
    value = value_at(scenario, free)
    moved, _ = stored_changes(scenario, {free: 0.9 * value or 1.0})
    own = {*moved, free}
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
    own = slope(evaluation, at, evaluation.wanted.free)
    if not math.isfinite(own) or abs(own) <= 1e-9 * abs(evaluation.wanted.value):
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
    over: Draws,
    *,
    start: float,
    progress: Callable[[int, int], None] | None,
) -> NeededValues:
    """Compute the value that is needed for each draw.

    With `linear` its logarithm is taken as linear in those of the parameters, from their medians.
    """
    report, space, linear = over.meter.reporting(progress), over.space, over.linear
    paths = tuple(path for path in space.paths if path != wanted.free)
    remarks = list(space.remarks)
    if len(paths) < len(space.paths):
        remarks.append(f"{wanted.free} is not drawn: it is the parameter that is sought")
    drawn = space.draw(over.seed, 0, over.n)
    evaluation = Evaluation(scenario, wanted, (wanted.free, *paths))
    middle = space.values({stream: np.array([0.5]) for stream in space.streams})
    medians = {path: float(middle[path][0]) for path in paths}
    center = _solved(evaluation, medians, start)
    if linear and not math.isfinite(center):
        raise InputError(
            f"space: with the medians of its parameters no value of {wanted.free} from {wanted.parameter(wanted.low)} to"
            f" {wanted.parameter(wanted.high)} gives {wanted.quantity(wanted.value)}; omit linear, or widen the range"
            " (--free PATH=LOW:HIGH)"
        )
    logs = np.zeros(over.n)
    if math.isfinite(center):
        at = medians | {wanted.free: center}
        for each in influences(evaluation, at, tuple(path for path in paths if medians[path])):
            ratio = drawn[each.path] / medians[each.path]
            if np.all(ratio > 0):
                logs += each.value * np.log(ratio)
    guesses = (center if math.isfinite(center) else start) * np.exp(np.clip(logs, -50, 50))
    if linear:
        values = np.where((guesses >= wanted.low) & (guesses <= wanted.high), guesses, math.nan)
        return NeededValues(space.title, values, over.seed, linear, tuple(remarks))
    values = np.empty(over.n)
    for i in range(over.n):
        report(i, over.n)
        values[i] = _solved(evaluation, {path: float(drawn[path][i]) for path in paths}, guesses[i])
    return NeededValues(space.title, values, over.seed, linear, tuple(remarks))


def _solved(evaluation: Evaluation, others: Mapping[str, float], guess: float) -> float:
    """Return the value of the free parameter for given other parameters, near a first guess; NaN if there is none."""
    wanted = evaluation.wanted
    function = Function(lambda at: evaluation({**others, wanted.free: at}))
    found = near_root(function, wanted.value, wanted.low, wanted.high, guess, EXACT)
    if math.isfinite(found):
        return found
    begin = guess if wanted.low < guess < wanted.high else wanted.high
    explore(function, first_values(wanted.low, wanted.high, begin))
    several = [each.value for each in solutions(function, wanted.value)[0]]
    return min(several, key=lambda each: _distance(each, guess), default=math.nan)


def _distance(value: float, other: float) -> float:
    return abs(math.log(value / other)) if has_ratio(value, other) else 1e6 + abs(value - other)
