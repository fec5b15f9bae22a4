"""Cases on a mesh: quantities of many scenarios from polynomials in arrays with an axis of cases.

Points that differ in numbers share one mesh (`on_meshes`); scenarios of one stack under tones in their periodic state have
meshes of equal size, each its own (`answers`). What a mesh does not resolve is solved one by one.
"""

from __future__ import annotations

import contextlib
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
from electrovib.solve.population.fingers import TOGETHER, Population
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
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Complex, Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.probes import Judged
    from electrovib.solve.expanded import Expanded
    from electrovib.solve.one_by_one import ParametricScenario
    from electrovib.solve.quantities.names import Named
    from electrovib.solve.stack.keys import Key

_CHUNK: Final = 1024
"""Points whose signals are in memory together, at most."""
_NUMBERS: Final = 1_000_000
"""Numbers of these signals, about."""
_PROBES: Final = 32
"""Points on which a mesh is refined."""
_ROUNDS: Final = 8
"""Largest number of rounds in which pieces of a mesh are halved."""
_MOST_NUMBERS: Final = 4_000_000
"""Numbers of their signals, beyond which it is not refined."""
_MOST_OPEN: Final = 0.5
"""Share of these points that a mesh may leave unresolved."""
_MESHES: Final = 4
"""Meshes that are tried, each for the points that the one before does not resolve."""
FEWEST_POINTS: Final = 32
"""Smallest number of points for which a mesh is made; fewer are evaluated one by one."""
_ROUNDED: Final = 1e-9
"""Most that the rounding of late times may add to the tolerance: points at once are those of each alone within it."""
FEWEST: Final = 2
"""Smallest number of scenarios under tones that are computed at once."""
MOST: Final = 1 << 15
"""Number of times of all scenarios that are in memory together, about."""
_DRIVE: Final = Transfer(rates=np.zeros(0), gains=np.zeros(0), direct=1.0)


def on_meshes(
    prepared: ParametricScenario,
    names: Sequence[Named],
    draws: Mapping[str, Real],
    found: Mapping[str, Real],
    report: Callable[[int, int], None],
) -> Indices:
    """Write the quantities of the points that a mesh resolves, each (points,), and return the other points."""
    count = len(next(iter(draws.values())))
    left = np.arange(count)
    for _ in range(_MESHES):
        if (
            len(left) < FEWEST_POINTS
            or (made := _mesh(prepared, names, of_points(draws, _probes(draws, left)))) is None
        ):
            break
        mesh, many = made
        size = max(1, min(_CHUNK, _NUMBERS // (len(mesh.times()) * len(many.names))))
        open_ = [left[:0]]
        for start in range(0, len(left), size):
            report(count - len(left) + start - sum(map(len, open_)), count)
            some = left[start : start + size]
            series = _series(mesh, many, names, of_points(draws, some))
            for each in names:
                found[each.name][some] = taken_from(each.taken, mesh, series[each.key])
            open_.append(some[~_resolved(mesh, series).all(axis=1)])
        left = np.concatenate(open_)
    return left


def population_on(
    prepared: ParametricScenario, names: Sequence[Named], mesh: Mesh, *, compared: bool = False
) -> Population:
    """Return the signals of points at the times of a mesh, whose materials are reduced as those of the scenario.

    With `compared` arrays were found to agree with fingers one by one on another mesh.
    """
    signals, band = tuple(dict.fromkeys(each.signal for each in names)), times_of_window(prepared.base)
    return Population(
        prepared.base, free=prepared.free, signals=signals, time=mesh.times(), band=band, compared=compared
    )


def _mesh(
    prepared: ParametricScenario, names: Sequence[Named], draws: Mapping[str, Real]
) -> tuple[Mesh, Population] | None:
    """Return a mesh that resolves some points, or None where they are not computed together on it.

    The first pieces are those of the point with the fastest mode among the ends of the parameters.
    """
    ends = (prepared.scenario({path: float(row[end]) for path, row in draws.items()}) for end in _ends(draws))
    runs = [solved(each, mechanics=False) for each in ends]
    mesh = first_mesh(max(runs, key=lambda run: float(np.max(run.section.modes.rates, initial=0.0))))
    for further in reversed(range(_ROUNDS)):
        many = population_on(prepared, names, mesh, compared=True)
        if many.method != TOGETHER:
            return None
        open_ = np.logical_not(_resolved(mesh, _series(mesh, many, names, draws)))
        finer = mesh.halved(np.any(open_, axis=0))
        if not open_.any() or not further or len(finer.times()) * len(open_) > _MOST_NUMBERS:
            break
        mesh = finer
    return (mesh, many) if np.mean(open_.any(axis=1)) <= _MOST_OPEN else None


def _series(
    mesh: Mesh, many: Population, names: Sequence[Named], draws: Mapping[str, Real]
) -> dict[tuple[str, str], Real]:
    """Return the polynomials (points, pieces, nodes) of the signals of which quantities are taken, by their keys."""
    found, layers = many.signals(draws), list(many.scenario.stack.layers)
    keys = dict.fromkeys(each.key for each in names)
    rows = {(name, of): found[name][:, layers.index(of)] if of else found[name] for name, of in keys}
    return {key: mesh.series(row) for key, row in rows.items()}


def _resolved(mesh: Mesh, series: Mapping[tuple[str, str], Real]) -> NDArray[np.bool_]:
    """Return which pieces of each case resolve all signals, shape (cases, pieces), up to the rounding of their times."""
    rounding = np.spacing(mesh.edges[..., 1:]) / mesh.lengths
    found = []
    for each in series.values():
        sizes = np.abs(each)
        largest = np.max(sizes.sum(axis=-1), axis=-1, keepdims=True)
        moved = sizes[..., 1:].sum(axis=-1) / np.where(largest > 0, largest, 1.0)
        found.append(relative_tails(each) <= TOLERANCE + np.minimum(rounding * moved, _ROUNDED))
    return np.asarray(np.all(found, axis=0))


def of_points(draws: Mapping[str, Real], points: Indices) -> dict[str, Real]:
    """Return the values of some points [SI units]."""
    return {path: values[points] for path, values in draws.items()}


def _probes(draws: Mapping[str, Real], points: Indices) -> Indices:
    """Return some of the points: evenly spaced ones, and those with the smallest and the largest value of a parameter."""
    spaced = np.arange(0, len(points), -(-len(points) // _PROBES))
    return points[np.union1d(spaced, _ends(of_points(draws, points)))]


def _ends(draws: Mapping[str, Real]) -> list[int]:
    """Return the points with the smallest and the largest value of each parameter."""
    return [int(end(values)) for values in draws.values() for end in (np.argmin, np.argmax)]


def answers(members: Sequence[Scenario], names: Sequence[Named]) -> Iterator[QuantityNumbers]:
    """Yield the quantities of one scenario after the other; those that share a part have it as the same object."""
    groups: dict[tuple[int, ...], list[int]] = {}  # equal in all parts except the drive
    for place, member in enumerate(members):
        groups.setdefault(_rest(member), []).append(place)
    before: dict[tuple[int, ...], Expanded] = {}
    found: dict[int, QuantityNumbers | None] = {}
    for place, member in enumerate(members):
        rest = _rest(member)
        own = found.get(place)
        if own is None:
            before[rest] = expanded = solved(member, before=before.pop(rest, None))
            if names and place not in found and is_of_tones(member):
                left = (each for each in groups[rest] if each not in found)
                found |= _together(expanded, {each: members[each] for each in left}, names)
                own = found.get(place)
        yield answer(before[rest], names) if own is None else own
        found[place] = None
        if place == groups[rest][-1]:
            before.pop(rest, None)


def _together(
    expanded: Expanded, members: Mapping[int, Scenario], names: Sequence[Named]
) -> dict[int, QuantityNumbers | None]:
    """Compute scenarios that have the stack of this one, as many as memory holds; None of one that is to be solved alone."""
    cases: dict[int, _Case] = {}
    for place, member in members.items():
        case = _Case.of(expanded, member)
        if case is not None and case.shape == next(iter(cases.values()), case).shape:
            cases[place] = case
            if (len(cases) + 1) * case.shape[0] > MOST:
                break
    if len(cases) >= FEWEST:
        # computed alone, each scenario raises its own error
        with contextlib.suppress(ElectrovibError, KeyError):
            found = _Cases(expanded, [*cases.values()]).answers(names)
            return dict(zip(cases, found, strict=True))
    return dict.fromkeys(cases)


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
        series = {
            key: self.mesh.series(np.array([values_of(each, self.expanded, key) for each in records]))
            for key in dict.fromkeys(each.key for each in names)
        }
        finite = [np.isfinite(each).all(axis=(1, 2)) for each in series.values()]
        known = np.all([*finite, _resolved(self.mesh, series).all(axis=1)], axis=0)
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
            for case, (run, resolved) in enumerate(zip(self.runs, known, strict=True))
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
        return {name: _in_tones(each, frequencies, tones, waves) for name, each in asked.items()}


def _in_tones(transfer: Transfer, frequencies: Real, tones: Complex, waves: Real) -> Real:
    """Return the response of cases to sines that have always been on, shape (cases, n).

    `frequencies`, `tones` (cases, tones) [Hz, V]; `waves` (cases, 2 tones, n), cosines and minus sines.
    """
    gain = np.stack([np.atleast_1d(transfer.at(each)) for each in frequencies.T], axis=1)
    own = gain * tones
    shares = np.concatenate([own.real, own.imag], axis=1)
    return np.asarray((shares[:, None] @ waves)[:, 0])
