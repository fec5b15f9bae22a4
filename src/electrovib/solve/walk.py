"""A record walked once: signals, attraction, friction without memory and largest values, in stretches that fit the cache."""

from __future__ import annotations

import functools
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.solve.choice import along, chosen, solve
from electrovib.solve.diagnostics.judge import at_moments
from electrovib.solve.diagnostics.memory import FORCE
from electrovib.solve.diagnostics.peaks import (
    Largest,
    PeakRecord,
    around_kinks,
    evaluation_times,
    joined,
    resolved,
    shows_every_sample,
)
from electrovib.solve.electrics.solution import OF_LAYERS
from electrovib.solve.mechanics.mechanical import Mechanics, is_instant, mechanical
from electrovib.solve.stack.keys import AmplitudeOf

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.probes import Extremes
    from electrovib.solve.electrics.solution import Solution
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection

SQUEEZED: Final = 8
"""Multiple of the frequency of a moving gap that is resolved: the field, which varies as 1/gap, has sharper peaks."""
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
            extremes.take(first, answer.found | {FORCE: answer.attraction})
        if moved is not None:
            own = mechanical(scenario, times[stretch], answer, functools.partial(solve, scenario, section))
            follows.put(stretch, {name: row for name, (_, row) in own.signals.items()})
        rows.put(stretch, answer.found | {FORCE: answer.attraction})
    assert answer is not None
    if moved is not None:
        moved.add(follows.whole)
    force = rows.whole.pop(FORCE)
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
    moved = scenario.motion.moved_gap
    beside = 0.0 if moved is None else SQUEEZED * moved.fastest
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
    """Return the response of a solver that steps through time, at the output times and between them."""
    both = np.union1d(times, _further(scenario, times))
    whole = solve(scenario, section, both)
    record = PeakRecord.of(scenario, both, whole.found)
    around = np.setdiff1d(around_kinks(np.array(whole.kinks), float(times[-1])), both)
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
                self.of_layers[quantity] = np.empty((len(names), self.count))
                self.whole |= zip(names, self.of_layers[quantity], strict=True)
        places = {id(row): key for key, row in rows.items() if not isinstance(key, AmplitudeOf)}
        for key, row in rows.items():
            if isinstance(key, AmplitudeOf) and id(row) in places:
                continue
            self.whole.setdefault(key, np.empty(self.count))
        for key in rows.keys() - self.whole.keys():
            self.whole[key] = self.whole[places[id(rows[key])]]
