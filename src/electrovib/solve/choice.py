"""Choice of the electrical solver: the first in an ordered list that accepts the scenario."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.leaks import answer_with_leak, leaks, refuse_leak
from electrovib.solve.electrics.over_frequency import one_sine, refuse_more_than_one_sine
from electrovib.solve.electrics.renewal import answer_on_fresh_film, refuse_renewal
from electrovib.solve.electrics.solution import (
    CURRENT_DRIVE,
    LEAK,
    LIMITED,
    MOVING_GAP,
    NONLINEAR,
    ONE_SINE,
    PERIODIC,
    RENEWAL,
    TRANSIENT,
    Along,
    Question,
    fields,
    linear_quantities,
    name_interface,
    some_quantities,
)
from electrovib.solve.electrics.transient import (
    along_linear,
    answer_linear,
    of_drive,
    refuse_behind_amplifier,
    refuse_current,
)
from electrovib.solve.electrics.without_modes import (
    follow_all,
    follow_moving_gap,
    moves_alone,
    refuse_without_modes,
    why_no_modes,
)
from electrovib.solve.rough_contact.solved import refuse_unsolved_contact
from electrovib.solve.stack.harmonics import refuse_unrepeated

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Method, Solution
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection
    from electrovib.solve.stack.transfer import Transfer


@dataclass(frozen=True)
class Solver:
    """Electrical solver, with the scenarios that it accepts and refuses.

    Parameters
    ----------
    method : Method
        Its name in a Trace, and the cost of its steps.
    takes : callable
        Whether it accepts a scenario that none before it in the list accepts.
    refuse : callable
        Raises for what such a scenario must not contain, with what to do instead, before any computation.
    solve : callable
        Returns the solution.
    """

    method: Method
    takes: Callable[[Scenario], object]
    refuse: Callable[[Scenario], None]
    solve: Callable[[Question], Solution]


def _answer_behind_limits(question: Question) -> Solution:
    from electrovib.solve.electrics.amplifier import amplified_response

    amplifier, transfers = question.scenario.circuit.amplifier, question.wanted(question.section)
    assert amplifier is not None
    return amplified_response(transfers, question.scenario.drive, question.times, amplifier=amplifier)


OF_THE_STACK: Final = (
    Solver(RENEWAL, lambda scenario: scenario.motion.renews_film, refuse_renewal, answer_on_fresh_film),
    Solver(MOVING_GAP, moves_alone, refuse_without_modes, follow_moving_gap),
    Solver(NONLINEAR, why_no_modes, refuse_without_modes, follow_all),
    Solver(LEAK, leaks, refuse_leak, answer_with_leak),
    Solver(
        LIMITED,
        lambda scenario: scenario.circuit.supply.is_limited,
        refuse_behind_amplifier,
        _answer_behind_limits,
    ),
    Solver(
        CURRENT_DRIVE, lambda scenario: scenario.drive.quantity == "current", refuse_current, answer_linear
    ),
    Solver(PERIODIC, lambda scenario: scenario.time.settled, lambda _: None, answer_linear),
    Solver(TRANSIENT, lambda _: True, lambda _: None, answer_linear),
)
"""Solvers of voltages, currents and fields, for any force law; the last accepts every scenario."""


def _refuse_beside_one_sine(scenario: Scenario) -> None:
    refuse_more_than_one_sine(scenario)
    _first(OF_THE_STACK, scenario).refuse(scenario)


SOLVERS: Final = (
    Solver(
        method=ONE_SINE,
        takes=lambda scenario: not scenario.force.causal,
        refuse=_refuse_beside_one_sine,
        solve=lambda question: one_sine(question, _first(OF_THE_STACK, question.scenario).solve(question)),
    ),
    *OF_THE_STACK,
)
"""All electrical solvers; the first that accepts a scenario is used."""


def _first(solvers: tuple[Solver, ...], scenario: Scenario) -> Solver:
    return next(solver for solver in solvers if solver.takes(scenario))


def chosen(scenario: Scenario) -> Solver:
    """Return the solver of a scenario, without computation."""
    return _first(SOLVERS, scenario)


def refuse_unsolved(scenario: Scenario) -> None:
    """Refuse a scenario that no electrical solver accepts, before any computation."""
    refuse_unsolved_contact(scenario)
    solver = chosen(scenario)
    if scenario.time.settled:
        refuse_unrepeated(scenario.drive)
    solver.refuse(scenario)


def solve(
    scenario: Scenario, section: ModalSection, times: Real, *, asked: Collection[str] | None = None
) -> Solution:
    """Compute the attraction over time, and of voltages, currents and fields those that are asked for, or all.

    `times` (n,) [s].
    """
    solver = chosen(scenario)
    alone = solver.method.each_alone and scenario.circuit.amplifier is None
    wanted = linear_quantities
    if asked is not None and alone:
        wanted = functools.partial(some_quantities, asked=asked)
    found = _asked(
        solver,
        scenario,
        section,
        times,
        wanted,
        with_drive=asked is None or not alone or "drive_voltage" in asked,
    )
    pull = total_pull(scenario, found.amplitudes()) if found.pull is None else found.pull
    return replace(found, force=attraction(scenario, pull, times))


def along(scenario: Scenario, section: ModalSection, times: Real) -> Along:
    """Return the response with its attraction in stretches of the times, one stretch where a solver needs all times at once.

    `times` (n,) [s].
    """
    solver, found = chosen(scenario), None
    if solver.method.each_alone:
        solver.refuse(scenario)
        wanted = functools.partial(linear_quantities, scenario)
        found = along_linear(Question(scenario=scenario, section=section, times=times, wanted=wanted))
    if found is None:
        return Along(
            lambda _: solve(scenario, section, times),
            lambda moments: solve_fields(scenario, section, moments).found,
            len(times),
        )
    through = found.through

    def pulled(stretch: slice) -> Solution:
        answer = through(stretch)
        pull = total_pull(scenario, answer.amplitudes())
        return replace(answer, force=attraction(scenario, pull, times[stretch]))

    return found._replace(through=pulled)


def solve_fields(scenario: Scenario, section: ModalSection, times: Real) -> Solution:
    """Compute voltages, currents and the fields of every layer, without the attraction."""
    return _asked(_first(OF_THE_STACK, scenario), scenario, section, times, fields)


def _asked(
    solver: Solver,
    scenario: Scenario,
    section: ModalSection,
    times: Real,
    wanted: Callable[[Scenario, ModalSection], dict[Key, Transfer]],
    *,
    with_drive: bool = True,
) -> Solution:
    """Return the solution of a solver, with drive and interface added."""
    solver.refuse(scenario)
    question = Question(
        scenario=scenario, section=section, times=times, wanted=functools.partial(wanted, scenario)
    )
    solution = solver.solve(question)
    found = dict(solution.found)
    if with_drive and "drive_voltage" not in found:
        found |= of_drive(question, found)
    name_interface(scenario, found)
    return replace(solution, found=found)
