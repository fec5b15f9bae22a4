"""Quantities of many scenarios that share parts.

Results that depend on these parts alone are computed once. Scenarios of one stack under tones in their periodic state are
computed at once, in arrays with an axis of cases.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.physics.drive.parts import Tones
from electrovib.solve.choice import chosen, solve
from electrovib.solve.diagnostics.memory import answer_errors, known_band
from electrovib.solve.diagnostics.peaks import PeakRecord, refined
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.solution import Solution, fields, linear_quantities, name_interface
from electrovib.solve.expanded import LATER_PERIODS, Record
from electrovib.solve.mechanics.mechanical import mechanical
from electrovib.solve.population.arrays import in_tones
from electrovib.solve.quantities.answer import QuantityNumbers, answer, judged
from electrovib.solve.quantities.resolve import (
    TOLERANCE,
    Mesh,
    first_mesh,
    missed,
    relative_tails,
    solved,
    taken_from,
    times_of_window,
    values_of,
)
from electrovib.solve.stack.transfer import Transfer, integral_weight

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.memory import Judged
    from electrovib.solve.expanded import Expanded
    from electrovib.solve.quantities.names import Named
    from electrovib.solve.stack.keys import Key

FEWEST: Final = 2
"""Smallest number of scenarios that are computed at once."""
MOST: Final = 1 << 15
"""Number of times of all scenarios that are in memory together, about."""
_DRIVE: Final = Transfer(rates=np.zeros(0), gains=np.zeros(0), direct=1.0)


class Together:
    """Scenarios of which the same quantities are requested.

    Parameters
    ----------
    members : sequence of Scenario
        Those that differ only in their drive share all other parts as the same objects.
    names : sequence of Named
        Quantities of each.
    """

    def __init__(self, members: Sequence[Scenario], names: Sequence[Named]) -> None:
        self.members, self.names = members, names
        self._found: dict[int, QuantityNumbers] = {}
        self._groups: dict[tuple[int, ...], list[int]] = {}
        for place, member in enumerate(members):
            self._groups.setdefault(_rest(member), []).append(place)
        self._expanded: dict[tuple[int, ...], Expanded] = {}
        self._alone: set[int] = set()

    def answer(self, place: int) -> QuantityNumbers:
        """Return the quantities of one of the scenarios."""
        if place not in self._found:
            rest = _rest(self.members[place])
            group = self._groups[rest]
            expanded = solved(self.members[place], before=self._expanded.pop(rest, None))
            if place not in self._alone:
                self._at_once(expanded, [each for each in group if each not in self._alone])
            if place not in self._found:
                self._found[place] = answer(expanded, self.names)
            group[:] = [each for each in group if each not in self._found]
            if group:
                self._expanded[rest] = expanded
        return self._found.pop(place)

    def _at_once(self, expanded: Expanded, group: list[int]) -> None:
        """Compute scenarios of a group with the stack of this one; those that arrays do not cover are left alone."""
        if not is_of_tones(expanded.scenario):
            return
        cases: dict[int, _Case] = {}
        for place in group:
            case = _Case.of(expanded, self.members[place])
            if case is not None and case.shape == next(iter(cases.values()), case).shape:
                cases[place] = case
                if (len(cases) + 1) * case.shape[0] > MOST:
                    break
        self._alone |= {*cases}
        if len(cases) < FEWEST:
            return
        try:
            found = _Cases(expanded, [*cases.values()]).answers(self.names)
        except (ElectrovibError, KeyError):  # computed alone, each scenario raises its own error
            return
        self._found |= {place: each for place, each in zip(cases, found, strict=True) if each is not None}


def _rest(member: Scenario) -> tuple[int, ...]:
    """Return the identities of all parts of a scenario except its drive."""
    return tuple(id(part) for name, part in member if name not in {"drive", "title", "sources"})


def is_of_tones(scenario: Scenario) -> bool:
    """Return whether arrays cover a scenario: linear layers in the periodic state of tones, and mechanics without memory."""
    motion, friction = scenario.motion, scenario.friction
    return (
        _tones(scenario) is not None
        and scenario.time.settled
        and scenario.drive.quantity == "voltage"
        and scenario.circuit.amplifier is None
        and scenario.force.causal
        and chosen(scenario).method.by_modes
        and not (friction.deflects or friction.has_memory)
        and scenario.finger is None
        and scenario.rig is None
        and motion.distance is None
        and motion.time_profile.is_constant
        and scenario.load.time_profile.is_constant
    )


def _tones(scenario: Scenario) -> Tones | None:
    """Return the tones whose sum a periodic drive is, if they are always on and not all of amplitude 0."""
    first, *others = scenario.drive.parts()
    if others or not isinstance(first, Tones) or scenario.drive.period is None:
        return None
    always = np.isinf(first.start) and np.isinf(first.stop) and np.all(first.frequencies > 0)
    return first if always and np.any(first.amplitudes) else None


@dataclass(frozen=True)
class _Case:
    """A scenario under tones, and the pieces of one period."""

    run: Expanded
    mesh: Mesh
    tones: Tones

    @classmethod
    def of(cls, expanded: Expanded, member: Scenario) -> _Case | None:
        """Return the case of a scenario that has the stack of this one; None if it is not covered."""
        tones, times = _tones(member), times_of_window(member)
        if tones is None or not expanded.has_stack_of(member, times):
            return None
        run = expanded.under(member, times)
        return cls(run, first_mesh(run), tones)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of times, of nodes in a piece, and of tones."""
        return len(self.mesh.times()), self.mesh.nodes, len(self.tones.frequencies)


class _Cases:
    """Cases of one stack, each under its own tones, with equal numbers of times; arrays (cases, n)."""

    def __init__(self, expanded: Expanded, cases: Sequence[_Case]) -> None:
        self.expanded, self.runs = expanded, [each.run for each in cases]
        self.scenario, self.section = expanded.scenario, expanded.section
        self.mesh = Mesh(np.array([each.mesh.edges for each in cases]), cases[0].mesh.nodes)
        self.times = self.mesh.times()
        self.frequencies = np.array([each.tones.frequencies for each in cases])
        self.amplitudes = np.array([each.tones.amplitudes for each in cases])
        self.transfers = linear_quantities(self.scenario, self.section)

    def answers(self, names: Sequence[Named]) -> list[QuantityNumbers | None]:
        """Return the quantities and diagnostics of every case; None of one whose signals the pieces do not resolve."""
        charged = np.any(self.section.modes.charges)
        if charged or any(np.any(integral_weight(each)) for each in self.transfers.values()):
            return [None for _ in self.runs]
        records = self._records()
        keys = dict.fromkeys(each.key for each in names)
        rows = {key: np.array([values_of(each, self.expanded, key) for each in records]) for key in keys}
        series = {key: self.mesh.series(row) for key, row in rows.items()}
        known = [
            np.isfinite(each).all(axis=(1, 2)) & np.all(relative_tails(each) <= TOLERANCE, axis=1)
            for each in series.values()
        ]
        values = {each.name: taken_from(each.taken, self.mesh, series[each.key]).tolist() for each in names}
        errors = {each.name: missed(self.mesh, series[each.key]).tolist() for each in names}
        return [
            judged(
                run,
                records[case],
                {name: row[case] for name, row in values.items()},
                {name: row[case] for name, row in errors.items()},
            )
            if resolved
            else None
            for case, (run, resolved) in enumerate(zip(self.runs, np.all(known, axis=0), strict=True))
        ]

    def _records(self) -> list[Record]:
        """Return the record of every case, with its largest values and its errors."""
        scenario, count = self.scenario, self.times.shape[1]
        solution, flat = self._solution(), self.times.ravel()
        moved = mechanical(scenario, flat, solution, lambda _: solution)
        signals = solution.signals(tuple(self.section.names)) | moved.signals
        rows, found = PeakRecord.of(scenario, flat, solution.found).rows, []
        parts = [slice(first, first + count) for first in range(0, len(flat), count)]
        records = [PeakRecord(flat[some], {name: row[some] for name, row in rows.items()}) for some in parts]
        peaks, errors = refined(records, self._look), self._errors(solution)
        for case, some in enumerate(parts):
            own = {name: (dims, row[..., some]) for name, (dims, row) in signals.items()}
            how, times = solution.how() | moved.how, self.times[case]
            found.append(
                Record(
                    times=times,
                    solution=solution.at(some),
                    signals=own,
                    how=how,
                    diagnostics=moved.diagnostics,
                    peaks=peaks[case],
                    errors=errors[case],
                )
            )
        return found

    def _solution(self) -> Solution:
        """Return the response of the stack, one case after the other."""
        scenario = self.scenario
        found = {name: row.ravel() for name, row in self._respond(self.transfers, self.times).items()}
        name_interface(scenario, found)
        alone = solve(scenario, self.section, self.times[0, :1], asked=())
        solution = Solution(found=found, method=alone.method, reason=alone.reason)
        return replace(solution, force=attraction(scenario, total_pull(scenario, solution.amplitudes())))

    def _errors(self, solution: Solution) -> list[tuple[Real, dict[Key, Judged]]]:
        """Return the errors of every case due to the reduction of materials, and the times of which they are."""
        members = [run.scenario for run in self.runs]
        periods = np.array([member.drive.period for member in members])
        later = self.times + LATER_PERIODS * periods[:, None]
        off: list[dict[Key, Judged]] = [{} for _ in members]
        if self.expanded.reduction_error:
            known = known_band(self.scenario)
            off = answer_errors(members, self.section, solution, later, known=known, respond=self._respond)
        return list(zip(later, off, strict=True))

    def _look(self, cases: Indices, times: Real) -> dict[Key, Real]:
        """Return the quantities with limits of some cases at other times (cases, n) [s]."""
        wanted = {name: self.transfers[name] for name in fields(self.scenario, self.section)}
        found = {name: row.ravel() for name, row in self._respond(wanted, times, cases).items()}
        name_interface(self.scenario, found)
        rows = PeakRecord.of(self.scenario, times.ravel(), found).rows
        return {name: row.reshape(times.shape) for name, row in rows.items()}

    def _respond(
        self, transfers: Mapping[Key, Transfer], times: Real, cases: Any = slice(None)
    ) -> dict[Key, Real]:
        """Return linear quantities of some cases at some times (cases, n) [s], and their drive."""
        frequencies, tones = self.frequencies[cases], self.amplitudes[cases]
        phases = 2 * np.pi * frequencies[:, :, None] * times[:, None]
        waves = np.concatenate([np.cos(phases), -np.sin(phases)], axis=1)
        asked = {**transfers, "drive_voltage": _DRIVE}
        return {name: in_tones(each, frequencies.T, tones, waves) for name, each in asked.items()}
