"""Validity of a result: the diagnostics, each with its value and limit, or why it could not be evaluated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.physics.motion import Distance
from electrovib.solve.choice import chosen, solve, solve_fields
from electrovib.solve.diagnostics.assumptions import (
    contact_diagnostics,
    moving_gap,
    negative_attraction,
    over_frequency_diagnostics,
    settled_charge,
    vanishing_gap,
)
from electrovib.solve.diagnostics.judge import (
    circuit_diagnostics,
    declared_diagnostics,
    discontinuities,
    stack_diagnostics,
)
from electrovib.solve.diagnostics.peaks import (
    PeakRecord,
    around_kinks,
    evaluation_times,
    refined,
    shows_every_sample,
)
from electrovib.solve.electrics.linear import caveat

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Solution
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection

SQUEEZED = 8
"""Multiple of the frequency of a moving gap that is resolved: the field, which varies as 1/gap, has sharper peaks."""


def solved(scenario: Scenario, section: ModalSection, times: Real) -> tuple[Solution, PeakRecord]:
    """Compute the electrical response at the output times, and its largest values between them.

    `times` (n,) [s].

    A solver in closed form is evaluated again at further times; a time-stepping solver returns all times of one run, and an
    amplifier with limits in a second run the values around the times at which it reaches or leaves a limit.
    """
    settled = scenario.time.settled
    moved = scenario.motion.moved_gap
    beside = 0.0 if moved is None else SQUEEZED * moved.fastest
    wanted = evaluation_times(
        scenario.drive, end=float(times[-1]), settled=settled, beside=beside, seen=times
    )

    if chosen(scenario).method.is_marched:
        both = np.union1d(times, wanted)
        whole = solve(scenario, section, both)
        record = PeakRecord.of(scenario, both, whole.found)
        around = np.setdiff1d(around_kinks(np.array(whole.kinks), float(times[-1])), both)
        return whole.at(np.searchsorted(both, times)), _joined(scenario, section, record, around)

    answer = solve(scenario, section, times)
    record = PeakRecord.of(scenario, times, answer.found)
    if shows_every_sample(scenario.drive, times):
        wanted = np.union1d(wanted, record.just_before())
    between = wanted[times[np.minimum(np.searchsorted(times, wanted), len(times) - 1)] != wanted]
    record = _joined(scenario, section, record.among(between), between)
    return answer, _refined(scenario, section, record)


def watched(scenario: Scenario, section: ModalSection, times: Real, answer: Solution) -> PeakRecord:
    """Return the quantities with limits, from a response at closely spaced times.

    `times` (n,) [s].
    """
    record = PeakRecord.of(scenario, times, answer.found)
    if (method := chosen(scenario).method).is_marched and not method.by_regimes:
        return record

    corners = np.union1d(scenario.drive.corners(float(times[-1]))[0], answer.kinks)
    whole = _joined(scenario, section, record, np.setdiff1d(record.before_corners(corners), times))
    return whole if method.by_regimes else _refined(scenario, section, whole)


def _at(scenario: Scenario, section: ModalSection, times: Real) -> PeakRecord:
    """Return the quantities with limits at further times [s]."""
    return PeakRecord.of(scenario, times, solve_fields(scenario, section, times).found)


def _joined(scenario: Scenario, section: ModalSection, record: PeakRecord, times: Real) -> PeakRecord:
    """Add further times [s], if any, to a record."""
    return record.joined(_at(scenario, section, times)) if len(times) else record


def _refined(scenario: Scenario, section: ModalSection, record: PeakRecord) -> PeakRecord:
    """Add times around largest values that a record does not resolve; of a solver in closed form."""

    def look(_: Indices, times: Real) -> dict[Key, Real]:
        return {name: row[None] for name, row in _at(scenario, section, times[0]).rows.items()}

    return refined([record], look)[0]


def judge_run(
    scenario: Scenario,
    section: ModalSection,
    record: PeakRecord,
    times: Real,
    variables: dict[str, Any],
    mean_squares: Mapping[str, float] | None = None,
) -> list[Diagnostic]:
    """Return the diagnostics of a run.

    `times` (n,) [s].
    """
    return [
        *scenario.force.diagnostics(scenario.stack.layers),
        *([] if scenario.drive.quantity == "voltage" else [caveat()]),
        *declared_diagnostics(scenario),
        *stack_diagnostics(scenario, record),
        *circuit_diagnostics(scenario, record, running_currents(scenario, section, record), mean_squares),
        *settled_charge(scenario),
        *contact_diagnostics(scenario, variables, times),
        *moving_gap(scenario, variables),
        *vanishing_gap(scenario, times, variables),
        *negative_attraction(scenario, variables),
        *over_frequency_diagnostics(scenario),
    ]


def running_currents(
    scenario: Scenario, section: ModalSection, record: PeakRecord
) -> dict[str, float] | None:
    """Return the largest currents apart from the response to the step of the drive at time 0."""
    end, drive = float(record.times[-1]), scenario.drive
    linear = not chosen(scenario).method.is_marched and not scenario.circuit.supply.is_limited
    if not linear or not discontinuities(scenario, end=end)[0]:
        return None
    names = ("current", "body_current")
    try:
        if drive.period is not None:
            periodic = scenario.replace({"time.initial_state": {"model": "PeriodicState"}})
            wanted = evaluation_times(drive, end=end, settled=True)
            repeated = _at(periodic, section, wanted).peaks()
            return {name: repeated[name] for name in names}
        stepped = scenario.replace({"drive": {"model": "Step", "level": float(drive.voltage(0.0))}})
        records = [record] if record.whole is None else [record, record.whole]
        switched = [
            PeakRecord.of(scenario, each.times, solve_fields(stepped, section, each.times).found)
            for each in records
        ]
        rest = {
            name: np.concatenate(
                [each.rows[name] - alone.rows[name] for each, alone in zip(records, switched, strict=True)]
            )
            for name in names
        }
        return {name: float(np.max(np.abs(row))) for name, row in rest.items()}
    except InputError:
        return None
