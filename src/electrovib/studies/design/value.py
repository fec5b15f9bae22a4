"""The values of one parameter that give a wanted quantity, within limits, and what they depend on."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import value_at
from electrovib.core.tables import stored_changes
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.choice import chosen
from electrovib.solve.effort import counted, last_time
from electrovib.solve.meter import Meter, measured
from electrovib.studies.check import LimitsSource, checked, declared_limits, several_limits
from electrovib.studies.check.result import not_in_rows
from electrovib.studies.design import search
from electrovib.studies.design.limits import Limited, Sampled, obtainable, widths_of
from electrovib.studies.design.result import DesignedParameter, Explored, FoundValue
from electrovib.studies.design.wanted import Evaluation, FreeSource, Wanted, WantSource, read_wanted
from electrovib.studies.sensitivity import Elasticity, elasticities, slope
from electrovib.studies.widths import LEVEL, ONE_FINGER, Width

_CONSTANT: Final = 1e-12
"""Relative range of a quantity up to which it does not depend on the parameter."""
_FLAT_LEVEL: Final = 1e-5
"""The same for a level [dB]."""
_LONG: Final = 0.1
"""Counted computing time of an evaluation from which on fewer are made [s]."""
_TIMES: Final = 200
"""Approximate number of times at which the solution of an evaluation is computed."""
_FEW_ADDED: Final = 12
"""Largest number of values that are then added where the quantity is bent."""
_BETWEEN: Final = 2000
"""Largest number of values that are added among many solutions."""
_EXACT: Final = 1e-7
"""Relative deviation of the quantity from the wanted value, up to which a search near a value ends."""
_NO_INPUTS: Final = ("time", "frequency", "limits")
"""Parts of a scenario that are no inputs of the model."""


@measured()
def find_value(
    scenario: Source,
    *,
    want: WantSource,
    free: FreeSource,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    progress: Callable[[int, int], None] | None = None,
) -> DesignedParameter:
    """Find the values of one parameter that give a wanted quantity, and what they depend on.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    want : str or mapping
        Quantity and value, ``"mean electrostatic_force = 50 mN"`` or ``{"mean electrostatic_force": 0.05}``; the quantity is
        named as for `electrovib.sweep`, or is a signal at one time, ``"electrostatic_force at 20 ms = 1 mN"``.
    free : str or mapping
        Dotted path of the parameter that is sought, ``"drive.amplitude"``; with the range in which it is sought where
        that is not its own, ``"drive.amplitude = 10 V:400 V"`` or ``{"drive.amplitude": (10, 400)}``.
    limits : str, Path, mapping, Limits, or a list of them, optional
        Further limits beside those of the scenario; the strictest counts.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    progress : callable, optional
        Function of the number of evaluations done and of all evaluations.

    Returns
    -------
    DesignedParameter
        All values, compared with the limits; `scenario` has the first one within them.

    Raises
    ------
    InputError
        For every mistake in the arguments, and where the quantity does not depend on the parameter.

    Examples
    --------
    >>> import electrovib as ev
    >>> found = ev.find_value("bau_2010/sine", want="mean electrostatic_force = 50 mN", free="drive.amplitude")
    >>> round(found.value, 4)
    50.8183
    """
    base = read_scenario(scenario, changes=set)
    wanted = read_wanted(base, want=want, free=free)
    given = several_limits(limits)
    declared_limits(base, given)  # a mistake is reported at once
    most_added, most_between = (_FEW_ADDED, _FEW_ADDED) if is_long(base) else (search.MOST_ADDED, _BETWEEN)
    evaluation = Evaluation(base, wanted, (wanted.free,))
    function = _explored(evaluation, sparse=most_added == _FEW_ADDED, most=most_added, progress=progress)
    search.sharpen_extremes(function, wanted.value)
    is_settled = search.look_between(function, wanted.value, most_added=most_between)
    roots, jumps, beyond = search.solutions(function, wanted.value)
    limited = Limited(lambda at: checked(evaluation.scenario({wanted.free: at}), limits=list(given)))
    each_compared = (FoundValue(each, limited(each.value), limited.problem(each.value)) for each in roots)
    found = tuple(sorted(each_compared, key=lambda each: _order(each, wanted)))
    near = None
    if not any(each.is_allowed for each in found):
        near = obtainable(function, limited, wanted.value, wanted.begin)
    main = found[0].value if found else None
    return DesignedParameter(
        base=base,
        wanted=wanted,
        solutions=found,
        explored=Explored.of(function, jumps, beyond=beyond, is_settled=is_settled),
        obtainable=near,
        influences=_influences(base, wanted, main) if main else (),
        widths=() if main is None else _widths(base, wanted, main),
        diagnostics=_diagnostics(evaluation, wanted.begin if main is None else main),
        limits=given,
    )


def _widths(scenario: Scenario, wanted: Wanted, main: float) -> tuple[Width, ...]:
    """Return the widths of the value for a detection level: of the thresholds of people and of the force law."""
    if wanted.name != LEVEL:
        return ()

    def needed(other: Wanted, factor: float) -> Sampled:
        asked = replace(other, value=other.with_force(other.value, factor))
        return (solved(Evaluation(scenario, asked, (wanted.free,)), main),) * 3

    return widths_of(scenario, wanted, (main,) * 3, sampling=ONE_FINGER, drawn=(), needed=needed)


def solved(evaluation: Evaluation, guess: float) -> float:
    """Return the value of the free parameter near a first guess; NaN if there is none."""
    wanted = evaluation.wanted
    function = search.Function(lambda at: evaluation({wanted.free: at}))
    found = search.near_root(function, wanted.value, wanted.low, wanted.high, guess, _EXACT)
    if math.isfinite(found):
        return found
    search.explore(function, search.first_values(wanted.low, wanted.high, guess))
    several = [each.value for each in search.solutions(function, wanted.value)[0]]
    return min(several, key=lambda each: _distance(each, guess), default=math.nan)


def _distance(value: float, other: float) -> float:
    return abs(math.log(value / other)) if search.has_ratio(value, other) else 1e6 + abs(value - other)


def is_long(scenario: Scenario) -> bool:
    """Return whether an evaluation of a scenario takes long: over time steps, or by its counted parts."""
    works = counted(scenario, np.linspace(0.0, last_time(scenario), _TIMES))
    return chosen(scenario).method.is_marched or sum(work.time for work in works) > _LONG


def _explored(
    evaluation: Evaluation, *, sparse: bool, most: int, progress: Callable[[int, int], None] | None
) -> search.Function:
    """Compute the quantity over the range; refused where it is known nowhere, or is the same everywhere."""
    wanted = evaluation.wanted
    values = search.first_values(wanted.low, wanted.high, wanted.begin, sparse=sparse)
    count, of = len(values), f"{len(values)} evaluations for {wanted.free}"
    meter = Meter.of_cases(
        "this design", of, count, numbers=0, remedy="narrow the range, --free PATH=LOW:HIGH"
    )
    report = meter.reporting(progress)

    def compute(at: float) -> float:
        report(min(len(searched.values), count), count)
        return evaluation({wanted.free: at})

    searched = search.Function(compute)
    search.explore(searched, values, most_added=most)
    points = searched.known
    if not points:
        judged = (each.text for each in _diagnostics(evaluation, wanted.begin))
        why = next(iter((*searched.refused.values(), *judged)), "its signal is not known")
        reach = f"{wanted.parameter(wanted.low)} to {wanted.parameter(wanted.high)}"
        raise InputError(f"{wanted.name} is not known at any value from {reach}: {why}", path=wanted.free)
    reached = [value for _, value in points]
    noise = max(_CONSTANT * max(map(abs, reached)), _FLAT_LEVEL if wanted.unit == "dB" else 0.0)
    if len(points) > 1 and max(reached) - min(reached) <= noise:
        same, reach = (
            wanted.quantity(reached[0]),
            " to ".join(wanted.parameter(points[i][0]) for i in (0, -1)),
        )
        why = f"{wanted.name} does not depend on it: it is {same} at every value from {reach}; choose another parameter"
        raise InputError(why, path=wanted.free)
    return searched


def _order(each: FoundValue, wanted: Wanted) -> tuple[bool, bool, float]:
    """Return the order of solutions: allowed, of the sign of the present value, near to it."""
    begin = wanted.begin
    alike = each.value * begin > 0 or (begin == 0 and each.value >= 0)
    distance = abs(math.log(each.value / begin)) if each.value * begin > 0 else abs(each.value - begin)
    return (not each.is_allowed, not alike, distance)


def _influences(scenario: Scenario, wanted: Wanted, value: float) -> tuple[Elasticity, ...]:
    """Return how a solution follows the other parameters, the largest first; empty where its own derivative is 0.

    With the quantity q(x, p), d ln x / d ln p = -(dq / d ln p) / (dq / d ln x).
    """
    at = scenario.replace({wanted.free: value})
    paths = _inputs(at, wanted.free)
    evaluation = Evaluation(at, wanted, (wanted.free, *paths))
    numbers = {path: number for path, number, _ in at.parameters() if path in paths and number is not None}
    numbers[wanted.free] = value
    own = slope(evaluation, numbers, wanted.free)
    if not math.isfinite(own) or abs(own) <= 1e-9 * abs(wanted.value):
        return ()
    found = elasticities(at, evaluation, numbers, paths, per=-own)
    known = (each for each in found if math.isfinite(each.value))
    return tuple(sorted(known, key=lambda each: -abs(each.value)))


def _inputs(scenario: Scenario, free: str) -> tuple[str, ...]:
    """Return the parameters other than the free one that an elasticity can be computed of: those that are not 0."""
    value = value_at(scenario, free)
    moved, _ = stored_changes(scenario, {free: 0.9 * value or 1.0})
    own = {*moved, free}
    return tuple(
        path
        for path, number, _ in scenario.parameters()
        if number and path not in own and path.partition(".")[0] not in _NO_INPUTS
    )


def _diagnostics(evaluation: Evaluation, at: float) -> tuple[Diagnostic, ...]:
    try:
        return not_in_rows(evaluation.warnings({evaluation.wanted.free: at}))
    except ElectrovibError:  # the check states why
        return ()
