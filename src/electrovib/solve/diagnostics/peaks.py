"""Largest values of solutions, at the output times and between them."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.safety import breakdown_share, paschen_voltage
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import DisplacementOf, FieldOf

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.keys import Key

REFINEMENTS = 3
"""Number of refinements; each divides the interval around a largest value by `DIVISIONS`/2."""
CLEAR = 1e-2
"""Relative drop of the neighbours of a largest value, below which a parabola through the three is accurate to 1e-5."""
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
ROUNDED = 1e-13
"""Share of the last time below which two times are equal by rounding."""
SUDDEN = 1e-6
"""Share of the last time within which a drop beyond `CLEAR` is a discontinuity, whose both sides are among the times."""
AT_A_CORNER = 1e-4
"""Ratio of the times to both neighbours, below which the largest value is at a corner, not between two times."""


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
        Record at all times, where this one holds only those that determine the largest values.
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
            thicknesses[gap] = found.get("gap", np.full(len(times), layers[gap].thickness))
            rows["gap"] = np.asarray(thicknesses[gap])
        rows["interface"] = found.get("interface_field", np.full(len(times), np.nan))
        if gap is not None:
            rows["breakdown"] = breakdown_share(rows["interface"], rows["gap"])
        rows["across"] = found["stack_voltage"]
        rows["voltage"] = found.get("plate_voltage", found["drive_voltage"])
        rows["current"] = found.get("amplifier_current", found["current"])
        rows["body_current"] = found["current"]
        rows["charge"] = around.area * found[DisplacementOf(next(iter(layers)))]
        energy = np.zeros(len(times))
        for name in layers:
            energy += thicknesses[name] * found[FieldOf(name)] * found[DisplacementOf(name)] / 2
        stray = scenario.circuit.supply.stray_capacitance
        rows["stored_energy"] = (1 + around.second) * around.area * energy + stray * rows["voltage"] ** 2 / 2
        return cls(times, rows)

    def among(self, moments: Real) -> PeakRecord:
        """Omit, of very many times, those that are neither near a largest value nor next to given further times."""
        if len(self.times) <= _MANY:
            return self
        largest = self._places
        beside = np.searchsorted(self.times, moments)
        near = [largest + step for step in range(-_BESIDE, _BESIDE + 1)] + [beside - 1, beside]
        last = len(self.times) - 1
        kept = np.unique(np.clip(np.concatenate([*near, [0, last]]), 0, last))
        return PeakRecord(self.times[kept], {name: row[kept] for name, row in self.rows.items()}, self)

    def just_before(self) -> Real:
        """Return times just before and just after each largest value, which distinguish a corner from a crest [s]."""
        places = self._places
        inner = places[(places > 0) & (places < len(self.times) - 1)]
        before = self.times[inner] - _JUST * (self.times[inner] - self.times[inner - 1])
        after = self.times[inner] + _JUST * (self.times[inner + 1] - self.times[inner])
        return np.unique(np.concatenate([before, after]))

    def before_corners(self, corners: Real) -> Real:
        """Return times just before the corners of the drive that are next to the largest values."""
        after = np.searchsorted(corners, self.times[self._places])
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
    def _places(self) -> Indices:
        """Index of the largest absolute value of each quantity."""
        if len(self.times) > _MANY:  # without a copy of all rows
            return np.array([int(_largest(row[None])[0]) for row in self.rows.values()])
        return _largest(np.array(list(self.rows.values())))

    @functools.cached_property
    def _crests(self) -> tuple[Real, Real]:
        """Largest absolute values, and how far their neighbours lie below them (0 at an end or a corner).

        Between times the largest value is that of a parabola through three of them, at most half of the drop above the
        middle one.
        """
        times, place, (left, right) = self.times, self._places, self._neighbours(self._places)
        inside = (left >= 0) & (right < len(times))
        left, right = np.where(inside, left, place), np.where(inside, right, place)
        value, first, last = self._sizes(place, left, right)
        first, last = value - first, value - last
        before, after = times[place] - times[left], times[right] - times[place]
        inside &= np.minimum(before, after) >= AT_A_CORNER * np.maximum(before, after)
        inside &= np.minimum(first, last) >= 0
        first, last = np.where(inside, first, 0.0), np.where(inside, last, 0.0)
        before, after = np.where(inside, before, 1.0), np.where(inside, after, 1.0)
        bend, drop = first / before + last / after, np.maximum(first, last)
        inside &= bend > 0
        tilt = (first * after / before - last * before / after) / (before + after)
        above = tilt**2 * (before + after) / (4 * np.where(inside, bend, 1.0))
        # a parabola through both sides of a discontinuity would lie above them
        steep = np.where(first > last, before, after) <= SUDDEN * times[-1]
        inside &= ~(steep & (drop > CLEAR * value))
        most = np.minimum(drop / 2, self._most_above(value, np.where(tilt < 0, left, right), tilt < 0))
        return value + np.where(inside, np.minimum(above, most), 0.0), drop

    def _most_above(self, value: Real, near: Indices, falls: NDArray[np.bool_]) -> Real:
        """Return how far concave courses between times and their neighbours can rise above the values at these times.

        They lie below the secant through that neighbour and the next one; so a corner, steep on one side only, has no
        crest.
        """
        outer = np.where(falls, *self._neighbours(near))
        known = (outer >= 0) & (outer < len(self.times))
        outer = np.where(known, outer, near)
        beside, beyond = self._sizes(near, outer)
        finite = np.isfinite(beside) & np.isfinite(beyond)
        beside, beyond = np.where(finite, beside, 0.0), np.where(finite, beyond, 0.0)
        slope = (beside - beyond) / np.where(known, self.times[near] - self.times[outer], 1.0)
        rise = beside + slope * (self.times[self._places] - self.times[near]) - value
        return np.where(known, np.maximum(rise, 0.0), np.inf)

    def _neighbours(self, places: Indices) -> tuple[Indices, Indices]:
        """Return the indices of the times before and after some, which differ from them by more than rounding."""
        here, apart = self.times[places], ROUNDED * self.times[-1]
        left = np.searchsorted(self.times, here - apart, side="left") - 1
        return left, np.searchsorted(self.times, here + apart, side="right")

    def _sizes(self, *places: Indices) -> Real:
        """Return the absolute values of the quantities, each at its own places, shape (places, quantities)."""
        each = np.transpose(places)
        return np.abs([row[at] for row, at in zip(self.rows.values(), each, strict=True)]).T

    def peaks(self) -> dict[Key, float]:
        """Return the largest absolute value of each quantity; NaN where it is unknown."""
        return dict(zip(self.rows, self._crests[0].tolist(), strict=True))

    def unclear(self) -> Real:
        """Return new times around the largest values whose neighbours are too far below them for a parabola [s]."""
        value, drop = self._crests
        unclear = self._places[drop > CLEAR * value]
        if not len(unclear):
            return np.zeros(0)
        left, right = self._neighbours(unclear)
        around = np.linspace(self.times[left], self.times[right], DIVISIONS + 1)
        return np.setdiff1d(around, self.times)

    def nearest_to_breakdown(self) -> tuple[float, float]:
        """Return field [V/m] and gap [m] at the time that is nearest to breakdown by Paschen's law."""
        quantity = list(self.rows).index("breakdown")
        share, place = float(self._crests[0][quantity]), self._places[quantity]
        gap = float(self.rows["gap"][place])
        if share == 0:
            return float(abs(self.rows["interface"][place])), gap
        return share * paschen_voltage(gap=gap) / gap, gap


def refined(
    records: Sequence[PeakRecord], look: Callable[[Indices, Real], Mapping[Key, Real]]
) -> list[PeakRecord]:
    """Add times around the largest values that their neighbours do not resolve, to all records in the same rounds.

    `look` evaluates the quantities of some records, by their indices (n,), at other times (n,) [s].
    """
    found = list(records)
    for _ in range(REFINEMENTS):
        wanted = [record.unclear() for record in found]
        counts = [len(each) for each in wanted]
        if not any(counts):
            break
        rows = look(np.repeat(np.arange(len(found)), counts), np.concatenate(wanted))
        ends = np.cumsum(counts)
        for case, (times, first, last) in enumerate(zip(wanted, ends - counts, ends, strict=True)):
            if len(times):
                own = {name: row[first:last] for name, row in rows.items()}
                found[case] = found[case].joined(PeakRecord(times, own))
    return found


def _largest(rows: Real) -> Indices:
    """Return the index of the largest absolute finite value of each row, shape (rows, n)."""
    sizes = np.abs(rows)
    found: Indices = np.argmax(sizes, axis=1)
    if np.all(np.isfinite(sizes[np.arange(len(rows)), found])):  # a NaN would be the first found
        return found
    return np.asarray(np.argmax(np.where(np.isfinite(sizes), sizes, -1.0), axis=1))
