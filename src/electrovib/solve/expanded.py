"""A scenario prepared for evaluation at any times: signals and their diagnostics.

A record is walked once: signals, attraction, friction without memory and largest values, in stretches that fit the cache.
"""

from __future__ import annotations

import copy
import functools
import math
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.solve.choice import along, chosen, refuse_unsolved, solve
from electrovib.solve.diagnostics.judge import at_moments, judge_run, watched
from electrovib.solve.diagnostics.memory import (
    CURRENT,
    answer_errors,
    extremes,
    jump_errors,
    known_band,
    memory_diagnostics,
)
from electrovib.solve.diagnostics.memory import FORCE as OF_FORCE
from electrovib.solve.diagnostics.peaks import (
    Largest,
    PeakRecord,
    around_kinks,
    evaluation_times,
    frequency_beside,
    joined,
    resolved,
    shows_every_sample,
)
from electrovib.solve.effort import last_time, refuse_large
from electrovib.solve.electrics.over_frequency import capacitance
from electrovib.solve.electrics.solution import ACROSS, OF_LAYERS, Solution
from electrovib.solve.mechanics.closed_form import attraction_in_pieces
from electrovib.solve.mechanics.mechanical import (
    BEHIND_FILTERS,
    Mechanics,
    is_instant,
    mechanical,
    refuse_unsolved_mechanics,
)
from electrovib.solve.stack.expand import band_of_run, modes, phasors
from electrovib.solve.stack.keys import AmplitudeOf

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.physics.force import ForceLaw
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.probes import Extremes, Judged
    from electrovib.solve.mechanics.closed_form import ExponentialSum
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection, PhasorSection

_PAGE: Final = (2 << 20) // 8
"""Numbers in a large page of memory."""
WHOLE: Final = ("voltage", "current", "body_current")
"""Quantities with limits that are judged at all times."""


class Walked(NamedTuple):
    """Electrical response at the output times, largest values between them, and the mechanics where it needs no memory."""

    answer: Solution
    peaks: PeakRecord
    moved: Mechanics | None


def walked(
    scenario: Scenario, section: ModalSection, times: Real, extremes: Extremes | None = None
) -> Walked:
    """Compute a response at the output times, and its largest values between them.

    `times` (n,) [s]; `extremes` takes the smallest and largest values between the probes.

    A solver in closed form is evaluated again at further times; a time-stepping solver returns all times of one run, and an
    amplifier with limits in a second run the values around the times at which it reaches or leaves a limit.
    """
    if chosen(scenario).method.is_marched:
        return _marched(scenario, section, times)
    course, largest = along(scenario, section, times), Largest()
    rows = _Rows(len(times), section.names, course.known)
    moved = Mechanics() if is_instant(scenario) else None
    answer, follows = None, _Rows(len(times))
    for first in range(0, len(times), course.stretch):
        stretch = slice(first, min(first + course.stretch, len(times)))
        answer = course.through(stretch)
        largest.take(first, PeakRecord.of(scenario, times[stretch], answer.found).rows)
        if extremes is not None:
            extremes.take(first, answer.found | {OF_FORCE: answer.attraction})
        if moved is not None:
            own = mechanical(scenario, times[stretch], answer, functools.partial(solve, scenario, section))
            follows.put(stretch, {name: row for name, (_, row) in own.signals.items()})
        rows.put(stretch, answer.found | {OF_FORCE: answer.attraction})
    assert answer is not None
    if moved is not None:
        moved.add(follows.whole)
    force = rows.whole.pop(OF_FORCE)
    answer = replace(answer, found=rows.whole, force=force, of_layers=rows.of_layers)

    def look(moments: Real) -> PeakRecord:
        return PeakRecord.of(scenario, moments, course.at(moments))

    wanted = _further(scenario, times)
    if shows_every_sample(scenario.drive, times):
        wanted = np.union1d(wanted, largest.just_beside(times))
    between = wanted[times[np.minimum(np.searchsorted(times, wanted), len(times) - 1)] != wanted]
    record = _record(scenario, times, answer, largest.kept(times, between))
    return Walked(answer, resolved(joined(record, between, look), look), moved)


def _further(scenario: Scenario, times: Real) -> Real:
    """Return the times at which a response can be largest [s]."""
    beside = frequency_beside(scenario)
    settled = scenario.time.settled
    return evaluation_times(scenario.drive, end=float(times[-1]), settled=settled, beside=beside, seen=times)


def _record(scenario: Scenario, times: Real, answer: Solution, kept: Any) -> PeakRecord:
    """Return the quantities with limits at the times that are kept."""
    if len(kept) == len(times):
        return PeakRecord.of(scenario, times, answer.found)
    found = {key: row[kept] for key, row in answer.found.items() if not isinstance(key, AmplitudeOf)}
    record = PeakRecord.of(scenario, times[kept], found)
    voltage = answer.found.get("plate_voltage", answer.found["drive_voltage"])
    current = answer.found.get("amplifier_current", answer.found["current"])
    whole: dict[Key, Real] = dict(zip(WHOLE, (voltage, current, answer.found["current"]), strict=True))
    return replace(record, whole=PeakRecord(times, whole))


def _marched(scenario: Scenario, section: ModalSection, times: Real) -> Walked:
    """Return the response of a solver that steps through time, at the output times and between them.

    A second run around the changes of regimes resolves the largest values too; without one these are those of a parabola.
    """
    both = np.union1d(times, _further(scenario, times))
    whole = solve(scenario, section, both)
    record = PeakRecord.of(scenario, both, whole.found)
    unclear = record.unclear() if whole.method.by_regimes and whole.kinks else np.zeros(0)
    around = np.setdiff1d(np.append(around_kinks(np.array(whole.kinks), float(times[-1])), unclear), both)
    peaks = joined(record, around, lambda moments: at_moments(scenario, section, moments))
    return Walked(whole.at(np.searchsorted(both, times)), peaks, None)


class _Rows:
    """Rows over all times, filled stretch by stretch; those of all layers are rows of one array, as in a Trace."""

    def __init__(
        self, count: int, layers: Sequence[str] = (), known: Mapping[Any, Real] = MappingProxyType({})
    ) -> None:
        self.count, self.layers, self.known = count, layers, known
        self.whole: dict[Any, Real] = {}
        self.of_layers: dict[str, Real] = {}

    def put(self, stretch: slice, rows: Mapping[Any, Real]) -> None:
        """Store the rows of a stretch; those of a record in one stretch are kept as they are."""
        if stretch == slice(0, self.count):
            self.whole = dict(rows)
            return
        if not self.whole:
            self._begin(rows)
        for key, row in rows.items():
            if key not in self.known:
                self.whole[key][stretch] = row

    def _begin(self, rows: Mapping[Any, Real]) -> None:
        """Make room for rows that are not known; an amplitude of the law that is another row itself shares its room."""
        self.whole |= self.known
        for quantity, key in OF_LAYERS.items():
            names = [key(name) for name in self.layers]
            if names and all(name in rows for name in names):
                self.of_layers[quantity] = _room(len(names), self.count)
                self.whole |= zip(names, self.of_layers[quantity], strict=True)
        places = {id(row): key for key, row in rows.items() if not isinstance(key, AmplitudeOf)}
        for key, row in rows.items():
            if isinstance(key, AmplitudeOf) and id(row) in places:
                continue
            if key not in self.whole:
                self.whole[key] = _room(self.count)
        for key in rows.keys() - self.whole.keys():
            self.whole[key] = self.whole[places[id(rows[key])]]


def _room(*shape: int) -> Real:
    """Return room for numbers that begins where a large page of memory does: the system then provides it in few steps."""
    count = math.prod(shape)
    space = np.empty(count + _PAGE)
    first = -(space.ctypes.data // space.itemsize) % _PAGE
    return space[first : first + count].reshape(shape)


OF_STACK: Final = ("stack", "circuit")
OF_ATTRACTION: Final = ("drive", "force", "contact", "load", "motion", "time")
OF_MECHANICS: Final = ("friction", "motion", "finger", "rig", "load", "contact", "time")
"""Parts of a scenario on which the modes depend, those on which the attraction depends besides, and those of the mechanics."""
FORCE: Final = frozenset({"electrostatic_force"})
OF_ELECTRICS: Final = FORCE | {*ACROSS, "field", "displacement", "capacitance"}
"""Signals that are independent of the mechanics."""
LATER_PERIODS: Final = 10
"""Periods by which the times of a periodic state are shifted before its errors are judged."""


@dataclass(frozen=True, kw_only=True)
class Record:
    """Signals of a scenario at some times.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing [s].
    solution : Solution
        Electrical response of the stack.
    signals : dict
        Dimensions and values of every signal over time, in its unit.
    how : dict
        Solver, reason for its choice, errors and events.
    diagnostics : list of Diagnostic
        Diagnostics of the mechanics.
    peaks : PeakRecord or None
        Quantities with limits over the whole run; None where these times resolve them.
    errors : tuple or None
        Times [s], and the errors there of the quantities due to the reduction of materials; None where they were not computed.
    noted : Extremes or None
        Extremes of a long record between the times at which such errors are computed.
    """

    times: Real
    solution: Solution
    signals: dict[str, Any]
    how: dict[str, Any]
    diagnostics: list[Diagnostic]
    peaks: PeakRecord | None = None
    errors: tuple[Real, Mapping[Key, Judged]] | None = None
    noted: Extremes | None = None


class Last(NamedTuple):
    """Times of an electrical response, the electrical signals that were asked for, None for all, and the response."""

    times: Real
    asked: frozenset[str] | None
    solution: Solution

    def holds(self, asked: frozenset[str] | None) -> bool:
        """Return whether it has the signals that are asked for."""
        return self.asked is None or (asked is not None and asked <= self.asked)


class Expanded:
    """A scenario with its stack in relaxation modes, which can be evaluated at any times.

    Parameters
    ----------
    scenario : Scenario
        Experiment.
    times : ndarray, shape (n,), optional
        Times of a run [s], over whose band materials are reduced to Debye terms; by default those of the scenario.
    before : Expanded, optional
        That of a scenario which shares parts with this one, as `with_numbers` makes them: results that depend on those
        parts alone are reused.
    mechanics : bool
        Whether signals of friction, finger or rig will be requested.

    Attributes
    ----------
    section : ModalSection
        The stack as relaxation modes.
    reduction_error : float
        Largest relative error of a bound permittivity reduced to Debye terms [1].
    last : Last or None
        The last electrical response.
    closed : (float, ExponentialSum or None) or None
        Last time of the attraction in closed form [s], and that form; None in its place where there is none.

    Raises
    ------
    BudgetError
        If a run would take more time or memory than is allowed; raised before any computation.
    """

    def __init__(
        self,
        scenario: Scenario,
        times: Real | None = None,
        *,
        before: Expanded | None = None,
        mechanics: bool = True,
    ) -> None:
        refuse_unsolved(scenario)
        if mechanics and not (before and _share(scenario, before.scenario, OF_MECHANICS)):
            refuse_unsolved_mechanics(scenario, end=last_time(scenario, times))
        if before is None or not _as_long(scenario, before.scenario):
            refuse_large(scenario, times)
        self.scenario: Scenario = scenario
        self.times: Real = scenario.time.times(scenario.drive) if times is None else times
        self.last: Last | None = None
        self.closed: tuple[float, ExponentialSum | None] | None = None
        if before is not None and before.has_stack_of(scenario, self.times):
            self.section: ModalSection = before.section
            self.reduction_error: float = before.reduction_error
            if _share(scenario, before.scenario, OF_ATTRACTION):
                self.last, self.closed = before.last, before.closed
        else:
            self.section, self.reduction_error = modes(scenario, self.times)

    def has_stack_of(self, scenario: Scenario, times: Real) -> bool:
        """Return whether another scenario has the same stack in the same circuit.

        `times` (n,) [s].
        """
        own = self.scenario
        return (
            _share(scenario, own, OF_STACK)
            and scenario.contact_area == own.contact_area
            and scenario.drive.quantity == own.drive.quantity
            and (not self.reduction_error or band_of_run(scenario, times) == self._band)
        )

    def before(self, scenario: Scenario) -> Expanded:
        """Return the same response of the stack before the friction, finger and rig of another scenario, equal in all else."""
        refuse_unsolved_mechanics(scenario, end=last_time(scenario, self.times))
        found = copy.copy(self)
        found.scenario = scenario
        return found

    def under(self, scenario: Scenario, times: Real) -> Expanded:
        """Return the same stack under the drive of another scenario, which differs in nothing else; `times` as for a new one."""
        _ = self.over_frequency  # with which every copy begins
        found = copy.copy(self)
        found.scenario, found.times, found.last, found.closed = scenario, times, None, None
        return found

    @functools.cached_property
    def _band(self) -> tuple[float, float]:
        return band_of_run(self.scenario, self.times)

    @functools.cached_property
    def declared(self) -> PhasorSection:
        """Stack over the scenario's frequencies, without leaks, exact for the materials as declared."""
        return phasors(self.scenario, self.scenario.frequency.frequencies(), leaks=False)

    def at(self, times: Real, *, closely: bool = False, wanted: Collection[str] | None = None) -> Record:
        """Compute signals over time.

        `times` (n,) [s].
        """
        scenario, section = self.scenario, self.section
        asked = None if wanted is None else frozenset(wanted)
        peaks: PeakRecord | None = None
        noted: Extremes | None = None
        moved: Mechanics | None
        method = chosen(scenario).method
        if closely:
            if self.reduction_error:
                noted = extremes(scenario, times, known_band(scenario))
            solution, peaks, moved = walked(scenario, section, times, noted)
        elif asked is not None and asked <= BEHIND_FILTERS and method.by_modes:
            solution, moved = Solution(found={}, method=method, reason=""), None if asked else Mechanics()
        else:
            solution = self._solution(times, asked and asked & OF_ELECTRICS - FORCE)
            moved = Mechanics() if asked is not None and asked <= OF_ELECTRICS else None
        if moved is None:
            between = functools.partial(solve, scenario, section, asked=())
            moved = mechanical(scenario, times, solution, between, closed=self._closed, wanted=asked)
        read = capacitance(scenario, times) if asked is None or "capacitance" in asked else {}
        return Record(
            times=times,
            solution=solution,
            signals=solution.signals(tuple(section.names)) | read | moved.signals,
            how=solution.how() | moved.how,
            diagnostics=moved.diagnostics,
            peaks=peaks,
            noted=noted,
        )

    def _solution(self, times: Real, asked: frozenset[str] | None) -> Solution:
        """Return the electrical response; the previous one where nothing that it depends on has changed."""
        if self.last is None or not (self.last.holds(asked) and np.array_equal(self.last.times, times)):
            self.last = Last(times, asked, solve(self.scenario, self.section, times, asked=asked))
        return self.last.solution

    def _closed(self, end: float) -> ExponentialSum | None:
        """Return the attraction up to a time in closed form; the previous one where nothing that it depends on has changed."""
        if self.closed is None or self.closed[0] != end:
            self.closed = end, attraction_in_pieces(self.scenario, self.section, end=end)
        return self.closed[1]

    def judge(
        self, record: Record, squared: Callable[[Expanded, PeakRecord], Mapping[str, float]]
    ) -> tuple[list[Diagnostic], dict[str, float]]:
        """Return the diagnostics and errors of a record."""
        scenario, known = self.scenario, known_band(self.scenario)
        times, errors = record.errors or self._errors(record, known)
        peaks = record.peaks or watched(scenario, self.section, record.times, record.solution)
        found = [
            *judge_run(scenario, self.section, peaks, record.times, record.signals, squared(self, peaks)),
            *memory_diagnostics(scenario, errors, times, known=known, method=record.solution.method),
            *record.diagnostics,
            *self.over_frequency[1],
        ]
        return found, self.stated(errors)

    def _errors(self, record: Record, known: tuple[float, float]) -> tuple[Real, dict[Key, Judged]]:
        """Return the errors due to the reduction of materials, and the times of which they are."""
        seen = self._seen(record)
        if not self.reduction_error:
            return seen.times, {}
        times = seen.times[None]
        (errors,) = answer_errors(
            [self.scenario], self.section, seen.solution, times, known=known, noted=seen.noted
        )
        jumps = jump_errors(self.scenario, self.section, record.solution, record.times, known)
        return seen.times, {name: each._replace(jump=jumps.get(name, 0.0)) for name, each in errors.items()}

    def stated(self, errors: Mapping[Key, Judged]) -> dict[str, float]:
        """Return the errors that a Trace states."""
        found = {"reduction_error": self.reduction_error}
        if self.scenario.force.causal:
            found["transfer_error"] = max(self.over_frequency[0], worst_of(errors))
        if OF_FORCE in errors:
            found["attraction_error"] = max(errors[OF_FORCE].of_peak, errors[OF_FORCE].jump)
        return found

    @functools.cached_property
    def over_frequency(self) -> tuple[float, tuple[Diagnostic, ...]]:
        """Error of the law's amplitudes over frequency [1], and the diagnostics of the law over frequency."""
        law, known = self.scenario.force, known_band(self.scenario)
        error = transfer_error(law, self.section, self.declared, known) if law.causal else 0.0
        return error, law.diagnostics_over_frequency(self.declared)

    def _seen(self, record: Record) -> Record:
        """Return the record without times nearer to a corner than those for which the materials were reduced."""
        if record.times is self.times or not self.reduction_error:
            return record
        drive, settled = self.scenario.drive, self.scenario.time.settled
        corners = np.append([] if settled else [0.0], drive.corners(float(record.times[-1]))[0])
        reduced_for = since_corners(corners, self.times)
        kept = since_corners(corners, record.times) >= np.min(reduced_for[reduced_for > 0], initial=np.inf)
        kept = kept if np.any(kept) else np.ones(len(kept), bool)
        later = 0.0
        if settled:
            # one period represents all of them: the remaining amplitude is never that at the end of the record
            later = LATER_PERIODS * (drive.period or 0.0)
        return replace(
            record,
            times=record.times[kept] + later,
            solution=record.solution.at(np.flatnonzero(kept)),
            signals={},
            diagnostics=[],
            peaks=None,
            noted=None,
        )


def _share(one: Scenario, other: Scenario, parts: tuple[str, ...]) -> bool:
    """Return whether two scenarios have the same objects as parts."""
    return all(getattr(one, name) is getattr(other, name) for name in parts)


def _as_long(one: Scenario, other: Scenario) -> bool:
    """Return whether the estimates of a run are equal for two scenarios."""
    drives = [(each.duration, each.period, each.highest_frequency) for each in (one.drive, other.drive)]
    return drives[0] == drives[1] and _share(one, other, ("motion", "time"))


def since_corners(corners: Real, times: Real) -> Real:
    """Return the time since the last corner [s], infinite before the first; both arrays increase."""
    last = np.append(-np.inf, corners)[np.searchsorted(corners, times, side="right")]
    return np.asarray(times - last)


def worst_of(errors: Mapping[Key, Judged]) -> float:
    """Return the largest relative error of fields, voltages and attraction [1]; that of the current is reported apart."""
    judged = [found for name, found in errors.items() if name != CURRENT]
    return max((max(found.error, found.jump) for found in judged), default=0.0)


def transfer_error(
    law: ForceLaw, section: ModalSection, exact: PhasorSection, known: tuple[float, float]
) -> float:
    """Return the largest error of a law's amplitudes over frequency, with materials as sums of Debye terms."""
    reduced, declared = law.amplitudes(section), law.amplitudes(exact)
    inside = (exact.frequency >= known[0]) & (exact.frequency <= known[1])
    if not np.any(inside):
        return math.nan
    errors = []
    for name, value in declared.items():
        scale = float(np.max(np.abs(value)))
        difference = reduced[name].at(exact.frequency[inside]) - value[inside]
        errors.append(float(np.max(np.abs(difference))) / (scale or 1.0))
    return max(errors)
