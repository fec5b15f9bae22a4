"""Largest values of solutions: the times between the output times at which they are sought, and what is found there."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.physics.safety import breakdown_share, paschen_voltage
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import DisplacementOf, FieldOf

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.keys import Key

PER_CYCLE = 64
"""Evaluation times in a cycle of the fastest oscillation of the drive; a parabola through three has the peak to 1e-6."""
MOST_OSCILLATIONS = 250
"""Cycles of one interval that are all evaluated; of more, half as many at either end, and scattered times between."""
_GOLDEN = (5**0.5 - 1) / 2
"""Multiples of it modulo 1 are evenly distributed and in step with no oscillation."""
FEW_CORNERS = 60
"""Number of corners, the first and the last ones, that are followed by times on a logarithmic scale."""
MOST_CORNERS = 10_000
"""Corners that are all evaluated; of more, an even choice."""
AFTER = np.append(1e-9, np.geomspace(1e-6, 1.0, 73)[:-1])
"""Evaluation times after a corner, as fractions of the time to the next one."""
BEFORE = 1 - np.array([1e-6, 1e-9])
"""Evaluation times just before a corner, as fractions of the time since the previous one."""
FIRST_CYCLES = 20
"""First cycles of a periodic drive from rest that are all evaluated; of the later ones a thinning choice, and the last two."""
REFINEMENTS = 3
"""Number of refinements; each divides the interval around a largest value by `DIVISIONS`/2."""
CLEAR = 1e-2
"""Relative drop of the neighbours of a largest value, below which a parabola is accurate to 1e-5, at uneven times to 1e-4."""
COUNTS = 1e-6
"""Relative height of a parabola above the times, up to which their distances do not matter."""
DIVISIONS = 12
"""Intervals into which the time between the neighbours of a largest value is divided."""
_MANY = 100_000
"""Number of times above which only those around the largest values and next to further evaluation times are kept."""
_BESIDE = 2
"""Times on both sides of a largest value that are kept."""
_JUST = 1e-6
"""Distance from a largest value at which it is evaluated again, as a share of the time to its neighbour."""
_BEFORE = 1e-9
"""Distance from a corner of the drive at which the value before it is evaluated, as a share of the time since the one before."""
SQUEEZED = 8
"""Multiple of the frequency of a moving gap that is resolved: the field, which varies as 1/gap, has sharper peaks."""
ROUNDED = 1e-13
"""Share of the last time below which two times are equal by rounding."""
SUDDEN = 1e-6
"""Share of the last time within which a drop beyond `CLEAR` is a discontinuity, whose both sides are among the times."""
AT_A_CORNER = 1e-4
"""Ratio of the times to both neighbours, below which the largest value is at a corner, not between two times."""


def evaluation_times(
    drive: Drive, *, end: float, settled: bool, beside: float = 0.0, seen: Real | None = None
) -> Real:
    """Return times at which a linear response can be largest.

    They are the corners of the drive, times just before them and on a logarithmic scale after them, and
    `PER_CYCLE` times in each cycle of its fastest oscillation. From rest the response to a periodic drive
    approaches its periodic state, so that of the later cycles a choice suffices.
    """
    period = drive.period
    if seen is not None and shows_every_sample(drive, seen):
        return _near_the_ends(drive, end, beside)
    if period is None or (end <= period and not settled):
        return _stretch(drive, 0.0, end, beside)
    if settled:
        return _stretch(drive, 0.0, period, beside)
    within = (
        _stretch(drive, period, 2 * period, beside) - period
    )  # a discontinuity in the first cycle may come from switching on alone
    count = int(np.ceil(end / period))
    later = np.geomspace(FIRST_CYCLES, max(count, FIRST_CYCLES + 1), FIRST_CYCLES).astype(int)
    cycles = np.unique(np.concatenate([np.arange(min(count, FIRST_CYCLES)), later, [count - 2, count - 1]]))
    cycles = cycles[(cycles >= 0) & (cycles < count)]
    found = np.concatenate(
        [_stretch(drive, 0.0, period, beside), (within + cycles[:, None] * period).ravel(), [end]]
    )
    return np.unique(found[found <= end])


def frequency_beside(scenario: Scenario) -> float:
    """Return the frequency that a moving gap adds to that of the drive [Hz]; 0 where none moves."""
    moved = scenario.motion.moved_gap
    return 0.0 if moved is None else SQUEEZED * moved.fastest


def around_kinks(kinks: Real, end: float) -> Real:
    """Return times just before and after changes between the regimes of an amplifier with limits, as around corners.

    `kinks` (n,) [s].

    The current into a capacitance is discontinuous there, and a parabola through both sides would not be its largest value.
    """
    if not len(kinks):
        return kinks
    since, until = np.diff(kinks, prepend=0.0), np.diff(kinks, append=end)
    few = _first_and_last(len(kinks))
    after = (kinks[few, None] + until[few, None] * AFTER).ravel()
    moments = np.unique(np.concatenate([kinks - AFTER[0] * since, kinks, kinks + AFTER[0] * until, after]))
    return np.asarray(moments[moments <= end])


def shows_every_sample(drive: Drive, times: Real) -> bool:
    """Return whether times are the samples of a measured drive, and too many to evaluate just before each.

    `times` (n,) [s].
    """
    parts = drive.parts()
    return len(times) > MOST_CORNERS and len(parts) == 1 and parts[0].begins_with(times)


def _near_the_ends(drive: Drive, end: float, beside: float) -> Real:
    """Return evaluation times between the first and between the last samples of a drive [s]."""
    corners, half = drive.corners(end)[0], FEW_CORNERS // 2
    spans = [np.append(0.0, corners[:half]), corners[-half - 1 :]]
    shares = np.concatenate([AFTER, BEFORE])
    found = [(each[:-1, None] + np.diff(each)[:, None] * shares).ravel() for each in spans]
    return np.unique(np.concatenate([*found, *_oscillating(beside, 0.0, end)]))


def count_evaluation_times(drive: Drive, *, end: float, settled: bool, beside: float = 0.0) -> int:
    """Return an upper estimate of the number of times that `evaluation_times` returns."""
    period, cycles = drive.period, 1
    if period is not None and (settled or end > period):
        cycles = 1 if settled else min(math.ceil(end / period), 2 * FIRST_CYCLES + 2) + 1
        end = period
    corners = min(drive.count_corners(end) + 2, MOST_CORNERS)
    oscillations = (drive.highest_frequency + beside) * end
    if oscillations > MOST_OSCILLATIONS:
        oscillations = 1.5 * MOST_OSCILLATIONS
    near = min(corners, FEW_CORNERS) * len(AFTER)
    return math.ceil(cycles * (corners * (1 + len(BEFORE)) + near + oscillations * PER_CYCLE)) + 1


def _stretch(drive: Drive, start: float, end: float, beside: float) -> Real:
    """Return evaluation times between two times, both included [s]."""
    corners = drive.corners(end)[0]
    corners = np.unique(np.concatenate([[start], corners[(corners > start) & (corners <= end)], [end]]))
    if len(corners) > MOST_CORNERS:
        corners = corners[np.unique(np.linspace(0, len(corners) - 1, MOST_CORNERS).astype(int))]
    spans = np.diff(corners)
    near = _first_and_last(len(spans))
    found = [corners]
    found += [(corners[:-1, None] + spans[:, None] * BEFORE).ravel()]
    found += [(corners[near, None] + spans[near, None] * AFTER).ravel()]
    return np.unique(np.concatenate([*found, *_oscillating(drive.highest_frequency + beside, start, end)]))


def _first_and_last(count: int) -> NDArray[np.intp]:
    """Return the indices of the corners that are followed by times on a logarithmic scale."""
    indices = np.arange(count)
    return indices[(indices < FEW_CORNERS // 2) | (indices >= count - FEW_CORNERS // 2)]


def _oscillating(frequency: float, start: float, end: float) -> list[Real]:
    cycles = (end - start) * frequency
    if cycles <= MOST_OSCILLATIONS:
        return [np.linspace(start, end, int(np.ceil(cycles * PER_CYCLE)) + 1)]
    count, share = MOST_OSCILLATIONS * PER_CYCLE // 2, MOST_OSCILLATIONS / 2 / cycles * (end - start)
    scattered = np.asarray(start + (end - start) * (np.arange(count) * _GOLDEN % 1), dtype=float)
    return [np.linspace(start, start + share, count), scattered, np.linspace(end - share, end, count)]


@dataclass(frozen=True)
class PeakRecord:
    """Quantities with limits, over time.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing [s].
    rows : dict of Key to ndarray, shape (n,)
        Field of each layer [V/m], ``interface`` [V/m], ``gap`` [m] and ``breakdown`` [1] where there is a gap,
        ``across`` (voltage of the stack) [V], and the quantities that `Limits` names.
    whole : PeakRecord or None
        Voltages and currents at all times, where this record holds only those that determine the largest values.
    """

    times: Real
    rows: dict[Key, Real]
    whole: PeakRecord | None = None

    @classmethod
    def of(cls, scenario: Scenario, times: Real, found: dict[Key, Real]) -> PeakRecord:
        """Return the quantities with limits from the quantities that a solver found.

        `times` (n,) [s].
        """
        around, layers = Surroundings.of(scenario), scenario.stack.layers
        gap = scenario.stack.gap_name
        rows: dict[Key, Real] = {FieldOf(name): found[FieldOf(name)] for name in layers}
        thicknesses: dict[str, Real | float] = {name: layer.thickness for name, layer in layers.items()}
        if gap is not None:
            thicknesses[gap] = found.get("gap", layers[gap].thickness)
            rows["gap"] = np.broadcast_to(thicknesses[gap], len(times))
        rows["interface"] = found.get("interface_field", np.broadcast_to(np.nan, len(times)))
        if gap is not None:
            rows["breakdown"] = breakdown_share(rows["interface"], rows["gap"])
        rows["across"] = found["stack_voltage"]
        rows["voltage"] = found.get("plate_voltage", found["drive_voltage"])
        rows["current"] = found.get("amplifier_current", found["current"])
        rows["body_current"] = found["current"]
        rows["charge"] = around.area * found[DisplacementOf(next(iter(layers)))]
        stray, energy = scenario.circuit.supply.stray_capacitance, np.zeros(len(times))
        for name in layers:
            product = found[FieldOf(name)] * found[DisplacementOf(name)]
            product *= (1 + around.second) * around.area / 2 * thicknesses[name]
            energy += product
        rows["stored_energy"] = energy + stray / 2 * rows["voltage"] ** 2 if stray else energy
        return cls(times, rows)

    def before_corners(self, corners: Real) -> Real:
        """Return times just before the corners of the drive that are next to the largest values."""
        after = np.searchsorted(corners, self.times[self._crests.places])
        near = (
            corners[np.unique(np.concatenate([after - 1, after]).clip(0, len(corners) - 1))]
            if len(corners)
            else corners
        )
        inside = near[(near > self.times[0]) & (near <= self.times[-1])]
        previous = self.times[np.searchsorted(self.times, inside) - 1]
        return np.unique(inside - _BEFORE * (inside - previous))

    def joined(self, other: PeakRecord) -> PeakRecord:
        """Return the union of two records of one solution; at a time of both, the values of this one."""
        times = np.concatenate([self.times, other.times])
        times, places = np.unique(times, return_index=True)
        rows = {name: np.concatenate([row, other.rows[name]])[places] for name, row in self.rows.items()}
        return PeakRecord(times, rows, self.whole)

    @functools.cached_property
    def _crests(self) -> _Crests:
        return crests([self])[0]

    def peaks(self) -> dict[Key, float]:
        """Return the largest absolute value of each quantity; NaN where it is unknown."""
        return dict(zip(self.rows, self._crests.values.tolist(), strict=True))

    def unclear(self) -> Real:
        """Return new times around the largest values whose neighbours are too far below them for a parabola [s]."""
        places, values, drops = self._crests
        unclear = places[drops > CLEAR * values]
        if not len(unclear):
            return np.zeros(0)
        left, right = _beside(self.times, unclear)
        around = np.linspace(self.times[left], self.times[right], DIVISIONS + 1)
        return np.setdiff1d(around, self.times)

    def nearest_to_breakdown(self) -> tuple[float, float]:
        """Return field [V/m] and gap [m] at the time that is nearest to breakdown by Paschen's law."""
        quantity = list(self.rows).index("breakdown")
        share, place = float(self._crests.values[quantity]), self._crests.places[quantity]
        gap = float(self.rows["gap"][place])
        if share == 0:
            return float(abs(self.rows["interface"][place])), gap
        return share * paschen_voltage(gap=gap) / gap, gap


class Largest:
    """Places of the largest absolute values of quantities whose record comes in stretches; `places` (quantities,)."""

    def __init__(self) -> None:
        self.places, self.sizes = np.zeros(0, np.intp), np.zeros(0)

    def take(self, first: int, rows: Mapping[Key, Real]) -> None:
        """Note the largest values of a stretch that begins with this index."""
        each = {id(row): row for row in rows.values()}  # a field may be that at the interface too
        places = {key: _farthest(row) for key, row in each.items()}
        own = np.array([places[id(row)] for row in rows.values()])
        sizes = np.abs([row[place] for row, place in zip(rows.values(), own.tolist(), strict=True)])
        sizes = np.where(np.isfinite(sizes), sizes, -1.0)
        if not first:
            self.places, self.sizes = own, sizes
        larger = sizes > self.sizes
        self.places = np.where(larger, first + own, self.places)
        self.sizes = np.where(larger, sizes, self.sizes)

    def just_beside(self, times: Real) -> Real:
        """Return times just before and just after each largest value, which distinguish a corner from a crest [s]."""
        inner = self.places[(self.places > 0) & (self.places < len(times) - 1)]
        before = times[inner] - _JUST * (times[inner] - times[inner - 1])
        after = times[inner] + _JUST * (times[inner + 1] - times[inner])
        return np.unique(np.concatenate([before, after]))

    def kept(self, times: Real, moments: Real) -> Indices:
        """Return the indices of very many times that are near a largest value or next to further times, or of all times."""
        if len(times) <= _MANY:
            return np.arange(len(times))
        beside = np.searchsorted(times, moments)
        near = [self.places + step for step in range(-_BESIDE, _BESIDE + 1)] + [beside - 1, beside]
        last = len(times) - 1
        return np.unique(np.clip(np.concatenate([*near, [0, last]]), 0, last))


class _Crests(NamedTuple):
    """Largest absolute values of quantities, the index of each, and how far its neighbours lie below it; all (quantities,)."""

    places: Indices
    values: Real
    drops: Real


class _Courses:
    """Records of the same quantities, with the last time of the shorter ones repeated."""

    def __init__(self, records: Sequence[PeakRecord]) -> None:
        self.cases = np.arange(len(records))
        self.times = _padded([each.times for each in records])
        self.rows = [_padded([each.rows[name] for each in records]) for name in records[0].rows]

    def places(self) -> Indices:
        """Return the index of the largest absolute value of each quantity, shape (quantities, cases) like all indices here."""
        if self.times.shape[1] > _MANY:  # without a copy of all rows
            return np.array([_largest(row) for row in self.rows])
        return _largest(np.array(self.rows))

    def beside(self, places: Indices) -> tuple[Indices, Indices]:
        """Return the indices of the times before and after some, which differ from them by more than rounding."""
        found = [_beside(times, own) for times, own in zip(self.times, places.T, strict=True)]
        left, right = np.array(found).transpose(1, 2, 0)
        return left, right

    def at(self, places: Indices) -> Real:
        """Return the times of some indices [s]."""
        return np.asarray(self.times[self.cases, places])

    def sizes(self, *places: Indices) -> Real:
        """Return the absolute values of the quantities, shape (places, quantities, cases)."""
        each = np.stack(places, axis=1)
        found = [row[self.cases, at] for row, at in zip(self.rows, each, strict=True)]
        return np.abs(found).swapaxes(0, 1)


def crests(records: Sequence[PeakRecord]) -> list[_Crests]:
    """Find the largest values of records of the same quantities, and how far their neighbours lie below them.

    Between times the largest value is that of a parabola through three of them, at most half of the drop above the
    middle one. The drop is 0 at an end and at a corner, and infinite where the parabola rises higher than at even times.
    """
    courses = _Courses(records)
    place = courses.places()
    left, right = courses.beside(place)
    inside = (left >= 0) & (right < courses.times.shape[1])
    left, right = np.where(inside, left, place), np.where(inside, right, place)
    value, first, last = courses.sizes(place, left, right)
    first, last = value - first, value - last
    here = courses.at(place)
    before, after = here - courses.at(left), courses.at(right) - here
    inside &= np.minimum(before, after) >= AT_A_CORNER * np.maximum(before, after)
    inside &= np.minimum(first, last) >= 0
    first, last = np.where(inside, first, 0.0), np.where(inside, last, 0.0)
    before, after = np.where(inside, before, 1.0), np.where(inside, after, 1.0)
    bend, drop = first / before + last / after, np.maximum(first, last)
    inside &= bend > 0
    tilt = (first * after / before - last * before / after) / (before + after)
    above = tilt**2 * (before + after) / (4 * np.where(inside, bend, 1.0))
    # a parabola through both sides of a discontinuity would lie above them
    steep = np.where(first > last, before, after) <= SUDDEN * courses.times[:, -1]
    inside &= ~(steep & (drop > CLEAR * value))
    concave = _most_above(courses, place, value, np.where(tilt < 0, left, right), tilt < 0)
    above = np.where(inside, np.minimum(above, concave), 0.0)
    value = value + np.minimum(above, drop / 2)
    drop = np.where(
        above > np.maximum(drop / 8, COUNTS * value), np.inf, drop
    )  # at even times at most drop/8
    return [_Crests(*each) for each in zip(place.T, value.T, drop.T, strict=True)]


def _most_above(
    courses: _Courses, place: Indices, value: Real, near: Indices, falls: NDArray[np.bool_]
) -> Real:
    """Return how far concave courses between times and their neighbours can rise above the values at these times.

    They lie below the secant through that neighbour and the next one; so a corner, steep on one side only, has no
    crest.
    """
    outer = np.where(falls, *courses.beside(near))
    known = (outer >= 0) & (outer < courses.times.shape[1])
    outer = np.where(known, outer, near)
    beside, beyond = courses.sizes(near, outer)
    finite = np.isfinite(beside) & np.isfinite(beyond)
    beside, beyond = np.where(finite, beside, 0.0), np.where(finite, beyond, 0.0)
    slope = (beside - beyond) / np.where(known, courses.at(near) - courses.at(outer), 1.0)
    rise = beside + slope * (courses.at(place) - courses.at(near)) - value
    return np.where(known, np.maximum(rise, 0.0), np.inf)


def _beside(times: Real, places: Indices) -> tuple[Indices, Indices]:
    """Return the indices of the times before and after some, which differ from them by more than rounding."""
    here, apart = times[places], ROUNDED * times[-1]
    left = np.searchsorted(times, here - apart, side="left") - 1
    return left, np.searchsorted(times, here + apart, side="right")


def _padded(rows: Sequence[Real]) -> Real:
    """Return rows as one array (cases, n), in which the last value of the shorter ones is repeated."""
    count = max(map(len, rows))
    if all(len(row) == count for row in rows):
        return rows[0][None] if len(rows) == 1 else np.array(rows)
    return np.array([np.append(row, np.full(count - len(row), row[-1])) for row in rows])


def joined(record: PeakRecord, moments: Real, look: Callable[[Real], PeakRecord]) -> PeakRecord:
    """Add further times [s], if any, to a record; `look` returns the quantities there."""
    return record.joined(look(moments)) if len(moments) else record


def resolved(record: PeakRecord, look: Callable[[Real], PeakRecord]) -> PeakRecord:
    """Add times around largest values that a record does not resolve; `look` returns the quantities at other times [s]."""

    def rows(_: Indices, times: Real) -> dict[Key, Real]:
        return {name: row[None] for name, row in look(times[0]).rows.items()}

    return refined([record], rows)[0]


def refined(
    records: Sequence[PeakRecord], look: Callable[[Indices, Real], Mapping[Key, Real]]
) -> list[PeakRecord]:
    """Add times around the largest values that their neighbours do not resolve, to all records in the same rounds.

    `look` evaluates the quantities of some records, by their indices (cases,), at other times (cases, n) [s].
    """
    found = list(records)
    wanted: dict[int, Real] = {}
    _find_crests(found)
    for _ in range(REFINEMENTS):
        wanted = {case: new for case in wanted or range(len(found)) if len(new := found[case].unclear())}
        if not wanted:
            break
        cases, times = np.array([*wanted]), _padded([*wanted.values()])
        rows = look(cases, times)
        for place, (case, new) in enumerate(wanted.items()):
            own = {name: row[place, : len(new)] for name, row in rows.items()}
            found[case] = found[case].joined(PeakRecord(new, own))
        _find_crests([found[case] for case in wanted])
    return found


def _find_crests(records: Sequence[PeakRecord]) -> None:
    """Find the largest values of all records at once, as each would by itself."""
    for record, own in zip(records, crests(records), strict=True):
        vars(record)["_crests"] = own


def _farthest(row: Real) -> int:
    """Return the index of the largest absolute finite value of a row (n,), without an array of these values."""
    high, low = int(np.argmax(row)), int(np.argmin(row))
    if not np.isfinite(row[high] - row[low]):  # a NaN would be the first found
        return int(_largest(row))
    sizes = float(row[high]), -float(row[low])
    return min(high, low) if sizes[0] == sizes[1] else high if sizes[0] > sizes[1] else low


def _largest(rows: Real) -> Indices:
    """Return the index of the largest absolute finite value of each row (..., n)."""
    sizes = np.abs(rows)
    found: Indices = np.argmax(sizes, axis=-1)
    if np.all(
        np.isfinite(np.take_along_axis(sizes, found[..., None], axis=-1))
    ):  # a NaN would be the first found
        return found
    return np.asarray(np.argmax(np.where(np.isfinite(sizes), sizes, -1.0), axis=-1))
