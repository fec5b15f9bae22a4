"""The value of one parameter that gives a wanted quantity."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.scenario.space import read_space
from electrovib.scenario.space.counter import checked_seed
from electrovib.solve.choice import chosen
from electrovib.solve.effort import counted, last_time
from electrovib.solve.meter import Meter, measured
from electrovib.study.check import checked, declared_limits
from electrovib.study.check.result import not_in_rows
from electrovib.study.design.parameter.evaluation import Evaluation
from electrovib.study.design.parameter.result import DesignedParameter, Explored, FoundValue, found_value
from electrovib.study.design.parameter.roots import Root, look_between, solutions
from electrovib.study.design.parameter.scale import first_values
from electrovib.study.design.parameter.search import MOST_ADDED, Function, explore, sharpen_extremes
from electrovib.study.design.parameter.uncertain import (
    NeededValues,
    influences,
    inputs_of,
    propagated,
)
from electrovib.study.design.parameter.wanted import BetweenSource, Wanted, WantSource, read_wanted
from electrovib.study.design.parameter.within import Limited, Obtainable, obtainable

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.scenario.space import Space, SpaceSource
    from electrovib.study.check import CheckResult, LimitsSource
    from electrovib.study.elasticity import Elasticity

_CONSTANT: Final = 1e-12
"""Relative range of a quantity up to which it does not depend on the parameter."""
_FLAT_LEVEL: Final = 1e-5
"""The same for a level [dB]."""
_LONG: Final = 0.1
"""Counted computing time of an evaluation from which on fewer are made [s]."""
_TIMES: Final = 200
"""Approximate number of times at which the solution of an evaluation is computed."""
_FEW_ADDED: Final = 12
_BETWEEN: Final = 2000
"""Largest number of values that are added among many solutions."""
"""Largest number of values that are then added where the quantity is bent."""
_DRAWS: Final = 200
"""Number of draws from a space."""
_WHAT: Final = "this design"


@measured()
def design_parameter(
    scenario: Scenario,
    *,
    want: WantSource,
    free: str,
    between: BetweenSource | None = None,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    space: SpaceSource | None = None,
    n: int | None = None,
    seed: int | None = None,
    linear: bool | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> DesignedParameter:
    """Find the values of one parameter that give a wanted quantity, and what they depend on.

    The arguments are those of `electrovib.design`. The quantity is computed over the range in the natural
    scale of the parameter (logarithmic where it spans decades), with more values where it is bent; extremes
    are refined, and each crossing of the wanted value is solved by Brent's method. Only what depends on the
    parameter is computed again. Without a space, d ln x / d ln p = -(dq / d ln p) / (dq / d ln x) states what
    the solution x depends on; linear propagation over a space is in logarithms, from its medians.
    """
    wanted = read_wanted(scenario, want=want, free=free, between=between)
    given = tuple(limits) if isinstance(limits, (list, tuple)) else () if limits is None else (limits,)
    declared_limits(scenario, list(given))  # a mistake in them is reported before anything is computed
    over = _draws(scenario, space, n=n, seed=seed, linear=linear)
    sparse = is_long(scenario)
    values = first_values(wanted.low, wanted.high, wanted.begin, sparse=sparse)
    evaluation, of = Evaluation(scenario, wanted, (wanted.free,)), f"{len(values)} evaluations for {free}"
    meter = Meter.of_cases(_WHAT, of, len(values), numbers=0, remedy="narrow the range, --free PATH=LOW:HIGH")
    report = meter.reporting(progress)
    function = Function(_reporting(lambda at: evaluation({wanted.free: at}), report, len(values)))
    explore(function, values, most_added=_FEW_ADDED if sparse else MOST_ADDED)
    _refuse_unknown(function, evaluation)
    _refuse_constant(function, wanted)
    sharpen_extremes(function, wanted.value)
    is_settled = look_between(function, wanted.value, most_added=_FEW_ADDED if sparse else _BETWEEN)
    roots, jumps, beyond = solutions(function, wanted.value)
    limited = Limited(lambda at: checked(evaluation.scenario({wanted.free: at}), limits=list(given)))
    found = sorted((_compared(each, limited) for each in roots), key=lambda each: _order(each, wanted))
    near = None
    if not any(each.is_allowed for each in found):
        near = obtainable(function, limited, wanted.value, wanted.begin)
    main = found[0].value if found else None
    return DesignedParameter(
        base=scenario,
        wanted=wanted,
        solutions=tuple(found),
        explored=_explored(function, jumps, beyond=beyond, is_settled=is_settled),
        obtainable=near,
        influences=() if main is None or over is not None else _influences(scenario, wanted, main),
        distribution=None
        if main is None or over is None
        else propagated(
            scenario,
            wanted,
            over.space,
            start=main,
            n=over.n,
            seed=over.seed,
            linear=over.linear,
            report=over.meter.reporting(progress),
        ),
        diagnostics=_diagnostics(evaluation, {wanted.free: wanted.begin if main is None else main}),
        limits=given,
    )


@dataclass(frozen=True)
class _Draws:
    """A space with the options of its draws."""

    space: Space
    n: int
    seed: int
    linear: bool
    meter: Meter


def is_long(scenario: Scenario) -> bool:
    """Return whether an evaluation of a scenario takes long: over time steps, or by its counted parts."""
    works = counted(scenario, np.linspace(0.0, last_time(scenario), _TIMES))
    return chosen(scenario).method.is_marched or sum(work.time for work in works) > _LONG


def _draws(
    scenario: Scenario, space: SpaceSource | None, *, n: int | None, seed: int | None, linear: bool | None
) -> _Draws | None:
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
    meter = Meter.of_cases(_WHAT, f"{count} draws", count, numbers=len(fingers.paths), remedy=remedy)
    return _Draws(fingers, count, checked_seed(seed), bool(linear), meter)


def _reporting(
    compute: Callable[[float], float], report: Callable[[int, int], None], count: int
) -> Callable[[float], float]:
    """Return the function with a report of each of its first evaluations."""
    done = 0

    def reported(at: float) -> float:
        nonlocal done
        report(min(done, count), count)
        done += 1
        return compute(at)

    return reported


def _refuse_unknown(function: Function, evaluation: Evaluation) -> None:
    """Refuse a search where the quantity is known nowhere, with the reason."""
    if function.known:
        return
    wanted = evaluation.wanted
    told = [
        *function.refused.values(),
        *(each.text for each in _diagnostics(evaluation, {wanted.free: wanted.begin})),
    ]
    raise InputError(
        f"{wanted.name} is not known at any value from {wanted.parameter(wanted.low)} to"
        f" {wanted.parameter(wanted.high)}: {next(iter(told), 'its signal is not known')}",
        path=wanted.free,
    )


def _refuse_constant(function: Function, wanted: Wanted) -> None:
    """Refuse a search where the quantity is the same everywhere."""
    points = function.known
    values = [value for _, value in points]
    noise = max(_CONSTANT * max(map(abs, values)), _FLAT_LEVEL if wanted.unit == "dB" else 0.0)
    if len(values) > 1 and max(values) - min(values) <= noise:
        raise InputError(
            f"{wanted.name} does not depend on it: it is {wanted.quantity(values[0])} at every value from"
            f" {wanted.parameter(points[0][0])} to {wanted.parameter(points[-1][0])}; choose another parameter",
            path=wanted.free,
        )


def _compared(solution: Root, limited: Limited) -> FoundValue:
    """Compare a solution with the limits; of an interval its first end."""
    problem = ""
    check: CheckResult | None = limited(solution.value)
    if check is None:
        problem = limited.problem(solution.value)
    return found_value(solution, check, problem)


def _order(each: FoundValue, wanted: Wanted) -> tuple[bool, bool, float]:
    """Return the order of solutions: allowed, of the sign of the present value, near to it."""
    begin = wanted.begin
    alike = each.value * begin > 0 or (begin == 0 and each.value >= 0)
    distance = abs(math.log(each.value / begin)) if each.value * begin > 0 else abs(each.value - begin)
    return (not each.is_allowed, not alike, distance)


def _explored(function: Function, jumps: list[float], *, beyond: int, is_settled: bool) -> Explored:
    points = function.known
    return Explored(
        count=len(function.values),
        lowest=min(points, key=lambda point: point[1]),
        highest=max(points, key=lambda point: point[1]),
        refused=dict(function.refused),
        unknown=len(function.values) - len(points) - len(function.refused),
        jumps=tuple(jumps),
        beyond=beyond,
        is_settled=is_settled,
    )


def _influences(scenario: Scenario, wanted: Wanted, value: float) -> tuple[Elasticity, ...]:
    """Return the elasticities of a solution; none of a solution that is 0."""
    if value == 0:
        return ()
    at = scenario.replace({wanted.free: value})
    paths = inputs_of(at, wanted.free)
    evaluation = Evaluation(at, wanted, (wanted.free, *paths))
    numbers = {path: number for path, number, _ in at.parameters() if path in paths and number is not None}
    return influences(evaluation, numbers | {wanted.free: value}, paths)


def _diagnostics(evaluation: Evaluation, at: dict[str, float]) -> tuple[Diagnostic, ...]:
    try:
        return not_in_rows(evaluation.warnings(at))
    except ElectrovibError:  # the check states why
        return ()


__all__ = ["DesignedParameter", "NeededValues", "Obtainable", "design_parameter"]
