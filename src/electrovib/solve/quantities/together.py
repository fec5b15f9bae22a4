"""Quantities of many scenarios that share parts.

Results that depend on these parts alone are computed once. Scenarios of one stack under sines in their periodic state are
solved at once, in arrays over all of them.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.physics.contact import FixedArea
from electrovib.physics.drive.parts import Tones
from electrovib.physics.drive.sines import Sine
from electrovib.physics.friction import SteadyFriction
from electrovib.physics.limits import MEAN_SQUARES
from electrovib.physics.time_profile import Steady
from electrovib.solve.choice import chosen, solve
from electrovib.solve.diagnostics import judge_run
from electrovib.solve.diagnostics.known import known_band, memory_diagnostics
from electrovib.solve.diagnostics.memory import errors_of_sines
from electrovib.solve.diagnostics.peaks import PeakRecord, refined
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.solution import PERIODIC, Solution, fields, linear_quantities, name_interface
from electrovib.solve.expanded import LATER_PERIODS
from electrovib.solve.mechanics.mechanical import mechanical, slowest_rates
from electrovib.solve.quantities.answer import Answer, answer, doubts
from electrovib.solve.quantities.pieces import tails, taken_of_many
from electrovib.solve.quantities.resolve import TOLERANCE, first_mesh, missed, solved, times_of_window
from electrovib.solve.stack.transfer import integral_weight

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Complex, Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.memory import Judged
    from electrovib.solve.expanded import Expanded
    from electrovib.solve.quantities.names import Named
    from electrovib.solve.quantities.pieces import Mesh
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.transfer import Transfer


FEWEST: Final = 2
"""Smallest number of scenarios that are computed at once."""
MOST: Final = 256
"""Largest number of scenarios that are held in memory together."""


class Together:
    """Scenarios of which the same quantities are requested.

    Parameters
    ----------
    members : sequence of Scenario
        Those that differ only in their drive share all other parts as the same objects.
    names : sequence of Named
        Quantities of each.

    Notes
    -----
    Scenarios that differ only in a sine are computed at once, in arrays over all of them; any other one separately, with
    the modes of a previous one that has the same stack.
    """

    def __init__(self, members: Sequence[Scenario], names: Sequence[Named]) -> None:
        self.members, self.names = members, names
        self._found: dict[int, Answer] = {}
        self._groups: dict[tuple[int, ...], list[int]] = {}
        for place, member in enumerate(members):
            self._groups.setdefault(_rest(member), []).append(place)
        self._expanded: dict[tuple[int, ...], Expanded] = {}
        self._apart = False

    def answer(self, place: int) -> Answer:
        """Return the quantities of one of the scenarios."""
        if place not in self._found:
            rest = _rest(self.members[place])
            group = self._groups[rest]
            expanded = solved(self.members[place], before=self._expanded.pop(rest, None))
            self._found |= self._at_once(expanded, group)
            if place not in self._found:
                self._found[place] = answer(expanded, self.names)
            group[:] = [each for each in group if each not in self._found]
            if group:
                self._expanded[rest] = expanded
        return self._found.pop(place)

    def _at_once(self, expanded: Expanded, group: list[int]) -> dict[int, Answer]:
        """Return the quantities of the scenarios of a group that share the band of this one; empty where none can be."""
        if self._apart or not is_of_sines(expanded.scenario):
            return {}
        members = [(place, self.members[place]) for place in group]
        some = [place for place, each in members if expanded.has_stack_of(each, times_of_window(each))][:MOST]
        if len(some) < FEWEST:
            return {}
        try:
            found = answers(expanded, [self.members[place] for place in some], self.names)
        except ElectrovibError:
            found = None  # computed separately, each scenario raises its own error
        self._apart = found is None
        return {} if found is None else dict(zip(some, found, strict=True))


def _rest(member: Scenario) -> tuple[int, ...]:
    """Return the identities of all parts of a scenario except its drive."""
    return tuple(id(part) for name, part in member if name not in {"drive", "title", "sources"})


def is_of_sines(scenario: Scenario) -> bool:
    """Return whether `answers` applies: linear layers in the periodic state of a sine, and mechanics without memory."""
    motion, friction = scenario.motion, scenario.friction
    return (
        type(scenario.drive) is Sine
        and not scenario.drive.offset
        and scenario.time.settled
        and chosen(scenario).method is PERIODIC
        and scenario.circuit.amplifier is None
        and isinstance(scenario.contact, FixedArea)
        and isinstance(friction, SteadyFriction)
        and scenario.finger is None
        and scenario.rig is None
        and motion.distance is None
        and isinstance(motion.time_profile, Steady)
        and isinstance(scenario.load.time_profile, Steady)
        and not slowest_rates(scenario)
        and all(getattr(scenario.limits, name) is None for name in MEAN_SQUARES)
    )


def answers(expanded: Expanded, members: Sequence[Scenario], names: Sequence[Named]) -> list[Answer] | None:
    """Compute quantities of scenarios that differ in the amplitude, frequency or phase of their sine."""
    scenario, section = expanded.scenario, expanded.section
    transfers = linear_quantities(scenario, section)
    if np.any(section.modes.charges) or any(integral_weight(each) for each in transfers.values()):
        return None
    meshes = [first_mesh(expanded, each) for each in members]
    if len({len(mesh.edges) for mesh in meshes}) > 1:
        return None
    parts = [part for each in members for part in each.drive.parts()]
    tones = [part for part in parts if isinstance(part, Tones)]
    if len(tones) < len(parts):  # an offset
        return None
    sines = Sines(
        np.concatenate([tone.frequencies for tone in tones]),
        np.concatenate([tone.amplitudes for tone in tones]),
    )
    if not np.all(sines.amplitude):
        return None
    group = _Group(expanded, members, sines, meshes, np.array([mesh.times() for mesh in meshes]), transfers)
    signals = group.signals()
    if signals is None:
        return None
    found = group.numbers(signals, names)
    return None if found is None else group.judged(signals, *found)


@dataclass(frozen=True)
class _Group:
    """Cases of one stack, each under its own sine, with equal numbers of times."""

    expanded: Expanded
    members: Sequence[Scenario]
    sines: Sines
    meshes: list[Mesh]
    times: Real
    transfers: Mapping[Key, Transfer]

    @functools.cached_property
    def cases(self) -> Indices:
        """Index of the case of each time."""
        return np.repeat(np.arange(len(self.times)), self.times.shape[1])

    @functools.cached_property
    def waves(self) -> tuple[Real, Real]:
        """Cosine and sine of the phase at all times."""
        return self.sines.waves(self.cases, self.times.ravel())

    @functools.cached_property
    def weights(self) -> dict[Key, Complex]:
        """Complex amplitudes of all quantities that are linear in the drive."""
        return self.sines.weights(self.transfers) | {"drive_voltage": self.sines.amplitude}

    @functools.cached_property
    def solution(self) -> Solution:
        """Responses of the stack to the sines, one case after the other."""
        scenario, first = self.expanded.scenario, self.times[0, :1]
        found = rows_of(self.weights, self.cases, self.waves)
        name_interface(scenario, found)
        reason = solve(scenario, self.expanded.section, first, force_alone=True).reason
        solution = Solution(found=found, method=PERIODIC, reason=reason)
        return replace(solution, force=attraction(scenario, total_pull(scenario, solution.amplitudes())))

    def signals(self) -> dict[str, Any] | None:
        """Return all signals, one case after the other; None where the mechanics has diagnostics of its own."""
        moved = mechanical(self.expanded.scenario, self.times.ravel(), self.solution, lambda _: self.solution)
        if moved.diagnostics or moved.how:
            return None
        return self.solution.signals(tuple(self.expanded.section.names)) | moved.signals

    def numbers(
        self, signals: dict[str, Any], names: Sequence[Named]
    ) -> tuple[list[dict[str, float]], list[dict[str, float]]] | None:
        """Return quantities and relative errors of every case; None where the pieces do not resolve a signal."""
        values: list[dict[str, float]] = [{} for _ in self.members]
        errors: list[dict[str, float]] = [{} for _ in self.members]
        for each in names:
            if each.signal not in signals:
                return None
            dims, row = signals[each.signal]
            row = row[list(self.expanded.section.names).index(each.layer)] if "layer" in dims else row
            series = [
                mesh.series(own) for mesh, own in zip(self.meshes, row.reshape(self.times.shape), strict=True)
            ]
            whole = np.array(series)
            sizes = np.max(np.abs(whole).sum(axis=2), axis=1)
            open_ = (
                tails(whole.reshape(-1, whole.shape[2])).reshape(len(series), -1) > TOLERANCE * sizes[:, None]
            )
            if not np.all(np.isfinite(whole)) or np.any(open_):
                return None
            found = taken_of_many(each.taken, self.meshes, whole)
            for case, (mesh, own) in enumerate(zip(self.meshes, series, strict=True)):
                values[case][each.name], errors[case][each.name] = float(found[case]), missed(mesh, own)
        return values, errors

    def judged(
        self, signals: dict[str, Any], values: list[dict[str, float]], errors: list[dict[str, float]]
    ) -> list[Answer]:
        """Return quantities and diagnostics of every case."""
        expanded, count = self.expanded, self.times.shape[1]
        scenario, known = expanded.scenario, known_band(expanded.scenario)
        later = self.times + LATER_PERIODS / self.sines.frequency[:, None]
        off: list[dict[Key, Judged]] = [{} for _ in self.members]
        if expanded.reduction_error:
            off = errors_of_sines(
                self.members, expanded.section, self.solution, later, known=known, respond=self._respond
            )
        rows = PeakRecord.of(scenario, self.times.ravel(), self.solution.found).rows
        split = {name: row.reshape(self.times.shape) for name, row in rows.items()}
        records = [
            PeakRecord(times, {name: row[case] for name, row in split.items()})
            for case, times in enumerate(self.times)
        ]
        peaks = refined(records, self._look)
        over_frequency = scenario.force.diagnostics_over_frequency(expanded.declared)
        how, found = self.solution.how(), []
        for case, member in enumerate(self.members):
            some = slice(case * count, (case + 1) * count)
            own = {name: (dims, row[..., some]) for name, (dims, row) in signals.items()}
            diagnostics = [
                *judge_run(member, expanded.section, peaks[case], self.times[case], own),
                *memory_diagnostics(member, off[case], later[case], known=known, method=PERIODIC),
                *over_frequency,
                *doubts(values[case], errors[case]),
            ]
            found.append(Answer(values[case], errors[case], how | expanded.stated(off[case]), diagnostics))
        return found

    def _respond(self, transfers: Mapping[Key, Transfer]) -> dict[Key, Real]:
        """Return the responses of other linear quantities to all sines."""
        return rows_of(self.sines.weights(transfers), self.cases, self.waves)

    def _look(self, cases: Indices, times: Real) -> dict[Key, Real]:
        """Return the quantities with limits of some cases at other times [s]."""
        wanted = fields(self.expanded.scenario, self.expanded.section)
        weights = {name: self.weights[name] for name in (*wanted, "drive_voltage")}
        found = rows_of(weights, cases, self.sines.waves(cases, times))
        name_interface(self.expanded.scenario, found)
        return PeakRecord.of(self.expanded.scenario, times, found).rows


@dataclass(frozen=True)
class Sines:
    """Sines that drive one stack, one in each case.

    Parameters
    ----------
    frequency : ndarray, shape (cases,)
        Frequencies [Hz].
    amplitude : ndarray of complex, shape (cases,)
        Complex amplitudes: peak values with phase [V].
    """

    frequency: Real
    amplitude: Complex

    def weights(self, transfers: Mapping[Key, Transfer]) -> dict[Key, Complex]:
        """Return the complex amplitudes of linear quantities in every case."""
        return {name: each.at(self.frequency) * self.amplitude for name, each in transfers.items()}

    def waves(self, cases: Indices, times: Real) -> tuple[Real, Real]:
        """Return cosine and sine of the phase of some cases at some times.

        `cases` (n,), `times` (n,) [s]; returns `cosine`, `sine` (n,).
        """
        phase = 2 * np.pi * self.frequency[cases] * times
        return np.cos(phase), np.sin(phase)


def rows_of(weights: Mapping[Key, Complex], cases: Indices, waves: tuple[Real, Real]) -> dict[Key, Real]:
    """Return linear quantities of the cases (n,) at the phases of `waves` from their complex amplitudes."""
    cosine, sine = waves
    return {name: each.real[cases] * cosine - each.imag[cases] * sine for name, each in weights.items()}
