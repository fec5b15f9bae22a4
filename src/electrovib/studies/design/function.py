"""The public function of all designs, and the forms of the question. A form is added by one function and one row of `FORMS`."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.choice import chosen
from electrovib.solve.effort import counted, last_time
from electrovib.solve.meter import Meter, measured
from electrovib.studies.check import LimitsSource, checked
from electrovib.studies.check.result import not_in_rows
from electrovib.studies.design import search
from electrovib.studies.design.drive import TargetSource, design_drive
from electrovib.studies.design.limits import Limited, obtainable, several_limits
from electrovib.studies.design.result import Designed, DesignedParameter, Explored, FoundValue
from electrovib.studies.design.share import design_for_share
from electrovib.studies.design.uncertain import influences, inputs_of, propagated, read_draws, solved
from electrovib.studies.design.wanted import BetweenSource, Evaluation, Wanted, WantSource, read_wanted
from electrovib.studies.design.widths import Sampled, widths_of
from electrovib.studies.widths import LEVEL, ONE_FINGER, Width

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario.space import SpaceSource
    from electrovib.studies.design.uncertain import NeededValues
    from electrovib.studies.sensitivity import Elasticity


_ALWAYS: Final = ("scenario", "progress")


def design(
    scenario: Source,
    *,
    want: WantSource | None = None,
    free: str | None = None,
    between: BetweenSource | None = None,
    target: TargetSource | None = None,
    method: str | None = None,
    carrier: float | str | None = None,
    rate: float | str | None = None,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    space: SpaceSource | None = None,
    n: int | None = None,
    seed: int | None = None,
    share: float | None = None,
    band: str | Sequence[str | float] | None = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    progress: Callable[[int, int], None] | None = None,
) -> Designed:
    """Find the value of a parameter that gives a wanted quantity, or the drive that gives a wanted force.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    want : str or mapping, optional
        Quantity and value, ``"mean electrostatic_force = 50 mN"`` or ``{"mean electrostatic_force": 0.05}``; the quantity is
        named as for `electrovib.sweep`, or is a signal at one time, ``"electrostatic_force at 20 ms = 1 mN"``.
    free : str, optional
        Dotted path of the parameter that is sought, ``"drive.amplitude"``.
    between : str or sequence of two, optional
        Ends of the range in which it is sought, ``"10 V:400 V"``; by default the range of the parameter.
    target : str, Path, Target or pair of array_like, optional
        Force over time, which is never negative: ``"sine 50 Hz 30 mN"`` (between 0 and 30 mN), ``"sine 50 Hz 10 mN to 30 mN
        for 0.2 s"``, ``"constant 5 mN for 1 s"``, a file with the columns time and force, or times [s] and forces [N].
    method : str, optional
        Method of the drive: ``"dc"``, ``"carrier"``, ``"sqrt-am"`` or ``"current"``.
    carrier : float or str, optional
        Frequency of the carrier [Hz]; chosen if absent.
    rate : float or str, optional
        Samples of the drive per second [Hz]; chosen if absent.
    limits : str, Path, mapping, Limits, or a list of them, optional
        Further limits beside those of the scenario; the strictest counts.
    space : str, Path, mapping or Space, optional
        Distributions of uncertain parameters, as for `electrovib.read_space`: ``"fingers"``.
    n : int, optional
        Number of draws from the space, 200 by default.
    seed : int, optional
        Seed of the draws; needed with `space`.
    share : float, optional
        Share of the fingers of `space` [1] for which the quantity has to be at least the wanted value; needs `seed`.
    band : str or sequence of two, optional
        With `share`: the band in which the quantity has to lie, ``"20 mN:60 mN"``; `want` then names the quantity alone.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    progress : callable, optional
        Function of the number of evaluations done and of all evaluations.

    Returns
    -------
    Designed
        The result: its sentences (`lines`), the scenario with the result in it (`scenario`), and all numbers.

    Raises
    ------
    InputError
        For every mistake in the arguments.
    BudgetError
        If the computation would take more time or memory than is allowed.
    """
    arguments = {name: value for name, value in locals().items() if name not in (*_ALWAYS, "set")}
    given = {name: value for name, value in arguments.items() if value is not None}
    found: Designed = form_of(given)(read_scenario(scenario, changes=set), progress=progress, **given)
    return found


def form_of(given: Mapping[str, Any]) -> Callable[..., Any]:
    """Return the form that is meant by the given arguments, all that it needs and nothing else among them.

    The first argument that a form needs decides that it is meant.
    """
    taken = {function: inspect.signature(function).parameters.values() for function in FORMS}
    needs = {
        each: [one.name for one in own if one.default is one.empty and one.name not in _ALWAYS]
        for each, own in taken.items()
    }
    form = next((each for each in FORMS if needs[each][0] in given), None)
    form = form or next((each for each in reversed(FORMS) if given.keys() & needs[each]), None)
    if form is None:
        examples = "; or ".join(f"{name} by {example}" for name, example in reversed(FORMS.values()))
        raise InputError(f"design: state what is wanted: {examples}")
    name, example = FORMS[form]
    if missing := [each for each in needs[form] if each not in given]:
        raise InputError(
            f"{missing[0]}: not given, but the design of {name} needs it, for instance {example}"
        )
    accepted = [each.name for each in taken[form] if each.name not in _ALWAYS]
    if foreign := [each for each in given if each not in accepted]:
        raise InputError(
            f"{each}: does not belong to the design of {name}, which takes {', '.join(accepted)}; omit it"
            for each in foreign
        )
    return form


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
    progress: Callable[[int, int], None] | None = None,
) -> DesignedParameter:
    """Find the values of one parameter that give a wanted quantity, and what they depend on.

    The arguments are those of `electrovib.design`. The quantity is computed over the range in the natural
    scale of the parameter (logarithmic where it spans decades), with more values where it is bent; extremes
    are refined, and each crossing of the wanted value is solved by Brent's method. Only what depends on the
    parameter is computed again. Without a space, d ln x / d ln p = -(dq / d ln p) / (dq / d ln x) states what
    the solution x depends on.
    """
    wanted = read_wanted(scenario, want=want, free=free, between=between)
    given = several_limits(limits, scenario)
    over = read_draws(scenario, space, n=n, seed=seed)
    most_added, most_between = (
        (_FEW_ADDED, _FEW_ADDED) if is_long(scenario) else (search.MOST_ADDED, _BETWEEN)
    )
    evaluation = Evaluation(scenario, wanted, (free,))
    function = _explored(evaluation, sparse=most_added == _FEW_ADDED, most=most_added, progress=progress)
    search.sharpen_extremes(function, wanted.value)
    is_settled = search.look_between(function, wanted.value, most_added=most_between)
    roots, jumps, beyond = search.solutions(function, wanted.value)
    limited = Limited(lambda at: checked(evaluation.scenario({free: at}), limits=list(given)))
    each_compared = (FoundValue(each, limited(each.value), limited.problem(each.value)) for each in roots)
    found = tuple(sorted(each_compared, key=lambda each: _order(each, wanted)))
    near = None
    if not any(each.is_allowed for each in found):
        near = obtainable(function, limited, wanted.value, wanted.begin)
    main = found[0].value if found else None
    distribution = None
    if main is not None and over is not None:
        distribution = propagated(scenario, wanted, over, start=main, progress=progress)
    return DesignedParameter(
        base=scenario,
        wanted=wanted,
        solutions=found,
        explored=Explored.of(function, jumps, beyond=beyond, is_settled=is_settled),
        obtainable=near,
        influences=() if main is None or over is not None else _influences(scenario, wanted, main),
        distribution=distribution,
        widths=() if main is None else _widths(scenario, wanted, main, distribution),
        diagnostics=_diagnostics(evaluation, wanted.begin if main is None else main),
        limits=given,
    )


def _widths(
    scenario: Scenario, wanted: Wanted, main: float, distribution: NeededValues | None
) -> tuple[Width, ...]:
    """Return the widths of a value that depends on people: of a detection level, or over the draws of a space."""
    if distribution is None and wanted.name != LEVEL:
        return ()

    def needed(other: Wanted, factor: float) -> Sampled:
        asked = replace(other, value=other.with_force(other.value, factor))
        return (solved(Evaluation(scenario, asked, (wanted.free,)), {}, main),) * 3

    sampling = ONE_FINGER if distribution is None else distribution.sampling(wanted.declared.unit)
    drawn = () if distribution is None else distribution.paths
    return widths_of(scenario, wanted, (main,) * 3, sampling=sampling, drawn=drawn, needed=needed)


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
    reach = f"at {{}} value from {wanted.parameter(wanted.low)} to {wanted.parameter(wanted.high)}"
    if not points:
        told = [*searched.refused.values(), *(each.text for each in _diagnostics(evaluation, wanted.begin))]
        why = next(iter(told), "its signal is not known")
        raise InputError(f"{wanted.name} is not known {reach.format('any')}: {why}", path=wanted.free)
    reached = [value for _, value in points]
    noise = max(_CONSTANT * max(map(abs, reached)), _FLAT_LEVEL if wanted.unit == "dB" else 0.0)
    if len(points) > 1 and max(reached) - min(reached) <= noise:
        low, high = wanted.parameter(points[0][0]), wanted.parameter(points[-1][0])
        raise InputError(
            f"{wanted.name} does not depend on it: it is {wanted.quantity(reached[0])} at every value from"
            f" {low} to {high}; choose another parameter",
            path=wanted.free,
        )
    return searched


def _order(each: FoundValue, wanted: Wanted) -> tuple[bool, bool, float]:
    """Return the order of solutions: allowed, of the sign of the present value, near to it."""
    begin = wanted.begin
    alike = each.value * begin > 0 or (begin == 0 and each.value >= 0)
    distance = abs(math.log(each.value / begin)) if each.value * begin > 0 else abs(each.value - begin)
    return (not each.is_allowed, not alike, distance)


def _influences(scenario: Scenario, wanted: Wanted, value: float) -> tuple[Elasticity, ...]:
    """Return the elasticities of a solution; none of a solution that is 0."""
    if value == 0:
        return ()
    at = scenario.replace({wanted.free: value})
    paths = inputs_of(at, wanted.free)
    evaluation = Evaluation(at, wanted, (wanted.free, *paths))
    numbers = {path: number for path, number, _ in at.parameters() if path in paths and number is not None}
    return influences(evaluation, numbers | {wanted.free: value}, paths)


def _diagnostics(evaluation: Evaluation, at: float) -> tuple[Diagnostic, ...]:
    try:
        return not_in_rows(evaluation.warnings({evaluation.wanted.free: at}))
    except ElectrovibError:  # the check states why
        return ()


FORMS: Final[dict[Callable[..., Any], tuple[str, str]]] = {
    design_for_share: (
        "a parameter for a share of a population",
        'want="mean electrostatic_force = 50 mN", free="drive.amplitude", space="fingers", share=0.9, seed=1',
    ),
    design_drive: ("a drive", 'target="sine 50 Hz 30 mN", method="carrier"'),
    design_parameter: ("a parameter", 'want="mean electrostatic_force = 50 mN", free="drive.amplitude"'),
}
"""Forms of the question with their names and an example."""
